//! One step of the simulation: one run of the schedule [`Step`], with public phases.
//!
//! The phases follow velocity Verlet, written as kick, drift, kick. A system that changes physics belongs to the phase
//! with the same purpose. A system that only reads belongs to [`Phase::Observe`].
//!
//! The first run of the schedule is *step zero*. Time does not advance, and [`Phase::Drift`] and [`Phase::Kick`] do not
//! run. The other phases evaluate the forces (and so the accelerations) of the initial state and observe it.

use crate::persist::{PersistApp as _, Problem};
use bevy_app::{App, Plugin};
use bevy_ecs::prelude::*;
use bevy_ecs::schedule::{LogLevel, ScheduleBuildSettings, ScheduleLabel, SingleThreadedExecutor};
use serde::{Deserialize, Serialize};

/// The schedule that a simulation runs once per step.
#[derive(ScheduleLabel, Clone, Debug, PartialEq, Eq, Hash)]
pub struct Step;

/// The phases of a step, in their order.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Phase {
    /// Grains enter. Slots are assigned anew if the population changed.
    Spawn,
    /// Computes x(t+dt) and v(t+dt/2); the clock advances. Not in step zero.
    Drift,
    /// Rebuilds cells and neighbour lists when needed.
    Neighbours,
    /// Evaluates forces at x(t+dt), v(t+dt/2): see [`ForceStage`].
    Forces,
    /// Computes a(t+dt), v(t+dt). Not in step zero. It may be deferred if no system reads velocities
    /// (`store/deferred_kick.rs`).
    Kick,
    /// Runs the rest detector and the door controller.
    Control,
    /// Counts and removes grains that left.
    Cull,
    /// Measures and draws pictures. Systems of this phase read, and never change physics.
    Observe,
}

/// Parts of a step around the systems of a [`Phase`]. In each phase the order is engine, refresh, the phase itself,
/// write-back. Before [`Phase::Spawn`] requests of the last step are carried out; after it come renumbering and sort.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Part {
    /// Before all phases: grains come, go and change as the last step has asked for.
    Requests,
    /// The passes over the particle store that do the phase's work.
    Engine(Phase),
    /// Copies the components that systems of the phase read from the store.
    Refresh(Phase),
    /// Copies the components that systems of the phase have written to the store.
    WriteBack(Phase),
    /// After [`Phase::Spawn`]: assigns slots.
    Renumber,
    /// After `Renumber`: sorts table rows into the order of slots.
    Sort,
    /// After all phases: old messages are removed.
    End,
}

impl Phase {
    /// All phases, in the order of a step.
    pub(crate) const ALL: [Self; 8] = [
        Self::Spawn,
        Self::Drift,
        Self::Neighbours,
        Self::Forces,
        Self::Kick,
        Self::Control,
        Self::Cull,
        Self::Observe,
    ];
}

/// The stages of [`Phase::Forces`], in their order, which is also the order of summation for each grain.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ForceStage {
    /// Weight; then contacts between grains, and between grains and wall grains; then contacts with wall surfaces, in the
    /// scene's order.
    Contacts,
    /// Weight of particles without contacts. For grains the weight is the first term of the contact sums instead.
    Gravity,
    /// Behaviours add their own forces here. Systems with the parameters `AddForce`, `AddTorque` and `PairForces`
    /// ([`added_loads`](crate::added_loads)) run in the order of their behaviours' names. A system with `&mut Force` may also set it:
    /// two systems of which one has it need a declared order (`.chain()`, `.after(...)`), otherwise they are refused as ambiguous.
    Added,
}

/// Simulated time. `time` is always `steps * dt`, so it does not accumulate round-off.
#[derive(Resource, Clone, Copy, Debug, Deserialize, Serialize)]
pub struct Clock {
    /// The time step, s.
    pub dt: f64,
    /// Number of completed steps.
    pub steps: u64,
    started: bool,
}

impl Clock {
    /// A clock at time zero with the step `dt` in seconds.
    #[must_use]
    pub fn new(dt: f64) -> Self {
        Self { dt, steps: 0, started: false }
    }

