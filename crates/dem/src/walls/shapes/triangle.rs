//! Triangle of solid space. Polygons and meshes are made of triangles.
//!
//! The nearest point is found region by region: at a corner, on an edge or in the face (C. Ericson, Real-Time Collision
//! Detection, 2005, section 5.1.5).

use crate::space::{Linear, Plane, Space};
use crate::walls::area::clipped_area;
use crate::walls::drawing::{Detail, Drawing};
use crate::walls::pose::Pose;
use crate::walls::shapes::{Nearest, Shape, box_around};

/// A thin triangle.
#[derive(Clone, Copy, Debug)]
pub struct Triangle<V: Space = Plane>(pub [V; 3]);

impl<V: Space> Triangle<V> {
    /// Returns the nearest point, m, and whether it is on an edge or at a corner.
    #[inline]
    fn nearest_point(&self, x: V) -> (V, bool) {
        let [a, b, c] = self.0;
        let ab = b - a;
        let ac = c - a;
        let [(a1, a2), (b1, b2), (c1, c2)] = self.0.map(|corner| (ab.dot(x - corner), ac.dot(x - corner)));
        if a1 <= 0.0 && a2 <= 0.0 {
            return (a, true);
        }
        if b1 >= 0.0 && b2 <= b1 {
            return (b, true);
        }
        if c2 >= 0.0 && c1 <= c2 {
            return (c, true);
        }
        let of_a = b1 * c2 - c1 * b2;
        let of_b = c1 * a2 - a1 * c2;
        let of_c = a1 * b2 - b1 * a2;
        if of_c <= 0.0 && a1 >= 0.0 && b1 <= 0.0 {
            return (a + ab * (a1 / (a1 - b1)), true);
        }
        if of_b <= 0.0 && a2 >= 0.0 && c2 <= 0.0 {
            return (a + ac * (a2 / (a2 - c2)), true);
        }
        let towards_c = b2 - b1;
        let towards_b = c1 - c2;
        if of_a <= 0.0 && towards_c >= 0.0 && towards_b >= 0.0 {
            return (b + (c - b) * (towards_c / (towards_c + towards_b)), true);
        }
        let whole = of_a + of_b + of_c;
        (a + ab * (of_b / whole) + ac * (of_c / whole), false)
    }
}

impl<V: Space> Shape<V> for Triangle<V> {
    #[inline]
    fn nearest(&self, x: V) -> Nearest<V> {
        let (point, at_edge) = self.nearest_point(x);
        Nearest::flat(x - point, at_edge, || {
            let [a, b, c] = self.0.map(Linear::spread);
            V::narrow((b - a).cross(c - a)).unit_or_zero()
        })
    }

    fn bounds(&self) -> Option<[V; 2]> {
        box_around(&self.0)
    }

    fn placed(&self, pose: &Pose<V>) -> Self {
        Self(self.0.map(|corner| pose.point(corner)))
    }

    /// On an edge that two triangles share, the path crosses at least one of them.
    fn crossing(&self, from: V, to: V) -> Option<f64> {
        let [a, b, c] = self.0.map(|corner| Linear::spread(corner) - from.spread());
        let way = Linear::spread(to - from);
        // Volumes of the tetrahedra of the path and each edge: of one sign if the path passes inside all edges.
        let beside = [way.cross(a).dot(b), way.cross(b).dot(c), way.cross(c).dot(a)];
        let passes = beside.iter().all(|&volume| volume >= 0.0) || beside.iter().all(|&volume| volume <= 0.0);
        let normal = (b - a).cross(c - a);
        let share = a.dot(normal) / way.dot(normal);
        // A path along the plane of the triangle has no share that is finite.
        (passes && (0.0..=1.0).contains(&share)).then_some(share)
    }

    fn reference(&self) -> V {
        self.0[0]
    }

    fn area_between(&self, low: f64, high: f64) -> Option<f64> {
        Some(clipped_area(&self.0, low, high))
    }

    fn drawing(&self, _: &Detail) -> Drawing {
        Drawing::triangle(self.0.map(Linear::spread))
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::space::Solid;

    fn solid((x, y, z): (f64, f64, f64)) -> Solid {
        Solid::new(x, y, z)
    }

    type Point = (std::ops::Range<f64>, std::ops::Range<f64>, std::ops::Range<f64>);

    const CUBE: Point = (-1.0..1.0, -1.0..1.0, -1.0..1.0);

    proptest! {
        #[test]
        fn no_point_of_a_fine_grid_is_nearer(a in CUBE, b in CUBE, c in CUBE, x in CUBE) {
            let [a, b, c, x] = [a, b, c, x].map(solid);
            let triangle = Triangle([a, b, c]);
            let (point, at_edge) = triangle.nearest_point(x);
            let steps = 60;
            let mut least = f64::INFINITY;
            for i in 0..=steps {
                for j in 0..=steps - i {
                    let s = f64::from(i) / f64::from(steps);
                    let t = f64::from(j) / f64::from(steps);
                    least = least.min((a + s * (b - a) + t * (c - a)).distance(x));
                }
            }
            let cell = (a.distance(b) + a.distance(c)) / f64::from(steps);
            prop_assert!(point.distance(x) <= least + 1e-12 && least <= point.distance(x) + cell);
            // Inside the face the line to the centre is at right angles to both edges.
            if !at_edge {
                let away = x - point;
                prop_assert!(away.dot(b - a).abs() < 1e-9 && away.dot(c - a).abs() < 1e-9);
            }
        }

        #[test]
        fn a_path_crosses_at_a_point_of_the_triangle(a in CUBE, b in CUBE, c in CUBE, from in CUBE, to in CUBE) {
            let [a, b, c, from, to] = [a, b, c, from, to].map(solid);
            let triangle = Triangle([a, b, c]);
            let height = |x: Solid| (x - a).dot((b - a).cross(c - a));
            prop_assume!((height(to) - height(from)).abs() > 1e-3);
            if let Some(share) = triangle.crossing(from, to) {
                prop_assert!(triangle.nearest(from + (to - from) * share).distance() < 1e-9);
            } else if height(from) * height(to) < 0.0 {
                let share = height(from) / (height(from) - height(to));
                let (_, at_edge) = triangle.nearest_point(from + (to - from) * share);
                prop_assert!(at_edge, "the path meets the plane inside the triangle");
            }
        }
    }
}
