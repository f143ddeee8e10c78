//! Faults of triangles that do not keep a mesh from being a wall, but make its contacts doubtful.
//!
//! * *T-junction*: a corner on an edge that has no neighbour of its own there. The seam between the triangles is then an edge.
//! * *Sliver*: a triangle whose height is below a hundredth of its longest edge.
//! * *Overlap*: two triangles in one plane that cover a common area. A grain there touches the nearer one, at random.
//! * *Reversed*: an edge that its two triangles pass in the same direction, so that one is turned against the other. Walls are
//!   two-sided, so this matters to other programs only.
//!
//! Tolerances are relative to the lengths of the edges.
//!
//! Searches go through trees (`walls::box_tree`), in which a corner far from the line of an edge, and a triangle far from the plane of another or in another
//! direction, are never looked at. So the time is about n log n also where all triangles have a corner in common or cross each other.

use std::collections::BTreeSet;
use std::ops::ControlFlow;

use rustc_hash::FxHashMap;

use crate::budget::Budget;
use crate::space::Solid;
use crate::walls::box_tree::{Bounds, BoxTree};

/// Height of a sliver over its longest edge.
const SLIVER: f64 = 0.01;

/// Largest distance of a corner from an edge or a plane that it lies on, over the length of the edge.
const ON: f64 = 1e-6;

/// Most pairs of triangles that are listed: where all overlap, there are n^2/2.
pub const MOST_OVERLAPS: usize = 1000;

/// Numbers of the triangles with a fault, from 1.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct MeshFaults {
    /// Triangles that have an edge with a corner of another triangle in its middle.
    pub t_junctions: Vec<usize>,
    /// Slivers.
    pub slivers: Vec<usize>,
    /// Pairs of triangles that overlap in a plane, at most [`MOST_OVERLAPS`].
    pub overlaps: Vec<[usize; 2]>,
}

/// Returns the faults of a mesh. Where the budget ends, it is told what was not examined: `what`, and the part of it.
#[must_use]
pub fn faults(triangles: &[[Solid; 3]], what: &str, budget: &Budget) -> MeshFaults {
    let slivers = (1..).zip(triangles).filter(|(_, triangle)| is_sliver(triangle)).map(|(number, _)| number).collect();
    let t_junctions = budget.share(0.5, || t_junctions(triangles, what, budget));
    MeshFaults { t_junctions, slivers, overlaps: overlaps(triangles, what, budget) }
}

/// Returns the number of edges that two triangles pass in the same direction.
#[must_use]
pub fn reversed(triangles: &[[Solid; 3]]) -> usize {
    edges(triangles).values().filter(|found| found.len() == 2 && found[0].is_forward == found[1].is_forward).count()
}

/// An edge of a triangle.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Edge {
    /// Index of the triangle.
    triangle: usize,
    /// Index of the edge among the sides of the triangle.
    side: usize,
    /// Whether the edge runs from the lower to the higher corner.
    is_forward: bool,
}

fn key(corner: Solid) -> [u64; 3] {
    (corner + Solid::ZERO).to_array().map(f64::to_bits)
}

fn ends(triangles: &[[Solid; 3]], triangle: usize, side: usize) -> [Solid; 2] {
    [triangles[triangle][side], triangles[triangle][(side + 1) % 3]]
}

/// Returns the edges by their ends.
fn edges(triangles: &[[Solid; 3]]) -> FxHashMap<[[u64; 3]; 2], Vec<Edge>> {
    let mut edges: FxHashMap<_, Vec<Edge>> = FxHashMap::default();
    for triangle in 0..triangles.len() {
        for side in 0..3 {
            let [from, to] = ends(triangles, triangle, side).map(key);
            let is_forward = from <= to;
            let ends = if is_forward { [from, to] } else { [to, from] };
            edges.entry(ends).or_default().push(Edge { triangle, side, is_forward });
        }
    }
    edges
}

fn is_sliver(&[a, b, c]: &[Solid; 3]) -> bool {
    let longest = a.distance(b).max(b.distance(c)).max(c.distance(a));
    (b - a).cross(c - a).length() < SLIVER * longest * longest
}

