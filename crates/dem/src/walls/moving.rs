//! Moving walls: walls with a motion of the scene, and doors that move.
//!
//! The place of a moving wall at the end of a step follows from the time alone, and for a door from its last command. So the
//! wall has no error of integration, and a continued run places it to the same bits. A point x of the wall has the velocity
//! v + omega x (x - r), with v the velocity of its reference point r. Forces use position and velocity at the end of the step.
//! Work on the grains is minus force times velocity minus torque times angular velocity (module `energy` of `siloflow`).
//!
//! The index of surfaces by place is made anew once a wall has moved by a quarter of a cell. Until then searches are wider by
//! the way of the walls.

use std::marker::PhantomData;

use bevy_app::{App, Plugin};
use bevy_ecs::prelude::*;
use serde::{Deserialize, Serialize};

use crate::space::{Linear, Space};
use crate::step::{Clock, ClockAdvanced, Part, Phase, Step};
use crate::store::AfterDeferredKick;
use crate::walls::motion::{Motion, PoseInTime};
use crate::walls::pose::Pose;
use crate::walls::shapes::Shape as _;
use crate::walls::surface_index::SurfaceIndex;
use crate::walls::surfaces::{SurfaceWall, Surfaces};

/// Walls that move together.
#[derive(Clone, Debug)]
pub struct Mover<V: Space> {
    /// The surfaces at their places in the scene, each with its index in [`Surfaces::all`].
    home: Vec<(usize, SurfaceWall<V>)>,
    drive: Drive<V>,
    /// Largest distance of a point of a surface with bounds from the reference point of that surface, m.
    reach: f64,
}

/// The cause of the motion of a [`Mover`].
#[derive(Clone, Debug)]
pub enum Drive<V: Space> {
    /// A motion of the scene.
    Motion(Motion),
    /// A door that moves between shut and open.
    Leaf {
        /// Number of the door.
        door: u16,
        /// Shift from shut to open, m.
        by: V,
        /// Speed, m/s.
        speed: f64,
        /// The present command.
        state: LeafState,
    },
}

/// The last command of a moving door.
#[derive(Clone, Copy, Debug, Default, Deserialize, Serialize)]
pub struct LeafState {
    /// Time of the command, s.
    since: f64,
    /// Share of the way to the open place at that time.
    share: f64,
    /// Whether the door opens.
    opens: bool,
}

impl LeafState {
    /// Returns the share of the way at a time (s), and whether the door is under way. `whole` is the time of the whole way, s.
    fn at(&self, time: f64, whole: f64) -> (f64, bool) {
        let way = (time - self.since).max(0.0) / whole;
        let share = if self.opens { (self.share + way).min(1.0) } else { (self.share - way).max(0.0) };
        (share, if self.opens { share < 1.0 } else { share > 0.0 })
    }
}

impl<V: Space> Drive<V> {
    fn at(&self, time: f64) -> PoseInTime<V> {
        match self {
            Self::Motion(motion) => motion.at(time),
            Self::Leaf { by, speed, state, .. } => {
                let (share, is_under_way) = state.at(time, by.length() / speed);
                let rate = match (is_under_way, state.opens) {
                    (false, _) => 0.0,
                    (true, true) => *speed,
                    (true, false) => -*speed,
                };
                PoseInTime { pose: Pose::shifted(*by * share), velocity: by.unit_or_zero() * rate, spin: V::Spin::ZERO }
            }
        }
    }
}

impl<V: Space> Mover<V> {
    /// Takes the walls at their places in the scene, each with its index among all surfaces.
    pub fn new(home: Vec<(usize, SurfaceWall<V>)>, drive: Drive<V>) -> Self {
        let corners = |wall: &SurfaceWall<V>| {
            let [low, high] = wall.surface.bounds().unwrap_or([wall.reference; 2]);
            V::from_components(|axis| {
                (high - wall.reference).axis(axis).abs().max((low - wall.reference).axis(axis).abs())
            })
            .length()
        };
        let reach = home.iter().map(|(_, wall)| corners(wall)).fold(0.0, f64::max);
        Self { home, drive, reach }
    }

