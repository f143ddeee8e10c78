//! Examines the release point of the spawner: a release needs room, and a place inside the walls.

use crate::scene::check::bed::up;
use crate::scene::check::start::{Body, place};
use crate::scene::loaded::Loaded;
use siloflow_dem::space::Solid;
use siloflow_dem::walls::config::Wall;
use siloflow_text::fault::Warning;

/// Adds the warnings about the release point. `distances` returns the least distances to a half-plane and to a thin wall.
pub(super) fn examine(
    loaded: &Loaded,
    bodies: &[Body],
    distances: impl Fn(Solid) -> [f64; 2],
    warnings: &mut Vec<Warning>,
) {
    let Some(spawner) = loaded.scene.spawner.as_ref().filter(|spawner| spawner.count > 0) else { return };
    let point = spawner.point.padded();
    let jitter = spawner.jitter.map_or(0.0, |jitter| jitter.padded().length());
    let (smallest, _) = spawner.radius.range();
    let [half, thin] = distances(point);
    let walls = || bodies.iter().filter(|body| body.grain.is_none());
    let room = walls().map(|wall| wall.centre.distance(point) - wall.radius).fold(half.min(thin), f64::min);
    if room + jitter < smallest {
        warnings.push(Warning {
            code: "check::no_room_to_release",
            message: format!(
                "the release point is {room:.3} m from a wall, and the smallest grain has a radius of {smallest} m"
            ),
            help: "move `spawner.point` away from the wall".to_owned(),
        });
    }
    // Half-planes have no ends, so they bound no box.
    let thin_walls = loaded.scene.walls.iter().filter_map(Wall::bounds).flatten();
    let corners: Vec<Solid> = walls().map(|wall| wall.centre).chain(thin_walls).collect();
    let bounds = corners.iter().copied().reduce(Solid::min).zip(corners.iter().copied().reduce(Solid::max));
    let Some((low, high)) = bounds.filter(|_| half.is_infinite()) else { return };
    let up = up(loaded);
    let beside =
        |axis: usize| loaded.scene.periodic.axes()[axis].is_none() && !(low[axis]..=high[axis]).contains(&point[axis]);
    let is_outside =
        (0..loaded.scene.space.count()).any(|axis| if axis == up { point[axis] < low[axis] } else { beside(axis) });
    if is_outside {
        warnings.push(Warning {
            code: "check::release_outside",
            message: format!(
                "the release point {} is outside the walls, which reach from {} to {}",
                place(point),
                place(low),
                place(high)
            ),
            help: "move `spawner.point` into the silo, or above it".to_owned(),
        });
    }
}
