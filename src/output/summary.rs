//! `summary.json`: what became of a run, as a contract for scripts.
//!
//! `format` is raised when a key changes its meaning or goes; keys may be added. Times are simulated seconds unless
//! they say `wall`; energies are in J; `null` stands for what did not happen.

use bevy_ecs::prelude::*;
use serde::Serialize;

use crate::contact::{Contact, LargestOverlap};
use crate::door::DoorState;
use crate::ending::EmptyTime;
use crate::energy::{Channels, EnergyFlows};
use crate::grains::spawner::ReleaseDelays;
use crate::integrate::Integrator;
use crate::ledger::{Ledger, LossRecord};
use crate::measure::bed::BedFigures;
use crate::measure::discharge::Discharge;
use crate::measure::totals;
use crate::neighbours::Rebuilds;
use crate::outcome::End;
use crate::output::state_hash;
use crate::rest::RestDetector;
use crate::scene::load::Loaded;
use crate::space::{Dimension, Plane, Solid};
use crate::step::Clock;
use crate::store::ParticleStore;
use crate::threads::Threads;
use crate::writers::SUMMARY_FORMAT;
use crate::writers::peak::peak_memory;

/// The whole summary.
#[derive(Debug, Serialize)]
pub struct Summary {
    /// [`SUMMARY_FORMAT`].
    pub format: u32,
    /// Name of the scene.
    pub scene: String,
    /// `empty`, `at_rest`, `time_reached`: done; `grains_lost`, `failed`: not.
    pub status: &'static str,
    /// Why it failed.
    pub failure: Option<String>,
    /// Steps done.
    pub steps: u64,
    /// Simulated time, s.
    pub time_s: f64,
    /// The ledger.
    pub grains: Grains,
    /// When the bed came to rest, s.
    pub rest_time_s: Option<f64>,
    /// When the door began to open, s.
    pub door_open_time_s: Option<f64>,
    /// When nobody was left inside, s.
    pub empty_time_s: Option<f64>,
    /// Largest overlap of the whole run, over the smaller radius of the pair.
    pub max_overlap_ratio: f64,
    /// Mean number of contacts of a grain at the end, with grains and walls alike.
    pub coordination: f64,
    /// The bed at rest, if the scene measures it.
    pub bed: Option<BedFigures>,
    /// The flow through the orifice.
    pub discharge: Option<Discharge>,
    /// Releases that had to wait.
    pub releases: Option<ReleaseDelays>,
    /// The energy balance, J.
    pub energy: Energy,
    /// What it cost.
    pub performance: Performance,
    /// The state of the grains at the end, as 16 hexadecimal digits.
    pub state_hash: String,
    /// Every lost grain.
    pub losses: Vec<LossRecord>,
}

/// The ledger: released = inside + out + lost.
#[derive(Debug, Serialize)]
pub struct Grains {
    /// Entered.
    pub released: u32,
    /// Neither out nor lost.
    pub inside: u32,
    /// Went through the orifice.
    pub out: u32,
    /// Left in any other way.
    pub lost: u32,
}

/// The energy balance, J: kinetic + rotational + potential + elastic = released + `wall_work` + lifted + `added_work` - dissipated - removed
/// + `balance_error`.
#[derive(Debug, Serialize)]
pub struct Energy {
    /// Of translation, at the end.
    pub kinetic: f64,
    /// Of rotation, at the end.
    pub rotational: f64,
    /// At the end; 0 at the origin.
    pub potential: f64,
    /// At the end.
    pub elastic: f64,
    /// The flows of the whole run; none of these keys where no books are kept.
    #[serde(flatten)]
    pub flows: Option<EnergyFlows>,
    /// What of `dissipated` went by friction and by rolling resistance, where grains spin.
    pub channels: Option<Channels>,
    /// The difference of the two sides, where books are kept.
    pub balance_error: Option<f64>,
}

