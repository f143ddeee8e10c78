//! The scene key `motions`: walls that translate, rotate, oscillate or follow a table.
//!
//! With tau = min(max(t, from), until) - from, a course is
//!
//! | course | value | rate |
//! |---|---|---|
//! | `Steady(r)` | r tau | r |
//! | `Oscillate` | a (sin(2 pi f tau + p) - sin p) | 2 pi f a cos(2 pi f tau + p) |
//! | `Table` | the curve of the table at tau ([`table`]) | its slope |
//!
//! Several entries of one wall add their shifts up; at most one of them turns it.
//!
//! `translate` gives a shift in m, `rotate` an angle in rad about an axis. The axis moves with the shift. Before `from` and after
//! `until` the wall rests; a motion that begins or ends with a rate other than zero does so at once, as a driven wall does.

pub mod table;

use std::f64::consts::TAU;
use std::path::PathBuf;
use std::sync::Arc;

use serde::{Deserialize, Serialize};

use self::table::{Curve, InTime};
use crate::math;
use crate::space::{Linear as _, Solid, Space};
use crate::values::{Finite, FiniteVector, NonNegative, Positive};
use crate::walls::pose::Pose;

/// One entry of the scene key `motions`.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Motion {
    /// The `name` of the walls that move.
    pub walls: String,
    /// Shift by a velocity, an oscillation or a table.
    #[serde(default)]
    pub translate: Option<Course<FiniteVector>>,
    /// Rotation about an axis, which moves along with the shift.
    #[serde(default)]
    pub rotate: Option<Turn>,
    /// When the motion begins, s. Default 0.
    #[serde(default)]
    pub from: Option<NonNegative>,
    /// When the motion ends, s. Default: never.
    #[serde(default)]
    pub until: Option<NonNegative>,
}

/// A rotation about an axis.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Turn {
    /// A point of the axis, m.
    pub about: FiniteVector,
    /// Direction of the axis, of any non-zero length, in solid space; in the plane the axis points to the reader.
    #[serde(default)]
    pub axis: Option<FiniteVector>,
    /// Angle by an angular velocity, an oscillation or a table; positive by the right-hand rule.
    pub by: Course<Finite>,
}

/// How a shift or an angle changes in time.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
pub enum Course<T> {
    /// At a constant rate, m/s or rad/s.
    Steady(T),
    /// In a sine about the place in the scene, from which it starts.
    Oscillate {
        /// Amplitude, m or rad.
        amplitude: T,
        /// Frequency, Hz.
        frequency: Positive,
        /// Phase at the start, rad. Default 0.
        #[serde(default)]
        phase: Option<Finite>,
    },
    /// Along the rows of a CSV file.
    Table {
        /// Path of the file, relative to the scene file. Its columns are `time_s`, then the components of the shift, m, or the angle, rad.
        file: PathBuf,
        /// The curve; read from the file after the scene.
        #[serde(skip)]
        curve: Arc<Curve>,
    },
}

/// A number of values that a course changes.
pub trait Values {
    /// The values padded with zeros.
    fn padded_values(&self) -> Solid;
}

impl Values for FiniteVector {
    fn padded_values(&self) -> Solid {
        self.padded()
    }
}

impl Values for Finite {
    fn padded_values(&self) -> Solid {
        Solid::new(self.get(), 0.0, 0.0)
    }
}

impl<T: Values> Course<T> {
    /// Returns the values after `tau` (s), and their rates (1/s).
    fn at(&self, tau: f64) -> InTime<Solid> {
        match self {
            Self::Steady(rate) => InTime { value: rate.padded_values() * tau, rate: rate.padded_values() },
            Self::Oscillate { amplitude, frequency, phase } => {
                let amplitude = amplitude.padded_values();
                let pulse = TAU * frequency.get();
                let phase = phase.map_or(0.0, Finite::get);
                let (sine, cosine) = math::sincos(pulse * tau + phase);
                InTime { value: amplitude * (sine - math::sin(phase)), rate: amplitude * (pulse * cosine) }
            }
            Self::Table { curve, .. } => {
                let InTime { value, rate } = curve.at(tau);
                InTime { value: value.into(), rate: rate.into() }
            }
        }
    }

    /// Returns the lowest and the highest values up to `tau`, s.
    fn range(&self, tau: f64) -> [Solid; 2] {
        let [one, other] = match self {
            Self::Steady(rate) => [Solid::ZERO, rate.padded_values() * tau],
            Self::Oscillate { amplitude, phase, .. } => {
                let amplitude = amplitude.padded_values();
                let start = math::sin(phase.map_or(0.0, Finite::get));
                [amplitude * (-1.0 - start), amplitude * (1.0 - start)]
            }
            Self::Table { curve, .. } => curve.range().map(Solid::from),
        };
        [one.min(other), one.max(other)]
    }

    /// Returns the largest rate, 1/s.
    fn fastest(&self) -> f64 {
        match self {
            Self::Steady(rate) => rate.padded_values().length(),
            Self::Oscillate { amplitude, frequency, .. } => TAU * frequency.get() * amplitude.padded_values().length(),
            Self::Table { curve, .. } => curve.fastest(),
        }
    }
}

/// A table of a motion.
#[derive(Debug)]
pub struct Table<'a> {
    /// The key of its file, within the motion.
    pub key: &'static str,
    /// Path of the file, relative to the scene file.
    pub file: &'a PathBuf,
    /// The curve that the rows make.
    pub curve: &'a mut Arc<Curve>,
    /// Number of values in a row.
    pub values: usize,
}

/// Pose of a wall and its rate of change.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PoseInTime<V: Space> {
    pub(crate) pose: Pose<V>,
    /// Velocity of the point about which the wall turns, m/s.
    pub(crate) velocity: V,
    /// Angular velocity, rad/s.
    pub(crate) spin: V::Spin,
}

