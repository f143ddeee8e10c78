//! The scene key `walls`.

pub mod cut;
pub mod geometry;
mod keys;
pub mod shape;

use serde::{Deserialize, Serialize};

use self::keys::CommonKeys;
use self::shape::{WallShape, Written};
use crate::particle::Species;
use crate::space::{Linear as _, Solid, Space};
use crate::values::FiniteVector;
use crate::walls::surface_wall::SurfaceWall;

/// One entry of the scene key `walls`.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(from = "Written", into = "Written")]
pub struct Wall {
    /// Its shape.
    pub shape: WallShape,
    /// Material. Default 0.
    pub species: u8,
    /// Name, for `motions` and `doors`; several walls may share one. Default: none.
    pub name: Option<String>,
    /// Whether the wall is part of the door of the key `door`. Such a wall vanishes when the door opens, and grains that pass through
    /// its place are out.
    pub door: bool,
}

/// A disc or sphere of the scene that is a fixed grain.
#[derive(Clone, Copy, Debug)]
pub struct WallGrain {
    /// Centre, m.
    pub centre: FiniteVector,
    /// Radius, m.
    pub radius: f64,
    /// Material.
    pub species: Species,
}

impl From<Written> for Wall {
    fn from(written: Written) -> Self {
        let (shape, CommonKeys { species, name, door }) = written.split();
        Self { shape, species, name, door }
    }
}

impl From<Wall> for Written {
    fn from(Wall { shape, species, name, door }: Wall) -> Self {
        Self::joined(shape, CommonKeys { species, name, door })
    }
}

impl Wall {
    /// Returns the name.
    #[must_use]
    pub fn name(&self) -> Option<&str> {
        self.name.as_deref()
    }

    /// Returns the wall grain that the wall is: a disc or sphere without a name that is no door.
    #[must_use]
    pub fn wall_grain(&self) -> Option<WallGrain> {
        match self.shape {
            WallShape::Disc { centre, radius } if self.name.is_none() && !self.door => {
                Some(WallGrain { centre, radius: radius.get(), species: Species(self.species) })
            }
            _ => None,
        }
    }

    /// Whether the wall is a surface, not a wall grain.
    #[must_use]
    pub fn is_surface(&self) -> bool {
        self.wall_grain().is_none()
    }

    /// Returns the surfaces of the wall, which has this number among the walls of the scene, from 0 and without wall grains: several
    /// for a polygon or a mesh, none for a wall grain.
    #[must_use]
    pub fn surfaces<V: Space>(&self, number: usize) -> Vec<SurfaceWall<V>> {
        if !self.is_surface() {
            return Vec::new();
        }
        let shapes = self.shape.surfaces(FiniteVector::get::<V>);
        let reference = shapes.first().map_or(V::ZERO, |shape| shape.shape().reference());
        let velocity = self.shape.own_velocity().map_or(V::ZERO, FiniteVector::get);
        let rate = self.shape.own_spin().map(|spin| spin.rate);
        let surfaces = (0..).zip(shapes).map(|(piece, shape)| {
            let spin = rate
                .zip(shape.shape().axis())
                .map_or(V::Spin::ZERO, |(rate, axis)| V::narrow_spin(axis.spread() * rate));
            let still = SurfaceWall::still(shape, Species(self.species));
            SurfaceWall { number, piece, reference, velocity, spin, ..still }
        });
        surfaces.collect()
    }

    /// Returns the lowest and the highest coordinates of a wall with ends, m; z is 0 in the plane. A wall grain has none.
    #[must_use]
    pub fn bounds(&self) -> Option<[Solid; 2]> {
        self.is_surface().then(|| self.shape.bounds())?
    }
}

#[cfg(test)]
mod tests {
    use ron::Error;
    use ron::error::SpannedResult;
    use ron::extensions::Extensions;

    use super::*;

    fn read(text: &str) -> SpannedResult<Wall> {
        ron::Options::default().with_default_extension(Extensions::IMPLICIT_SOME).from_str(text)
    }

    #[test]
    fn a_wall_is_one_value_of_the_keys_of_its_shape_and_those_of_every_wall() {
        let ball = read("Sphere(centre: (0.0, 0.0, 1.0), radius: 0.5, species: 2, name: \"bob\", door: true)").unwrap();
        assert!(matches!(ball.shape, WallShape::Disc { .. }));
        assert_eq!((ball.species, ball.name(), ball.door), (2, Some("bob"), true));
        let text = ron::to_string(&ball).unwrap();
        assert!(text.starts_with("Disc(centre:"), "{text}");
        assert!(text.ends_with("species:2,name:Some(\"bob\"),door:true)"), "{text}");
        let line = read("Segment(from: (0.0, 0.0), to: (1.0, 0.0))").unwrap();
        assert_eq!((line.species, line.name(), line.door), (0, None, false));
    }

    #[test]
    fn a_key_that_does_not_exist_is_answered_with_all_keys() {
        let error = read("Segment(from: (0.0, 0.0), too: (1.0, 0.0))").unwrap_err();
        let Error::NoSuchStructField { expected, .. } = error.code else { panic!("{error}") };
        assert_eq!(expected, ["from", "to", "species", "name", "door"]);
    }
}
