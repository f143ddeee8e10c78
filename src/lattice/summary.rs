//! `summary.json` of a lattice gas: what became of a run, as a contract for scripts.
//!
//! `format` is raised when a key changes its meaning or goes; keys may be added. `null` stands for what did not happen.

use std::io::{self, Write};

use bevy_ecs::prelude::*;
use serde::Serialize;

use crate::ending::EmptyTime;
use crate::lattice::door::DoorState;
use crate::lattice::gas::Gas;
use crate::lattice::load::LoadedLattice;
use crate::lattice::rest::RestDetector;
use crate::lattice::rules::Rules;
use crate::lattice::sites::Sites;
use crate::outcome::End;
use crate::step::Clock;
use crate::threads::Threads;
use crate::writers::SUMMARY_FORMAT;
use crate::writers::fnv::Fnv;
use crate::writers::peak::peak_memory;

/// The whole summary.
#[derive(Debug, Serialize)]
pub struct Summary {
    /// [`SUMMARY_FORMAT`].
    pub format: u32,
    /// Name of the scene.
    pub scene: String,
    /// `LatticeGas`.
    pub method: &'static str,
    /// `empty`, `at_rest`, `time_reached`: done; `failed`: not.
    pub status: &'static str,
    /// Why it failed.
    pub failure: Option<String>,
    /// Steps done.
    pub steps: u64,
    /// Fluid sites.
    pub sites: usize,
    /// The ledger.
    pub particles: Particles,
    /// The step at whose end the gas was found at rest.
    pub rest_step: Option<u64>,
    /// The step at whose end the door opened.
    pub door_open_step: Option<u64>,
    /// The step at whose end nobody was left inside.
    pub empty_step: Option<u64>,
    /// What it cost.
    pub performance: Performance,
    /// The state of the gas at the end, as 16 hexadecimal digits.
    pub state_hash: String,
}

/// The ledger: entered = inside + out.
#[derive(Debug, Serialize)]
pub struct Particles {
    /// Entered.
    pub entered: u64,
    /// Not out.
    pub inside: u64,
    /// Went through the outlet.
    pub out: u64,
}

/// What a run cost.
#[derive(Debug, Serialize)]
pub struct Performance {
    /// Wall-clock time of the steps, s.
    pub wall_s: f64,
    /// Steps times fluid sites.
    pub site_updates: u64,
    /// Their quotient.
    pub site_updates_per_s: f64,
    /// The largest resident set of the program up to the end of the last step, set-up included, bytes; `null` where the system
    /// does not tell.
    pub peak_memory_bytes: Option<u64>,
    /// Threads.
    pub threads: usize,
    /// The rules.
    pub rules: Rules,
}

/// The hash of the gas: FNV-1a, 64 bits, over the states of the fluid sites, in the order of the store, 2 bytes each,
/// little-endian.
#[must_use]
pub fn state_hash(sites: &Sites, gas: &Gas) -> u64 {
    let mut hash = Fnv::default();
    sites.fluid().for_each(|s| hash.eat(&gas.states()[s].to_le_bytes()));
    hash.value()
}

/// `state.csv`: the sites with particles, their places (m) and their states, bit i for a particle with velocity i.
///
/// # Errors
/// If it cannot be written.
pub fn write_state(sites: &Sites, gas: &Gas, file: &mut dyn Write) -> io::Result<()> {
    writeln!(file, "x_m,y_m,state")?;
    for s in sites.fluid().filter(|&s| gas.states()[s] != 0) {
        let x = sites.position(s);
        writeln!(file, "{:.9},{:.9},{}", x.x, x.y, gas.states()[s])?;
    }
    Ok(())
}

impl Summary {
    /// The summary of a run that came to `end` in `wall_s` seconds of the clock on the wall.
    #[must_use]
    pub fn of(world: &World, loaded: &LoadedLattice, end: &End, wall_s: f64) -> Self {
        let (sites, gas, clock) = (world.resource::<Sites>(), world.resource::<Gas>(), world.resource::<Clock>());
        let failure = match end {
            End::Failed(failure) => Some(failure.to_string()),
            _ => None,
        };
        let site_updates = clock.steps * sites.fluid_count() as u64;
        #[expect(clippy::cast_precision_loss, reason = "a figure for people")]
        let speed = site_updates as f64 / wall_s.max(f64::MIN_POSITIVE);
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a number of steps")]
        let empty_step = world.resource::<EmptyTime>().0.map(|time| time as u64);
        Self {
            format: SUMMARY_FORMAT,
            scene: loaded.source.name.clone(),
            method: "LatticeGas",
            status: end.word(),
            failure,
            steps: clock.steps,
            sites: sites.fluid_count(),
            particles: Particles { entered: gas.entered(), inside: gas.inside(), out: gas.out() },
            rest_step: world.get_resource::<RestDetector>().and_then(|rest| rest.rest_step),
            door_open_step: world.get_resource::<DoorState>().and_then(|door| door.open_step),
            empty_step,
            performance: Performance {
                wall_s,
                site_updates,
                site_updates_per_s: speed,
                peak_memory_bytes: peak_memory(),
                threads: world.resource::<Threads>().count(),
                rules: loaded.rules,
            },
            state_hash: format!("{:016x}", state_hash(sites, gas)),
        }
    }
}
