//! The bed and the fall, for estimates: where grains start, how fast they arrive, and what the lowest of them carry.

use crate::scene::loaded::Loaded;
use siloflow_dem::space::Dimension;
use siloflow_dem::walls::config::shape::WallShape;
use siloflow_dem::walls::enclosure::Enclosure;

/// Speed at the lowest point of the walls, after a fall from where grains start, m/s.
pub(super) fn impact_speed(loaded: &Loaded) -> f64 {
    let floor = lowest_point(loaded);
    let g = loaded.scene.gravity.padded().length();
    let up = up(loaded);
    let fall = |height: f64, speed: f64| (speed * speed + 2.0 * g * (height - floor).max(0.0)).sqrt();
    let start = loaded.grains.iter().map(|grain| fall(grain.position[up], grain.velocity.length()));
    let released = loaded.scene.spawner.iter().map(|s| fall(s.point.padded()[up], s.velocity.padded().length()));
    let fed = loaded.scene.feed.iter().map(|feed| {
        // Few of the Gaussian velocities exceed three standard deviations.
        let agitation = feed.agitation.map_or(0.0, |agitation| 3.0 * agitation.padded().length());
        fall(feed.region.bounds().1[up], feed.velocity.padded().length() + agitation)
    });
    start.chain(released).chain(fed).fold(0.0, f64::max)
}

/// The axis that points up: the axis along which gravity is strongest, or the last axis without gravity.
pub(super) fn up(loaded: &Loaded) -> usize {
    let gravity = loaded.scene.gravity.padded();
    (0..loaded.scene.space.count()).max_by(|&a, &b| gravity[a].abs().total_cmp(&gravity[b].abs())).unwrap_or(0)
}

fn lowest_point(loaded: &Loaded) -> f64 {
    let up = up(loaded);
    let discs = loaded.wall_discs().into_iter().map(|disc| disc.centre[up.min(1)]);
    let surfaces = loaded.scene.walls.iter().filter_map(|wall| match &wall.shape {
        WallShape::HalfPlane { point, .. } => Some(point.padded()[up]),
        _ => wall.bounds().map(|[low, _]| low[up]),
    });
    let lowest = discs.chain(surfaces).fold(f64::INFINITY, f64::min);
    let grains = loaded.grains.iter().map(|grain| grain.position[up]).fold(f64::INFINITY, f64::min);
    if lowest.is_finite() { lowest } else { grains.min(loaded.scene.cull.map_or(0.0, |cull| cull.below.get())) }
}

/// Load of a contact at the bottom of the bed, N: the weight of all grains over their base area, times the base area of
/// one grain; 0 if the area is unknown.
pub(super) fn carried_at_the_bottom(loaded: &Loaded, radius: f64) -> f64 {
    let ground: Option<f64> = match loaded.scene.space {
        Dimension::Plane => {
            let outline = Enclosure::new(&loaded.wall_discs(), &loaded.silo.door, &loaded.own_surfaces(), 0.0);
            outline.bounds().map(|[low, high]| high.x - low.x).or_else(|| extent(loaded, 0))
        }
        Dimension::Solid => extent(loaded, 0).zip(extent(loaded, 1)).map(|(x, y)| x * y),
    };
    let axes = i32::try_from(loaded.scene.space.count()).unwrap_or(2) - 1;
    let Some(ground) = ground.filter(|&ground| ground > 0.0) else { return 0.0 };
    let start: f64 = loaded.grains.iter().map(|grain| grain.mass).sum();
    let released: f64 = loaded
        .scene
        .spawner
        .iter()
        .zip(loaded.scene.mass)
        .map(|(spawner, law)| {
            let (smallest, largest) = spawner.radius.range();
            f64::from(spawner.count) * 0.5 * (law.of(smallest) + law.of(largest))
        })
        .sum();
    let fed = loaded.scene.feed.iter().zip(loaded.scene.mass.iter().cycle());
    let fed: f64 = fed.map(|(feed, &law)| feed.count(law).unwrap_or(0.0) * feed.mean_mass(law)).sum();
    (start + released + fed) * loaded.scene.gravity.padded().length() / ground * (2.0 * radius).powi(axes)
}

/// Extent of the scene along a horizontal axis, m: the periodic length, or the distance from the first to the last grain
/// at the start.
fn extent(loaded: &Loaded, axis: usize) -> Option<f64> {
    if let Some((low, high)) = loaded.scene.periodic.axes()[axis] {
        return Some(high - low);
    }
    let ends = loaded.grains.iter().map(|g| (g.position[axis] - g.radius, g.position[axis] + g.radius));
    ends.reduce(|a, b| (a.0.min(b.0), a.1.max(b.1))).map(|(low, high)| high - low)
}
