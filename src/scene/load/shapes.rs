//! Makes the shapes of a scene, and resolves the keys of its sources that name them.

use crate::grains::shaped::{OrientationLaw, Shaped, Shapes};
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
    shape: Option<&'a str>,
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
                shape: fill.shape.as_deref(),
                scale: fill.scale.as_ref(),
                orientation: fill.orientation,
                radius: &fill.radius,
                key: format!("fill[{index}]"),
            };
            let Resolved { shaped, radius } = self.resolve(&keys)?;
            if shaped.is_some() && fill.fixed {
                return Err(self
                    .fault("scene::shape", &format!("fill[{index}].fixed"), "fixed grains of a fill are spheres")
                    .help("leave out `shape`, or `fixed`; a behaviour may fix shaped grains with `Fixed`"));
            }
            (self.scene.fill[index].shaped, self.scene.fill[index].radius) = (shaped, radius);
        }
        for index in 0..self.scene.feed.len() {
            let feed = &self.scene.feed[index];
            let keys = SourceKeys {
                shape: feed.shape.as_deref(),
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
                shape: spawner.shape.as_deref(),
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

    fn make_shape<V: Space>(&self, name: &str, config: &ShapeConfig) -> Result<RigidShape<V>, Fault> {
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
                .help("in the plane: Discs, Ellipse, Capsule; in solid space: Spheres, Ellipsoid, Capsule"));
        }
        let refuse = |message: String| {
            self.fault("scene::shape", &key, message)
                .help("lengths are in m; a shape is a chain or cluster of spheres that overlap")
        };
        let MadeShape { spheres, .. } = config.make().map_err(refuse)?;
        let sphere = |&(at, radius): &(Solid, f64)| ShapeSphere { at: V::narrow(at), radius };
        let spheres: Vec<_> = spheres.iter().map(sphere).collect();
        RigidShape::new(name, &spheres).map_err(|fault| refuse(fault.to_string()))
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
        let Some(name) = shape else {
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
        let Some(shape) = self.shapes.named(name) else {
            let names: Vec<_> = self.scene.shapes.keys().map(String::as_str).collect();
            let help = match &names[..] {
                [] => "the scene has no `shapes`: add them, by name".to_owned(),
                names => did_you_mean("shapes", name, names),
            };
            return Err(self.fault("scene::shape", &key("shape"), format!("there is no shape `{name}`")).help(help));
        };
        let facts = self.shapes.facts[shape.index()].clone();
        if has_radius && scale.is_some() {
            return Err(self
                .fault("scene::shape", &key("scale"), "`radius` and `scale` both give the size")
                .help("`scale` is relative to the shape, `radius` that of the sphere (disc) of equal volume (area), m; remove one"));
        }
        let radius = match scale {
            _ if has_radius => (*radius).clone(),
            Some(scale) => scale.times(facts.equivalent_radius),
            None => RadiusLaw::default().times(facts.equivalent_radius),
        };
        if let Some(OrientationLaw::Along(direction)) = orientation
            && direction.padded() == Solid::ZERO
        {
            return Err(self
                .fault("scene::zero_direction", &key("orientation"), "the direction has no length")
                .help("give a vector of any other length"));
        }
        let orientation = orientation.unwrap_or_default();
        Ok(Resolved { shaped: Some(Shaped { shape, facts, orientation }), radius })
    }
}

impl RadiusLaw {
    /// Returns the law with all sizes multiplied.
    fn times(&self, factor: f64) -> Self {
        // A product that no positive number holds leaves the factor, which the rules on masses refuse.
        let times = |size: Positive| Positive::try_from(size.get() * factor).unwrap_or(size);
        match self {
            Self::Fixed(size) => Self::Fixed(times(*size)),
            Self::Uniform(low, high) => Self::Uniform(times(*low), times(*high)),
            Self::Mixture(sizes) => Self::Mixture(sizes.iter().map(|(size, share)| (times(*size), *share)).collect()),
        }
    }
}
