//! Searches for a gap through which a grain could leave rigid walls with a closed door.
//!
//! A flood fill runs over a square grid with a spacing of a quarter of the smallest grain's radius R. It starts where
//! grains start. Grid points nearer than R + R_w to a wall grain, or R to a wall surface, are blocked. If the fill reaches
//! the bounding box of the walls other than at its top, the walls leak. Limit: a gap whose free width is less than the
//! diagonal of the grid, a third of the radius, may be overlooked. A search that would need more than 2e7 points, or more time than the budget has, is
//! given up, and the budget is told.

use crate::scene::loaded::Loaded;
use siloflow_dem::budget::Budget;
use siloflow_dem::space::{Dimension, Vector};
use siloflow_dem::walls::enclosure::Enclosure;
use siloflow_dem::walls::shapes::Planar;
use siloflow_dem::walls::silo_file::Disc;
use siloflow_dem::walls::surface::Surface;

/// Largest number of grid points. Each takes a byte, and more would take several seconds.
const MOST_POINTS: f64 = 2e7;

/// The point where a grain gets out, m; `None` if no grain does, or without walls or grains, or if the search was given up.
#[must_use]
pub fn way_out(loaded: &Loaded, budget: &Budget) -> Option<Vector> {
    // In solid space the grid would have too many points. In a periodic box every path leaves the bounding box.
    if loaded.scene.space != Dimension::Plane || !loaded.scene.periodic.is_open() {
        return None;
    }
    let (radius, _) = loaded.grain_radii()?;
    let mut discs = loaded.wall_discs();
    discs.extend(&loaded.silo.door);
    let walls = loaded.own_surfaces();
    let balls = walls.iter().filter_map(|wall| match wall.surface.shape().planar() {
        Some(Planar::Ball { centre, radius }) => Some(Disc { centre, radius }),
        _ => None,
    });
    discs.extend(balls);
    let [low, high] = Enclosure::new(&discs, &[], &walls, radius).bounds()?;
    let surfaces: Vec<Surface> = walls.into_iter().map(|wall| wall.surface).collect();
    let spacing = 0.25 * radius;
    let points = |extent: Vector, reach: f64| {
        let whole = extent.abs() + Vector::splat(2.0 * (reach + spacing));
        whole.element_product() / (spacing * spacing)
    };
    let blocked_by_discs: f64 = discs.iter().map(|disc| points(Vector::ZERO, disc.radius + radius)).sum();
    let blocked_by_segments = surfaces.iter().map(|surface| match surface.shape().planar() {
        Some(Planar::Segment { from, to }) => points(to - from, radius),
        _ => 0.0,
    });
    // Discs also block points just outside of the box.
    let margin = discs.iter().map(|disc| disc.radius).fold(0.0, f64::max) + radius + 2.0 * spacing;
    let needed = points(high - low, margin) + blocked_by_discs + blocked_by_segments.sum::<f64>();
    if needed.is_nan() || needed > MOST_POINTS {
        budget.give_up(format!("gaps in the walls, of which the search needs a grid of {needed:.1e} points"));
        return None;
    }
    let mut field = Field::new(low - Vector::splat(margin), high + Vector::splat(margin), spacing);
    for disc in discs.iter().take_while(|_| !budget.is_spent()) {
        field.block(disc.centre, disc.centre, disc.radius + radius, |x| x.distance(disc.centre));
    }
    for surface in surfaces.iter().take_while(|_| !budget.is_spent()) {
        if let Some(Planar::Segment { from, to }) = surface.shape().planar() {
            field.block(from, to, radius, |x| surface.distance(x));
        }
    }
    let is_half_plane = |surface: &&Surface| matches!(surface.shape().planar(), Some(Planar::HalfPlane { .. }));
    let half_planes: Vec<_> = surfaces.iter().filter(is_half_plane).collect();
    let behind = |x: Vector| half_planes.iter().any(|surface| surface.distance(x) < radius);
    let starts =
        loaded.scene.spawner.iter().map(|s| s.point.get()).chain(loaded.grains.iter().map(|g| g.position.truncate()));
    let fed = loaded.scene.feed.iter().map(|feed| feed.region.point([0.5; 3]).truncate());
    let mut stack: Vec<_> = starts.chain(fed).map(|x| grid(x, spacing)).collect();
    for &point in &stack {
        field.see(point);
    }
    while let Some((i, j)) = stack.pop() {
        // Walls may be missing in the field then.
        if budget.is_spent() {
            budget.give_up("gaps in the walls");
            return None;
        }
        let x = place((i, j), spacing);
        if x.y >= high.y || field.is_blocked((i, j)) || behind(x) {
            continue;
        }
        if x.x <= low.x || x.x >= high.x || x.y <= low.y {
            return Some(x);
        }
        for next in [(i + 1, j), (i - 1, j), (i, j + 1), (i, j - 1)] {
            if field.see(next) {
                stack.push(next);
            }
        }
    }
    None
}

