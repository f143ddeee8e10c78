//! Adds particles to the silo: a random fill at the start, pouring at the top, or single particles at given places.
//!
//! *Fill*: each of a site's thirteen states is occupied with probability `per_site`/13. *Pour*: at the start of each
//! step, each site of the top three rows that has no downward mover (direction 4) gets one with probability `chance`.
//! Pouring ends when `per_site` times the number of sites have entered.

use bevy_app::{App, Plugin};
use bevy_ecs::prelude::*;
use serde::{Deserialize, Serialize};

use crate::grains::pending::Pending;
use crate::lattice_silo::step::LatticeStage;
use siloflow_dem::space::Plane;
use siloflow_dem::step::{Clock, Step};
use siloflow_dem::values::{FiniteVector, Positive, Share};
use siloflow_lattice::draws::{Chance, Purpose, Streams};
use siloflow_lattice::gas::Gas;
use siloflow_lattice::rules::Odds;
use siloflow_lattice::sites::Sites;
use siloflow_lattice::velocities::DOWN;

/// The scene's key `fill`.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Fill {
    /// Mean number of particles per site, at most 13.
    pub per_site: Positive,
}

/// The scene's key `pour`.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Pour {
    /// Total number of particles that enter, divided by the number of sites; at most 13.
    pub per_site: Positive,
    /// Probability that a free site of the top rows gets a particle in a step. Default 0.5.
    #[serde(default = "half")]
    pub chance: Share,
}

fn half() -> Share {
    Share::try_from(0.5).expect("a share")
}

/// A single particle of the start: an element of the scene's key `particles`.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Thrown {
    /// Place, m; the particle starts at the nearest fluid site.
    pub at: FiniteVector,
    /// Velocity: 0 for rest, 1 to 12 for a direction of [`velocities`](siloflow_lattice::velocities).
    pub velocity: u8,
}

/// Number of rows at the top that particles are poured into.
const POURED_ROWS: i32 = 3;

/// Particles of the start.
pub(super) struct Start<'a> {
    pub particles: &'a [Thrown],
    pub fill: Option<Fill>,
    /// Seed of the fill.
    pub seed: u64,
}

/// Adds the particles of the start to the gas.
pub(super) fn enter(start: &Start, sites: &Sites, gas: &mut Gas) {
    for thrown in start.particles {
        if let Some(site) = sites.nearest(thrown.at.get::<Plane>()) {
            gas.add(site, usize::from(thrown.velocity));
        }
    }
    if let Some(fill) = start.fill {
        let share = Chance::of(fill.per_site.get() / 13.0);
        let streams = Streams::new(start.seed, 0, Purpose::Enter, 0);
        for site in sites.fluid() {
            for state in (0..13).filter(|&state| share.happens(streams.of(site).high(state as u64))) {
                gas.add(site, state);
            }
        }
    }
}

/// Sites of the top rows, the probability of a particle there, and the number of particles that enter in total.
#[derive(Resource, Clone)]
struct PourSource {
    sites: Vec<usize>,
    chance: Chance,
    target: u64,
}

fn pour(
    clock: Res<Clock>,
    odds: Res<Odds>,
    source: Res<PourSource>,
    mut gas: ResMut<Gas>,
    mut pending: ResMut<Pending>,
) {
    // Particles enter before the clock advances to this step.
    let streams = Streams::new(odds.seed, clock.steps + 1, Purpose::Enter, 0);
    let is_free = |&site: &usize| gas.states()[site] & 1 << DOWN == 0;
    let gets_one = |&site: &usize| source.chance.happens(streams.of(site).high(0));
    let mut chosen: Vec<usize> = source.sites.iter().copied().filter(is_free).filter(gets_one).collect();
    // The last particles go to random sites of the chosen ones, so that low site indices have no preference.
    let left = usize::try_from(source.target.saturating_sub(gas.entered())).unwrap_or(usize::MAX);
    if chosen.len() > left {
        chosen.sort_by_key(|&site| streams.of(site).word(1));
        chosen.truncate(left);
    }
    for site in chosen {
        gas.add(site, DOWN);
    }
    pending.0 = u32::try_from(source.target.saturating_sub(gas.entered())).unwrap_or(u32::MAX);
}

fn particles_are_pending(pending: Res<Pending>) -> bool {
    pending.0 > 0
}

/// Plugin that pours particles in at the top.
pub(super) struct PourPlugin {
    source: PourSource,
}

impl PourPlugin {
    /// Creates the plugin for a silo with these sites.
    pub fn new(config: &Pour, sites: &Sites) -> Self {
        // The row of a site is Y/2, rounded down, in columns of either parity.
        let row = |s: usize| sites.coordinates(s).1 / 2;
        let top = sites.fluid().map(row).max().unwrap_or(0);
        let poured = sites.fluid().filter(|&s| row(s) > top - POURED_ROWS).collect();
        #[expect(
            clippy::cast_precision_loss,
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a particle count"
        )]
        let target = (config.per_site.get() * sites.fluid_count() as f64).round() as u64;
        Self { source: PourSource { sites: poured, chance: Chance::of(config.chance.get()), target } }
    }
}

impl Plugin for PourPlugin {
    fn build(&self, app: &mut App) {
        app.insert_resource(Pending(u32::try_from(self.source.target).unwrap_or(u32::MAX)))
            .insert_resource(self.source.clone())
            .add_systems(Step, pour.in_set(LatticeStage::Enter).run_if(particles_are_pending));
    }
}