    /// Iterates over the surfaces without ends that turn: a point of them far away moves by any distance in a step.
    pub(super) fn endless_that_turn(&self) -> impl Iterator<Item = usize> {
        let turns = matches!(&self.drive, Drive::Motion(Motion { rotate: Some(_), .. }));
        let endless = self.home.iter().filter(move |(_, wall)| turns && wall.surface.bounds().is_none());
        endless.map(|(index, _)| *index)
    }

    pub(super) fn leaf(&self) -> Option<LeafState> {
        match self.drive {
            Drive::Leaf { state, .. } => Some(state),
            Drive::Motion(_) => None,
        }
    }

    pub(super) fn set_leaf(&mut self, saved: Option<LeafState>) {
        if let (Drive::Leaf { state, .. }, Some(saved)) = (&mut self.drive, saved) {
            *state = saved;
        }
    }
}

impl<V: Space> Surfaces<V> {
    /// Adds what moves, and places all walls for the start.
    #[must_use]
    pub fn with_movers(mut self, movers: Vec<Mover<V>>) -> Self {
        self.movers = movers;
        self.place(0.0);
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

    /// Places all moving walls for a time, s.
    pub(super) fn place(&mut self, time: f64) {
        let Self { all, movers, .. } = self;
        let mut longest = 0.0f64;
        for mover in movers {
            let before = mover.drive.at(self.placed_at);
            let now = mover.drive.at(time);
            let turned = (now.pose.angle - before.pose.angle).abs();
            let pivot = now.pose.point(now.pose.about);
            for (index, home) in &mover.home {
                let wall = &mut all[*index];
                let reference = now.pose.point(home.reference);
                longest = longest.max(wall.reference.distance(reference) + turned * mover.reach);
                wall.surface = home.surface.placed(&now.pose);
                wall.reference = reference;
                wall.velocity = home.velocity + now.velocity + (reference - pivot).turned_by(now.spin);
                wall.spin = home.spin + now.spin;
            }
        }
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
            if let Drive::Leaf { door, by, speed, state } = &mut mover.drive
                && *door == number
            {
                let whole = by.length() / *speed;
                let share = state.at(time, whole).0;
                *state = LeafState { since: time, share, opens };
                arrival = Some(time + whole * if opens { 1.0 - share } else { share });
            }
        }
        arrival
    }

    /// Whether a grain that was at `from` at one time and is at `to` at the other (s) has passed through a moving wall that is
    /// no door. The path is straight as seen from the wall.
    pub fn is_moving_wall_crossed(&self, from: V, to: V, times: [f64; 2]) -> bool {
        let motions = self.movers.iter().filter(|mover| matches!(mover.drive, Drive::Motion(_)));
        let mut motions = motions.map(|mover| {
            let [before, now] = times.map(|time| mover.drive.at(time).pose);
            (mover, before.origin_of(from), now.origin_of(to))
        });
        motions.any(|(mover, from, to)| {
            let present = mover.home.iter().filter(|(index, _)| self.all[*index].is_present);
            present.map(|(_, wall)| &wall.surface).any(|surface| surface.crossing(from, to).is_some())
        })
    }
}

fn place_walls<V: Space>(clock: Res<Clock>, mut walls: ResMut<Surfaces<V>>) {
    // Readers of changes look for walls that come or go; the way of the walls is in `travel`.
    walls.bypass_change_detection().place(clock.time());
}

/// The set that places moving walls at x(t + dt).
#[derive(SystemSet, Clone, Debug, PartialEq, Eq, Hash)]
pub struct WallsPlaced;

/// Moves the walls.
pub struct MovingWallsPlugin<V: Space>(pub PhantomData<V>);

impl<V: Space> Plugin for MovingWallsPlugin<V> {
    fn build(&self, app: &mut App) {
        let place = place_walls::<V>.in_set(Part::Engine(Phase::Drift)).in_set(WallsPlaced);
        app.add_systems(Step, place.after(ClockAdvanced).after(AfterDeferredKick));
    }
}
