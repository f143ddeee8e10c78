//! Shaped grains of a source: the keys `shape`, `scale` and `orientation` of `fill`, `feed` and `spawner`.
//!
//! A grain of a shape has a mass by the scene's law at its equivalent radius R, that of the sphere (disc) of equal volume (area). So the density of
//! `Sphere` and of `Disc` is that of the union of its spheres. Its radius is R = `scale` times that of the shape as described; a source may give
//! `radius` in place of `scale`.
//!
//! Places are free for a shaped grain if the smallest sphere about its centre of mass that holds it is free.

use std::any::Any;
use std::fmt;
use std::sync::Arc;

use serde::de::{self, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use crate::grains::sizes::RadiusLaw;
use siloflow_dem::bodies::makers::Deviation;
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
    /// The centre of mass in the shape as described, m.
    pub centre: Solid,
    /// The distance of the surface from the one asked for; `None` if the scene lists the spheres.
    pub deviation: Option<Deviation>,
}

/// A shape in the space `V`, as it was made.
#[derive(Clone, Debug)]
pub struct MadeBody<V: Space> {
    /// The rigid body.
    pub rigid: RigidShape<V>,
    /// The distance of its surface from the one asked for.
    pub deviation: Option<Deviation>,
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
    pub fn new<V: Space>(shapes: Vec<MadeBody<V>>) -> Self {
        let facts = |MadeBody { rigid, deviation }: &MadeBody<V>| ShapeFacts {
            name: rigid.name.clone(),
            equivalent_radius: rigid.equivalent_radius(),
            reach: rigid.bounding_radius(),
            spheres: rigid.sphere_radii(),
            count: rigid.spheres.len(),
            mobility: rigid.mobility,
            axes: rigid.axes.to_quaternion(),
            centre: rigid.centre.spread(),
            deviation: *deviation,
        };
        let facts = shapes.iter().map(facts).collect();
        let shapes: Arc<[RigidShape<V>]> = shapes.into_iter().map(|made| made.rigid).collect();
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

/// The scene key `shape` of a source: the name of a shape, or a list with one name for each size of a mixture.
#[derive(Clone, Debug, PartialEq)]
pub struct ShapeNames(pub Vec<String>);

impl Serialize for ShapeNames {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match &self.0[..] {
            [name] => serializer.serialize_str(name),
            names => names.serialize(serializer),
        }
    }
}

impl<'de> Deserialize<'de> for ShapeNames {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(NamesVisitor)
    }
}

struct NamesVisitor;

impl<'de> Visitor<'de> for NamesVisitor {
    type Value = ShapeNames;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("the name of a shape, or a list of names, one for each size of a mixture")
    }

    fn visit_str<E: de::Error>(self, name: &str) -> Result<ShapeNames, E> {
        Ok(ShapeNames(vec![name.to_owned()]))
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut sequence: A) -> Result<ShapeNames, A::Error> {
        let mut names = Vec::new();
        while let Some(name) = sequence.next_element()? {
            names.push(name);
        }
        Ok(ShapeNames(names))
    }
}

/// A shape of the scene.
#[derive(Clone, Debug)]
pub struct KnownShape {
    /// Its number.
    pub shape: Shape,
    /// Its facts.
    pub facts: ShapeFacts,
}

/// The shapes of the grains of a source.
#[derive(Clone, Debug)]
pub struct Shaped {
    /// One shape for all grains, or one for each size of a mixture.
    pub shapes: Vec<KnownShape>,
    /// Orientations.
    pub orientation: OrientationLaw,
}

impl PartialEq for Shaped {
    fn eq(&self, other: &Self) -> bool {
        let numbers = |shaped: &Self| shaped.shapes.iter().map(|known| known.shape).collect::<Vec<_>>();
        (numbers(self), self.orientation) == (numbers(other), other.orientation)
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
    /// Returns the shape of grains of size number `size` of a mixture; of all grains if there is one shape.
    #[must_use]
    pub fn of_size(&self, size: usize) -> &KnownShape {
        &self.shapes[size.min(self.shapes.len() - 1)]
    }

    /// Returns the posture of a grain of size number `size` and this equivalent radius (m), from three uniform random numbers.
    #[must_use]
    pub fn posture<V: Space>(&self, size: usize, radius: f64, numbers: [f64; 3]) -> Posture {
        let KnownShape { shape, facts } = self.of_size(size);
        let described = match self.orientation {
            OrientationLaw::Random => V::Rotor::from_uniform(numbers).to_quaternion(),
            OrientationLaw::Along(direction) => along(direction.padded()),
        };
        Posture { shape: *shape, rotor: described * facts.axes, reach: facts.reach_of(radius) }
    }
}

/// Returns the reach (m) of a grain of size number `size` and radius `radius`, m: its radius, if the source has no shapes.
#[must_use]
pub fn reach(shaped: Option<&Shaped>, size: usize, radius: f64) -> f64 {
    shaped.map_or(radius, |shaped| shaped.of_size(size).facts.reach_of(radius))
}

/// Radii of a source, m, and their shape.
#[derive(Clone, Copy, Debug)]
pub struct SizeRange<'a> {
    /// The smallest radius, m.
    pub low: f64,
    /// The largest radius, m.
    pub high: f64,
    /// The facts of the shape; `None` for spheres.
    pub facts: Option<&'a ShapeFacts>,
}

impl SizeRange<'_> {
    /// The radii of the smallest and the largest sphere, m.
    #[must_use]
    pub fn spheres(&self) -> (f64, f64) {
        let [largest, smallest] = self.facts.map_or([1.0; 2], ShapeFacts::factors);
        (self.low * smallest, self.high * largest)
    }

    /// The largest reach of a grain, m.
    #[must_use]
    pub fn reach(&self) -> f64 {
        self.facts.map_or(self.high, |facts| facts.reach_of(self.high))
    }

    /// The number of spheres of a grain.
    #[must_use]
    pub fn count(&self) -> usize {
        self.facts.map_or(1, |facts| facts.count)
    }
}

/// Returns the sizes of a source, one by one if it is a mixture.
#[must_use]
pub fn size_ranges<'a>(radius: &RadiusLaw, shaped: Option<&'a Shaped>) -> Vec<SizeRange<'a>> {
    let facts = |size: usize| shaped.map(|shaped| &shaped.of_size(size).facts);
    if let RadiusLaw::Mixture(sizes) = radius {
        let radii = sizes.iter().map(|(radius, _)| radius.get());
        return radii
            .enumerate()
            .map(|(size, radius)| SizeRange { low: radius, high: radius, facts: facts(size) })
            .collect();
    }
    let (low, high) = radius.range();
    vec![SizeRange { low, high, facts: facts(0) }]
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

/// Returns the largest reach of a grain of a source, m.
#[must_use]
pub fn largest_reach(radius: &RadiusLaw, shaped: Option<&Shaped>) -> f64 {
    size_ranges(radius, shaped).iter().map(SizeRange::reach).fold(0.0, f64::max)
}
