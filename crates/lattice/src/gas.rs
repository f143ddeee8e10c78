//! The gas: the state of each site, and the intermediate results that the phases of a step pass to each other.
//!
//! Between steps only [`Gas::states`] is meaningful. Within a step, the collision phases write outgoing movers to
//! `movers` and particles at rest to `resting`. Wall friction and gravity change them. Propagation combines them into
//! the next states.

use bevy_ecs::prelude::*;
use serde::{Deserialize, Serialize};

use crate::sites::{Kind, Sites};
use crate::velocities::STEPS;

/// All particles of the lattice. The lists have an element for each stored site.
#[derive(Resource, Clone, Debug)]
pub struct Gas {
    /// State of each site: bit i is set if there is a particle with velocity i. 0 at walls and sinks.
    pub(crate) states: Vec<u16>,
    /// Outgoing movers of each site, as a state; 0 at walls and sinks.
    pub(crate) movers: Vec<u16>,
    /// Rest place of each site: 0 free, 1 taken, [`CLOSED`] at walls and sinks.
    pub(crate) resting: Vec<u8>,
    /// Number of particles of each site before the collision.
    pub(crate) numbers: Vec<u8>,
    /// Number of particles of each site that the collision has stopped, in the site's own rest place or at a neighbour.
    pub(crate) stopped: Vec<u8>,
    /// Stopped particles that need a rest place at a neighbour, by ascending site.
    pub(crate) surplus: Vec<Surplus>,
    entered: u64,
    out: u64,
}

/// Stopped particles of a site beyond the one that takes the site's own rest place.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Surplus {
    /// The site.
    pub site: usize,
    /// Their number.
    pub count: u8,
}

/// Value of [`Gas::resting`] at sites where no particle can rest.
pub(crate) const CLOSED: u8 = 2;

/// The state of a gas between two steps.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub struct SavedGas {
    states: Vec<u16>,
    entered: u64,
    out: u64,
}

/// The bits that a state can have: of 13 velocities.
const ALL_VELOCITIES: u16 = (1 << STEPS.len()) - 1;

impl Gas {
    /// Creates a gas without particles.
    #[must_use]
    pub fn new(sites: &Sites) -> Self {
        let count = sites.kinds.len();
        let resting = sites.kinds.iter().map(|&kind| if kind == Kind::Fluid { 0 } else { CLOSED });
        Self {
            states: vec![0; count],
            movers: vec![0; count],
            resting: resting.collect(),
            numbers: vec![0; count],
            stopped: vec![0; count],
            surplus: Vec::new(),
            entered: 0,
            out: 0,
        }
    }

    /// Returns what is kept between two steps.
    #[must_use]
    pub fn saved(&self) -> SavedGas {
        SavedGas { states: self.states.clone(), entered: self.entered, out: self.out }
    }

    /// Takes over what [`Gas::saved`] returned, in a gas on the same sites.
    ///
    /// # Errors
    /// If it is of other sites, or cannot be a gas.
    pub fn restore(&mut self, saved: SavedGas) -> Result<(), &'static str> {
        let SavedGas { states, entered, out } = saved;
        if states.len() != self.states.len() {
            return Err("the checkpoint has another number of sites");
        }
        let is_state = |(&state, &rest): (&u16, &u8)| state & !ALL_VELOCITIES == 0 && (rest != CLOSED || state == 0);
        if !states.iter().zip(&self.resting).all(is_state) || out > entered {
            return Err("a site has a state that no gas can have");
        }
        self.states = states;
        self.entered = entered;
        self.out = out;
        Ok(())
    }

    /// Returns the state of each stored site: bit i is set if there is a particle with velocity i.
    #[must_use]
    pub fn states(&self) -> &[u16] {
        &self.states
    }

    /// Adds a particle with velocity `direction` at a site and returns true. Returns false if the site already has a
    /// particle with this velocity or is not a fluid site.
    pub fn add(&mut self, site: usize, direction: usize) -> bool {
        let is_free = self.resting[site] != CLOSED && self.states[site] & 1 << direction == 0;
        if is_free {
            self.states[site] |= 1 << direction;
            self.entered += 1;
        }
        is_free
    }

    /// Returns the number of particles that have entered.
    #[must_use]
    pub fn entered(&self) -> u64 {
        self.entered
    }

    /// Returns the number of particles that have left through the door.
    #[must_use]
    pub fn out(&self) -> u64 {
        self.out
    }

    /// Returns the number of particles inside by the balance: entered minus out.
    #[must_use]
    pub fn inside(&self) -> u64 {
        self.entered - self.out
    }

    /// Counts the particles inside, from the states. It differs from [`Gas::inside`] only if a particle was lost.
    #[must_use]
    pub fn count(&self) -> u64 {
        self.states.iter().map(|state| u64::from(state.count_ones())).sum()
    }

    /// Counts particles that have arrived in a sink.
    pub(crate) fn add_out(&mut self, count: u32) {
        self.out += u64::from(count);
    }
}
