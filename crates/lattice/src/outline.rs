//! Polygons for the outline of a silo and its inserts: point-in-polygon test and nearest edge.

use siloflow_dem::math;
use siloflow_dem::space::Vector;

/// A closed polygon: its corners in order, clockwise or anticlockwise, m.
#[derive(Clone, Debug)]
pub struct Polygon(pub Vec<Vector>);

impl Polygon {
    /// Returns the edges (from, to), in the order of the corners.
    pub fn edges(&self) -> impl Iterator<Item = (Vector, Vector)> {
        let next = self.0.iter().skip(1).chain(self.0.first());
        self.0.iter().copied().zip(next.copied())
    }

    /// Whether the point `x` is inside, or within `tolerance` (m) of the boundary.
    #[must_use]
    pub fn holds(&self, x: Vector, tolerance: f64) -> bool {
        let is_on_edge = self.edges().any(|edge| distance(x, edge) <= tolerance);
        // A point is inside if a ray to its right crosses the boundary an odd number of times.
        let crosses = |(a, b): (Vector, Vector)| {
            (a.y > x.y) != (b.y > x.y) && x.x < a.x + (x.y - a.y) / (b.y - a.y) * (b.x - a.x)
        };
        is_on_edge || self.edges().filter(|&edge| crosses(edge)).count() % 2 == 1
    }

    /// Returns the lower left and the upper right corner of the bounding box, m.
    #[must_use]
    pub fn bounds(&self) -> (Vector, Vector) {
        let infinity = Vector::splat(f64::INFINITY);
        self.0.iter().fold((infinity, -infinity), |(low, high), &x| (low.min(x), high.max(x)))
    }

    /// Whether two edges that do not share a corner cross or touch.
    #[must_use]
    pub fn crosses_itself(&self) -> bool {
        let edges: Vec<_> = self.edges().collect();
        let are_neighbours = |i: usize, j: usize| i + 1 == j || (i == 0 && j + 1 == edges.len());
        let pairs = (0..edges.len()).flat_map(|i| (i + 1..edges.len()).map(move |j| (i, j)));
        pairs.into_iter().any(|(i, j)| !are_neighbours(i, j) && have_common_point(edges[i], edges[j]))
    }

    /// Returns the area, m^2.
    #[must_use]
    pub fn area(&self) -> f64 {
        0.5 * self.edges().map(|(a, b)| a.perp_dot(b)).sum::<f64>().abs()
    }
}

/// Whether two line segments have a point in common.
fn have_common_point((a, b): (Vector, Vector), (c, d): (Vector, Vector)) -> bool {
    let side = |from: Vector, to: Vector, x: Vector| (to - from).perp_dot(x - from);
    let are_apart = |p: f64, q: f64| p * q < 0.0;
    let touches = |x: Vector, edge| distance(x, edge) == 0.0;
    are_apart(side(a, b, c), side(a, b, d)) && are_apart(side(c, d, a), side(c, d, b))
        || [a, b].into_iter().any(|x| touches(x, (c, d)))
        || [c, d].into_iter().any(|x| touches(x, (a, b)))
}

/// Returns the distance of a point from a line segment, m. The segment must not have zero length.
#[must_use]
pub fn distance(x: Vector, (a, b): (Vector, Vector)) -> f64 {
    let along = b - a;
    let share = ((x - a).dot(along) / along.length_squared()).clamp(0.0, 1.0);
    x.distance(a + share * along)
}

/// Returns the angle between the edge nearest to `x` and the horizontal, degrees; 0 if there are no edges.
#[must_use]
pub fn nearest_tangent(x: Vector, edges: &[(Vector, Vector)]) -> f64 {
    let nearest = edges.iter().min_by(|&&a, &&b| distance(x, a).total_cmp(&distance(x, b)));
    nearest.map_or(0.0, |&(a, b)| math::atan2((b - a).y, (b - a).x).to_degrees())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn hopper() -> Polygon {
        Polygon([(-1.0, 0.0), (1.0, 0.0), (3.0, 2.0), (-3.0, 2.0)].map(|(x, y)| Vector::new(x, y)).to_vec())
    }

    #[test]
    fn a_polygon_holds_its_inside_and_its_boundary() {
        for (x, y, expected) in [
            (0.0, 1.0, true),
            (1.9, 1.0, true),
            (2.0, 1.0, true),
            (2.1, 1.0, false),
            (0.0, -0.1, false),
            (0.0, 2.0, true),
        ] {
            assert_eq!(hopper().holds(Vector::new(x, y), 1e-9), expected, "({x}, {y})");
        }
        assert!((hopper().area() - 8.0).abs() < 1e-12);
    }

    #[test]
    fn a_bow_tie_crosses_itself() {
        assert!(!hopper().crosses_itself());
        let bow_tie =
            |y: f64| Polygon([(0.0, 0.0), (1.0, 1.0), (1.0, y), (0.0, 1.0)].map(|(x, y)| Vector::new(x, y)).to_vec());
        assert!(bow_tie(0.0).crosses_itself() && bow_tie(-1.0).crosses_itself() && !bow_tie(2.0).crosses_itself());
    }

    #[test]
    fn the_tangent_is_the_angle_of_the_nearest_edge() {
        let edges: Vec<_> = hopper().edges().collect();
        assert!((nearest_tangent(Vector::new(1.8, 1.0), &edges) - 45.0).abs() < 1e-12);
        assert!(nearest_tangent(Vector::new(0.0, 0.2), &edges).abs() < 1e-12);
    }
}
