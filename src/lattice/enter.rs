//! How particles enter: all at once, poured in at the top, or one by one where a scene puts them.
//!
//! *Fill*: each of a site's thirteen states is taken with probability `per_site`/13. *Pour*: at the beginning of each step
//! every site of the top three rows without a particle on its way down gets one with probability `chance`, until there
//! are `per_site` times as many particles as sites.

use bevy_app::{App, Plugin};
use bevy_ecs::prelude::*;
use serde::{Deserialize, Serialize};

use crate::grains::spawner::Pending;
use crate::lattice::draws::{Chance, Purpose, Streams};
use crate::lattice::gas::Gas;
use crate::lattice::load::LoadedLattice;
use crate::lattice::rules::Odds;
use crate::lattice::sites::Sites;
use crate::lattice::velocities::DOWN;
use crate::space::Plane;
use crate::step::{Clock, Phase, Step, time_moves};
use crate::values::{FiniteVector, Positive, Share};

/// The scene's `fill`.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Fill {
    /// Particles a site, in the mean, at most 13.
    pub per_site: Positive,
}

/// The scene's `pour`.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Pour {
    /// How many particles in all, in units of the number of sites, at most 13.
    pub per_site: Positive,
    /// Chance of one at a site of the top rows in a step. Default 0.5.
    #[serde(default = "half")]
    pub chance: Share,
}

fn half() -> Share {
    Share::try_from(0.5).expect("a share")
}

/// One of the scene's `particles`.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Thrown {
    /// Where, m: at the nearest site.
    pub at: FiniteVector,
    /// Its velocity: 0 at rest, 1 to 12 a direction.
    pub velocity: u8,
}

/// Rows of sites that are poured into.
const POURED_ROWS: i32 = 3;

/// Puts the particles of the start into the gas.
pub(super) fn enter(loaded: &LoadedLattice, sites: &Sites, gas: &mut Gas) {
    for thrown in &loaded.scene.particles {
        if let Some(site) = sites.nearest(thrown.at.get::<Plane>()) {
            gas.add(site, usize::from(thrown.velocity));
        }
    }
    if let Some(fill) = loaded.scene.fill {
        let (share, streams) =
            (Chance::of(fill.per_site.get() / 13.0), Streams::new(loaded.scene.seed, 0, Purpose::Enter, 0));
        for site in sites.fluid() {
            for state in (0..13).filter(|&state| share.happens(streams.of(site).high(state as u64))) {
                gas.add(site, state);
            }
        }
    }
}

/// The sites of the top rows and how many particles are to come.
#[derive(Resource)]
struct Hopper {
    sites: Vec<usize>,
    chance: Chance,
    target: u64,
}

fn pour(clock: Res<Clock>, odds: Res<Odds>, hopper: Res<Hopper>, mut gas: ResMut<Gas>, mut pending: ResMut<Pending>) {
    // The clock moves on later in the step.
    let streams = Streams::new(odds.seed, clock.steps + 1, Purpose::Enter, 0);
    let is_free = |&site: &usize| gas.states()[site] & 1 << DOWN == 0;
    let gets_one = |&site: &usize| hopper.chance.happens(streams.of(site).high(0));
    let mut chosen: Vec<usize> = hopper.sites.iter().copied().filter(is_free).filter(gets_one).collect();
    // The last of them go where another draw says, not where the store begins.
    let left = usize::try_from(hopper.target.saturating_sub(gas.entered())).unwrap_or(usize::MAX);
    if chosen.len() > left {
        chosen.sort_by_key(|&site| streams.of(site).word(1));
        chosen.truncate(left);
    }
    for site in chosen {
        gas.add(site, DOWN);
    }
    pending.0 = u32::try_from(hopper.target.saturating_sub(gas.entered())).unwrap_or(u32::MAX);
}

fn is_not_full(pending: Res<Pending>) -> bool {
    pending.0 > 0
}

/// Pours.
pub(super) struct PourPlugin {
    hopper: (Vec<usize>, Chance, u64),
}

impl PourPlugin {
    /// For a silo.
    pub fn new(config: &Pour, sites: &Sites) -> Self {
        // A site's row is Y/2, rounded down, for a column of either parity.
        let row = |s: usize| sites.coordinates(s).1 / 2;
        let top = sites.fluid().map(row).max().unwrap_or(0);
        let poured = sites.fluid().filter(|&s| row(s) > top - POURED_ROWS).collect();
        #[expect(
            clippy::cast_precision_loss,
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a count"
        )]
        let target = (config.per_site.get() * sites.fluid_count() as f64).round() as u64;
        Self { hopper: (poured, Chance::of(config.chance.get()), target) }
    }
}

impl Plugin for PourPlugin {
    fn build(&self, app: &mut App) {
        let (sites, chance, target) = self.hopper.clone();
        app.insert_resource(Pending(u32::try_from(target).unwrap_or(u32::MAX)))
            .insert_resource(Hopper { sites, chance, target })
            .add_systems(Step, pour.in_set(Phase::Spawn).run_if(is_not_full).run_if(time_moves));
    }
}
