//! Flat convex polygons: the hull of points, the part on one side of a plane, the area, and polygons that share whole edges.

use crate::space::{Linear, Solid, Space, Vector};

/// Returns the part of a convex polygon in which `depth`, a linear function of the place, is not negative.
pub(crate) fn clip<V: Space>(corners: &[V], depth: impl Fn(V) -> f64) -> Vec<V> {
    let mut kept = Vec::new();
    for (n, &here) in corners.iter().enumerate() {
        let next = corners[(n + 1) % corners.len()];
        let of_here = depth(here);
        let of_next = depth(next);
        if of_here >= 0.0 {
            kept.push(here);
        }
        if (of_here < 0.0) != (of_next < 0.0) {
            kept.push(here + (next - here) * (of_here / (of_here - of_next)));
        }
    }
    kept
}

/// Returns the area of a flat convex polygon, m^2.
pub(crate) fn area<V: Space>(corners: &[V]) -> f64 {
    let Some((&first, rest)) = corners.split_first() else { return 0.0 };
    let crosses = rest.windows(2).map(|pair| (pair[0] - first).cross(pair[1] - first).spread());
    0.5 * crosses.sum::<Solid>().length()
}

/// Adds corners of other polygons that lie on an edge of a polygon to that edge, so that neighbours share whole edges. Points nearer than
/// `tolerance` (m) are one point.
pub fn share_edges<V: Space>(polygons: &mut [Vec<V>], tolerance: f64) {
    // In the order of x, so that an edge looks only at the corners beside it.
    let mut corners = polygons.concat();
    corners.sort_unstable_by(|a, b| a.axis(0).total_cmp(&b.axis(0)));
    for polygon in polygons {
        let edges = polygon.iter().zip(polygon.iter().cycle().skip(1));
        *polygon = edges
            .flat_map(|(&from, &to)| std::iter::once(from).chain(between(from, to, &corners, tolerance)))
            .collect();
    }
}

/// Returns the points that lie on a line between its ends, in their order from the first end. `points` are in the order of x.
fn between<V: Space>(from: V, to: V, points: &[V], tolerance: f64) -> Vec<V> {
    let way = to - from;
    let length = (to - from).length();
    let place = |x: V| (x - from).dot(way) / length;
    let is_on_the_line = |x: &V| {
        let along = place(*x);
        along > tolerance && along < length - tolerance && (*x - from - way * (along / length)).length() < tolerance
    };
    let left = from.axis(0).min(to.axis(0)) - tolerance;
    let right = from.axis(0).max(to.axis(0)) + tolerance;
    let beside = &points[points.partition_point(|x| x.axis(0) < left)..points.partition_point(|x| x.axis(0) <= right)];
    let mut found: Vec<V> = beside.iter().copied().filter(is_on_the_line).collect();
    found.sort_by(|a, b| place(*a).total_cmp(&place(*b)));
    found.dedup_by(|a, b| a.distance(*b) < tolerance);
    found
}

/// Returns the corners of the convex hull of some points, once round it from the leftmost one and back to it (Andrew, Inf. Process. Lett. 9, 216, 1979). The
/// rightmost corner stands there twice. The points that are farthest apart are corners.
#[must_use]
pub fn hull(mut points: Vec<Vector>) -> Vec<Vector> {
    points.sort_unstable_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
    points.dedup();
    let chain = |points: &mut dyn Iterator<Item = Vector>| {
        let mut chain: Vec<Vector> = Vec::new();
        for point in points {
            while let [.., a, b] = chain[..]
                && (b - a).perp_dot(point - b) <= 0.0
            {
                chain.pop();
            }
            chain.push(point);
        }
        chain
    };
    let mut lower = chain(&mut points.iter().copied());
    lower.extend(chain(&mut points.iter().rev().copied()));
    lower
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn polygons_beside_each_other_share_whole_edges() {
        let [a, b, c, d] = [(0.0, 0.0), (2.0, 0.0), (2.0, 1.0), (0.0, 1.0)].map(|(x, y)| Solid::new(x, y, 0.0));
        let middle = Solid::new(1.0, 0.0, 0.0);
        let low = Solid::new(0.5, -1.0, 0.0);
        let mut polygons = [vec![a, b, c, d], vec![low, middle, a], vec![low, b, middle]];
        share_edges(&mut polygons, 1e-9);
        assert_eq!(polygons, [vec![a, middle, b, c, d], vec![low, middle, a], vec![low, b, middle]]);
    }
}
