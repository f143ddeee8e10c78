//! Grain files: CSV with one grain per row. The scene key `grains` reads them, and `state.csv` is one.
//!
//! Columns are found by name: `id` (whole, unique), `radius` (m), `mass` (kg), `x`, `y` (m), `vx`, `vy` (m/s), and in
//! solid space also `z` and `vz`. Optional columns are `species` (whole, default 0) and the spin (rad/s, default 0):
//! `wz` in the plane, `wx`, `wy` and `wz` in solid space. Grains with a shape have `shape`, its name, and an orientation: `angle` (rad) in the
//! plane, the quaternion `qw`, `qx`, `qy`, `qz` in solid space, of the shape as the scene describes it. Their `radius` is that of the sphere
//! (disc) of equal volume (area); a column `scale`, its ratio to that of the shape, may stand in its place.
//!
//! A planar scene accepts the other columns of solid space if they are zero throughout. A scene without friction
//! accepts spin columns under the same condition. Numbers are written with enough digits to be read back to the same
//! bits.

mod read;
pub(crate) mod write;

use std::path::PathBuf;

use serde::{Deserialize, Serialize};

pub use self::read::{parse, read};
pub use self::write::{without_spin, write, write_to};
use crate::grains::shaped::{Posture, ShapeFacts};
use siloflow_dem::particle::{Grain, GrainBundle, GrainId, Mass, Particle, Position, Radius, Species, Velocity};
use siloflow_dem::space::{Dimension, Solid, Space};

/// The scene key `grains`.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct GrainFile {
    /// Path of the CSV file, relative to the scene file.
    pub file: PathBuf,
    /// Path of a CSV file with memories of contacts between these grains and with walls, relative to the scene file.
    pub contacts: Option<PathBuf>,
}

/// One grain, SI.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GrainRow {
    /// Id.
    pub id: GrainId,
    /// Radius, m.
    pub radius: f64,
    /// Mass, kg.
    pub mass: f64,
    /// Centre, m; in the plane, z is 0.
    pub position: Solid,
    /// Velocity, m/s.
    pub velocity: Solid,
    /// Spin, rad/s; in the plane, along z.
    pub spin: Solid,
    /// Shape and orientation; `None` for a sphere (disc).
    pub posture: Option<Posture>,
    /// Species.
    pub species: Species,
}

impl GrainRow {
    /// Returns the radius (m) of the smallest sphere about the centre that holds the grain.
    #[must_use]
    pub fn reach(&self) -> f64 {
        self.posture.map_or(self.radius, |posture| posture.reach)
    }

    /// Returns the components of the grain as an entity, without those of its shape.
    #[must_use]
    pub fn bundle<V: Space>(&self) -> GrainBundle<V> {
        GrainBundle {
            particle: Particle {
                id: self.id,
                position: Position(V::narrow(self.position)),
                velocity: Velocity(V::narrow(self.velocity)),
                radius: Radius(self.radius),
            },
            mass: Mass(self.mass),
            species: self.species,
            grain: Grain,
        }
    }
}

/// Columns that every file needs.
const ALWAYS: [&str; 7] = ["id", "radius", "mass", "x", "y", "vx", "vy"];
/// Additional columns that a file of a solid scene needs.
const SOLID: [&str; 2] = ["z", "vz"];
/// Columns of the spin.
const SPIN: [&str; 3] = ["wx", "wy", "wz"];
/// Columns of grains with shapes.
const SHAPE: [&str; 7] = ["shape", "scale", "angle", "qw", "qx", "qy", "qz"];

/// Properties of a scene that determine the columns of its grain files.
#[derive(Clone, Copy, Debug)]
pub struct Kind<'a> {
    /// Plane or solid space.
    pub dimension: Dimension,
    /// Whether grains spin.
    pub spins: bool,
    /// The shapes of the scene.
    pub shapes: &'a [ShapeFacts],
}

