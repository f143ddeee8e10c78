//! Makes the shapes of a scene, and resolves the keys of its sources that name them.

use crate::grains::shaped::{KnownShape, MadeBody, OrientationLaw, ShapeNames, Shaped, Shapes};
use crate::grains::sizes::RadiusLaw;
use crate::scene::Scene;
use crate::scene::loaded::Loaded;
use siloflow_dem::bodies::config::{MadeShape, ShapeConfig};
use siloflow_dem::bodies::{RigidShape, ShapeSphere};
use siloflow_dem::integrate::Integrator;
use siloflow_dem::space::{Dimension, Plane, Solid, Space};
use siloflow_dem::values::Positive;
use siloflow_text::fault::Fault;
use siloflow_text::suggestion::did_you_mean;

/// The keys of a source of grains that concern shapes.
struct SourceKeys<'a> {
    shape: Option<&'a ShapeNames>,
    scale: Option<&'a RadiusLaw>,
    orientation: Option<OrientationLaw>,
    radius: &'a RadiusLaw,
    /// Key of the source in the scene, such as `feed[0]`.
    key: String,
}

/// The shape and the sizes of the grains of a source, from its keys.
struct Resolved {
    shaped: Option<Shaped>,
    radius: RadiusLaw,
}

impl Loaded {
    /// Makes all shapes, and resolves the keys of all sources.
    pub(super) fn resolve_shapes(&mut self) -> Result<(), Fault> {
        self.shapes = match self.scene.space {
            Dimension::Plane => self.make_shapes::<Plane>()?,
            Dimension::Solid => self.make_shapes::<Solid>()?,
        };
        if !self.shapes.is_empty() {
            self.check_scene_of_shapes()?;
        }
        for index in 0..self.scene.fill.len() {
            let fill = &self.scene.fill[index];
            let keys = SourceKeys {
                shape: fill.shape.as_ref(),
                scale: fill.scale.as_ref(),
                orientation: fill.orientation,
                radius: &fill.radius,
                key: format!("fill[{index}]"),
            };
            let Resolved { shaped, radius } = self.resolve(&keys)?;
            (self.scene.fill[index].shaped, self.scene.fill[index].radius) = (shaped, radius);
        }
        for index in 0..self.scene.feed.len() {
            let feed = &self.scene.feed[index];
            let keys = SourceKeys {
                shape: feed.shape.as_ref(),
                scale: feed.scale.as_ref(),
                orientation: feed.orientation,
                radius: &feed.radius,
                key: format!("feed[{index}]"),
            };
            let Resolved { shaped, radius } = self.resolve(&keys)?;
            (self.scene.feed[index].shaped, self.scene.feed[index].radius) = (shaped, radius);
        }
        if let Some(spawner) = &self.scene.spawner {
            let keys = SourceKeys {
                shape: spawner.shape.as_ref(),
                scale: spawner.scale.as_ref(),
                orientation: spawner.orientation,
                radius: &spawner.radius,
                key: "spawner".to_owned(),
            };
            let Resolved { shaped, radius } = self.resolve(&keys)?;
            if let Some(spawner) = &mut self.scene.spawner {
                (spawner.shaped, spawner.radius) = (shaped, radius);
            }
        }
        Ok(())
    }

    fn make_shapes<V: Space>(&self) -> Result<Shapes, Fault> {
        let shapes = self.scene.shapes.iter().map(|(name, config)| self.make_shape::<V>(name, config));
        Ok(Shapes::new(shapes.collect::<Result<Vec<_>, _>>()?))
    }

    fn make_shape<V: Space>(&self, name: &str, config: &ShapeConfig) -> Result<MadeBody<V>, Fault> {
        let key = format!("shapes.{name}");
        let is_plain = |c: char| c.is_alphanumeric() || " _-.".contains(c);
        if name.is_empty() || name.trim() != name || !name.chars().all(is_plain) {
            return Err(self
                .fault("scene::shape", "shapes", format!("`{name}` is no name of a shape"))
                .help("use letters, digits, `_`, `-`, `.` and spaces inside: grain files have the name in a column"));
        }
        if let Some(space) = config.space().filter(|space| *space != V::DIMENSION) {
            let message = format!("this kind of shape belongs to `space: {space:?}`");
            return Err(self
                .fault("scene::dimension", &key, message)
                .help("in the plane: Discs, Ellipse, Polygon, Capsule; in solid space: Spheres, Ellipsoid, Crop, Cuboid, Mesh, Capsule"));
        }
        let refuse = |message: String| {
            self.fault("scene::shape", &key, message)
                .help("lengths are in m; a shape is a chain or cluster of spheres that overlap")
        };
        let MadeShape { spheres, deviation } = config.make().map_err(refuse)?;
        let sphere = |&(at, radius): &(Solid, f64)| ShapeSphere { at: V::narrow(at), radius };
        let spheres: Vec<_> = spheres.iter().map(sphere).collect();
        let rigid = RigidShape::new(name, &spheres).map_err(|fault| refuse(fault.to_string()))?;
        Ok(MadeBody { rigid, deviation })
    }

