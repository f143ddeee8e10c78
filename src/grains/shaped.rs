//! Shaped grains of a source: the keys `shape`, `scale` and `orientation` of `fill`, `feed` and `spawner`.
//!
//! A grain of a shape has a mass by the scene's law at its equivalent radius R, that of the sphere (disc) of equal volume (area). So the density of
//! `Sphere` and of `Disc` is that of the union of its spheres. Its radius is R = `scale` times that of the shape as described; a source may give
//! `radius` in place of `scale`.
//!
//! Places are free for a shaped grain if the smallest sphere about its centre of mass that holds it is free.

use std::any::Any;
use std::sync::Arc;

use serde::{Deserialize, Serialize};

use siloflow_dem::bodies::{Orientation, RigidShape, Shape, ShapeSphere};
use siloflow_dem::space::{Plane, Quaternion, Rotor, Solid, Space};
use siloflow_dem::values::FiniteVector;

/// The scene key `orientation` of a source.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize, Serialize)]
pub enum OrientationLaw {
    /// All orientations are equally likely.
    #[default]
    Random,
    /// The x axis of the shape, as described, points along this vector of any length.
    Along(FiniteVector),
}

/// A shape with what the rest of a scene needs to know, all at scale one.
#[derive(Clone, Debug)]
pub struct ShapeFacts {
    /// The name in the scene.
    pub name: String,
    /// Radius of the sphere (disc) of equal volume (area), m.
    pub equivalent_radius: f64,
    /// Radius of the smallest sphere about the centre of mass that holds the shape, m.
    pub reach: f64,
    /// Radii of the largest and the smallest sphere, m.
    pub spheres: [f64; 2],
    /// Number of spheres.
    pub count: usize,
    /// The mass over the smallest effective mass at a contact ([`RigidShape::mobility`]).
    pub mobility: f64,
    /// Turns the principal axes into the axes of the shape as described.
    pub axes: Quaternion,
}

impl ShapeFacts {
    /// The radii of the largest and the smallest sphere over the equivalent radius.
    #[must_use]
    pub fn factors(&self) -> [f64; 2] {
        self.spheres.map(|radius| radius / self.equivalent_radius)
    }

    /// Returns the reach (m) of a grain of the equivalent radius `radius`, m.
    #[must_use]
    pub fn reach_of(&self, radius: f64) -> f64 {
        radius * (self.reach / self.equivalent_radius)
    }
}

/// The shapes of a scene, in the order of their numbers.
#[derive(Debug, Default)]
pub struct Shapes {
    /// Facts of each.
    pub facts: Vec<ShapeFacts>,
    /// The shapes, if the scene is planar.
    plane: Arc<[RigidShape<Plane>]>,
    /// The shapes, if it is in solid space.
    solid: Arc<[RigidShape<Solid>]>,
}

impl Shapes {
    /// Takes over the shapes of a scene in the space `V`.
    #[must_use]
    pub fn new<V: Space>(shapes: Vec<RigidShape<V>>) -> Self {
        let facts = |shape: &RigidShape<V>| ShapeFacts {
            name: shape.name.clone(),
            equivalent_radius: shape.equivalent_radius(),
            reach: shape.bounding_radius(),
            spheres: shape.sphere_radii(),
            count: shape.spheres.len(),
            mobility: shape.mobility,
            axes: shape.axes.to_quaternion(),
        };
        let shapes: Arc<[RigidShape<V>]> = shapes.into();
        let facts = shapes.iter().map(facts).collect();
        let shapes: &dyn Any = &shapes;
        let plane = shapes.downcast_ref::<Arc<[RigidShape<Plane>]>>().cloned().unwrap_or_default();
        let solid = shapes.downcast_ref::<Arc<[RigidShape<Solid>]>>().cloned().unwrap_or_default();
        Self { facts, plane, solid }
    }

