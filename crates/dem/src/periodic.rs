//! Periodic sides: a grain that leaves the box through one side enters at the opposite side.
//!
//! Along a periodic axis with box length L, every grain stands for its images at x + n L. Positions are kept in low <=
//! x < high: X < low gets +L and X >= high gets -L, once per step, after the drift. (Algorithm 1 of Kumawat's *Soft
//! Particle Molecular Dynamic Simulation* has both signs the other way round; see `docs/explanation/soft-particle.md`.)
//!
//! Two grains interact by their nearest images: a separation longer than L/2 is shortened by L. This is unambiguous
//! only if a grain cannot touch two images of another. L must therefore exceed twice the largest distance of centres in
//! contact; a smaller box is refused. Walls are repeated as far as grains reach them ([`twins`](crate::walls::twins)).
//!
//! Down a periodic incline a grain falls for ever. Wrapping by L along an axis with gravity raises its potential
//! energy, which the energy balance records as `lifted`.

use serde::{Deserialize, Serialize};

use crate::space::Space;
use crate::space::quad;

/// The scene's `periodic`: lower and upper end (m) of each periodic axis.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct PeriodicSides {
    /// Lower and upper side along x, m.
    pub x: Option<(f64, f64)>,
    /// Lower and upper side along y, m.
    pub y: Option<(f64, f64)>,
    /// Lower and upper side along z, m.
    pub z: Option<(f64, f64)>,
}

impl PeriodicSides {
    /// The ends by axis: x, y, z.
    #[must_use]
    pub fn axes(&self) -> [Option<(f64, f64)>; 3] {
        [self.x, self.y, self.z]
    }

    /// Whether no axis is periodic.
    #[must_use]
    pub fn is_open(&self) -> bool {
        self.axes().iter().all(Option::is_none)
    }
}

/// The periodic box, m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Periodic<V: Space> {
    /// Lower ends; minus infinity where the axis is open.
    pub low: V,
    /// Side lengths; 0 where the axis is open.
    pub length: V,
    /// Upper ends; infinite where the axis is open.
    high: V,
    /// One over the lengths; 0 where the axis is open.
    inverse_length: V,
}

/// 1.5 * 2^52: doubles of this size are whole numbers.
const ROUNDING: f64 = 6_755_399_441_055_744.0;

/// Returns s - L round(s/L), from L and 1/L.
#[inline(always)]
fn shortest(separation: f64, length: f64, inverse_length: f64) -> f64 {
    // Adding a number of this size rounds to a whole number, with an instruction that every processor has.
    let boxes = (separation * inverse_length + ROUNDING) - ROUNDING;
    separation - length * boxes
}

impl<V: Space> Periodic<V> {
    /// Returns the box of `sides`; `None` if no axis is periodic.
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

    /// The box length along an axis, m; `None` if the axis is open.
    #[must_use]
    pub fn side(&self, axis: usize) -> Option<f64> {
        let length = self.length.axis(axis);
        (length > 0.0).then_some(length)
    }

    /// Returns the shortest separation between any images of two positions in the box: s - L round(s/L).
    #[inline]
    #[must_use]
    pub fn shortest(&self, mut separation: V) -> V {
        for axis in 0..V::COMPONENTS {
            let length = self.length.axis(axis);
            let inverse = self.inverse_length.axis(axis);
            separation = separation.with_axis(axis, shortest(separation.axis(axis), length, inverse));
        }
        separation
    }

    /// Returns the images of a position that may pass through sides of the box if it moves by `distance`, m, without the position itself.
    pub(crate) fn images_beyond(&self, position: V, distance: f64) -> Vec<V> {
        let is_inner = |axis| {
            let x = position.axis(axis);
            x - self.low.axis(axis) > distance && self.high.axis(axis) - x > distance
        };
        if (0..V::COMPONENTS).all(is_inner) {
            return Vec::new();
        }
        let mut images = vec![position];
        for axis in 0..V::COMPONENTS {
            let x = position.axis(axis);
            let length = self.length.axis(axis);
            let below = (x - self.low.axis(axis) <= distance).then_some(length);
            let above = (self.high.axis(axis) - x <= distance).then_some(-length);
            let so_far = images.clone();
            for shift in below.into_iter().chain(above) {
                images.extend(so_far.iter().map(|image| image.with_axis(axis, x + shift)));
            }
        }
        images.remove(0);
        images
    }

    /// Whether a position is in the box.
    #[inline]
    pub(crate) fn contains(&self, position: V) -> bool {
        // No early exit: few positions are outside.
        (0..V::COMPONENTS).fold(true, |inside, axis| {
            inside & (position.axis(axis) >= self.low.axis(axis)) & (position.axis(axis) < self.high.axis(axis))
        })
    }

    /// Wraps a position into the box, if it is outside. Few are.
    #[inline]
    pub(crate) fn wrap(&self, position: &mut V) {
        if !self.contains(*position) {
            *position = self.wrapped(*position);
        }
    }

