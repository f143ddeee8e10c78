//! A shape with its mass properties, and the components of a shaped grain.
//!
//! The spheres of a shape are kept in its principal axes, from its centre of mass. A grain has the shape at a scale, the ratio of its
//! [`Radius`](crate::particle::Radius) to [`RigidShape::equivalent_radius`].
//!
//! **Effective mass.** A force along n at the place r from the centre changes the velocity of that place along n by 1/m + (r x n) I^-1 (r x n)
//! per momentum. [`RigidShape::mobility`] is the largest value of m times this number over all places where spheres can touch: the effective mass
//! of a contact is at least m over it. For a sphere it is 1, at the end of a thin rod 4.

use std::fmt;

use bevy_ecs::prelude::*;
use serde::{Deserialize, Serialize};

use crate::bodies::disc_union::{self, Disc};
use crate::bodies::sphere_union::{self, Ball};
use crate::bodies::symmetric::Symmetric;
use crate::math;
use crate::space::{Dimension, Linear, Plane, Rotor, Solid, Space};

/// The number of a grain's shape in the scene's list of shapes. A grain without it is a sphere (disc). It counts when the grain enters, and a grain
/// keeps it.
#[derive(Component, Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Deserialize, Serialize)]
#[component(immutable)]
pub struct Shape(pub u16);

impl Shape {
    /// The place in the list of shapes.
    #[must_use]
    pub fn index(self) -> usize {
        usize::from(self.0)
    }
}

/// The orientation of a shaped grain: turns vectors in the shape's principal axes into vectors of space.
#[derive(Component, Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
#[component(summary_tick)]
#[serde(bound = "")]
pub struct Orientation<V: Space = Plane>(pub V::Rotor);

/// A sphere (disc) of a shape.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShapeSphere<V: Space = Plane> {
    /// Centre, m.
    pub at: V,
    /// Radius, m.
    pub radius: f64,
}

/// A shape: spheres that move as one rigid body.
#[derive(Clone, Debug)]
pub struct RigidShape<V: Space = Plane> {
    /// The name in the scene.
    pub name: String,
    /// The spheres, in the principal axes, from the centre of mass.
    pub spheres: Vec<ShapeSphere<V>>,
    /// Volume of the union, m^3; in the plane its area, m^2.
    pub size: f64,
    /// Principal moments of inertia over the mass, m^2.
    pub gyration: V::Principal,
    /// Turns vectors in the principal axes into vectors of the shape as it was described.
    pub axes: V::Rotor,
    /// The centre of mass in the shape as it was described, m.
    pub centre: V,
    /// The largest mass of the grain over the effective mass at a contact.
    pub mobility: f64,
    /// The unit vector, in the principal axes, by which orientations are measured; `None` if no direction stands out. It points along a long shape
    /// and across a flat one: in solid space it is the axis whose moment differs most from the middle one.
    pub director: Option<V>,
}

/// The smallest length of a shape and the largest one, m: their fifth powers, of which moments are made, are numbers with all digits.
pub const SIZES: [f64; 2] = [1e-50, 1e50];

/// Why spheres form no shape.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ShapeFault {
    /// There is none.
    Empty,
    /// There are more than [`RigidShape::MOST_SPHERES`].
    TooMany,
    /// A number of this sphere is not finite, or its radius is not positive.
    NotASphere(usize),
    /// This sphere is not within [`SIZES`].
    OutOfRange(usize),
    /// The first sphere lies inside the second.
    Inside(usize, usize),
    /// This sphere is not connected with the first one: no chain of overlapping spheres joins them.
    Apart(usize),
}

impl fmt::Display for ShapeFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Empty => write!(f, "the shape has no sphere"),
            Self::TooMany => write!(f, "the shape has more than {} spheres", RigidShape::<Plane>::MOST_SPHERES),
            Self::NotASphere(i) => {
                write!(f, "sphere {} of the shape needs a finite centre and a finite radius above zero", i + 1)
            }
            Self::OutOfRange(i) => {
                let [least, greatest] = SIZES;
                write!(
                    f,
                    "sphere {} of the shape has a radius below {least:e} m, or reaches beyond {greatest:e} m",
                    i + 1
                )
            }
            Self::Inside(i, j) => write!(f, "sphere {} of the shape lies inside sphere {}", i + 1, j + 1),
            Self::Apart(i) => {
                write!(f, "sphere {} of the shape is not connected with sphere 1 by overlapping spheres", i + 1)
            }
        }
    }
}

