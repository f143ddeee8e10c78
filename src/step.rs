//! One step of the simulation is one run of the schedule [`Step`], whose phases are public.
//!
//! The phases follow velocity Verlet, written as kick, drift, kick. A system that writes physics belongs to the
//! phase whose job it shares; a system that only looks belongs to [`Phase::Observe`]. The first run of the
//! schedule is *step zero*: time stands still, [`Phase::Drift`] and [`Phase::Kick`] do not run, and what remains
//! evaluates the forces, so the accelerations, of the initial state and observes it.

use bevy_app::{App, Plugin};
use bevy_ecs::prelude::*;
use bevy_ecs::schedule::{LogLevel, ScheduleBuildSettings, ScheduleLabel, SingleThreadedExecutor};

/// The schedule that a simulation runs once a step.
#[derive(ScheduleLabel, Clone, Debug, PartialEq, Eq, Hash)]
pub struct Step;

/// What happens in a step, in this order.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Phase {
    /// Grains enter; the columns are renumbered when the population changed.
    Spawn,
    /// x(t+dt) and v(t+dt/2); the clock moves on. Not in step zero.
    Drift,
    /// Cells and neighbour lists, rebuilt when needed.
    Neighbours,
    /// Forces at x(t+dt), v(t+dt/2): see [`ForceStage`].
    Forces,
    /// a(t+dt), v(t+dt). Not in step zero. Where no system looks at velocities it may be put off (`store/deferred_kick.rs`).
    Kick,
    /// Rest detector, door controller.
    Control,
    /// Grains that left are counted and removed.
    Cull,
    /// Measurements and pictures. They read; they never write physics.
    Observe,
}

/// What surrounds the systems of a [`Phase`]: a chain of engine, refresh, the phase itself, and write-back. In [`Phase::Spawn`]
/// the engine, which deals out slots, comes last as well.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Part {
    /// The passes over the packed store that are the phase's job.
    Engine(Phase),
    /// Components that systems of the phase read are copied from the store.
    Refresh(Phase),
    /// Components that systems of the phase have written are copied into the store.
    WriteBack(Phase),
    /// After [`Phase::Spawn`]: slots are dealt out.
    Renumber,
    /// After that: rows of tables are brought into the order of slots.
    Sort,
    /// After all phases: messages age.
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

/// The stages of [`Phase::Forces`], in this order, which is also the order of summation in each grain.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ForceStage {
    /// Weight; then contacts between grains, and between grains and wall grains; then contacts with flat walls, in the scene's order.
    Contacts,
    /// Weight, of what has no contacts: that of grains is what their sums begin with.
    Gravity,
    /// Here a behaviour adds its own force to `Force`. Systems of one stage run in the order of registration only
    /// if they say so (`.chain()`, `.after(...)`); two that write `Force` and do not are refused as ambiguous.
    Added,
}

/// Simulated time. `time` is always `steps * dt`, so it does not gather round-off.
#[derive(Resource, Clone, Copy, Debug)]
pub struct Clock {
    /// The time step, s.
    pub dt: f64,
    /// Steps done.
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

    /// Whether a moment, in s, has come: to within a thousandth of a step, so that 0.05 s is step 50 of 1 ms.
    #[must_use]
    pub fn has_reached(&self, moment: f64) -> bool {
        self.time() >= moment - 1e-3 * self.dt
    }

    /// Whether this run of the schedule is step zero.
    #[must_use]
    pub fn is_step_zero(&self) -> bool {
        !self.started
    }

    /// Ends step zero; called by the runner after the first run.
    pub(crate) fn start(&mut self) {
        self.started = true;
    }
}

/// Run condition: time moves in this run of the schedule.
#[must_use]
pub fn time_moves(clock: Res<Clock>) -> bool {
    !clock.is_step_zero()
}

/// Run condition: this run of the schedule is step zero.
#[must_use]
pub fn is_step_zero(clock: Res<Clock>) -> bool {
    clock.is_step_zero()
}

/// A schedule on one thread, in which two systems whose order matters must have one.
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

/// The schedule, its phases and the clock.
pub struct StepPlugin {
    /// The time step, s.
    pub dt: f64,
}

/// Systems that need the time of the end of the step run after this one.
#[derive(SystemSet, Clone, Debug, PartialEq, Eq, Hash)]
pub struct ClockAdvanced;

/// Systems that act on x(t+dt) within [`Phase::Drift`] run after this set.
#[derive(SystemSet, Clone, Debug, PartialEq, Eq, Hash)]
pub struct Drifted;

impl Plugin for StepPlugin {
    fn build(&self, app: &mut App) {
        app.add_schedule(serial(Step)).insert_resource(Clock::new(self.dt));
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
            // Components are copied in step zero too: run conditions of systems are evaluated then as well.
            for phase in [Phase::Drift, Phase::Kick] {
                schedule.configure_sets((Part::Engine(phase).run_if(time_moves), phase.run_if(time_moves)));
            }
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
