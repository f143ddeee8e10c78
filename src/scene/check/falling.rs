//! Whether a grain can fall for ever: there is gravity, no `cull`, and nothing below that holds all grains.
//!
//! Half-planes hold a grain if no direction v leads downwards along all of them: v g > 0 and n v >= 0 for all normals n. The
//! directions with the largest v g are those of g itself, of g projected on one plane, or of the line of two planes, so these
//! are tried. Along a periodic axis a grain does not get away. In the plane, discs and segments hold the grains if
//! [`leaks`](super::leaks) finds no way out of them. In solid space panels are not examined. A scene without any wall is meant
//! to have grains in free flight.

use crate::scene::loaded::Loaded;
use siloflow_dem::space::{Dimension, Solid};
use siloflow_dem::walls::config::Wall;
use siloflow_dem::walls::config::shape::WallShape;
use siloflow_text::fault::Warning;

/// Most half-planes whose lines are examined.
const MOST_HALF_PLANES: usize = 100;

/// Adds the warning. `leak` tells whether discs and segments leave a way out.
pub(super) fn examine(loaded: &Loaded, leak: impl Fn() -> bool, warnings: &mut Vec<Warning>) {
    let scene = &loaded.scene;
    let has_walls = !scene.walls.is_empty() || !loaded.silo.wall.is_empty() || !loaded.fixed.is_empty();
    if scene.cull.is_some() || !has_walls || !can_slide(loaded) {
        return;
    }
    let has_thin_walls = scene.walls.iter().any(|wall| !matches!(wall.shape, WallShape::HalfPlane { .. }))
        || !loaded.silo.wall.is_empty()
        || !loaded.fixed.is_empty();
    let has_door = scene.opens_a_door();
    let is_closed = has_thin_walls
        && !has_door
        && match scene.space {
            Dimension::Plane => !leak() && !starts_beside(loaded),
            Dimension::Solid => true,
        };
    if !is_closed {
        warnings.push(Warning {
            code: "check::falls_for_ever",
            message: "grains that leave the walls fall until the end of the run, and cost time in every step"
                .to_owned(),
            help: "add `cull: (below: ...)`, in m, below all walls".to_owned(),
        });
    }
}

/// Whether a grain of a planar scene starts to the left or right of all walls with ends.
fn starts_beside(loaded: &Loaded) -> bool {
    let discs = loaded.wall_discs().into_iter().map(|disc| [disc.centre.x; 2]);
    let surfaces = loaded.scene.walls.iter().filter_map(Wall::bounds).map(|[low, high]| [low.x, high.x]);
    let ends = |[low, high]: [f64; 2], [from, to]: [f64; 2]| [low.min(from), high.max(to)];
    let [low, high] = discs.chain(surfaces).fold([f64::INFINITY, f64::NEG_INFINITY], ends);
    let released = loaded.scene.spawner.iter().map(|spawner| spawner.point.padded().x);
    let fed = loaded.scene.feed.iter().map(|feed| feed.region.bounds()).flat_map(|(low, high)| [low.x, high.x]);
    let mut starts = loaded.grains.iter().map(|grain| grain.position.x).chain(released).chain(fed);
    loaded.scene.periodic.x.is_none() && starts.any(|x| !(low..=high).contains(&x))
}

/// Whether half-planes that do not turn and periodic sides leave a direction downwards.
fn can_slide(loaded: &Loaded) -> bool {
    let gravity = loaded.scene.gravity.padded();
    let axes = [Solid::X, Solid::Y, Solid::Z].into_iter().zip(loaded.scene.periodic.axes());
    let closed: Vec<Solid> = axes.filter(|(_, side)| side.is_some()).map(|(axis, _)| axis).collect();
    let turns = |wall: &Wall| {
        let mut motions = loaded.scene.motions.iter();
        motions.any(|motion| motion.rotate.is_some() && wall.name() == Some(&motion.walls))
            || loaded.scene.free_walls.iter().any(|free| wall.name() == Some(&free.walls))
    };
    let normals: Vec<Solid> = loaded.scene.walls.iter().filter(|wall| !turns(wall)).filter_map(half_plane).collect();
    if normals.len() > MOST_HALF_PLANES {
        return false;
    }
    let planes = || normals.iter().chain(&closed).copied();
    let projected = planes().map(|n| gravity - gravity.dot(n) * n);
    let lines = planes().flat_map(|a| planes().map(move |b| a.cross(b)));
    let lines = lines.flat_map(|line| [line, -line]);
    let mut directions = std::iter::once(gravity).chain(projected).chain(lines);
    let scale = gravity.length();
    directions.any(|direction| {
        let Some(v) = direction.try_normalize() else { return false };
        let is_down = v.dot(gravity) > 1e-9 * scale;
        is_down && closed.iter().all(|axis| v.dot(*axis).abs() < 1e-9) && normals.iter().all(|n| n.dot(v) > -1e-9)
    })
}

fn half_plane(wall: &Wall) -> Option<Solid> {
    match &wall.shape {
        WallShape::HalfPlane { normal, .. } => normal.padded().try_normalize(),
        _ => None,
    }
}
