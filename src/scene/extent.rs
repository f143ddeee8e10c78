//! How much the state of a scene, or a frame of it, can take: the limit up to which files of a run are unpacked.
//!
//! A compressed file of a few megabytes can stand for gigabytes of zeros. A checkpoint or a frame of a scene has no more particles than the
//! scene can release, no more walls than it has, and no more cells of fields than it asks for. The figures below are several times those
//! that were found in runs, so that no file of a real run is refused.
//!
//! Limit: state of behaviours is their own matter. A scene with behaviours may have state of [`OF_BEHAVIOURS`] times the bytes of the file.

use crate::measure::fields::{Layout, MOST_BLOCKS};
use crate::scene::expected::shapes;
use crate::scene::loaded::{AnyScene, Loaded};
use siloflow_dem::walls::config::Wall;
use siloflow_dem::walls::config::shape::WallShape;

/// Most bytes that do not depend on the scene: departures, kicks, sums over a run.
const BASE: u64 = 16 << 20;

/// Most bytes of a particle with its contacts: some 400 bytes of its own, and up to 32 contacts of 100 bytes each; in a frame also the
/// columns of behaviours.
const OF_PARTICLE: u64 = 8 << 10;

/// Most bytes of a wall, which is drawn with up to 48 sectors and as many rings, and of a triangle of a mesh.
const OF_WALL: u64 = 512 << 10;
const OF_TRIANGLE: u64 = 512;

/// Most bytes of a flow field: of some four million cells.
const OF_FLOW: u64 = 256 << 20;

/// Most bytes of a number in a sum over time.
const OF_NUMBER: u64 = 16;

/// Most bytes of a site of the lattice gas.
const OF_SITE: u64 = 64;

/// Bytes of the state of behaviours over the bytes of a file.
pub const OF_BEHAVIOURS: u64 = 16;

/// Returns the most bytes that the state of a scene or one of its frames takes.
#[must_use]
pub fn most_bytes(scene: &AnyScene) -> u64 {
    let bytes = match scene {
        AnyScene::Grains(loaded) => of_grains(loaded),
        AnyScene::Lattice(loaded) => {
            let flow = if loaded.scene.flow.is_some() { OF_FLOW } else { 0 };
            flow.saturating_add((loaded.sites.kinds.len() as u64).saturating_mul(OF_SITE))
        }
    };
    BASE.saturating_add(bytes)
}

/// As [`most_bytes`], for a file of `length` bytes that may hold state of behaviours.
#[must_use]
pub fn most_bytes_of_file(scene: &AnyScene, length: u64) -> u64 {
    let has_behaviours = match scene {
        AnyScene::Grains(loaded) => !loaded.scene.behaviours.is_empty(),
        AnyScene::Lattice(loaded) => !loaded.scene.behaviours.is_empty(),
    };
    most_bytes(scene).saturating_add(if has_behaviours { length.saturating_mul(OF_BEHAVIOURS) } else { 0 })
}

fn of_grains(loaded: &Loaded) -> u64 {
    let scene = &loaded.scene;
    let particles = (shapes(loaded) as u64).saturating_mul(OF_PARTICLE);
    let of_wall = |wall: &Wall| match &wall.shape {
        WallShape::Mesh { triangles, .. } => OF_WALL + OF_TRIANGLE * triangles.len() as u64,
        _ => OF_WALL,
    };
    let walls = scene.walls.iter().map(of_wall).fold(0, u64::saturating_add);
    let species = loaded.largest_species() as u64 + 2;
    let sums = Layout { components: scene.space.count(), species: loaded.field_species() }.sums() * (MOST_BLOCKS + 1);
    let fields = scene.fields.iter().map(|field| field.grid.cells().saturating_mul(sums) as u64);
    let bins = scene.profiles.iter().map(|profile| u64::from(profile.bins).saturating_mul(16 * species));
    let bands = scene.wall_bands.iter().map(|bands| u64::from(bands.bins).saturating_mul(16));
    let numbers = fields.chain(bins).chain(bands).fold(0, u64::saturating_add).saturating_mul(OF_NUMBER);
    let flow = if scene.flow.is_some() { OF_FLOW } else { 0 };
    [particles, walls, numbers, flow].into_iter().fold(0, u64::saturating_add)
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::scene::load;

    #[test]
    fn the_limit_grows_with_what_a_scene_can_hold() {
        let of = |settings: &[(&str, &str)]| {
            let settings: Vec<_> =
                settings.iter().map(|(key, value)| ((*key).to_owned(), (*value).to_owned())).collect();
            let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/silo1.ron");
            most_bytes(&load::any(&path, &settings).unwrap())
        };
        let [few, many] = ["20", "100020"].map(|count| of(&[("spawner.count", count), ("flow", "None")]));
        assert!((BASE..2 * BASE).contains(&few), "{few}");
        assert_eq!(many - few, 100_000 * OF_PARTICLE);
    }
}
