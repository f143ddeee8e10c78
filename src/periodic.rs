//! Periodic sides: what leaves through one side of the box comes in at the other.
//!
//! Along a periodic axis with box length L every grain stands for its images at x + n L. Positions are kept in
//! low <= x < high: X < low gets +L and X >= high gets -L, once a step, after the drift (the source's algorithm 1 has
//! both signs the other way round). Two grains meet by their nearest images: the separation is shortened by L where it
//! is longer than L/2. That is unambiguous only if a grain can touch no other twice, so L must exceed twice the largest
//! distance of centres in contact; a smaller box is refused. Walls are not repeated: they must be the same in every
//! image, which `check` cannot see.
//!
//! Down a periodic incline a grain falls for ever: what is set back by L along an axis with gravity is lifted by that much
//! of potential energy, which the balance books as `lifted`.

use serde::{Deserialize, Serialize};

use crate::space::Space;
use crate::space::quad;

/// The scene's `periodic`: lower and upper end (m) of each axis that repeats itself.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct PeriodicSides {
    /// Along x.
    pub x: Option<(f64, f64)>,
    /// Along y.
    pub y: Option<(f64, f64)>,
    /// Along z.
    pub z: Option<(f64, f64)>,
}

impl PeriodicSides {
    /// By axis.
    #[must_use]
    pub fn axes(&self) -> [Option<(f64, f64)>; 3] {
        [self.x, self.y, self.z]
    }

    /// Whether no axis repeats itself.
    #[must_use]
    pub fn is_open(&self) -> bool {
        self.axes().iter().all(Option::is_none)
    }
}

/// The box, m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Periodic<V: Space> {
    /// Lower ends; minus infinity where the axis is open.
    pub low: V,
    /// Lengths; 0 where the axis is open.
    pub length: V,
    /// Upper ends; infinite where the axis is open.
    high: V,
    /// One over the lengths; 0 where the axis is open.
    inverse_length: V,
}

/// 3/2 2^52: doubles of this size are whole numbers.
const WHOLE: f64 = 6_755_399_441_055_744.0;

/// s - L round(s/L), from L and 1/L.
#[inline(always)]
fn shortest(separation: f64, length: f64, inverse_length: f64) -> f64 {
    // Where doubles are whole numbers, adding rounds: an instruction that every processor has.
    let boxes = (separation * inverse_length + WHOLE) - WHOLE;
    separation - length * boxes
}

impl<V: Space> Periodic<V> {
    /// The box of `sides`; `None` if no axis repeats itself.
    #[must_use]
    pub fn new(sides: &PeriodicSides) -> Option<Self> {
        if sides.is_open() {
            return None;
        }
        let mut periodic = Self { low: V::ZERO, length: V::ZERO, high: V::ZERO, inverse_length: V::ZERO };
        for (axis, side) in sides.axes().into_iter().take(V::COMPONENTS).enumerate() {
            let length = side.map_or(0.0, |(low, high)| high - low);
            periodic.low = periodic.low.with_axis(axis, side.map_or(f64::NEG_INFINITY, |(low, _)| low));
            periodic.length = periodic.length.with_axis(axis, length);
            periodic.high = periodic.high.with_axis(axis, side.map_or(f64::INFINITY, |(low, _)| low + length));
            periodic.inverse_length = periodic.inverse_length.with_axis(axis, side.map_or(0.0, |_| 1.0 / length));
        }
        Some(periodic)
    }

    /// The length along an axis, if that is periodic, m.
    #[must_use]
    pub fn side(&self, axis: usize) -> Option<f64> {
        let length = self.length.axis(axis);
        (length > 0.0).then_some(length)
    }

    /// The shortest of all separations that a separation of two positions in the box stands for: s - L round(s/L).
    #[inline]
    #[must_use]
    pub fn shortest(&self, mut separation: V) -> V {
        for axis in 0..V::COMPONENTS {
            let (length, inverse) = (self.length.axis(axis), self.inverse_length.axis(axis));
            separation = separation.with_axis(axis, shortest(separation.axis(axis), length, inverse));
        }
        separation
    }

    /// Whether a position is in the box.
    #[inline]
    pub(crate) fn contains(&self, position: V) -> bool {
        // Not cut short: few are outside.
        (0..V::COMPONENTS).fold(true, |inside, axis| {
            inside & (position.axis(axis) >= self.low.axis(axis)) & (position.axis(axis) < self.high.axis(axis))
        })
    }

    /// Sets a position back into the box, if it is outside: few are.
    #[inline]
    pub(crate) fn wrap(&self, position: &mut V) {
        if !self.contains(*position) {
            *position = self.wrapped(*position);
        }
    }

    /// The position in the box that a position not far outside stands for.
    #[cold]
    #[inline(never)]
    #[must_use]
    pub fn wrapped(&self, mut position: V) -> V {
        for axis in 0..V::COMPONENTS {
            let (mut x, low, high) = (position.axis(axis), self.low.axis(axis), self.high.axis(axis));
            if x < low || x >= high {
                let length = self.length.axis(axis);
                x -= length * ((x - low) / length).floor();
                // A tiny step below `low` rounds to the upper end, which is the lower one.
                if x >= high || x < low {
                    x = low;
                }
                position = position.with_axis(axis, x);
            }
        }
        position
    }