    /// Returns the image in the box of a position that is not far outside.
    #[cold]
    #[inline(never)]
    #[must_use]
    pub fn wrapped(&self, mut position: V) -> V {
        for axis in 0..V::COMPONENTS {
            let mut x = position.axis(axis);
            let low = self.low.axis(axis);
            let high = self.high.axis(axis);
            if x < low || x >= high {
                let length = self.length.axis(axis);
                x -= length * ((x - low) / length).floor();
                // A tiny step below `low` rounds to the upper end, which stands for the lower end.
                if x >= high || x < low {
                    x = low;
                }
                position = position.with_axis(axis, x);
            }
        }
        position
    }

    /// The shifts (m) that give the images of a short path that starts at `from` and ends in the box. They are no shift
    /// and, for each axis on which `from` lies outside the box, the shift that brings it back, in all combinations. A
    /// wall of the scene stands in one image only, so a grain that crosses a side may pass the wall in any of these images.
    pub fn shifts_of_path(&self, from: V) -> impl Iterator<Item = V> {
        let back = self.wrapped(from) - from;
        let axes: Vec<_> = (0..V::COMPONENTS).filter(|&axis| back.axis(axis) != 0.0).collect();
        (0..1usize << axes.len()).map(move |chosen| {
            let shifted = axes.iter().enumerate().filter(|(number, _)| chosen >> number & 1 == 1);
            shifted.fold(V::ZERO, |shift, (_, &axis)| shift.with_axis(axis, back.axis(axis)))
        })
    }
}

/// How separations are measured. It is a type parameter of the force pass, so that open scenes have no cost of periodic
/// ones.
pub trait Metric<V: Space>: Copy + Send + Sync {
    /// Returns the shortest vector for these differences of positions, m. Numbers beyond the axes of the space are no
    /// positions, and are returned unchanged.
    fn shorten(&self, differences: [f64; 4]) -> [f64; 4];
}

/// The metric of a scene without periodic sides.
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
        // A missing axis gets length 0, like an open one.
        let by_axis = |of: V| quad(|axis| if axis < V::COMPONENTS { of.axis(axis) } else { 0.0 });
        let lengths = by_axis(self.length);
        let inverse_lengths = by_axis(self.inverse_length);
        quad(|axis| shortest(differences[axis], lengths[axis], inverse_lengths[axis]))
    }
}

impl<V: Space> Periodic<V> {
    /// Whether gravity acts along a periodic axis, so that wrapping changes the potential energy.
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

    fn strip_along_x() -> Periodic<Plane> {
        Periodic::new(&PeriodicSides { x: Some((-1.0, 2.0)), ..PeriodicSides::default() }).unwrap()
    }

    #[test]
    fn an_open_axis_is_left_alone() {
        assert_eq!(strip_along_x().wrapped(Plane::new(0.5, 1e9)), Plane::new(0.5, 1e9));
        assert_eq!(strip_along_x().shortest(Plane::new(0.5, -1e9)), Plane::new(0.5, -1e9));
        assert_eq!(Periodic::<Solid>::new(&PeriodicSides::default()), None);
    }

    #[test]
    fn a_position_near_sides_has_an_image_beyond_each() {
        let sides = PeriodicSides { x: Some((-1.0, 2.0)), y: Some((0.0, 1.0)), z: None };
        let images = |x, y| Periodic::<Plane>::new(&sides).unwrap().images_beyond(Plane::new(x, y), 0.1);
        assert_eq!(images(0.5, 0.5), []);
        assert_eq!(images(-0.95, 0.5), [Plane::new(2.05, 0.5)]);
        let mut corner = images(1.95, 0.05);
        corner.sort_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
        let expected = [Plane::new(-1.05, 0.05), Plane::new(-1.05, 1.05), Plane::new(1.95, 1.05)];
        assert!(corner.iter().zip(expected).all(|(a, b)| a.distance(b) < 1e-12) && corner.len() == 3, "{corner:?}");
    }

    #[test]
    fn a_path_has_an_image_at_each_side_that_it_crossed() {
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
                let wrapped = strip_along_x().wrapped(Plane::new(x, 0.0)).x;
                prop_assert!((-1.0..2.0).contains(&wrapped), "{wrapped}");
                let images = (x - wrapped) / 3.0;
                // Rounding errors of a few numbers up to 40.
                prop_assert!((images - images.round()).abs() < 40.0 * 4.0 * f64::EPSILON);
            }
        }

        #[test]
        fn the_shortest_separation_is_the_shortest_of_all_images(a in -1.0..2.0f64, b in -1.0..2.0f64) {
            let s = strip_along_x().shortest(Plane::new(a - b, 0.0)).x;
            for image in [-3.0, 0.0, 3.0] {
                prop_assert!(s.abs() <= (a - b + image).abs() + 1e-15);
            }
            prop_assert_eq!(strip_along_x().shortest(Plane::new(b - a, 0.0)).x, -s);
        }
    }
}
