//! Doors made of spheres (discs) with gaps. A grain is out when the path of its centre crosses the place of a sphere of the door, so that a path through a gap is
//! not counted, and the grain is lost at the cull line.
//!
//! Seen along gravity the spheres are discs, and the door is the convex hull of their centres (in the plane a line). Each point of it has to lie in a disc. A part that
//! does not has corners: where two circles meet inside the hull, or where a circle meets an edge of it. So these points are examined. The circles
//! are a little larger than the discs, because a third circle may run through the same point.
//!
//! Limits: nothing is said without gravity, about doors of a silo file or with other surfaces, or about gaps between a door and the walls beside it.

use std::collections::BTreeMap;

use crate::scene::loaded::Loaded;
use siloflow_dem::space::{Dimension, Solid, Space as _, Vector};
use siloflow_dem::walls::clip::hull;
use siloflow_dem::walls::config::shape::WallShape;
use siloflow_text::fault::Warning;

/// Share of a radius by which two discs may miss each other at a point.
const ROUND_OFF: f64 = 1e-9;

/// Share by which circles are larger than their discs where corners are sought.
const LARGER: f64 = 1e-6;

/// A sphere as seen along gravity.
#[derive(Clone, Copy)]
struct Disc {
    centre: Vector,
    radius: f64,
}

impl Disc {
    fn enlarged(self) -> Self {
        Self { radius: self.radius * (1.0 + LARGER), ..self }
    }

    fn holds(self, point: Vector) -> bool {
        self.centre.distance(point) <= self.radius * (1.0 + ROUND_OFF)
    }
}

/// The discs of a door in the order of their places along one axis, so that only near ones are examined.
struct Discs {
    sorted: Vec<Disc>,
    /// The largest radius, m.
    largest: f64,
}

impl Discs {
    fn new(mut discs: Vec<Disc>) -> Self {
        discs.sort_unstable_by(|a, b| a.centre.x.total_cmp(&b.centre.x));
        let largest = discs.iter().map(|disc| disc.radius).fold(0.0, f64::max);
        Self { sorted: discs, largest }
    }

    /// Returns the discs with a centre within `reach` (m) of a place on the axis.
    fn near(&self, x: f64, reach: f64) -> &[Disc] {
        let first = self.sorted.partition_point(|disc| disc.centre.x < x - reach);
        let end = self.sorted.partition_point(|disc| disc.centre.x <= x + reach);
        &self.sorted[first..end]
    }

    fn hold(&self, point: Vector) -> bool {
        self.near(point.x, self.largest * (1.0 + ROUND_OFF)).iter().any(|disc| disc.holds(point))
    }
}

/// Adds a warning for each door with a gap.
pub(super) fn examine(loaded: &Loaded, warnings: &mut Vec<Warning>) {
    let gravity = loaded.scene.gravity.padded().unit_or_zero();
    if gravity == Solid::ZERO {
        return;
    }
    let (first, second) = match loaded.scene.space {
        Dimension::Plane => (Solid::new(gravity.y, -gravity.x, 0.0), Solid::ZERO),
        Dimension::Solid => gravity.any_orthonormal_pair(),
    };
    let mut doors: BTreeMap<u16, Option<Vec<Disc>>> = BTreeMap::new();
    for wall in &loaded.scene.walls {
        let Some(door) = loaded.scene.door_of(wall) else { continue };
        let discs = doors.entry(door).or_insert_with(|| Some(Vec::new()));
        if let WallShape::Disc { centre, radius } = wall.shape {
            let centre = centre.padded();
            let disc = Disc { centre: Vector::new(centre.dot(first), centre.dot(second)), radius: radius.get() };
            if let Some(all) = discs {
                all.push(disc);
            }
        } else {
            *discs = None;
        }
    }
    for point in doors.into_values().flatten().filter_map(gap) {
        let place = first * point.x + second * point.y;
        let across = match loaded.scene.space {
            Dimension::Plane => format!("({:.4}, {:.4})", place.x, place.y),
            Dimension::Solid => format!("({:.4}, {:.4}, {:.4})", place.x, place.y, place.z),
        };
        warnings.push(Warning {
            code: "check::gap_in_door",
            message: format!(
                "the spheres of the door leave a gap; seen along gravity it is at {across} m. A grain whose centre passes through it is not counted as out"
            ),
            help: "let the spheres overlap until none can be seen through, or make the door of a flat surface".to_owned(),
        });
    }
}