    /// The shifts (m) that give the images of a short path that starts at `from` and ends in the box: no shift, and, along each
    /// axis on which `from` lies outside the box, the side that brings it back, in all combinations. A wall stands in one image
    /// only, so a grain that comes round a side may pass it in any of these.
    pub(crate) fn shifts_of_path(&self, from: V) -> impl Iterator<Item = V> {
        let back = self.wrapped(from) - from;
        let axes: Vec<_> = (0..V::COMPONENTS).filter(|&axis| back.axis(axis) != 0.0).collect();
        (0..1usize << axes.len()).map(move |chosen| {
            let shifted = axes.iter().enumerate().filter(|(number, _)| chosen >> number & 1 == 1);
            shifted.fold(V::ZERO, |shift, (_, &axis)| shift.with_axis(axis, back.axis(axis)))
        })
    }
}

/// How separations are measured: compiled into the kernel, so that open scenes pay nothing for periodic ones.
pub trait Metric<V: Space>: Copy + Send + Sync {
    /// The shortest vector for these differences of positions, m. Four numbers: those beyond the axes are none of positions, and stay what they are.
    fn shorten(&self, differences: [f64; 4]) -> [f64; 4];
}

/// Nothing repeats itself.
#[derive(Clone, Copy, Debug)]
pub struct Open;

impl<V: Space> Metric<V> for Open {
    #[inline(always)]
    fn shorten(&self, differences: [f64; 4]) -> [f64; 4] {
        differences
    }
}

impl<V: Space> Metric<V> for Periodic<V> {
    #[inline(always)]
    fn shorten(&self, differences: [f64; 4]) -> [f64; 4] {
        // Without length, so open, where there is no axis.
        let by_axis = |of: V| quad(|axis| if axis < V::COMPONENTS { of.axis(axis) } else { 0.0 });
        let (lengths, inverse_lengths) = (by_axis(self.length), by_axis(self.inverse_length));
        quad(|axis| shortest(differences[axis], lengths[axis], inverse_lengths[axis]))
    }
}

impl<V: Space> Periodic<V> {
    /// Whether gravity acts along a periodic axis, so that setting back lifts.
    #[must_use]
    pub fn lifts(&self, gravity: V) -> bool {
        (0..V::COMPONENTS).any(|axis| self.side(axis).is_some() && gravity.axis(axis) != 0.0)
    }
}

#[cfg(test)]
#[expect(clippy::float_cmp, reason = "exact values")]
mod tests {
    use super::*;
    use crate::space::{Plane, Solid};
    use proptest::prelude::*;

    fn strip() -> Periodic<Plane> {
        Periodic::new(&PeriodicSides { x: Some((-1.0, 2.0)), ..PeriodicSides::default() }).unwrap()
    }

    #[test]
    fn an_open_axis_is_left_alone() {
        assert_eq!(strip().wrapped(Plane::new(0.5, 1e9)), Plane::new(0.5, 1e9));
        assert_eq!(strip().shortest(Plane::new(0.5, -1e9)), Plane::new(0.5, -1e9));
        assert_eq!(Periodic::<Solid>::new(&PeriodicSides::default()), None);
    }

    #[test]
    fn a_path_that_came_round_has_an_image_at_each_side_that_it_crossed() {
        let sides = PeriodicSides { x: Some((-1.0, 2.0)), y: Some((0.0, 1.0)), z: None };
        let shifts = |from| Periodic::<Plane>::new(&sides).unwrap().shifts_of_path(from).collect::<Vec<_>>();
        assert_eq!(shifts(Plane::new(0.5, 0.5)), [Plane::ZERO]);
        assert_eq!(shifts(Plane::new(-1.25, 0.5)), [Plane::ZERO, Plane::new(3.0, 0.0)]);
        let corner = [(0.0, 0.0), (-3.0, 0.0), (0.0, 1.0), (-3.0, 1.0)].map(|(x, y)| Plane::new(x, y));
        assert_eq!(shifts(Plane::new(2.25, -0.25)), corner);
    }

    proptest! {
        #[test]
        fn wrapping_stays_in_the_box_and_keeps_the_image(x in -40.0..40.0f64, tiny in 0.0..1e-16f64) {
            for x in [x, -1.0 - tiny, 2.0 - tiny] {
                let wrapped = strip().wrapped(Plane::new(x, 0.0)).x;
                prop_assert!((-1.0..2.0).contains(&wrapped), "{wrapped}");
                let images = (x - wrapped) / 3.0;
                // A few roundings of numbers up to 40.
                prop_assert!((images - images.round()).abs() < 40.0 * 4.0 * f64::EPSILON);
            }
        }

        #[test]
        fn the_shortest_separation_is_the_shortest_of_all_images(a in -1.0..2.0f64, b in -1.0..2.0f64) {
            let s = strip().shortest(Plane::new(a - b, 0.0)).x;
            for image in [-3.0, 0.0, 3.0] {
                prop_assert!(s.abs() <= (a - b + image).abs() + 1e-15);
            }
            prop_assert_eq!(strip().shortest(Plane::new(b - a, 0.0)).x, -s);
        }
    }
}
