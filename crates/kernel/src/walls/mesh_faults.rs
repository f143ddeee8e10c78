//! Faults of triangles that do not keep a mesh from being a wall, but make its contacts doubtful.
//!
//! * *T-junction*: a corner on an edge that has no neighbour of its own there. The seam between the triangles is then an edge.
//! * *Sliver*: a triangle whose height is below a hundredth of its longest edge.
//! * *Overlap*: two triangles in one plane that cover a common area. A grain there touches the nearer one, at random.
//! * *Reversed*: an edge that its two triangles pass in the same direction, so that one is turned against the other. Walls are
//!   two-sided, so this matters to other programs only.
//!
//! Tolerances are relative to the lengths of the edges.

use rustc_hash::FxHashMap;

use crate::space::Solid;

/// Height of a sliver over its longest edge.
const SLIVER: f64 = 0.01;

/// Largest distance of a corner from an edge or a plane that it lies on, over the length of the edge.
const ON: f64 = 1e-6;

/// Most pairs of triangles whose overlap is examined.
const PATIENCE: usize = 5_000_000;

/// Numbers of the triangles with a fault, from 1.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct MeshFaults {
    /// Triangles that have an edge with a corner of another triangle in its middle.
    pub t_junctions: Vec<usize>,
    /// Slivers.
    pub slivers: Vec<usize>,
    /// Pairs of triangles that overlap in a plane.
    pub overlaps: Vec<(usize, usize)>,
    /// Number of edges that two triangles pass in the same direction.
    pub reversed: usize,
}

/// Returns the faults of a mesh.
#[must_use]
pub fn faults(triangles: &[[Solid; 3]]) -> MeshFaults {
    let edges = edges(triangles);
    let open: Vec<_> = edges.values().filter(|found| found.len() == 1).map(|found| found[0]).collect();
    MeshFaults {
        t_junctions: t_junctions(triangles, &open),
        slivers: (1..).zip(triangles).filter(|(_, triangle)| is_sliver(triangle)).map(|(number, _)| number).collect(),
        overlaps: overlaps(triangles),
        reversed: edges.values().filter(|found| found.len() == 2 && found[0].2 == found[1].2).count(),
    }
}

/// Index of a triangle, index of an edge in it, and whether the edge runs from the lower to the higher corner.
type Edge = (usize, usize, bool);

fn key(corner: Solid) -> [u64; 3] {
    (corner + Solid::ZERO).to_array().map(f64::to_bits)
}

fn ends(triangles: &[[Solid; 3]], (triangle, edge, _): Edge) -> [Solid; 2] {
    [triangles[triangle][edge], triangles[triangle][(edge + 1) % 3]]
}

/// Returns the edges by their ends.
fn edges(triangles: &[[Solid; 3]]) -> FxHashMap<[[u64; 3]; 2], Vec<Edge>> {
    let mut edges: FxHashMap<_, Vec<Edge>> = FxHashMap::default();
    for triangle in 0..triangles.len() {
        for edge in 0..3 {
            let [from, to] = ends(triangles, (triangle, edge, true)).map(key);
            let is_forward = from <= to;
            let ends = if is_forward { [from, to] } else { [to, from] };
            edges.entry(ends).or_default().push((triangle, edge, is_forward));
        }
    }
    edges
}

fn is_sliver(&[a, b, c]: &[Solid; 3]) -> bool {
    let longest = a.distance(b).max(b.distance(c)).max(c.distance(a));
    (b - a).cross(c - a).length() < SLIVER * longest * longest
}

/// Returns the triangles with an open edge that a corner of another open edge divides.
fn t_junctions(triangles: &[[Solid; 3]], open: &[Edge]) -> Vec<usize> {
    let mut corners: Vec<Solid> = open.iter().flat_map(|&edge| ends(triangles, edge)).collect();
    corners.sort_unstable_by(|a, b| a.x.total_cmp(&b.x));
    let is_divided = |&edge: &Edge| {
        let [from, to] = ends(triangles, edge);
        let way = to - from;
        let tolerance = ON * way.length();
        let (low, high) = (from.x.min(to.x) - tolerance, from.x.max(to.x) + tolerance);
        let first = corners.partition_point(|corner| corner.x < low);
        corners[first..].iter().take_while(|corner| corner.x <= high).any(|&corner| {
            let share = (corner - from).dot(way) / way.length_squared();
            let is_inside = share > ON && share < 1.0 - ON;
            is_inside && corner.distance(from + way * share) <= tolerance
        })
    };
    let mut found: Vec<_> = open.iter().filter(|edge| is_divided(edge)).map(|edge| edge.0 + 1).collect();
    found.sort_unstable();
    found.dedup();
    found
}

/// Returns the pairs of triangles in one plane that cover a common area.
fn overlaps(triangles: &[[Solid; 3]]) -> Vec<(usize, usize)> {
    let bounds = |triangle: &[Solid; 3]| {
        let [a, b, c] = *triangle;
        [a.min(b).min(c), a.max(b).max(c)]
    };
    let mut boxes: Vec<_> = triangles.iter().enumerate().map(|(index, triangle)| (index, bounds(triangle))).collect();
    boxes.sort_unstable_by(|a, b| a.1[0].x.total_cmp(&b.1[0].x));
    let (mut found, mut examined) = (Vec::new(), 0);
    for (place, (one, [low, high])) in boxes.iter().enumerate() {
        for (other, [other_low, other_high]) in boxes[place + 1..].iter().take_while(|other| other.1[0].x <= high.x) {
            examined += 1;
            if examined > PATIENCE {
                return found;
            }
            let apart = (1..3).any(|axis| other_low[axis] > high[axis] || other_high[axis] < low[axis]);
            if !apart && cover_common_area(&triangles[*one], &triangles[*other]) {
                found.push((one.min(other) + 1, one.max(other) + 1));
            }
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
            let (from, way) = (of[edge], of[(edge + 1) % 3] - of[edge]);
            let across = normal.cross(way).normalize();
            let sides = |triangle: &[Solid; 3]| triangle.map(|corner| (corner - from).dot(across));
            let (a, b) = (sides(one), sides(other));
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

    fn at(x: f64, y: f64) -> Solid {
        Solid::new(x, y, 0.3 * x)
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
        assert_eq!(faults(&shifted).overlaps, [(1, 2)]);
        let inside = [[at(0.0, 0.0), at(3.0, 0.0), at(0.0, 3.0)], [at(0.5, 0.5), at(0.5, 1.0), at(1.0, 0.5)]];
        assert_eq!(faults(&inside).overlaps, [(1, 2)]);
        let turned = [[at(0.0, 0.0), at(1.0, 0.0), at(1.0, 1.0)], [at(0.0, 1.0), at(1.0, 1.0), at(0.0, 0.0)]];
        assert_eq!(faults(&turned).reversed, 1);
    }

    #[test]
    fn triangles_in_parallel_or_crossing_planes_do_not_overlap() {
        let up = Solid::new(0.0, 0.0, 0.1);
        let flat = [at(0.0, 0.0), at(1.0, 0.0), at(1.0, 1.0)];
        let crossing = [Solid::new(0.5, 0.2, -1.0), Solid::new(0.5, 0.2, 1.0), Solid::new(0.9, 0.2, 0.0)];
        assert!(faults(&[flat, flat.map(|corner| corner + up)]).overlaps.is_empty());
        assert!(faults(&[flat, crossing]).overlaps.is_empty());
    }
}
