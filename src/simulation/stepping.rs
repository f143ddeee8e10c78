//! The steps of a simulation.

use std::sync::Arc;
use std::sync::atomic::AtomicUsize;

use bevy_ecs::prelude::*;

use crate::ending::request::StopRequest;
use crate::output::checkpoint;
use crate::simulation::Simulation;
use siloflow_dem::outcome::{End, Outcome};
use siloflow_dem::step::{Clock, Step};
use siloflow_dem::store;
use siloflow_dem::threads::Threads;

impl Simulation {
    /// Runs step zero if it has not run, else one step. Returns the end of the run once there is one; from then on it
    /// does nothing.
    ///
    /// For many steps, [`Simulation::run_steps`] is faster, because this function refreshes all components after each
    /// step.
    pub fn step(&mut self) -> Option<End> {
        let end = self.advance_while(|_| false);
        self.refresh();
        end
    }

    /// Steps until the run ends or `each` returns false. `each` receives the world after every step, with components
    /// that may be out of date.
    pub(crate) fn advance_while(&mut self, mut each: impl FnMut(&mut World) -> bool + Send) -> Option<End> {
        Threads::run(&mut self.world, |world| {
            loop {
                let end = advance(world);
                if !each(world) || end.is_some() {
                    return end;
                }
            }
        })
    }

    /// Ends the run with [`End::Interrupted`] once `flag` holds a number other than zero. The flag is read before each step
    /// after step zero, and that step is then the last one. Signal handlers and other threads may set it.
    pub fn stop_on(&mut self, flag: Arc<AtomicUsize>) {
        self.world.resource_mut::<StopRequest>().watch(flag);
    }

    /// Runs step zero, if no step has run yet. Returns the end of the run, if it has ended.
    pub(crate) fn step_zero(&mut self) -> Option<End> {
        if self.world().resource::<Clock>().is_step_zero() {
            return self.advance_while(|_| false);
        }
        self.world().resource::<Outcome>().end().cloned()
    }

    /// Steps until the run ends. `each` receives the world after every step, with components that may be out of date.
    pub(crate) fn advance_to_end(&mut self, mut each: impl FnMut(&mut World) + Send) -> End {
        loop {
            let continues = |world: &mut World| {
                each(world);
                true
            };
            if let Some(end) = self.advance_while(continues) {
                return end;
            }
        }
    }

    /// Refreshes all components, for a caller from outside.
    fn refresh(&mut self) {
        store::complete_world(&mut self.world);
    }

    /// Steps until the run ends.
    pub fn run(&mut self) -> End {
        let end = self.advance_to_end(|_| {});
        self.refresh();
        end
    }

    /// Steps until the clock shows `steps` steps, or the run ends.
    pub fn run_steps(&mut self, steps: u64) -> Option<End> {
        let continues = |world: &World| {
            let clock = world.resource::<Clock>();
            clock.is_step_zero() || clock.steps < steps
        };
        if !continues(self.world()) {
            return self.world().resource::<Outcome>().end().cloned();
        }
        let end = self.advance_while(|world| continues(world));
        self.refresh();
        end
    }
}

/// Runs step zero if it has not run, else one step. Returns the end of the run once there is one; from then on it does
/// nothing.
fn advance(world: &mut World) -> Option<End> {
    if world.resource::<Outcome>().end().is_none() {
        world.resource_mut::<StopRequest>().read();
        store::collect_from_world(world);
        checkpoint::at_border(world);
        world.run_schedule(Step);
        world.resource_mut::<Clock>().start();
        world.clear_trackers();
        world.check_change_ticks();
    }
    world.resource::<Outcome>().end().cloned()
}
