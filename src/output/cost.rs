//! The cost of a run so far. It is saved with checkpoints, so that a resumed run reports its whole cost.

use std::time::Instant;

use bevy_app::{App, Plugin};
use bevy_ecs::prelude::*;

use crate::output::summary::Cost;
use siloflow_dem::persist::PersistApp as _;

/// The cost of a run so far.
#[derive(Resource)]
pub struct RunCost {
    /// Wall-clock time of the steps before the run was resumed, s.
    before_s: f64,
    since: Instant,
    /// Number of updates: of particles, or of sites of the lattice gas.
    pub updates: u64,
}

impl RunCost {
    /// Counts wall-clock time from now on, in addition to the time until [`RunCost::pause`].
    pub fn resume(&mut self) {
        self.since = Instant::now();
    }

    /// Ends a count of wall-clock time.
    pub fn pause(&mut self) {
        self.before_s = self.wall_s();
        self.resume();
    }

    /// Wall-clock time of the steps so far, s.
    #[must_use]
    pub fn wall_s(&self) -> f64 {
        self.before_s + self.since.elapsed().as_secs_f64()
    }

    /// The cost until now.
    #[must_use]
    pub fn cost(&self) -> Cost {
        Cost { wall_s: self.wall_s(), updates: self.updates }
    }
}

/// Counts the cost of a run.
pub struct CostPlugin;

impl Plugin for CostPlugin {
    fn build(&self, app: &mut App) {
        app.insert_resource(RunCost { before_s: 0.0, since: Instant::now(), updates: 0 });
        app.persist_sound_part::<RunCost, _>(
            |cost| Ok((cost.wall_s(), cost.updates)),
            |cost, saved| {
                (cost.before_s, cost.updates) = saved;
                Ok(())
            },
        );
    }
}