    /// Refuses the keys of a scene that have no meaning with shapes.
    fn check_scene_of_shapes(&self) -> Result<(), Fault> {
        let Scene { inertia, integrator, .. } = &self.scene;
        if inertia.is_some() {
            return Err(self
                .fault("scene::shape", "inertia", "moments of inertia follow from the shapes")
                .help("remove `inertia`: spheres have 2/5 m R^2, discs 1/2 m R^2"));
        }
        if matches!(integrator, Integrator::SymplecticEuler | Integrator::ExplicitEuler) {
            return Err(self
                .fault("scene::shape", "integrator", "the Euler schemes do not turn grains")
                .help("use `Centred`, the default, or `Verlet`"));
        }
        Ok(())
    }

    fn resolve(&self, keys: &SourceKeys<'_>) -> Result<Resolved, Fault> {
        let SourceKeys { shape, scale, orientation, radius, key } = keys;
        let key = |name: &str| format!("{key}.{name}");
        let has_radius = self.source.value_of(&key("radius")).is_some();
        let Some(names) = shape else {
            let stray = [("scale", scale.is_some()), ("orientation", orientation.is_some())];
            if let Some((name, _)) = stray.into_iter().find(|(_, is_given)| *is_given) {
                return Err(self
                    .fault("scene::shape", &key(name), format!("`{name}` belongs to grains with a `shape`"))
                    .help("name a shape of `shapes`, or remove this key"));
            }
            if !has_radius {
                return Err(self
                    .fault("scene::missing_key", &key("radius"), "the key `radius` is missing")
                    .help("add `radius: Fixed(...)`, in m, or `shape` with the name of a shape of `shapes`"));
            }
            return Ok(Resolved { shaped: None, radius: (*radius).clone() });
        };
        let known = names.0.iter().map(|name| self.known_shape(name, &key("shape"))).collect::<Result<Vec<_>, _>>()?;
        if has_radius && scale.is_some() {
            return Err(self
                .fault("scene::shape", &key("scale"), "`radius` and `scale` both give the size")
                .help("`scale` is relative to the shape, `radius` that of the sphere (disc) of equal volume (area), m; remove one"));
        }
        self.check_number_of_shapes(keys, known.len())?;
        let shaped = Shaped { shapes: known, orientation: orientation.unwrap_or_default() };
        let radius = if has_radius {
            (*radius).clone()
        } else {
            let scale = scale.cloned().unwrap_or_default();
            scale.times(|size| shaped.of_size(size).facts.equivalent_radius)
        };
        if let Some(OrientationLaw::Along(direction)) = orientation
            && direction.padded() == Solid::ZERO
        {
            return Err(self
                .fault("scene::zero_direction", &key("orientation"), "the direction has no length")
                .help("give a vector of any other length"));
        }
        Ok(Resolved { shaped: Some(shaped), radius })
    }

    /// Returns the shape with this name, which stands at `key`.
    fn known_shape(&self, name: &str, key: &str) -> Result<KnownShape, Fault> {
        if let Some(shape) = self.shapes.named(name) {
            return Ok(KnownShape { shape, facts: self.shapes.facts[shape.index()].clone() });
        }
        let names: Vec<_> = self.scene.shapes.keys().map(String::as_str).collect();
        let help = match &names[..] {
            [] => "the scene has no `shapes`: add them, by name".to_owned(),
            names => did_you_mean("shapes", name, names),
        };
        Err(self.fault("scene::shape", key, format!("there is no shape `{name}`")).help(help))
    }

    /// Refuses a list of shapes without a mixture of as many sizes.
    fn check_number_of_shapes(&self, keys: &SourceKeys<'_>, count: usize) -> Result<(), Fault> {
        let key = format!("{}.shape", keys.key);
        let sizes = match keys.scale.unwrap_or(keys.radius) {
            RadiusLaw::Mixture(sizes) => sizes.len(),
            _ => 1,
        };
        if count == 1 || count == sizes {
            return Ok(());
        }
        let message = format!("there are {count} shapes for {sizes} sizes");
        Err(self.fault("scene::shape", &key, message).help(
            "give a name, or a list with one name for each size of a mixture, such as `shape: [\"rice\", \"lentil\"], \
             scale: Mixture([(1.0, 0.7), (1.0, 0.3)])`: the second number is the share of grains",
        ))
    }
}

impl RadiusLaw {
    /// Returns the law with each size multiplied by the factor of its number.
    pub(super) fn times(&self, factor: impl Fn(usize) -> f64) -> Self {
        // A product that no positive number holds leaves the factor, which the rules on masses refuse.
        let times = |size: Positive, number: usize| Positive::try_from(size.get() * factor(number)).unwrap_or(size);
        match self {
            Self::Fixed(size) => Self::Fixed(times(*size, 0)),
            Self::Uniform(low, high) => Self::Uniform(times(*low, 0), times(*high, 0)),
            Self::Mixture(sizes) => {
                let sizes = sizes.iter().enumerate();
                Self::Mixture(sizes.map(|(number, (size, share))| (times(*size, number), *share)).collect())
            }
        }
    }
}