/// Mass properties of spheres as they are described.
struct MassProperties<V: Space> {
    size: f64,
    centre: V,
    gyration: V::Principal,
    axes: V::Rotor,
    director: Option<V>,
}

/// Least relative difference of moments by which a direction stands out.
const LEAST_DIFFERENCE: f64 = 1e-6;

/// Returns the direction along which an area with these second moments is longest.
fn long_axis(squares: Plane, mixed: f64) -> Option<Plane> {
    // The direction of twice the angle.
    let doubled = Plane::new(squares.x - squares.y, 2.0 * mixed);
    let length = Linear::length(doubled);
    if length <= LEAST_DIFFERENCE * (squares.x + squares.y) {
        return None;
    }
    let Plane { x, y } = doubled / length;
    let half = if x > 0.0 { Plane::new(1.0 + x, y) } else { Plane::new(y.abs(), (1.0 - x).copysign(y)) };
    Some(half / Linear::length(half))
}

/// Returns the axis whose moment differs most from the middle one.
fn outstanding_axis(moments: Solid) -> Option<Solid> {
    let mut order = [0, 1, 2];
    order.sort_by(|&i, &j| moments[i].total_cmp(&moments[j]));
    let [low, middle, high] = order.map(|axis| moments[axis]);
    let axis = if middle - low < high - middle { order[2] } else { order[0] };
    (high - low > LEAST_DIFFERENCE * high).then(|| Solid::ZERO.with_axis(axis, 1.0))
}

impl<V: Space> MassProperties<V> {
    fn of(spheres: &[ShapeSphere<V>]) -> Self {
        match V::DIMENSION {
            Dimension::Plane => {
                let disc =
                    |sphere: &ShapeSphere<V>| Disc { centre: sphere.at.spread().truncate(), radius: sphere.radius };
                let discs: Vec<_> = spheres.iter().map(disc).collect();
                // Moments about the centre, so that rounding stays small for discs far from the origin.
                let centre = discs[0].centre;
                let centred =
                    |centre: Plane| discs.iter().map(move |disc| Disc { centre: disc.centre - centre, ..*disc });
                let first = disc_union::moments(&centred(centre).collect::<Vec<_>>());
                let centre = centre + first.first / first.area;
                let moments = disc_union::moments(&centred(centre).collect::<Vec<_>>());
                let gyration = (moments.second.x + moments.second.y) / moments.area;
                Self {
                    size: moments.area,
                    centre: V::narrow(centre.extend(0.0)),
                    gyration: V::Principal::from_components(|_| gyration),
                    axes: V::Rotor::IDENTITY,
                    director: long_axis(moments.second, moments.mixed).map(|axis| V::narrow(axis.extend(0.0))),
                }
            }
            Dimension::Solid => {
                let ball = |sphere: &ShapeSphere<V>| Ball { centre: sphere.at.spread(), radius: sphere.radius };
                let moments = sphere_union::moments(&spheres.iter().map(ball).collect::<Vec<_>>());
                let eigen = moments.inertia.eigen();
                Self {
                    size: moments.volume,
                    centre: V::narrow(moments.centre),
                    gyration: V::Principal::from_components(|axis| eigen.values[axis]),
                    axes: V::Rotor::from_axes(eigen.vectors),
                    director: outstanding_axis(eigen.values).map(V::narrow),
                }
            }
        }
    }
}