/// Returns a point between the centres that no disc holds.
fn gap(discs: Vec<Disc>) -> Option<Vector> {
    let corners = hull(discs.iter().map(|disc| disc.centre).collect());
    let discs = Discs::new(discs);
    let is_bare = |point: &Vector| !discs.hold(*point);
    let edges = || corners.windows(2).filter(|edge| edge[0] != edge[1]).map(|edge| [edge[0], edge[1]]);
    let on_edges = edges().flat_map(|edge| discs.sorted.iter().flat_map(move |disc| on_edge(disc.enlarged(), edge)));
    if let Some(point) = on_edges.flatten().find(is_bare) {
        return Some(point);
    }
    let is_inside = |point: &Vector| {
        edges().all(|[from, to]| (to - from).perp_dot(*point - from) > ROUND_OFF * (to - from).length_squared())
    };
    let meetings = discs.sorted.iter().flat_map(|a| {
        let reach = (a.radius + discs.largest) * (1.0 + LARGER);
        discs.near(a.centre.x, reach).iter().flat_map(|b| meeting(a.enlarged(), b.enlarged()))
    });
    meetings.flatten().find(|point| is_inside(point) && is_bare(point))
}

/// The points at which a circle meets an edge.
fn on_edge(disc: Disc, [from, to]: [Vector; 2]) -> [Option<Vector>; 2] {
    let along = (to - from).normalize();
    let middle = (disc.centre - from).dot(along);
    let off = (disc.centre - from).perp_dot(along);
    let half = (disc.radius * disc.radius - off * off).sqrt();
    let point = |at: f64| (at > 0.0 && at < from.distance(to)).then(|| from + along * at);
    // Where the circle does not reach the edge, the half is not a number, and no comparison holds.
    [point(middle - half), point(middle + half)]
}

/// The points at which two circles meet.
fn meeting(a: Disc, b: Disc) -> [Option<Vector>; 2] {
    let way = b.centre - a.centre;
    let distance = way.length();
    let is_apart = distance > a.radius + b.radius || distance < (a.radius - b.radius).abs();
    if is_apart || distance == 0.0 {
        return [None; 2];
    }
    let along = 0.5 * (distance + (a.radius * a.radius - b.radius * b.radius) / distance);
    let half = (a.radius * a.radius - along * along).max(0.0).sqrt();
    let middle = a.centre + way * (along / distance);
    let across = way.perp() * (half / distance);
    [Some(middle + across), Some(middle - across)]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Discs on a square lattice.
    fn lattice(columns: i32, rows: i32, spacing: f64, radius: f64) -> Vec<Disc> {
        let centre = |n: i32| Vector::new(f64::from(n % columns), f64::from(n / columns)) * spacing;
        (0..columns * rows).map(|n| Disc { centre: centre(n), radius }).collect()
    }

    #[test]
    fn a_row_has_a_gap_where_discs_do_not_touch() {
        assert!(gap(lattice(5, 1, 1.0, 0.5)).is_none());
        let found = gap(lattice(5, 1, 1.0, 0.49)).unwrap();
        assert!(found.y.abs() < 1e-12 && (found.x.fract() - 0.5).abs() < 0.011, "{found}");
        // A large disc that covers a gap between two small ones.
        let mut row = lattice(2, 1, 1.0, 0.4);
        row.push(Disc { centre: Vector::new(0.5, 0.0), radius: 0.3 });
        assert!(gap(row.clone()).is_none());
        row[2].radius = 0.05;
        assert!(gap(row.clone()).is_some());
        // Two equal discs, each on the circle of the other.
        row[2] = row[0];
        assert!(gap(row.clone()).is_some());
        assert!(gap(lattice(1, 1, 1.0, 0.1)).is_none() && gap(vec![]).is_none());
    }

    #[test]
    fn a_lattice_has_a_gap_until_its_diagonals_are_covered() {
        // The middle of a cell is sqrt(1/2) from its four centres.
        assert!(gap(lattice(4, 3, 1.0, 0.708)).is_none());
        for radius in [0.706, 0.5, 0.3] {
            assert!(gap(lattice(4, 3, 1.0, radius)).is_some(), "{radius}");
        }
        let mut twice = lattice(4, 3, 1.0, 0.5);
        twice.extend(lattice(4, 3, 1.0, 0.5));
        assert!(gap(twice).is_some());
        // A missing disc inside, whose place the neighbours cover, or not.
        for (radius, is_open) in [(0.99, true), (1.01, false)] {
            let mut ring = lattice(3, 3, 1.0, radius);
            ring.remove(4);
            assert_eq!(gap(ring).is_some(), is_open, "{radius}");
        }
    }
}