/// A point of the grid.
type Point = (i64, i64);

const BLOCKED: u8 = 1;
const SEEN: u8 = 2;

/// State of the grid points of a rectangle. Points outside are free, and the fill stops there.
struct Field {
    spacing: f64,
    low: Point,
    high: Point,
    marks: Vec<u8>,
}

impl Field {
    fn new(low: Vector, high: Vector, spacing: f64) -> Self {
        let low = grid(low, spacing);
        let high = grid(high, spacing);
        let side = |from: i64, to: i64| usize::try_from(to - from + 1).unwrap_or(0);
        let marks = vec![0; side(low.0, high.0) * side(low.1, high.1)];
        Self { spacing, low, high, marks }
    }

    fn mark(&mut self, (i, j): Point) -> Option<&mut u8> {
        if !(self.low.0..=self.high.0).contains(&i) || !(self.low.1..=self.high.1).contains(&j) {
            return None;
        }
        let index = (i - self.low.0) * (self.high.1 - self.low.1 + 1) + j - self.low.1;
        self.marks.get_mut(usize::try_from(index).ok()?)
    }

    fn is_blocked(&mut self, point: Point) -> bool {
        self.mark(point).is_some_and(|mark| *mark & BLOCKED != 0)
    }

    /// Whether the point is visited for the first time.
    fn see(&mut self, point: Point) -> bool {
        self.mark(point).is_none_or(|mark| std::mem::replace(mark, *mark | SEEN) & SEEN == 0)
    }

    /// Blocks the points nearer than `reach` to a body between `from` and `to`.
    fn block(&mut self, from: Vector, to: Vector, reach: f64, distance: impl Fn(Vector) -> f64) {
        let margin = Vector::splat(reach + self.spacing);
        let low = grid(from.min(to) - margin, self.spacing);
        let high = grid(from.max(to) + margin, self.spacing);
        for i in low.0..=high.0 {
            for j in low.1..=high.1 {
                if distance(place((i, j), self.spacing)) < reach
                    && let Some(mark) = self.mark((i, j))
                {
                    *mark |= BLOCKED;
                }
            }
        }
    }
}

#[expect(clippy::cast_possible_truncation, reason = "saturates far outside any scene")]
fn grid(x: Vector, spacing: f64) -> Point {
    ((x.x / spacing).round() as i64, (x.y / spacing).round() as i64)
}

#[expect(clippy::cast_precision_loss, reason = "grid indices are small")]
fn place((i, j): Point, spacing: f64) -> Vector {
    Vector::new(i as f64, j as f64) * spacing
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::load::from_text;

    /// A box with a gap in its floor, and grains of R = 5 cm.
    fn way_through(gap: f64) -> Option<Vector> {
        let wall = |from: (f64, f64), to: (f64, f64)| format!("Segment(from: {from:?}, to: {to:?})");
        let half = 0.5 * gap;
        let walls = [
            wall((-0.5, 1.0), (-0.5, 0.0)),
            wall((-0.5, 0.0), (-half, 0.0)),
            wall((half, 0.0), (0.5, 0.0)),
            wall((0.5, 0.0), (0.5, 1.0)),
        ];
        let text = format!(
            "(gravity: (0.0, -9.81), contact: Assignment(k: 1.0e5, b: 0.0), mass: ArealSquare(100.0), step: Fixed(1.0e-4),
              walls: [{}], until: 1.0, spawner: (point: (0.2, 0.8), velocity: (0.0, 0.0), interval: 1.0, count: 1,
              radius: Fixed(0.05)))",
            walls.join(", ")
        );
        let loaded = from_text("box.ron", "box", std::path::Path::new("."), text, &[]).unwrap();
        way_out(&loaded, &Budget::usual())
    }

    #[test]
    fn grains_get_out_where_they_are_narrower_than_the_gap() {
        assert_eq!((way_through(0.0), way_through(0.099)), (None, None));
        // Wider than a grain by more than the grid's diagonal, 1.8 cm.
        let place = way_through(0.12).expect("a way out");
        assert!(place.x.abs() < 0.06 && place.y <= 0.0, "{place}");
    }
}