/// Returns the first fault of the spheres.
fn fault<V: Space>(spheres: &[ShapeSphere<V>]) -> Option<ShapeFault> {
    if spheres.is_empty() {
        return Some(ShapeFault::Empty);
    }
    if spheres.len() > RigidShape::<V>::MOST_SPHERES {
        return Some(ShapeFault::TooMany);
    }
    let is_sphere = |sphere: &ShapeSphere<V>| sphere.at.is_finite() && sphere.radius.is_finite() && sphere.radius > 0.0;
    if let Some(i) = spheres.iter().position(|sphere| !is_sphere(sphere)) {
        return Some(ShapeFault::NotASphere(i));
    }
    let [least, greatest] = SIZES;
    let is_in_range =
        |sphere: &ShapeSphere<V>| sphere.radius >= least && sphere.at.length() + sphere.radius <= greatest;
    if let Some(i) = spheres.iter().position(|sphere| !is_in_range(sphere)) {
        return Some(ShapeFault::OutOfRange(i));
    }
    for (i, one) in spheres.iter().enumerate() {
        let holds = |other: &ShapeSphere<V>| one.at.distance(other.at) + one.radius <= other.radius * (1.0 + 1e-12);
        if let Some((j, _)) = spheres.iter().enumerate().find(|&(j, other)| j != i && holds(other)) {
            return Some(ShapeFault::Inside(i, j));
        }
    }
    let mut reached = vec![false; spheres.len()];
    let mut next = vec![0];
    while let Some(i) = next.pop() {
        if std::mem::replace(&mut reached[i], true) {
            continue;
        }
        let overlaps = |j: usize| spheres[i].at.distance(spheres[j].at) < spheres[i].radius + spheres[j].radius;
        next.extend((0..spheres.len()).filter(|&j| !reached[j] && overlaps(j)));
    }
    reached.iter().position(|&is_reached| !is_reached).map(ShapeFault::Apart)
}

/// Returns principal moments of which those that differ by less than 1e-8 are equal. They are known to 1e-10 only, and bodies of revolution turn
/// exactly and with half the work.
fn snapped<P: Linear>(moments: P) -> P {
    P::from_components(|axis| {
        let moment = moments.component(axis);
        let mut earlier = (0..axis).map(|axis| moments.component(axis));
        earlier.find(|earlier| (moment / earlier - 1.0).abs() < 1e-8).unwrap_or(moment)
    })
}

/// Returns the largest m (r x n) I^-1 (r x n) over all directions n, for a place r from the centre.
fn turning_mobility<V: Space>(arm: V, gyration: V::Principal) -> f64 {
    match V::DIMENSION {
        Dimension::Plane => arm.length_squared() / gyration.component(0),
        Dimension::Solid => {
            // n . A n with A = sum over axes of (e x r)(e x r)^T/I: r x n . e = n . (e x r).
            let arm = arm.spread();
            let mut matrix = Symmetric::default();
            for (axis, e) in [Solid::X, Solid::Y, Solid::Z].into_iter().enumerate() {
                let v = e.cross(arm);
                let inverse = 1.0 / gyration.component(axis);
                matrix.diagonal += v * v * inverse;
                matrix.beside += Solid::new(v.y * v.z, v.z * v.x, v.x * v.y) * inverse;
            }
            matrix.eigen().values.max_element()
        }
    }
}

impl<V: Space> RigidShape<V> {
    /// Largest number of spheres of a shape.
    pub const MOST_SPHERES: usize = 1000;

    /// Makes a shape of spheres, given in any axes.
    ///
    /// # Errors
    /// If they form no rigid body, with the reason.
    pub fn new(name: impl Into<String>, spheres: &[ShapeSphere<V>]) -> Result<Self, ShapeFault> {
        if let Some(fault) = fault(spheres) {
            return Err(fault);
        }
        let MassProperties { size, centre, gyration, axes, director } = MassProperties::<V>::of(spheres);
        let gyration = snapped(gyration);
        let in_axes = |sphere: &ShapeSphere<V>| ShapeSphere { at: axes.turn_back(sphere.at - centre), ..*sphere };
        let spheres: Vec<_> = spheres.iter().map(in_axes).collect();
        let turning = spheres.iter().map(|sphere| turning_mobility(sphere.at, gyration)).fold(0.0, f64::max);
        Ok(Self { name: name.into(), spheres, size, gyration, axes, centre, mobility: 1.0 + turning, director })
    }

