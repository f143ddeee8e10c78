//! Walls in the words of LAMMPS: a region and a `fix wall/gran/region` for each wall of the scene.
//!
//! | siloflow | region |
//! |---|---|
//! | `HalfPlane` | `plane` |
//! | `Panel`, `Segment` | `block` of no thickness, `side out`, turned by a constant `rotate` where it is not along the axes |
//! | `Cylinder`, `Cone` along an axis | `cylinder`, `cone`, open at both ends |
//! | `Annulus` without a hole along an axis | `cylinder` of no height, `side out` |
//!
//! A block of no thickness has the nearest point of the rectangle for every point of space. An open cylinder or cone acts on both of its
//! sides and at its rims. So distances and normals are those of siloflow (measured: equal to round-off). Unions and intersections are never
//! written: their forces are documented as wrong at convex edges, such as the lip of an outlet.
//!
//! Limits: siloflow drops the contact with an edge that another wall continues; LAMMPS counts both. A grain whose centre is behind a plane
//! is pushed back by siloflow, and not by LAMMPS. Laws that depend on the contact radius differ on the outer side of a
//! cylinder, where LAMMPS takes that of a plane, and on a cone, which LAMMPS takes for a cylinder of the local radius R, seen from within: r 2R/(2R - r) for a grain of
//! radius r. siloflow takes r 2R/(2R - r cos a) for the half-angle a. Hertz's stiffness differs by the square root of the ratio: by 0.15 % for r = R/50 and 45 degrees.

use std::fmt::Write as _;

use crate::lammps::laws::Laws;
use crate::lammps::motions::{self, Leaf};
use crate::lammps::{number, refused, vector};
use crate::scene::loaded::Loaded;
use siloflow_dem::contact::Contact;
use siloflow_dem::space::{Dimension, Solid};
use siloflow_dem::values::NonNegative;
use siloflow_dem::walls::config::geometry::Cuts;
use siloflow_dem::walls::config::shape::WallShape;
use siloflow_text::fault::Fault;

/// The walls of a scene.
#[derive(Debug, Default)]
pub(super) struct Walls {
    /// Regions and fixes.
    pub lines: String,
    /// The fixes of each wall, with its number from 1 as in `walls.csv`.
    pub fixes: Vec<(usize, Vec<String>)>,
    /// The fixes of each door that vanishes or stays, by its number.
    pub doors: Vec<(u16, Vec<String>)>,
    /// The walls of doors that move, each with the number of its region.
    pub leaves: Vec<(usize, Leaf)>,
    /// Whether a wall is a half-plane.
    pub has_planes: bool,
    /// Whether walls with edges are more than one.
    pub may_meet: bool,
    /// Whether the normal of a contact may turn: on an edge or a curved wall.
    pub may_turn: bool,
}

/// Translates the wall surfaces of a scene.
///
/// # Errors
/// If a wall has no counterpart.
pub(super) fn walls(loaded: &Loaded, laws: &Laws) -> Result<Walls, Fault> {
    let mut walls = Walls::default();
    let surfaces = loaded.scene.walls.iter().enumerate().filter(|(_, wall)| wall.is_surface());
    let mut with_edges = 0;
    for (number, (index, wall)) in (1..).zip(surfaces) {
        let key = loaded.key_of_wall(index);
        let region = region(loaded, &wall.shape, &key, number)?;
        if wall.shape.moves_in_place() && Leaf::of(loaded, wall).is_some() {
            let message = "a door that moves and has a velocity or spin of its own is not written";
            return Err(refused(loaded, &key, message).help("export without the velocity or spin"));
        }
        let motion = motions::motion(loaded, wall, number)?;
        if motion.turns && region.contains(" rotate ") {
            let message = "a region of LAMMPS has one rotation, which the slant of this wall needs";
            return Err(refused(loaded, &key, message).help("turn walls that begin along the axes"));
        }
        let _ = writeln!(walls.lines, "{}{}{}", motion.variables, region.trim_end(), motion.words);
        let mut fixes = Vec::new();
        for grain in 0..laws.species() {
            let one = laws.species() == 1;
            let name = if one { format!("wall_{number}") } else { format!("wall_{number}_{}", grain + 1) };
            let group = if one { "grains".to_owned() } else { format!("species_{}", grain + 1) };
            let law = laws.wall(grain, wall.species);
            let _ = writeln!(walls.lines, "fix {name} {group} wall/gran/region {law} region shape_{number} contacts");
            fixes.push(name);
        }
        let door = loaded.scene.door_of(wall);
        if let Some(leaf) = Leaf::of(loaded, wall) {
            walls.leaves.push((number, leaf));
        } else if let Some(door) = door {
            match walls.doors.iter_mut().find(|(number, _)| *number == door) {
                Some((_, own)) => own.extend(fixes.iter().cloned()),
                None => walls.doors.push((door, fixes.clone())),
            }
        }
        walls.fixes.push((number, fixes));
        let is_plane = matches!(wall.shape, WallShape::HalfPlane { .. });
        walls.has_planes |= is_plane;
        with_edges += usize::from(!is_plane);
    }
    walls.may_meet = with_edges > 1;
    walls.may_turn = with_edges > 0;
    Ok(walls)
}