    /// Simulated time, s.
    #[must_use]
    #[expect(clippy::cast_precision_loss, reason = "2^53 steps are out of reach")]
    pub fn time(&self) -> f64 {
        self.steps as f64 * self.dt
    }

    /// Whether a moment (s) has come, to within a thousandth of a step: 0.05 s is step 50 of 1 ms.
    #[must_use]
    pub fn has_reached(&self, moment: f64) -> bool {
        self.time() >= moment - 1e-3 * self.dt
    }

    /// Whether this run of the schedule is step zero.
    #[must_use]
    pub fn is_step_zero(&self) -> bool {
        !self.started
    }

    /// Ends step zero. The simulation calls it after the first run.
    pub fn start(&mut self) {
        self.started = true;
    }
}

/// Run condition: time advances in this run of the schedule.
#[must_use]
pub fn time_moves(clock: Res<Clock>) -> bool {
    !clock.is_step_zero()
}

/// Run condition: this run of the schedule is step zero.
#[must_use]
pub fn is_step_zero(clock: Res<Clock>) -> bool {
    clock.is_step_zero()
}

/// Returns a single-threaded schedule that refuses two conflicting systems without a declared order.
pub(crate) fn serial(label: impl ScheduleLabel) -> Schedule {
    let mut schedule = Schedule::new(label);
    schedule.set_executor(SingleThreadedExecutor::new());
    schedule.set_build_settings(ScheduleBuildSettings {
        ambiguity_detection: LogLevel::Error,
        ..ScheduleBuildSettings::new()
    });
    schedule
}

fn advance(mut clock: ResMut<Clock>) {
    clock.steps += 1;
}

/// Refuses a restored clock whose time does not advance.
fn check_clock(world: &mut World) -> Result<(), Problem> {
    let is_wrong = world.get_resource::<Clock>().is_some_and(|clock| clock.dt <= 0.0);
    if is_wrong { Err("its time step is not positive".to_owned()) } else { Ok(()) }
}

/// Adds the schedule, its phases and the clock.
pub struct StepPlugin {
    /// The time step, s.
    pub dt: f64,
}

/// The set that advances the clock. Systems that need the time of the step's end run after it.
#[derive(SystemSet, Clone, Debug, PartialEq, Eq, Hash)]
pub struct ClockAdvanced;

/// The set after which positions are x(t+dt). Systems of [`Phase::Drift`] that use them run after it.
#[derive(SystemSet, Clone, Debug, PartialEq, Eq, Hash)]
pub struct Drifted;

impl Plugin for StepPlugin {
    fn build(&self, app: &mut App) {
        app.add_schedule(serial(Step))
            .insert_resource(Clock::new(self.dt))
            .persist_sound::<Clock>()
            .check_restored(check_clock);
        app.edit_schedule(Step, |schedule| {
            let mut last = None;
            for phase in Phase::ALL {
                let chain = (Part::Engine(phase), Part::Refresh(phase), phase, Part::WriteBack(phase)).chain();
                schedule.configure_sets(match last {
                    None => chain,
                    Some(before) => chain.after(Part::WriteBack(before)),
                });
                last = Some(phase);
            }
            // Components are synced in step zero too, because run conditions are evaluated even then.
            for phase in [Phase::Drift, Phase::Kick] {
                schedule.configure_sets((Part::Engine(phase).run_if(time_moves), phase.run_if(time_moves)));
            }
            schedule.configure_sets(Part::Requests.before(Part::Engine(Phase::Spawn)));
            let renumber = (Part::Renumber, Part::Sort).chain();
            let renumber = renumber.after(Part::WriteBack(Phase::Spawn)).before(Part::Engine(Phase::Drift));
            schedule.configure_sets((renumber, Part::End.after(Part::WriteBack(Phase::Observe))));
            schedule.configure_sets(
                (ForceStage::Contacts, ForceStage::Gravity).chain().in_set(Part::Engine(Phase::Forces)),
            );
            schedule.configure_sets(ForceStage::Added.in_set(Phase::Forces));
        });
        app.add_systems(Step, advance.in_set(Part::Engine(Phase::Drift)).in_set(ClockAdvanced));
    }
}