/// Returns the triangles with an open edge that a corner of another open edge divides.
fn t_junctions(triangles: &[[Solid; 3]], what: &str, budget: &Budget) -> Vec<usize> {
    let mut open: Vec<Edge> =
        edges(triangles).into_values().filter(|found| found.len() == 1).map(|found| found[0]).collect();
    open.sort_unstable();
    let places: BTreeSet<_> = open.iter().flat_map(|edge| ends(triangles, edge.triangle, edge.side)).map(key).collect();
    let corners: Vec<Solid> = places.into_iter().map(|place| Solid::from_array(place.map(f64::from_bits))).collect();
    let tree = BoxTree::new(&corners.iter().map(|corner| [corner.to_array(); 2]).collect::<Vec<_>>());
    let is_divided = |edge: Edge| {
        let [from, to] = ends(triangles, edge.triangle, edge.side);
        let way = to - from;
        let tolerance = ON * way.length();
        let found = tree.search(
            |bounds| !budget.is_spent() && meets_line(bounds, from, way, tolerance),
            |corner| {
                let corner = corners[corner];
                let share = (corner - from).dot(way) / way.length_squared();
                let is_inside = share > ON && share < 1.0 - ON;
                let is_on = is_inside && corner.distance(from + way * share) <= tolerance;
                if is_on { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
            },
        );
        found.is_break()
    };
    let mut found = Vec::new();
    for (done, &edge) in open.iter().enumerate() {
        if budget.is_spent() {
            budget.give_up(format!("T-junctions {what}, after {done} of {} open edges", open.len()));
            break;
        }
        found.extend(is_divided(edge).then_some(edge.triangle + 1));
    }
    found.dedup();
    found
}

/// Whether a box comes near the line from `from` along `way` (its slabs, axis by axis).
fn meets_line([low, high]: &Bounds<3>, from: Solid, way: Solid, margin: f64) -> bool {
    let mut enters = 0.0f64;
    let mut leaves = 1.0f64;
    for axis in 0..3 {
        let [low, high] = [low[axis] - margin - from[axis], high[axis] + margin - from[axis]];
        if way[axis] == 0.0 {
            if low > 0.0 || high < 0.0 {
                return false;
            }
            continue;
        }
        let [one, other] = [low / way[axis], high / way[axis]];
        enters = enters.max(one.min(other));
        leaves = leaves.min(one.max(other));
    }
    enters <= leaves + ON
}

/// A triangle as overlaps see it.
struct Flat {
    corners: [Solid; 3],
    low: Solid,
    high: Solid,
    /// Unit normal.
    normal: Solid,
    /// Length of the longest edge at the first corner, m.
    size: f64,
    /// Least height over that length.
    thickness: f64,
}

impl Flat {
    fn new(&corners: &[Solid; 3]) -> Self {
        let [a, b, c] = corners;
        let across = (b - a).cross(c - a);
        let longest = a.distance(b).max(b.distance(c)).max(c.distance(a));
        Self {
            corners,
            low: a.min(b).min(c),
            high: a.max(b).max(c),
            normal: across.normalize(),
            size: a.distance(b).max(a.distance(c)),
            thickness: across.length() / longest,
        }
    }

    /// Place, products of the components of the normal (which do not depend on its sign), and the least height below zero, so that the upper
    /// bound of a branch tells of its thinnest triangle.
    fn bounds(&self) -> Bounds<10> {
        let n = self.normal;
        let products = [n.x * n.x, n.y * n.y, n.z * n.z, n.x * n.y, n.y * n.z, n.z * n.x];
        let with = |x: Solid| {
            [
                x.x,
                x.y,
                x.z,
                products[0],
                products[1],
                products[2],
                products[3],
                products[4],
                products[5],
                -self.thickness,
            ]
        };
        [with(self.low), with(self.high)]
    }

    /// Whether a triangle with these bounds may lie in the plane of this one, over a common place.
    fn may_overlap(&self, own: &Bounds<10>, [low, high]: &Bounds<10>) -> bool {
        if (0..3).any(|axis| low[axis] > own[1][axis] || high[axis] < own[0][axis]) {
            return false;
        }
        // The corners of the other are within `ON` sizes of this plane, so its normal is turned by at most twice this over its height. Each
        // product changes by at most twice the angle.
        let angle = 2.0 * ON * self.size / -high[9];
        let margin = 2.0 * angle + 1e-12;
        if (3..9).any(|axis| low[axis] > own[1][axis] + margin || high[axis] < own[0][axis] - margin) {
            return false;
        }
        // The plane passes between the corners of the box.
        let [low, high] = [low, high].map(|corner| Solid::new(corner[0], corner[1], corner[2]));
        let middle = 0.5 * (low + high) - self.corners[0];
        let half = 0.5 * (high - low);
        let reach = half.dot(self.normal.abs()) + ON * self.size;
        middle.dot(self.normal).abs() <= reach * (1.0 + 1e-12)
    }
}

/// Returns the pairs of triangles in one plane that cover a common area, at most [`MOST_OVERLAPS`]. Where the budget ends, it is told so.
#[must_use]
fn overlaps(triangles: &[[Solid; 3]], what: &str, budget: &Budget) -> Vec<[usize; 2]> {
    let flat: Vec<_> = triangles.iter().map(Flat::new).collect();
    let bounds: Vec<_> = flat.iter().map(Flat::bounds).collect();
    let tree = BoxTree::new(&bounds);
    let mut found = Vec::new();
    for (one, own) in flat.iter().enumerate() {
        let mut is_cut_short = false;
        let _ = tree.search(
            |branch| {
                is_cut_short = is_cut_short || budget.is_spent();
                !is_cut_short && own.may_overlap(&bounds[one], branch)
            },
            |other| {
                // The first of a pair is the one that begins at the lower x.
                let [x, its_x] = [own.low.x, flat[other].low.x];
                let is_first = x < its_x || (x <= its_x && one < other);
                if is_first
                    && own.may_overlap(&bounds[one], &bounds[other])
                    && cover_common_area(&own.corners, &triangles[other])
                {
                    found.push([one.min(other) + 1, one.max(other) + 1]);
                }
                if found.len() == MOST_OVERLAPS { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
            },
        );
        if is_cut_short {
            budget.give_up(format!("overlaps {what}, after {one} of {} triangles", triangles.len()));
        }
        if is_cut_short || found.len() == MOST_OVERLAPS {
            break;
        }
    }
    found.sort_unstable();
    found
}

/// Whether two triangles lie in one plane, and no line along an edge of either parts them.
fn cover_common_area(one: &[Solid; 3], other: &[Solid; 3]) -> bool {
    let normal = (one[1] - one[0]).cross(one[2] - one[0]).normalize();
    let size = one[0].distance(one[1]).max(one[0].distance(one[2]));
    if other.iter().any(|&corner| (corner - one[0]).dot(normal).abs() > ON * size) {
        return false;
    }
    let parts = |of: &[Solid; 3]| {
        (0..3).any(|edge| {
            let from = of[edge];
            let way = of[(edge + 1) % 3] - of[edge];
            let across = normal.cross(way).normalize();
            let sides = |triangle: &[Solid; 3]| triangle.map(|corner| (corner - from).dot(across));
            let a = sides(one);
            let b = sides(other);
            let low = |of: [f64; 3]| of.into_iter().fold(f64::INFINITY, f64::min);
            let high = |of: [f64; 3]| of.into_iter().fold(f64::NEG_INFINITY, f64::max);
            let margin = ON * size;
            high(a) <= low(b) + margin || high(b) <= low(a) + margin
        })
    };
    !parts(one) && !parts(other)
}

#[cfg(test)]
mod tests {
    use super::*;

    use std::time::{Duration, Instant};

    fn at(x: f64, y: f64) -> Solid {
        Solid::new(x, y, 0.3 * x)
    }

    fn faults(triangles: &[[Solid; 3]]) -> MeshFaults {
        super::faults(triangles, "of a mesh", &Budget::of(Duration::MAX))
    }

    #[test]
    fn a_square_of_two_triangles_has_no_fault() {
        let square = [[at(0.0, 0.0), at(1.0, 0.0), at(1.0, 1.0)], [at(0.0, 0.0), at(1.0, 1.0), at(0.0, 1.0)]];
        assert_eq!(faults(&square), MeshFaults::default());
    }

    #[test]
    fn each_fault_is_found() {
        // The long edge of the first triangle meets two short ones.
        let junction = [
            [at(0.0, 0.0), at(2.0, 0.0), at(1.0, 2.0)],
            [at(0.0, 0.0), at(0.0, -1.0), at(1.0, 0.0)],
            [at(1.0, 0.0), at(1.0, -1.0), at(2.0, 0.0)],
        ];
        assert_eq!(faults(&junction).t_junctions, [1]);
        let sliver = [[at(0.0, 0.0), at(2.0, 0.0), at(1.0, 0.015)]];
        assert_eq!(faults(&sliver).slivers, [1]);
        let shifted = [[at(0.0, 0.0), at(1.0, 0.0), at(1.0, 1.0)], [at(0.5, 0.0), at(1.5, 0.0), at(1.5, 1.0)]];
        assert_eq!(faults(&shifted).overlaps, [[1, 2]]);
        let inside = [[at(0.0, 0.0), at(3.0, 0.0), at(0.0, 3.0)], [at(0.5, 0.5), at(0.5, 1.0), at(1.0, 0.5)]];
        assert_eq!(faults(&inside).overlaps, [[1, 2]]);
        let turned = [[at(0.0, 0.0), at(1.0, 0.0), at(1.0, 1.0)], [at(0.0, 1.0), at(1.0, 1.0), at(0.0, 0.0)]];
        assert_eq!((reversed(&turned), reversed(&shifted)), (1, 0));
    }

    #[test]
    fn triangles_in_parallel_or_crossing_planes_do_not_overlap() {
        let up = Solid::new(0.0, 0.0, 0.1);
        let flat = [at(0.0, 0.0), at(1.0, 0.0), at(1.0, 1.0)];
        let crossing = [Solid::new(0.5, 0.2, -1.0), Solid::new(0.5, 0.2, 1.0), Solid::new(0.9, 0.2, 0.0)];
        assert!(faults(&[flat, flat.map(|corner| corner + up)]).overlaps.is_empty());
        assert!(faults(&[flat, crossing]).overlaps.is_empty());
    }

    /// Numbers between 0 and 1 without order.
    fn random() -> impl FnMut() -> f64 {
        let mut state = 1u64;
        move || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            f64::from((state >> 33) as u32) / f64::from(1u32 << 31)
        }
    }

    #[test]
    fn overlaps_are_those_of_all_pairs() {
        let mut u = random();
        // Triangles of very different sizes and shapes in few planes, and some turned by rounding.
        let mut point = |plane: f64, size: f64| {
            let x = u() - 0.5 + size * u();
            let y = u() - 0.5 + size * u();
            at(x, y) + Solid::new(0.0, 0.0, 0.1 * plane + 1e-9 * u())
        };
        let triangles: Vec<[Solid; 3]> = (0..200)
            .map(|n| {
                let size = [1.0, 0.1, 0.003][n % 3];
                let plane = [0.0, 1.0, 2.0, 3.0][n % 4];
                let a = 0.0;
                let corner = point(plane, 0.0);
                [corner, corner + size * (point(plane, a) - corner), corner + size * (point(plane, a) - corner)]
            })
            .collect();
        let mut expected = Vec::new();
        for one in 0..triangles.len() {
            for other in one + 1..triangles.len() {
                let lowest = |t: usize| triangles[t].iter().map(|corner| corner.x).fold(f64::INFINITY, f64::min);
                let (first, second) = if lowest(other) < lowest(one) { (other, one) } else { (one, other) };
                if cover_common_area(&triangles[first], &triangles[second]) {
                    expected.push([one + 1, other + 1]);
                }
            }
        }
        assert!(expected.len() > 100 && expected.len() < MOST_OVERLAPS, "{}", expected.len());
        assert_eq!(faults(&triangles).overlaps, expected);
    }

    /// Pair by pair, each of these takes minutes.
    #[test]
    fn many_triangles_at_one_corner_or_across_each_other_take_little_time() {
        let n = 20_000;
        let mut u = random();
        let mut corner = || Solid::new(u(), u(), u());
        let crossing: Vec<_> = (0..n).map(|_| [corner(), corner(), corner()]).collect();
        let fan: Vec<_> = (0..n).map(|_| [Solid::ZERO, corner(), corner()]).collect();
        let round = |k: i32| Solid::new((1.57e-4 * f64::from(k)).cos(), (1.57e-4 * f64::from(k)).sin(), 1.0);
        let cone: Vec<_> = (0..n).map(|k| [Solid::ZERO, round(k), round(k + 1)]).collect();
        for (number, mesh) in [crossing, fan, cone].iter().enumerate() {
            let start = Instant::now();
            let found = faults(mesh);
            assert!(start.elapsed() < Duration::from_secs(20), "{number}: {:?}", start.elapsed());
            assert!(found.overlaps.is_empty() && found.t_junctions.is_empty(), "{number}");
        }
    }

    #[test]
    fn reports_are_bounded_and_an_empty_budget_says_what_was_not_examined() {
        let pile: Vec<_> = (0..3000).map(|n| [at(0.0, 0.0), at(1.0, 0.0), at(1.0 + f64::from(n), 1.0)]).collect();
        assert_eq!(faults(&pile).overlaps.len(), MOST_OVERLAPS);
        let empty = Budget::of(Duration::ZERO);
        assert!(super::faults(&pile, "of a pile", &empty).overlaps.is_empty());
        let unfinished = empty.take_unfinished();
        assert!(unfinished[0].starts_with("T-junctions of a pile") && unfinished[1].starts_with("overlaps of a pile"));
    }
}
