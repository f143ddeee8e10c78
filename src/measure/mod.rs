//! Measurements: they look when they are due, and at the end of the run, and never write physics.
//!
//! The clock of [`observe_every`] is known beforehand: components are brought up to date, and kicks made in time, only for steps in which
//! an observer is due (`register_predictable` in `store/gates.rs`). A system with another run condition counts as looking in every step.

pub mod bed;
pub mod discharge;
pub mod flow;
pub mod profile;
pub mod totals;

use std::marker::PhantomData;

use bevy_app::{App, Plugin};
use bevy_ecs::prelude::*;

use crate::outcome::Outcome;
use crate::step::{Clock, Part, Phase, Step};
use crate::store::{KickAppliedAtEnd, register_predictable};

/// The stages of [`Phase::Observe`], in this order.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ObserveStage {
    /// What is needed is measured.
    Measure,
    /// Rows and pictures are written.
    Write,
}

/// The clock of the observer `T`: due at time 0, after every interval, and in the last step of a run.
#[derive(Resource)]
pub struct Every<T> {
    interval: f64,
    looks: u64,
    is_due: bool,
    observer: PhantomData<T>,
}

impl<T> Every<T> {
    #[expect(clippy::cast_precision_loss, reason = "2^53 looks are out of reach")]
    fn is_time(&self, clock: &Clock) -> bool {
        clock.has_reached(self.looks as f64 * self.interval)
    }
}

#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "2^53 looks are out of reach, and time is not negative"
)]
fn tick<T: Send + Sync + 'static>(clock: Res<Clock>, outcome: Res<Outcome>, mut every: ResMut<Every<T>>) {
    let is_time = every.is_time(&clock);
    if is_time {
        every.looks = (((clock.time() + 1e-3 * clock.dt) / every.interval).floor() as u64).saturating_add(1);
    }
    every.is_due = is_time || outcome.end().is_some();
}

/// Run condition: the observer `T` is due.
#[must_use]
pub fn due<T: Send + Sync + 'static>(every: Option<Res<Every<T>>>) -> bool {
    every.is_some_and(|every| every.is_due)
}

/// Registers the clock of the observer `T` with an interval in s.
pub fn observe_every<T: Send + Sync + 'static>(app: &mut App, interval: f64) {
    app.insert_resource(Every::<T> { interval, looks: 0, is_due: false, observer: PhantomData })
        .add_systems(Step, tick::<T>.in_set(Part::Engine(Phase::Observe)).after(KickAppliedAtEnd));
    register_predictable(app, due::<T>, |clock: Res<Clock>, every: Res<Every<T>>| every.is_time(&clock));
}

/// The stages.
pub struct ObservePlugin;

impl Plugin for ObservePlugin {
    fn build(&self, app: &mut App) {
        app.edit_schedule(Step, |schedule| {
            schedule.configure_sets((ObserveStage::Measure, ObserveStage::Write).chain().in_set(Phase::Observe));
        });
    }
}
