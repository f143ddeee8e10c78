//! Is there a way out for a grain, if everything were hard and the door closed?
//!
//! The centre of the smallest grain walks on a square grid of a quarter of its radius, from where grains start, over
//! points that are farther than R + R_w from every wall grain (R from a flat wall). It must not reach the edge of
//! the walls' bounding box other than at the top. Limit: a gap whose free width is less than the grid's diagonal,
//! a third of the radius, may be overlooked.

use std::collections::HashSet;

use crate::scene::load::Loaded;
use crate::space::{Dimension, Vector};
use crate::walls::outline::Outline;
use crate::walls::surfaces::Surface;

/// Grid points beyond which it is not worth the wait: some seconds.
const PATIENCE: f64 = 2e7;

/// Where a grain gets out, m; `None` if it does not, or if there are no walls, no grains or too many points.
#[must_use]
pub fn way_out(loaded: &Loaded) -> Option<Vector> {
    // In solid space a grid would have too many points, and round a periodic side every way leads out of the box.
    if loaded.scene.space != Dimension::Plane || !loaded.scene.periodic.is_open() {
        return None;
    }
    let (radius, _) = loaded.grain_radii()?;
    let mut discs = loaded.wall_discs();
    discs.extend(&loaded.silo.door);
    let surfaces: Vec<Surface> = loaded.surfaces().into_iter().map(|wall| wall.surface).collect();
    let [low, high] = Outline::new(&discs, &[], &loaded.surfaces(), radius).bounds()?;
    let spacing = 0.25 * radius;
    let points = |extent: Vector, reach: f64| {
        let whole = extent.abs() + Vector::splat(2.0 * (reach + spacing));
        whole.element_product() / (spacing * spacing)
    };
    let blocked_by_discs: f64 = discs.iter().map(|disc| points(Vector::ZERO, disc.radius + radius)).sum();
    let blocked_by_segments = surfaces.iter().map(|surface| match *surface {
        Surface::Segment { from, to } => points(to - from, radius),
        Surface::HalfPlane { .. } | Surface::Panel { .. } => 0.0,
    });
    if points(high - low, radius) + blocked_by_discs + blocked_by_segments.sum::<f64>() > PATIENCE {
        return None;
    }
    let mut blocked: HashSet<(i64, i64)> = HashSet::new();
    for disc in &discs {
        block(&mut blocked, disc.centre, disc.centre, spacing, disc.radius + radius, &|x| x.distance(disc.centre));
    }
    for surface in &surfaces {
        if let Surface::Segment { from, to } = *surface {
            block(&mut blocked, from, to, spacing, radius, &|x| surface.distance(x).0);
        }
    }
    let behind = |x: Vector| {
        surfaces.iter().any(|wall| matches!(wall, Surface::HalfPlane { .. }) && wall.distance(x).0 < radius)
    };
    let starts =
        loaded.scene.spawner.iter().map(|s| s.point.get()).chain(loaded.grains.iter().map(|g| g.position.truncate()));
    let mut stack: Vec<_> = starts.map(|x| grid(x, spacing)).collect();
    let mut seen: HashSet<_> = stack.iter().copied().collect();
    while let Some((i, j)) = stack.pop() {
        let x = place((i, j), spacing);
        if x.y >= high.y || blocked.contains(&(i, j)) || behind(x) {
            continue;
        }
        if x.x <= low.x || x.x >= high.x || x.y <= low.y {
            return Some(x);
        }
        for next in [(i + 1, j), (i - 1, j), (i, j + 1), (i, j - 1)] {
            if seen.insert(next) {
                stack.push(next);
            }
        }
    }
    None
}

#[expect(clippy::cast_possible_truncation, reason = "saturates far outside any scene")]
fn grid(x: Vector, spacing: f64) -> (i64, i64) {
    ((x.x / spacing).round() as i64, (x.y / spacing).round() as i64)
}

#[expect(clippy::cast_precision_loss, reason = "grid indices are small")]
fn place((i, j): (i64, i64), spacing: f64) -> Vector {
    Vector::new(i as f64, j as f64) * spacing
}

/// Blocks the grid points nearer than `reach` to a body between `from` and `to`.
fn block(
    blocked: &mut HashSet<(i64, i64)>,
    from: Vector,
    to: Vector,
    spacing: f64,
    reach: f64,
    distance: &dyn Fn(Vector) -> f64,
) {
    let margin = Vector::splat(reach + spacing);
    let (low, high) = (grid(from.min(to) - margin, spacing), grid(from.max(to) + margin, spacing));
    for i in low.0..=high.0 {
        for j in low.1..=high.1 {
            if distance(place((i, j), spacing)) < reach {
                blocked.insert((i, j));
            }
        }
    }
}
