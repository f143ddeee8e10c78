//! Moving walls: walls with a motion of the scene, and doors that move.
//!
//! The place of a moving wall at the end of a step follows from the time alone, and for a door from its last command. So the
//! wall has no error of integration, and a continued run places it to the same bits. A point x of the wall has the velocity
//! v + omega x (x - r), with v the velocity of its reference point r. Forces use position and velocity at the end of the step. Under the scheme
//! `Centred` springs between a grain and the wall gather the difference of their velocities in the middle of the step, so that they follow both motions.
//! Work on the grains is minus force times velocity minus torque times angular velocity (module `energy` of `siloflow`).
//!
//! The index of surfaces by place is made anew once a wall has moved by a quarter of a cell. Until then searches are wider by
//! the way of the walls.

use std::marker::PhantomData;

use bevy_app::{App, Plugin};
use bevy_ecs::prelude::*;

use crate::space::Space;
use crate::step::{Clock, ClockAdvanced, Part, Phase, Step};
use crate::store::AfterDeferredKick;
use crate::walls::free::{FreeState, FreeWall};
use crate::walls::mover::Mover;
use crate::walls::surface_index::SurfaceIndex;
use crate::walls::surfaces::Surfaces;

impl<V: Space> Surfaces<V> {
    /// Adds what moves, and places all walls for the start.
    #[must_use]
    pub fn with_movers(mut self, movers: Vec<Mover<V>>) -> Self {
        self.movers = movers;
        self.place(0.0, None);
        self.list_anew();
        self.travel = 0.0;
        self
    }

    /// Whether any wall moves.
    #[must_use]
    pub fn move_in_time(&self) -> bool {
        !self.movers.is_empty()
    }

    /// Sum over the steps of the longest way of any point of a wall in a step, m.
    #[must_use]
    pub fn travel(&self) -> f64 {
        self.travel
    }

    /// Places all moving walls for a time, s. `half` is half the step (s) where contacts take velocities predicted for its end.
    pub(super) fn place(&mut self, time: f64, half: Option<f64>) {
        let Self { all, movers, placed_at, .. } = self;
        let longest = movers.iter().map(|mover| mover.place(all, *placed_at, time, half)).fold(0.0, f64::max);
        self.placed_at = time;
        self.travel += longest;
        self.drift += longest;
        if self.drift > self.largest {
            self.list_anew();
        }
    }

    /// Makes the index of surfaces by place anew.
    pub(super) fn list_anew(&mut self) {
        if self.are_many() {
            self.index = SurfaceIndex::new(&self.all, self.largest);
        }
        self.drift = 0.0;
    }

    /// Moves the leaves of a door towards open or shut from a time on, s. Returns when they arrive, s; `None` if the door has
    /// no leaf.
    pub fn command(&mut self, number: u16, opens: bool, time: f64) -> Option<f64> {
        let mut arrival = None;
        for mover in &mut self.movers {
            arrival = mover.command(number, opens, time).or(arrival);
        }
        arrival
    }

    /// Whether a grain that was at `from` at one time and is at `to` at the other (s) has passed through a moving wall that is
    /// no door. The path is straight as seen from the wall. `coordinates` are those of free walls at the first time.
    pub fn is_moving_wall_crossed(&self, from: V, to: V, times: [f64; 2], coordinates: &[f64]) -> bool {
        let was = |place: usize| coordinates.get(place).copied().unwrap_or(0.0);
        self.movers.iter().enumerate().any(|(place, mover)| mover.is_crossed(&self.all, from, to, times, was(place)))
    }

    /// The coordinate of each mover that is a free wall, m or rad, and 0 for others; empty without free walls.
    #[must_use]
    pub fn coordinates(&self) -> Vec<f64> {
        if self.free().next().is_none() {
            return Vec::new();
        }
        self.movers.iter().map(|mover| mover.free().map_or(0.0, |(_, state)| state.coordinate)).collect()
    }

    /// The free walls with their states.
    pub fn free(&self) -> impl Iterator<Item = (&FreeWall, &FreeState)> {
        self.movers.iter().filter_map(Mover::free)
    }

    /// Moves the coordinates of free walls by a step of `dt` (s) that ends at `time`, s. [`Self::place`] places them.
    pub(super) fn drift_free(&mut self, dt: f64, time: f64, is_predicted: bool) {
        for mover in &mut self.movers {
            mover.drift_free(dt, time, is_predicted);
        }
    }

    /// Moves the rates of free walls to the end of a step of `dt` (s) by the loads of the grains, without `dt` at the start.
    ///
    /// # Errors
    /// The name of a wall that is not finite.
    pub(super) fn kick_free(&mut self, dt: Option<f64>, time: f64, gravity: V) -> Result<(), String> {
        let Self { all, movers, loads, .. } = self;
        movers.iter_mut().try_for_each(|mover| mover.kick_free(all, loads, dt, time, gravity))
    }
}

fn place_walls<V: Space>(clock: Res<Clock>, meeting: Res<Meeting>, mut walls: ResMut<Surfaces<V>>) {
    let half = (meeting.is_predicted && !clock.is_step_zero()).then_some(0.5 * clock.dt);
    // Readers of changes look for walls that come or go; the way of the walls is in `travel`.
    walls.bypass_change_detection().place(clock.time(), half);
}

/// How grains meet moving walls.
#[derive(Resource)]
pub(super) struct Meeting {
    /// Whether contacts take velocities that are predicted for the end of the step.
    pub(super) is_predicted: bool,
}

/// The set that places moving walls at x(t + dt).
#[derive(SystemSet, Clone, Debug, PartialEq, Eq, Hash)]
pub struct WallsPlaced;

/// Moves the walls.
pub struct MovingWallsPlugin<V: Space> {
    /// Whether contacts take velocities that are predicted for the end of the step, as the centred scheme does.
    pub is_predicted: bool,
    /// The space.
    pub space: PhantomData<V>,
}

impl<V: Space> Plugin for MovingWallsPlugin<V> {
    fn build(&self, app: &mut App) {
        app.insert_resource(Meeting { is_predicted: self.is_predicted });
        let place = place_walls::<V>.in_set(Part::Engine(Phase::Drift)).in_set(WallsPlaced);
        app.add_systems(Step, place.after(ClockAdvanced).after(AfterDeferredKick));
    }
}