impl<V: Space> PoseInTime<V> {
    /// A wall at its place in the scene, at rest.
    pub(crate) fn still() -> Self {
        Self { pose: Pose::shifted(V::ZERO), velocity: V::ZERO, spin: V::Spin::ZERO }
    }

    /// The sum of two motions, of which at most one turns.
    pub(crate) fn and(self, other: Self) -> Self {
        let turning = if other.pose.axis == V::Spin::ZERO { self } else { other };
        let shift = self.pose.shift + other.pose.shift;
        Self { pose: Pose { shift, ..turning.pose }, velocity: self.velocity + other.velocity, spin: turning.spin }
    }
}

impl Motion {
    /// Returns the pose at a time, s.
    pub(crate) fn at<V: Space>(&self, time: f64) -> PoseInTime<V> {
        let from = self.from.map_or(0.0, NonNegative::get);
        let until = self.until.map_or(f64::INFINITY, NonNegative::get).max(from);
        let tau = time.clamp(from, until) - from;
        let is_under_way = (from..until).contains(&time);
        let rate = |rate: Solid| if is_under_way { rate } else { Solid::ZERO };
        let shift = self.translate.as_ref().map_or_else(Default::default, |course| course.at(tau));
        let mut motion = PoseInTime {
            pose: Pose::shifted(V::narrow(shift.value)),
            velocity: V::narrow(rate(shift.rate)),
            spin: V::Spin::ZERO,
        };
        if let Some(turn) = &self.rotate {
            let axis = turn.axis.map_or(Solid::Z, FiniteVector::padded).unit_or_zero();
            let angle = turn.by.at(tau);
            motion.pose.about = V::narrow(turn.about.padded());
            motion.pose.axis = V::narrow_spin(axis);
            motion.pose.angle = angle.value.x;
            motion.spin = V::narrow_spin(rate(axis * angle.rate.x));
        }
        motion
    }

    /// Returns the lowest and the highest components of the shift up to the time `end` (s), m.
    #[must_use]
    pub fn shifts(&self, end: f64) -> [Solid; 2] {
        let from = self.from.map_or(0.0, NonNegative::get);
        let tau = (self.until.map_or(end, |until| until.get().min(end)) - from).max(0.0);
        self.translate.as_ref().map_or([Solid::ZERO; 2], |course| course.range(tau))
    }

    /// Returns the largest speed of a point at most `reach` (m) from the axis, m/s.
    #[must_use]
    pub fn fastest(&self, reach: f64) -> f64 {
        self.translate.as_ref().map_or(0.0, Course::fastest)
            + self.rotate.as_ref().map_or(0.0, |turn| turn.by.fastest() * reach)
    }

    /// Returns the tables of the motion: of a shift in a space with `components`, and of an angle.
    pub fn tables(&mut self, components: usize) -> impl Iterator<Item = Table<'_>> {
        let shift = match &mut self.translate {
            Some(Course::Table { file, curve }) => {
                Some(Table { key: "translate.file", file, curve, values: components })
            }
            _ => None,
        };
        let angle = match &mut self.rotate {
            Some(Turn { by: Course::Table { file, curve }, .. }) => {
                Some(Table { key: "rotate.by.file", file, curve, values: 1 })
            }
            _ => None,
        };
        shift.into_iter().chain(angle)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::space::Plane;

    fn motion(text: &str) -> Motion {
        ron::Options::default()
            .with_default_extension(ron::extensions::Extensions::IMPLICIT_SOME)
            .from_str(text)
            .unwrap()
    }

    #[test]
    fn the_velocity_is_the_slope_of_the_path_of_a_point() {
        let motion = motion(
            "(walls: \"drum\", translate: Oscillate(amplitude: (0.1, 0.0, -0.2), frequency: 3.0, phase: 0.4),
              rotate: (about: (0.1, 0.2, 0.3), axis: (1.0, 2.0, -1.0), by: Steady(2.5)), from: 0.5, until: 2.0)",
        );
        let x = Solid::new(0.3, -0.7, 1.1);
        let step = 1e-6;
        for time in [0.2, 0.6, 1.3, 1.99, 2.5] {
            let [before, here, after] = [time - step, time, time + step].map(|time| motion.at::<Solid>(time));
            let slope = (after.pose.point(x) - before.pose.point(x)) / (2.0 * step);
            let arm = here.pose.point(x) - here.pose.point(here.pose.about);
            let velocity = here.velocity + arm.turned_by(here.spin);
            // The third derivative is below (6 pi)^3 0.3 + 2.5^3 2 = 2100 m/s^3; times step^2/6.
            assert!((slope - velocity).length() < 1e-8, "{time}: {slope} {velocity}");
            assert!(velocity.length() <= motion.fastest(2.0), "{time}");
        }
    }

    #[test]
    fn a_motion_rests_before_and_after() {
        let motion = motion("(walls: \"lid\", translate: Steady((0.0, -2.0)), from: 1.0, until: 3.0)");
        for (time, height, velocity) in [(0.0, 0.0, 0.0), (2.0, -2.0, -2.0), (3.0, -4.0, 0.0), (9.0, -4.0, 0.0)] {
            let found = motion.at::<Plane>(time);
            assert_eq!((found.pose.shift.y, found.velocity.y), (height, velocity), "{time}");
        }
        assert_eq!(motion.shifts(2.0), [Solid::new(0.0, -2.0, 0.0), Solid::ZERO]);
        assert_eq!(motion.shifts(9.0), [Solid::new(0.0, -4.0, 0.0), Solid::ZERO]);
    }
}
