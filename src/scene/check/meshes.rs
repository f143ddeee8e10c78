//! Warnings about meshes whose size does not fit the grains, because files have no unit, and about triangles of meshes: T-junctions,
//! slivers and overlaps (`walls::mesh_faults`). Walls of the scene may overlap in one plane: a grain touches their union.

use crate::scene::loaded::Loaded;
use siloflow_dem::budget::Budget;
use siloflow_dem::space::Solid;
use siloflow_dem::walls::config::Wall;
use siloflow_dem::walls::config::shape::WallShape;
use siloflow_dem::walls::mesh_faults::{MOST_OVERLAPS, faults};
use siloflow_text::fault::Warning;

/// Diameters of the largest grain across which a mesh is suspiciously wide. A bed so wide would have more than 10^9 grains in a single layer; a mesh in mm that is
/// read as m is a thousand times too wide.
const VERY_WIDE: f64 = 3e4;

/// Adds the warnings.
pub(super) fn examine(loaded: &Loaded, budget: &Budget, warnings: &mut Vec<Warning>) {
    for (number, wall) in loaded.scene.walls.iter().enumerate() {
        if let WallShape::Mesh { triangles, .. } = &wall.shape {
            size(loaded, number, wall, warnings);
            budget.share(0.5, || of_mesh(number, triangles, budget, warnings));
        }
    }
}

/// Meshes narrower than a grain, or very much wider.
fn size(loaded: &Loaded, number: usize, wall: &Wall, warnings: &mut Vec<Warning>) {
    let Some(((_, largest), [low, high])) = loaded.grain_radii().zip(wall.bounds()) else { return };
    let width = (high - low).max_element();
    let diameter = 2.0 * largest;
    if width < diameter || width > VERY_WIDE * diameter {
        warnings.push(Warning {
            code: "check::mesh_size",
            message: format!(
                "the mesh of walls[{number}] is {width:.3e} m wide, and the largest grain {diameter:.3e} m"
            ),
            help: format!("is `walls[{number}].unit` the unit of the numbers in the file?"),
        });
    }
}

fn of_mesh(number: usize, triangles: &[[Solid; 3]], budget: &Budget, warnings: &mut Vec<Warning>) {
    let found = faults(triangles, &format!("of the mesh of walls[{number}]"), budget);
    let mut warn = |code, what: String, help: &str| {
        warnings.push(Warning {
            code,
            message: format!("the mesh of walls[{number}] has {what}"),
            help: help.to_owned(),
        });
    };
    if let [first, ..] = found.t_junctions[..] {
        let count = found.t_junctions.len();
        warn(
            "check::t_junctions",
            format!("{count} triangles with a corner of another triangle on an edge, first triangle {first}"),
            "divide the edge at this corner; at present grains touch an edge where the surface is smooth",
        );
    }
    if let [first, ..] = found.slivers[..] {
        let count = found.slivers.len();
        warn(
            "check::slivers",
            format!("{count} triangles lower than a hundredth of their longest edge, first triangle {first}"),
            "make the mesh anew with triangles of better shape, if contacts there matter to you",
        );
    }
    if let [[one, other], ..] = found.overlaps[..] {
        let count = found.overlaps.len();
        let count = if count < MOST_OVERLAPS { count.to_string() } else { format!("{count} or more") };
        warn(
            "check::overlapping_triangles",
            format!("{count} pairs of triangles that overlap in one plane, first triangles {one} and {other}"),
            "remove the part that comes twice",
        );
    }
}
