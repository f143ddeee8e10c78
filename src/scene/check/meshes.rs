//! Warnings about triangles of meshes: T-junctions, slivers and overlaps (`walls::mesh_faults`). Walls of the scene may overlap in one
//! plane: a grain touches their union.

use crate::fault::Warning;
use crate::scene::loaded::Loaded;
use crate::space::Solid;
use crate::walls::config::Wall;
use crate::walls::mesh_faults::faults;

/// Adds the warnings.
pub(super) fn examine(loaded: &Loaded, warnings: &mut Vec<Warning>) {
    for (number, wall) in loaded.scene.walls.iter().enumerate() {
        if let Wall::Mesh { triangles, .. } = wall {
            of_mesh(number, triangles, warnings);
        }
    }
}

fn of_mesh(number: usize, triangles: &[[Solid; 3]], warnings: &mut Vec<Warning>) {
    let found = faults(triangles);
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
    if let [(one, other), ..] = found.overlaps[..] {
        let count = found.overlaps.len();
        warn(
            "check::overlapping_triangles",
            format!("{count} pairs of triangles that overlap in one plane, first triangles {one} and {other}"),
            "remove the part that comes twice",
        );
    }
}