    /// Returns the radius (m) of the sphere of equal volume; in the plane, of the disc of equal area.
    #[must_use]
    pub fn equivalent_radius(&self) -> f64 {
        match V::DIMENSION {
            Dimension::Plane => (self.size / std::f64::consts::PI).sqrt(),
            Dimension::Solid => math::cbrt(self.size * 0.75 / std::f64::consts::PI),
        }
    }

    /// Returns the radius (m) of the smallest sphere about the centre of mass that holds the shape.
    #[must_use]
    pub fn bounding_radius(&self) -> f64 {
        self.spheres.iter().map(|sphere| sphere.at.length() + sphere.radius).fold(0.0, f64::max)
    }

    /// Returns the radius (m) of the largest and of the smallest sphere.
    #[must_use]
    pub fn sphere_radii(&self) -> [f64; 2] {
        let radii = || self.spheres.iter().map(|sphere| sphere.radius);
        [radii().fold(0.0, f64::max), radii().fold(f64::INFINITY, f64::min)]
    }

    /// Returns the scale of a grain of this shape with the equivalent radius `radius`, m.
    #[must_use]
    pub fn scale(&self, radius: f64) -> f64 {
        radius / self.equivalent_radius()
    }

    /// Returns the inverses of the principal moments of inertia, 1/(kg m^2), of a grain of this mass (kg) at a scale.
    #[must_use]
    pub fn inverse_inertia(&self, mass: f64, scale: f64) -> V::Principal {
        V::Principal::from_components(|axis| 1.0 / (mass * scale * scale * self.gyration.component(axis)))
    }