/// Returns whether a law that depends on the contact radius meets a round wall.
pub(super) fn have_another_radius(loaded: &Loaded) -> bool {
    let mut laws = loaded.scene.pairs.iter().map(|pair| &pair.contact).chain([&loaded.scene.contact]);
    laws.any(|law| matches!(law, Contact::Hertz { .. } | Contact::Linear { rolling: Some(_), .. }))
        && loaded
            .scene
            .walls
            .iter()
            .any(|wall| matches!(wall.shape, WallShape::Cylinder { .. } | WallShape::Cone { .. }))
}

/// Returns the region command of a wall, with the variable that it needs.
///
/// # Errors
/// If LAMMPS has no such region.
fn region(loaded: &Loaded, shape: &WallShape, key: &str, place: usize) -> Result<String, Fault> {
    let name = format!("region shape_{place}");
    if !matches!(shape.cuts(), Cuts { hole: None, patch: None }) {
        let message = "LAMMPS has no region for a wall with a hole, or for a part of one";
        return Err(refused(loaded, key, message).help("use panels, cylinders and cones without `hole` and `patch`"));
    }
    Ok(match shape {
        WallShape::HalfPlane { point, normal, .. } => {
            let normal = normal.padded() / normal.padded().length();
            format!("{name} plane {} {}\n", vector(point.padded()), vector(normal))
        }
        WallShape::Panel { corner, along, across, .. } => {
            rectangle(&name, place, corner.padded(), [along.padded(), across.padded()])
        }
        WallShape::Segment { from, to } => {
            let along = to.padded() - from.padded();
            let from = from.padded();
            match loaded.scene.space {
                Dimension::Plane => band(&name, place, from, along),
                Dimension::Solid => rectangle(&name, place, from, [along, Solid::ZERO]),
            }
        }
        WallShape::Cylinder { from, to, radius, .. } => {
            revolved(loaded, &name, key, [from.padded(), to.padded()], [radius.get(); 2])?
        }
        WallShape::Cone { from, to, radii, .. } => {
            revolved(loaded, &name, key, [from.padded(), to.padded()], <[NonNegative; 2]>::from(*radii).map(f64::from))?
        }
        WallShape::Annulus { centre, normal, inner, outer, .. } if inner.is_none_or(|inner| inner.get() <= 0.0) => {
            let (axis, [a, b]) = axis_of(loaded, key, normal.padded())?;
            let centre = centre.padded();
            let [a, b, radius, at] =
                [centre[a], centre[b], outer.get(), centre["xyz".find(axis).unwrap_or(2)]].map(number);
            format!("{name} cylinder {axis} {a} {b} {radius} {at} {at} side out\n")
        }
        other => return Err(no_region(loaded, other, key)),
    })
}