    /// Whether the scene has no shapes.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.facts.is_empty()
    }

    /// The shapes in the space of the scene; none in the other space.
    #[must_use]
    pub fn rigid<V: Space>(&self) -> Arc<[RigidShape<V>]> {
        let of_both: [&dyn Any; 2] = [&self.plane, &self.solid];
        of_both
            .into_iter()
            .find_map(|shapes| shapes.downcast_ref::<Arc<[RigidShape<V>]>>())
            .cloned()
            .unwrap_or_default()
    }

    /// The number of the shape with this name.
    #[must_use]
    pub fn named(&self, name: &str) -> Option<Shape> {
        let number = self.facts.iter().position(|facts| facts.name == name)?;
        u16::try_from(number).ok().map(Shape)
    }

    /// The spheres of a grain of this posture and equivalent radius (m): places from its centre and radii, m.
    #[must_use]
    pub fn spheres_of<V: Space>(&self, posture: &Posture, radius: f64) -> Vec<(Solid, f64)> {
        let shapes = self.rigid::<V>();
        let Some(shape) = shapes.get(posture.shape.index()) else { return Vec::new() };
        let scale = shape.scale(radius);
        let rotor = V::Rotor::of_quaternion(posture.rotor);
        let sphere = |sphere: &ShapeSphere<V>| (rotor.turn(sphere.at * scale).spread(), sphere.radius * scale);
        shape.spheres.iter().map(sphere).collect()
    }

    /// The facts of a shape.
    #[must_use]
    pub fn facts_of(&self, shape: Shape) -> Option<&ShapeFacts> {
        self.facts.get(shape.index())
    }
}

/// The shape of the grains of a source.
#[derive(Clone, Debug)]
pub struct Shaped {
    /// Its number.
    pub shape: Shape,
    /// Its facts.
    pub facts: ShapeFacts,
    /// Orientations.
    pub orientation: OrientationLaw,
}

impl PartialEq for Shaped {
    fn eq(&self, other: &Self) -> bool {
        (self.shape, self.orientation) == (other.shape, other.orientation)
    }
}

/// The shape and the orientation of a grain.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
pub struct Posture {
    /// The shape.
    pub shape: Shape,
    /// The orientation of its principal axes.
    pub rotor: Quaternion,
    /// Radius of the smallest sphere about the centre that holds the grain, m.
    pub reach: f64,
}

impl Posture {
    /// The components of a grain.
    #[must_use]
    pub fn components<V: Space>(&self) -> (Shape, Orientation<V>) {
        (self.shape, Orientation(V::Rotor::of_quaternion(self.rotor)))
    }
}

impl Shaped {
    /// Returns the reach (m) of a grain of the equivalent radius `radius`, m.
    #[must_use]
    pub fn reach(&self, radius: f64) -> f64 {
        self.facts.reach_of(radius)
    }

    /// Returns the posture of a grain of this equivalent radius (m), from three uniform random numbers.
    #[must_use]
    pub fn posture<V: Space>(&self, radius: f64, numbers: [f64; 3]) -> Posture {
        let described = match self.orientation {
            OrientationLaw::Random => V::Rotor::from_uniform(numbers).to_quaternion(),
            OrientationLaw::Along(direction) => along(direction.padded()),
        };
        Posture { shape: self.shape, rotor: described * self.facts.axes, reach: self.reach(radius) }
    }
}

/// Returns the rotation of the x axis to `direction`.
fn along(direction: Solid) -> Quaternion {
    let direction = direction.normalize_or(Solid::X);
    if direction.z == 0.0 {
        // About z, also for the opposite direction.
        return Rotor::<Plane>::to_quaternion(direction.truncate());
    }
    Quaternion::from_rotation_arc(Solid::X, direction)
}

/// Returns the factors of the largest and the smallest sphere: their radii over the radius of a grain.
#[must_use]
pub fn sphere_factors(shaped: Option<&Shaped>) -> [f64; 2] {
    shaped.map_or([1.0; 2], |shaped| shaped.facts.factors())
}
