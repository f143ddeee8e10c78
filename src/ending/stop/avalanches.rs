//! The record of avalanches: grains that left between two clogs of one run.

use bevy_ecs::prelude::*;
use serde::{Deserialize, Serialize};

use crate::ledger::Ledger;
use siloflow_dem::persist::Problem;

/// Grains that left between two clogs.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Avalanche {
    /// Time at which the clog was found and the kick began, s.
    pub end_s: f64,
    /// Number of grains.
    pub grains: u32,
}

/// The avalanches so far, each ended by a clog and a kick.
#[derive(Resource, Clone, Debug, Default, Deserialize, Serialize)]
pub struct Avalanches {
    /// In order of time.
    pub all: Vec<Avalanche>,
    /// End of the last kick, s; may be in the future.
    pub(super) kick_end: Option<f64>,
    /// Number of grains that were out when it began.
    out_before: u32,
}

impl Avalanches {
    /// Records the end of an avalanche at `time` (s), when `out` grains were out, and the kick of `duration` (s) that begins.
    pub(super) fn record(&mut self, time: f64, duration: f64, out: u32) {
        self.all.push(Avalanche { end_s: time, grains: out - self.out_before });
        self.kick_end = Some(time + duration);
        self.out_before = out;
    }
}

/// Refuses restored avalanches of more grains than are out.
pub(super) fn check_avalanches(world: &mut World) -> Result<(), Problem> {
    let (Some(avalanches), Some(ledger)) = (world.get_resource::<Avalanches>(), world.get_resource::<Ledger>()) else {
        return Ok(());
    };
    if avalanches.out_before <= ledger.out() {
        Ok(())
    } else {
        Err("more grains left before a kick than are out".into())
    }
}
