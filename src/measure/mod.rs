//! Measurements: observers that run at intervals and at the end of the run. They never write physics.
//!
//! The times of [`observe_every`] and [`observe_at`] are predictable. So components are refreshed and kicks are made in time only for
//! steps with an observer that is due (`register_predictable` in `store/predictable_conditions.rs`). A system with any
//! other run condition counts as running in every step.

pub(crate) mod averaging;
pub mod bed;
pub mod discharge;
pub mod fields;
pub mod flow;
pub mod moment;
pub mod orientation;
pub mod outflow;
pub mod outputs;
pub mod profile;
pub mod slope;
pub mod times;
pub mod totals;
pub mod wall_bands;

use std::marker::PhantomData;

use bevy_app::{App, Plugin};
use bevy_ecs::prelude::*;

use self::times::Times;
use siloflow_dem::outcome::Outcome;
use siloflow_dem::persist::PersistApp as _;
use siloflow_dem::step::{Clock, Part, Phase, Step};
use siloflow_dem::store::{KickAppliedAtEnd, register_predictable};

/// The stages of [`Phase::Observe`], in this order.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ObserveStage {
    /// Observers measure.
    Measure,
    /// Columns that behaviours have registered are computed ([`outputs`]).
    Columns,
    /// Outputs write rows and pictures.
    Write,
}

/// Clock of the observer `T`. It is due at time 0, at its times, and in the last step of a run.
#[derive(Resource)]
pub struct Every<T> {
    times: Times,
    /// The observer is due next at this number of its finest intervals.
    next: u64,
    is_due: bool,
    observer: PhantomData<T>,
}

impl<T> Every<T> {
    #[expect(clippy::cast_precision_loss, reason = "a run has fewer than 2^53 intervals")]
    fn is_due_at(&self, clock: &Clock) -> bool {
        clock.has_reached(self.next as f64 * self.times.finest)
    }
}

#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "a run has fewer than 2^53 intervals, and time is not negative"
)]
fn tick<T: Send + Sync + 'static>(clock: Res<Clock>, outcome: Res<Outcome>, mut every: ResMut<Every<T>>) {
    let is_due = every.is_due_at(&clock);
    if is_due {
        every.next = every.times.next(((clock.time() + 1e-3 * clock.dt) / every.times.finest).floor() as u64);
    }
    every.is_due = is_due || outcome.end().is_some();
}

/// Run condition: the observer `T` is due.
#[must_use]
pub fn due<T: Send + Sync + 'static>(every: Option<Res<Every<T>>>) -> bool {
    every.is_some_and(|every| every.is_due)
}

/// Registers the clock of the observer `T` with an interval in s.
pub fn observe_every<T: Send + Sync + 'static>(app: &mut App, interval: f64) {
    observe_at::<T>(app, Times::every(interval));
}

/// Registers the clock of the observer `T`.
pub fn observe_at<T: Send + Sync + 'static>(app: &mut App, times: Times) {
    app.persist_sound_part::<Every<T>, _>(
        |every| Ok((every.next, every.is_due)),
        |every, state| {
            (every.next, every.is_due) = state;
            Ok(())
        },
    );
    app.insert_resource(Every::<T> { times, next: 0, is_due: false, observer: PhantomData })
        .add_systems(Step, tick::<T>.in_set(ClocksRead));
    register_predictable(app, due::<T>, |clock: Res<Clock>, every: Res<Every<T>>| every.is_due_at(&clock));
}

/// The set that decides which observers are due in this step, before [`Phase::Observe`].
#[derive(SystemSet, Clone, Debug, PartialEq, Eq, Hash)]
pub(crate) struct ClocksRead;

/// Adds the stages of [`Phase::Observe`].
pub struct ObservePlugin;

impl Plugin for ObservePlugin {
    fn build(&self, app: &mut App) {
        app.edit_schedule(Step, |schedule| {
            schedule.configure_sets(ClocksRead.in_set(Part::Engine(Phase::Observe)).after(KickAppliedAtEnd));
            schedule.configure_sets(
                (ObserveStage::Measure, ObserveStage::Columns, ObserveStage::Write).chain().in_set(Phase::Observe),
            );
        });
    }
}