impl Kind<'_> {
    fn is_solid(self) -> bool {
        self.dimension == Dimension::Solid
    }

    fn needed(self) -> impl Iterator<Item = &'static str> {
        ALWAYS.into_iter().chain(SOLID.into_iter().filter(move |_| self.is_solid()))
    }

    /// Returns whether a column, if present, must be zero.
    fn must_be_zero(self, column: &str) -> bool {
        match column {
            "z" | "vz" => !self.is_solid(),
            "wx" | "wy" => !(self.is_solid() && self.spins),
            "wz" => !self.spins,
            _ => false,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bevy_ecs::prelude::*;
    use siloflow_dem::space::Plane;
    use siloflow_dem::spin::Spin;

    const PLANE: Kind = Kind { dimension: Dimension::Plane, spins: false, shapes: &[] };

    #[test]
    fn written_grains_are_read_back_to_the_same_bits() {
        let text =
            "id,radius,mass,x,y,vx,vy,species\n1,0.1,0.3,0.30000000000000004,-1e-300,5e-324,-0,0\n7,1,2,3,4,5,6,255\n";
        let mut world = World::new();
        let rows = parse("a.csv", text, PLANE).unwrap();
        world.spawn_batch(rows.iter().rev().map(GrainRow::bundle::<Plane>).collect::<Vec<_>>());
        let again = parse("b.csv", &write::<Plane>(&mut world), PLANE).unwrap();
        assert_eq!(again, rows);
        assert!(again[0].velocity.y.is_sign_negative());
    }

    #[test]
    fn spinning_spheres_are_written_as_they_were_read() {
        let kind = Kind { dimension: Dimension::Solid, spins: true, shapes: &[] };
        let text = "id,radius,mass,x,y,z,vx,vy,vz,species,wx,wy,wz\n4,0.1,0.3,1,2,3,4,5,6,1,7,8,0.1\n";
        let mut world = World::new();
        for row in parse("a.csv", text, kind).unwrap() {
            world.spawn((row.bundle::<Solid>(), Spin(row.spin)));
        }
        assert_eq!(write::<Solid>(&mut world), text);
    }

    #[test]
    fn faults_point_at_the_wrong_line_and_column() {
        let cases = [
            ("id,radius,mass,x,y,vx\n", "grain_file::missing_column", (1, 1)),
            ("id,radius,mass,x,y,vx,vy,spin\n", "grain_file::unknown_column", (1, 1)),
            ("id,radius,mass,x,y,vx,vy\n1,1,1,0,0,0,0\n2,-1,1,0,0,0,0\n", "grain_file::value", (3, 3)),
            ("id,radius,mass,x,y,vx,vy\n1,1,1,0,0,0,inf\n", "grain_file::value", (2, 13)),
            ("id,radius,mass,x,y,vx,vy\n1,1,1,0,0\n", "grain_file::value", (2, 10)),
            ("id,radius,mass,x,y,vx,vy\n-1,1,1,0,0,0,0\n", "grain_file::value", (2, 1)),
            ("id,radius,mass,x,y,vx,vy,wz\n1,1,1,0,0,0,0,2\n", "grain_file::value", (2, 15)),
            ("id,radius,mass,x,y,vx,vy\n3,1,1,0,0,0,0\n3,1,1,9,0,0,0\n", "grain_file::duplicate_id", (3, 1)),
        ];
        for (text, code, place) in cases {
            let fault = parse("bad.csv", text, PLANE).unwrap_err();
            assert_eq!((fault.code(), fault.line_and_column()), (code, Some(place)), "{text:?}: {fault}");
        }
        let spinning = Kind { spins: true, ..PLANE };
        assert!(parse("good.csv", cases[6].0, spinning).is_ok());
        let solid = Kind { dimension: Dimension::Solid, ..PLANE };
        assert_eq!(parse("flat.csv", cases[7].0, solid).unwrap_err().code(), "grain_file::missing_column");
    }
}
