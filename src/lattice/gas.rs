//! The gas: a state for each site, and what the phases of a step hand on to each other.
//!
//! Between steps only [`Gas::states`] counts. Within a step, collisions leave outgoing movers in `movers` and particles at
//! rest in `resting`, walls and gravity change them, and propagation makes the next states of them.

use bevy_ecs::prelude::*;

use crate::lattice::sites::{Kind, Sites};

/// The particles.
#[derive(Resource, Clone, Debug)]
pub struct Gas {
    /// Of each site, bit i for a particle with velocity i; 0 where nothing can be.
    pub(super) states: Vec<u16>,
    /// Of each site, outgoing movers; none at walls.
    pub(super) movers: Vec<u16>,
    /// Of each site, whether the place at rest is taken: 1, at walls [`CLOSED`].
    pub(super) resting: Vec<u8>,
    /// Of each site, particles before the collision.
    pub(super) numbers: Vec<u8>,
    /// Of each site, particles that the collision has stopped, there or next to it.
    pub(super) held: Vec<u8>,
    /// Sites with stopped particles that want a place next to them, and how many.
    pub(super) spare: Vec<(usize, u8)>,
    entered: u64,
    out: u64,
}

/// Of `resting`, where no particle can rest.
pub(super) const CLOSED: u8 = 2;

impl Gas {
    /// An empty gas.
    #[must_use]
    pub fn new(sites: &Sites) -> Self {
        let count = sites.kinds.len();
        let resting = sites.kinds.iter().map(|&kind| if kind == Kind::Fluid { 0 } else { CLOSED });
        Self {
            states: vec![0; count],
            movers: vec![0; count],
            resting: resting.collect(),
            numbers: vec![0; count],
            held: vec![0; count],
            spare: Vec::new(),
            entered: 0,
            out: 0,
        }
    }

    /// The states by site: bit i for a particle with velocity i.
    #[must_use]
    pub fn states(&self) -> &[u16] {
        &self.states
    }

    /// Adds a particle with velocity `direction` at a fluid site, unless there is one already; tells whether it did.
    pub fn add(&mut self, site: usize, direction: usize) -> bool {
        let is_free = self.resting[site] != CLOSED && self.states[site] & 1 << direction == 0;
        if is_free {
            self.states[site] |= 1 << direction;
            self.entered += 1;
        }
        is_free
    }

    /// Particles that have entered.
    #[must_use]
    pub fn entered(&self) -> u64 {
        self.entered
    }

    /// Particles that have gone out.
    #[must_use]
    pub fn out(&self) -> u64 {
        self.out
    }

    /// Particles that should be inside.
    #[must_use]
    pub fn inside(&self) -> u64 {
        self.entered - self.out
    }

    /// Particles that are inside, counted.
    #[must_use]
    pub fn count(&self) -> u64 {
        self.states.iter().map(|state| u64::from(state.count_ones())).sum()
    }

    pub(super) fn let_out(&mut self, count: u32) {
        self.out += u64::from(count);
    }
}