/// Returns the fault of a shape for which LAMMPS has no region.
fn no_region(loaded: &Loaded, shape: &WallShape, key: &str) -> Fault {
    let (message, help) = match shape {
        WallShape::Polygon { .. } | WallShape::Mesh { .. } => {
            ("walls of triangles need LAMMPS of July 2026 or later, and are not written", "build the wall from panels")
        }
        WallShape::Annulus { .. } => ("LAMMPS has no region for a flat ring", "use panels, or a cone with a slope"),
        WallShape::SphericalZone { .. } => ("LAMMPS has no region for a part of a sphere", "use a cone"),
        WallShape::Disc { .. } => (
            "a disc or sphere that is a wall surface is not written",
            "leave out its `name` and `door`: then it is written as a fixed atom",
        ),
        _ => ("LAMMPS has no region for a wall of this shape", "use panels, cylinders and cones"),
    };
    refused(loaded, key, message).help(help)
}

/// A segment of the plane: a band of no thickness that reaches above and below the plane.
fn band(name: &str, place: usize, from: Solid, along: Solid) -> String {
    let depth = Solid::Z * along.length();
    if along.x == 0.0 || along.y == 0.0 {
        return rectangle(name, place, from - depth, [along, 2.0 * depth]);
    }
    let block = sides(from - depth, from + Solid::X * along.length() + depth);
    let angle = number(along.y.atan2(along.x));
    let from = vector(from);
    format!("variable turn_{place} equal {angle}\n{name} block {block} side out rotate v_turn_{place} {from} 0 0 1\n")
}

/// A block of no thickness from a corner and two edges at right angles, of which the second may be zero.
fn rectangle(name: &str, place: usize, corner: Solid, edges: [Solid; 2]) -> String {
    let along_axis = |edge: Solid| edge.to_array().iter().filter(|part| **part != 0.0).count() <= 1;
    if edges.into_iter().all(along_axis) {
        let low = corner.min(corner + edges[0]);
        let high = corner.max(corner + edges[0]);
        let low = low.min(low + edges[1]);
        let high = high.max(high + edges[1]);
        return format!("{name} block {} side out\n", sides(low, high));
    }
    let first = edges[0] / edges[0].length();
    let second = if edges[1] == Solid::ZERO { first.any_orthonormal_vector() } else { edges[1] / edges[1].length() };
    let turn = glam::DQuat::from_mat3(&glam::DMat3::from_cols(first, second, first.cross(second))).normalize();
    let (axis, angle) = turn.to_axis_angle();
    let size = Solid::new(edges[0].length(), edges[1].length(), 0.0);
    format!(
        "variable turn_{place} equal {}\n{name} block {} side out rotate v_turn_{place} {} {}\n",
        number(angle),
        sides(corner, corner + size),
        vector(corner),
        vector(axis)
    )
}

fn sides(low: Solid, high: Solid) -> String {
    (0..3).map(|axis| format!("{} {}", number(low[axis]), number(high[axis]))).collect::<Vec<_>>().join(" ")
}

/// The axis that a direction is along, and the numbers of the two others in LAMMPS's order.
fn axis_of(loaded: &Loaded, key: &str, direction: Solid) -> Result<(char, [usize; 2]), Fault> {
    match direction.to_array().map(|part| part != 0.0) {
        [true, false, false] => Ok(('x', [1, 2])),
        [false, true, false] => Ok(('y', [0, 2])),
        [false, false, true] => Ok(('z', [0, 1])),
        _ => Err(refused(loaded, key, "round regions of LAMMPS are along x, y or z, and this axis is not")
            .help("turn the scene so that the axis is along x, y or z")),
    }
}

fn revolved(loaded: &Loaded, name: &str, key: &str, ends: [Solid; 2], radii: [f64; 2]) -> Result<String, Fault> {
    let [from, to] = ends;
    let (axis, [a, b]) = axis_of(loaded, key, to - from)?;
    let along = "xyz".find(axis).unwrap_or(2);
    let upwards = from[along] < to[along];
    let (low, high, radii) = if upwards { (from, to, radii) } else { (to, from, [radii[1], radii[0]]) };
    let [a, b, low, high] = [from[a], from[b], low[along], high[along]].map(number);
    let [r_low, r_high] = radii.map(number);
    Ok(if radii[0].to_bits() == radii[1].to_bits() {
        format!("{name} cylinder {axis} {a} {b} {r_low} {low} {high} open 1 open 2\n")
    } else {
        format!("{name} cone {axis} {a} {b} {r_low} {r_high} {low} {high} open 1 open 2\n")
    })
}
