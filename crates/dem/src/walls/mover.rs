//! Movers: surfaces that move together, and the cause of their motion.

use serde::{Deserialize, Serialize};

use crate::space::{Linear, Space};
use crate::walls::free::{FreeState, FreeWall, Freedom};
use crate::walls::motion::{Motion, PoseInTime};
use crate::walls::pose::Pose;
use crate::walls::surface_wall::{SurfaceWall, WallGain, WallLoad};

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
#[expect(clippy::large_enum_variant, reason = "a scene has few movers")]
pub enum Drive<V: Space> {
    /// Motions of the scene. Their shifts add up, and at most one of them turns.
    Motions(Vec<Motion>),
    /// Forces.
    Free(FreeWall, FreeState),
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

/// The place of a moving door.
struct LeafPlace {
    /// Share of the way from shut to open.
    share: f64,
    is_under_way: bool,
}

impl LeafState {
    /// Returns the place of the door at a time, s. `whole` is the time of the whole way, s.
    fn at(&self, time: f64, whole: f64) -> LeafPlace {
        let way = (time - self.since).max(0.0) / whole;
        let share = if self.opens { (self.share + way).min(1.0) } else { (self.share - way).max(0.0) };
        LeafPlace { share, is_under_way: if self.opens { share < 1.0 } else { share > 0.0 } }
    }
}

impl<V: Space> Drive<V> {
    /// A free wall as it is at the start.
    #[must_use]
    pub fn free(wall: FreeWall) -> Self {
        let state = FreeState::new(&wall);
        Self::Free(wall, state)
    }