/// What a run cost.
#[derive(Debug, Serialize)]
pub struct Performance {
    /// Wall-clock time of the steps, s.
    pub wall_s: f64,
    /// Sum over the steps of the movable grains in the world.
    pub particle_steps: u64,
    /// Their quotient.
    pub particle_steps_per_s: f64,
    /// The largest resident set of the program up to the end of the last step, set-up included, bytes; `null` where the system
    /// does not tell.
    pub peak_memory_bytes: Option<u64>,
    /// How often cells were filled or the list was renewed.
    pub neighbour_rebuilds: u64,
    /// Threads of the force pass.
    pub threads: usize,
    /// The scheme.
    pub integrator: Integrator,
    /// The law.
    pub contact_law: Contact,
}

/// What the runner has counted and timed.
#[derive(Debug, Clone, Copy, Default)]
pub struct Cost {
    /// Wall-clock time of the steps, s.
    pub wall_s: f64,
    /// Sum over the steps of the movable grains in the world.
    pub particle_steps: u64,
}

/// Movable grains of a world, for [`Cost::particle_steps`].
#[must_use]
pub fn movable_grains(world: &World) -> usize {
    match Dimension::of_world(world) {
        Dimension::Plane => world.resource::<ParticleStore<Plane>>().movable_end,
        Dimension::Solid => world.resource::<ParticleStore<Solid>>().movable_end,
    }
}

impl Summary {
    /// The summary of a run that came to `end`.
    pub fn of(world: &mut World, loaded: &Loaded, end: &End, cost: Cost) -> Self {
        let totals = totals::of_world(world);
        let state_hash = format!("{:016x}", state_hash::of_world(world));
        let ledger = world.resource::<Ledger>();
        let clock = world.resource::<Clock>();
        let flows = world.get_resource::<EnergyFlows>().copied();
        let failure = match end {
            End::Failed(failure) => Some(failure.to_string()),
            _ => None,
        };
        let status = if ledger.lost() > 0 && failure.is_none() { "grains_lost" } else { end.word() };
        #[expect(clippy::cast_precision_loss, reason = "a figure for people")]
        let speed = cost.particle_steps as f64 / cost.wall_s.max(f64::MIN_POSITIVE);
        Self {
            format: SUMMARY_FORMAT,
            scene: loaded.source.name.clone(),
            status,
            failure,
            steps: clock.steps,
            time_s: clock.time(),
            grains: Grains {
                released: ledger.released,
                inside: ledger.inside(),
                out: ledger.out(),
                lost: ledger.lost(),
            },
            rest_time_s: world.get_resource::<RestDetector>().and_then(|rest| rest.rest_time),
            door_open_time_s: world.get_resource::<DoorState>().and_then(|door| door.open_time),
            empty_time_s: world.resource::<EmptyTime>().0,
            max_overlap_ratio: world.resource::<LargestOverlap>().0,
            coordination: totals.coordination,
            bed: world.get_resource().copied(),
            discharge: Discharge::of(ledger),
            releases: world.get_resource().copied(),
            energy: Energy {
                kinetic: totals.kinetic,
                rotational: totals.rotational,
                potential: totals.potential,
                elastic: totals.elastic,
                flows,
                channels: world.get_resource().copied(),
                balance_error: flows.map(|flows| totals.energy() - flows.expected()),
            },
            performance: Performance {
                wall_s: cost.wall_s,
                particle_steps: cost.particle_steps,
                particle_steps_per_s: speed,
                peak_memory_bytes: peak_memory(),
                neighbour_rebuilds: world.resource::<Rebuilds>().0,
                threads: world.resource::<Threads>().count(),
                integrator: loaded.scene.integrator,
                contact_law: loaded.scene.contact,
            },
            state_hash,
            losses: ledger.lost.clone(),
        }
    }

    /// Whether the run did what it was asked to.
    #[must_use]
    pub fn is_done(&self) -> bool {
        self.failure.is_none() && self.grains.lost == 0
    }
}