    /// Returns the mean of the principal moments of inertia, kg m^2, of a grain of this mass (kg) and equivalent radius (m).
    #[must_use]
    pub fn mean_inertia(&self, mass: f64, radius: f64) -> f64 {
        let scale = self.scale(radius);
        #[expect(clippy::cast_precision_loss, reason = "one or three")]
        let mean = self.gyration.sum_of_components() / V::Principal::COUNT as f64;
        mass * scale * scale * mean
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::space::Quaternion;

    fn sphere(x: f64, y: f64, z: f64, radius: f64) -> ShapeSphere<Solid> {
        ShapeSphere { at: Solid::new(x, y, z), radius }
    }

    fn disc(x: f64, y: f64, radius: f64) -> ShapeSphere<Plane> {
        ShapeSphere { at: Plane::new(x, y), radius }
    }

    #[test]
    fn a_shape_of_one_sphere_is_that_sphere() {
        let shape = RigidShape::new("ball", &[sphere(1.0, 2.0, 3.0, 0.5)]).unwrap();
        assert!((shape.equivalent_radius() - 0.5).abs() < 1e-12 && (shape.bounding_radius() - 0.5).abs() < 1e-12);
        assert!((shape.gyration - Solid::splat(0.1)).length() < 1e-12 && (shape.mobility - 1.0).abs() < 1e-12);
        let shape = RigidShape::new("disc", &[disc(1.0, 2.0, 0.5)]).unwrap();
        assert!((shape.equivalent_radius() - 0.5).abs() < 1e-14 && (shape.gyration - 0.125).abs() < 1e-14);
    }

    #[test]
    fn the_end_of_a_thin_rod_has_a_quarter_of_its_mass() {
        let rod: Vec<_> = (0..200).map(|i| disc(f64::from(i) * 0.01, 0.0, 0.0100)).collect();
        let shape = RigidShape::new("rod", &rod).unwrap();
        // A rod of length L: I = m L^2/12, so 1 + (L/2)^2/(L^2/12) = 4.
        assert!((shape.mobility - 4.0).abs() < 0.1, "{}", shape.mobility);
        assert!((shape.spheres[0].at + shape.spheres[199].at).length() < 1e-12);
    }

    #[test]
    fn the_director_points_along_long_shapes_and_across_flat_ones() {
        let rod = RigidShape::new("rod", &[disc(0.0, 0.0, 1.0), disc(0.6, 0.8, 1.0)]).unwrap();
        assert!((rod.director.unwrap() - Plane::new(0.6, 0.8)).length() < 1e-12);
        let upright = RigidShape::new("rod", &[disc(0.0, 0.0, 1.0), disc(0.0, 1.0, 1.0)]).unwrap();
        assert!((upright.director.unwrap().y.abs() - 1.0).abs() < 1e-12);
        assert_eq!(RigidShape::new("disc", &[disc(0.3, 0.0, 1.0)]).unwrap().director, None);
        let along = |spheres: &[ShapeSphere<Solid>]| {
            let shape = RigidShape::new("", spheres).unwrap();
            shape.director.map(|director| shape.axes.turn(director))
        };
        let rod = along(&[sphere(0.0, 0.0, 0.0, 1.0), sphere(0.0, 0.6, 0.8, 1.0)]).unwrap();
        assert!((rod.dot(Solid::new(0.0, 0.6, 0.8)).abs() - 1.0).abs() < 1e-9);
        let ring = [
            sphere(1.0, 0.0, 0.0, 0.9),
            sphere(-0.5, 0.75_f64.sqrt(), 0.0, 0.9),
            sphere(-0.5, -0.75_f64.sqrt(), 0.0, 0.9),
        ];
        assert!((along(&ring).unwrap().z.abs() - 1.0).abs() < 1e-9);
        assert_eq!(along(&[sphere(0.0, 0.0, 0.0, 1.0)]), None);
    }

    #[test]
    fn spheres_are_kept_in_principal_axes() {
        let turn = Quaternion::from_axis_angle(Solid::new(0.6, 0.0, 0.8), 0.7);
        let straight = [sphere(-1.0, 0.0, 0.0, 0.6), sphere(0.0, 0.0, 0.0, 0.8), sphere(1.0, 0.0, 0.0, 0.6)];
        let turned = straight.map(|ball| ShapeSphere { at: turn * ball.at + Solid::new(5.0, 0.0, 1.0), ..ball });
        let shape = RigidShape::new("peanut", &turned).unwrap();
        for (own, described) in shape.spheres.iter().zip(turned) {
            assert!((shape.axes.turn(own.at) + shape.centre - described.at).length() < 1e-9);
        }
        let straight = RigidShape::new("peanut", &straight).unwrap();
        let sorted = |shape: &RigidShape<Solid>| {
            let mut moments = shape.gyration.to_array();
            moments.sort_by(f64::total_cmp);
            Solid::from_array(moments)
        };
        assert!((sorted(&shape) / sorted(&straight) - Solid::ONE).length() < 1e-8);
        assert_eq!(straight.axes, Quaternion::IDENTITY);
    }

    #[test]
    fn spheres_that_form_no_body_are_refused() {
        assert_eq!(RigidShape::<Plane>::new("", &[]).unwrap_err(), ShapeFault::Empty);
        let faults = [
            (vec![disc(0.0, 0.0, 1.0), disc(0.0, f64::NAN, 1.0)], ShapeFault::NotASphere(1)),
            (vec![disc(0.0, 0.0, -1.0)], ShapeFault::NotASphere(0)),
            (vec![disc(0.0, 0.0, 1e-60)], ShapeFault::OutOfRange(0)),
            (vec![disc(0.0, 0.0, 1.0), disc(1e60, 0.0, 1.0)], ShapeFault::OutOfRange(1)),
            (vec![disc(0.0, 0.0, 1.0), disc(0.1, 0.0, 0.5)], ShapeFault::Inside(1, 0)),
            (vec![disc(0.0, 0.0, 1.0), disc(1.0, 0.0, 1.0), disc(3.5, 0.0, 1.0)], ShapeFault::Apart(2)),
            (vec![disc(0.0, 0.0, 1.0); 1001], ShapeFault::TooMany),
        ];
        for (discs, fault) in faults {
            assert_eq!(RigidShape::new("", &discs).unwrap_err(), fault);
        }
    }
}