    fn at(&self, time: f64) -> PoseInTime<V> {
        match self {
            Self::Motions(motions) => {
                motions.iter().map(|motion| motion.at(time)).reduce(PoseInTime::and).unwrap_or_else(PoseInTime::still)
            }
            // Its place does not follow from the time.
            Self::Free(wall, state) => wall.pose(state.coordinate, state.shown),
            Self::Leaf { by, speed, state, .. } => {
                let LeafPlace { share, is_under_way } = state.at(time, by.length() / speed);
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
        let turns = match &self.drive {
            Drive::Motions(motions) => motions.iter().any(|motion| motion.rotate.is_some()),
            Drive::Free(wall, _) => matches!(wall.moves, Freedom::About { .. }),
            Drive::Leaf { .. } => false,
        };
        let endless = self.home.iter().filter(move |(_, wall)| turns && wall.surface.bounds().is_none());
        endless.map(|(index, _)| *index)
    }

    /// Returns the gain of the velocity of the pivot and of the spin from the middle of the step, at the time `middle` (s), to its end, at which
    /// the walls move as in `end`.
    fn gained(&self, middle: f64, end: &PoseInTime<V>) -> WallGain<V> {
        if let Drive::Free(wall, state) = &self.drive {
            let PoseInTime { velocity, spin, .. } = wall.pose(state.coordinate, state.gained());
            return WallGain { velocity, spin };
        }
        let middle = self.drive.at(middle);
        WallGain { velocity: end.velocity - middle.velocity, spin: end.spin - middle.spin }
    }

    /// Places the surfaces for the time `now`, s. Returns the longest way of one of their points since the time `before`, m. `half` is half the
    /// step (s) where contacts take velocities predicted for its end.
    pub(super) fn place(&self, all: &mut [SurfaceWall<V>], before: f64, now: f64, half: Option<f64>) -> f64 {
        let before = match &self.drive {
            Drive::Free(wall, state) => wall.pose(state.before, 0.0),
            drive => drive.at(before),
        };
        let middle = half.map(|half| now - half);
        let now = self.drive.at(now);
        let gained = middle.map(|middle| self.gained(middle, &now)).filter(|gained| !gained.is_zero());
        let turned = (now.pose.angle - before.pose.angle).abs();
        let pivot = now.pose.point(now.pose.about);
        let mut longest = 0.0f64;
        for (index, home) in &self.home {
            let wall = &mut all[*index];
            let reference = now.pose.point(home.reference);
            longest = longest.max(wall.reference.distance(reference) + turned * self.reach);
            wall.surface = home.surface.placed(&now.pose);
            wall.reference = reference;
            wall.velocity = home.velocity + now.velocity + (reference - pivot).turned_by(now.spin);
            wall.spin = home.spin + now.spin;
            if let Some(WallGain { velocity, spin }) = gained {
                let velocity = velocity + (reference - pivot).turned_by(spin);
                // A mesh has many surfaces: their boxes are kept.
                **wall.gained.get_or_insert_default() = WallGain { velocity, spin };
            } else {
                wall.gained = None;
            }
        }
        longest
    }

    /// Gives the surfaces the velocities of a free wall at a rate.
    fn set_rate(&self, all: &mut [SurfaceWall<V>], rate: f64) {
        let Drive::Free(free, state) = &self.drive else { return };
        let now = free.pose::<V>(state.coordinate, rate);
        let pivot = now.pose.point(now.pose.about);
        for (index, home) in &self.home {
            let wall = &mut all[*index];
            wall.velocity = home.velocity + now.velocity + (wall.reference - pivot).turned_by(now.spin);
            wall.spin = home.spin + now.spin;
        }
    }

    /// Moves the coordinate of a free wall by a step of `dt` (s) that ends at `time`, s.
    pub(super) fn drift_free(&mut self, dt: f64, time: f64, is_predicted: bool) {
        if let Drive::Free(wall, state) = &mut self.drive {
            state.drift(wall, dt, time, is_predicted);
        }
    }

    /// Moves the rate of a free wall to the end of a step of `dt` (s) by the loads of the grains, without `dt` at the start. Returns the name of a
    /// wall that is not finite.
    pub(super) fn kick_free(
        &mut self,
        all: &mut [SurfaceWall<V>],
        loads: &[WallLoad<V>],
        dt: Option<f64>,
        time: f64,
        gravity: V,
    ) -> Result<(), String> {
        let Drive::Free(wall, state) = &mut self.drive else { return Ok(()) };
        let mut force = 0.0;
        let mut last = None;
        for (index, _) in &self.home {
            let surface = &all[*index];
            // The load of a wall of several surfaces is about the reference point of the first.
            if last.replace(surface.number) != Some(surface.number) {
                let load = &loads[surface.number];
                force += wall.along(load.force, load.torque, surface.reference);
            }
        }
        state.kick(wall, force, dt, time, gravity);
        let rate = state.rate;
        if !state.is_finite() {
            return Err(wall.walls.clone());
        }
        self.set_rate(all, rate);
        Ok(())
    }

    /// The free wall of this mover, and its state.
    #[must_use]
    pub fn free(&self) -> Option<(&FreeWall, &FreeState)> {
        match &self.drive {
            Drive::Free(wall, state) => Some((wall, state)),
            _ => None,
        }
    }

    /// Takes over the state of a free wall.
    pub(super) fn set_free(&mut self, saved: Option<FreeState>) {
        if let (Drive::Free(_, state), Some(saved)) = (&mut self.drive, saved) {
            *state = saved;
        }
    }

    /// Moves the leaf of a door towards open or shut from a time on, s. Returns when it arrives, s; `None` if the mover is no leaf of
    /// this door.
    pub(super) fn command(&mut self, number: u16, opens: bool, time: f64) -> Option<f64> {
        match &mut self.drive {
            Drive::Leaf { door, by, speed, state } if *door == number => {
                let whole = by.length() / *speed;
                let share = state.at(time, whole).share;
                *state = LeafState { since: time, share, opens };
                Some(time + whole * if opens { 1.0 - share } else { share })
            }
            _ => None,
        }
    }

    /// Whether the mover is a motion of the scene, and a grain that was at `from` at one time and is at `to` at the other (s) has passed
    /// through one of its surfaces that are present. The path is straight as seen from the wall. A free wall was at the coordinate `was` then.
    pub(super) fn is_crossed(&self, all: &[SurfaceWall<V>], from: V, to: V, times: [f64; 2], was: f64) -> bool {
        let [before, now] = match &self.drive {
            Drive::Leaf { .. } => return false,
            Drive::Free(wall, state) => [was, state.coordinate].map(|coordinate| wall.pose(coordinate, 0.0).pose),
            drive @ Drive::Motions(_) => times.map(|time| drive.at(time).pose),
        };
        let from = before.origin_of(from);
        let to = now.origin_of(to);
        let present = self.home.iter().filter(|(index, _)| all[*index].is_present);
        present.map(|(_, wall)| &wall.surface).any(|surface| surface.crossing(from, to).is_some())
    }

    /// Returns the last command of a moving door.
    pub(super) fn leaf(&self) -> Option<LeafState> {
        match self.drive {
            Drive::Leaf { state, .. } => Some(state),
            Drive::Motions(_) | Drive::Free(..) => None,
        }
    }

    /// Takes over the last command of a moving door.
    pub(super) fn set_leaf(&mut self, saved: Option<LeafState>) {
        if let (Drive::Leaf { state, .. }, Some(saved)) = (&mut self.drive, saved) {
            *state = saved;
        }
    }
}
