//! Segment: a thin line between two points; in solid space a thin rod.

use crate::space::{Dimension, Linear, Plane, Space};
use crate::walls::area::share_between;
use crate::walls::drawing::{Detail, Drawing};
use crate::walls::pose::Pose;
use crate::walls::shapes::{Nearest, Planar, Shape, box_around, foot_share, is_along, is_end};

/// A thin line between two points.
#[derive(Clone, Copy, Debug)]
pub struct Segment<V: Space = Plane> {
    /// One end, m.
    pub from: V,
    /// The other end, m.
    pub to: V,
}

impl<V: Space> Shape<V> for Segment<V> {
    #[inline(always)]
    fn nearest(&self, x: V) -> Nearest<V> {
        let edge = self.to - self.from;
        let share = foot_share(x - self.from, edge);
        // In solid space, a panel may have the whole rod as its edge.
        let at_edge = V::DIMENSION == Dimension::Solid || is_end(share);
        Nearest::flat(x - (self.from + edge * share), at_edge, || edge.any_perpendicular())
    }

    fn bounds(&self) -> Option<[V; 2]> {
        box_around(&[self.from, self.to])
    }

    /// In solid space never: a rod has no area.
    fn crossing(&self, from: V, to: V) -> Option<f64> {
        if V::DIMENSION == Dimension::Solid {
            return None;
        }
        let path = to - from;
        let line = self.to - self.from;
        let offset = self.from - from;
        // In the plane a cross product has one component.
        let across = |a: V, b: V| a.cross(b).component(0);
        let cross = across(path, line);
        if cross == 0.0 {
            return None;
        }
        let along_path = across(offset, line) / cross;
        let along_line = across(offset, path) / cross;
        ((0.0..=1.0).contains(&along_path) && (0.0..=1.0).contains(&along_line)).then_some(along_path)
    }

    fn placed(&self, pose: &Pose<V>) -> Self {
        Self { from: pose.point(self.from), to: pose.point(self.to) }
    }

    fn reference(&self) -> V {
        self.from
    }

    /// In solid space it is 0, because a rod has no area.
    fn area_between(&self, low: f64, high: f64) -> Option<f64> {
        Some(match V::DIMENSION {
            Dimension::Plane => {
                let heights = [self.from, self.to].map(Space::height);
                self.from.distance(self.to) * share_between(heights, low, high)
            }
            Dimension::Solid => 0.0,
        })
    }

    fn drawing(&self, _: &Detail) -> Drawing {
        Drawing::line([self.from, self.to].map(Linear::spread))
    }

    fn runs_along(&self, axis: usize) -> bool {
        is_along(self.to - self.from, axis)
    }

    fn planar(&self) -> Option<Planar<V>> {
        Some(Planar::Segment { from: self.from, to: self.to })
    }
}

#[cfg(test)]
#[expect(clippy::float_cmp, reason = "exact values")]
mod tests {
    use super::*;
    use crate::space::{PARTED, Vector};

    #[test]
    fn a_segment_is_round_at_its_ends_and_two_sided() {
        let wall = Segment { from: Vector::ZERO, to: Vector::new(2.0, 0.0) };
        let point = |away, at_edge| Nearest::Point { away, curvature: 0.0, at_edge };
        assert_eq!(wall.nearest(Vector::new(1.0, -0.5)), point(Vector::new(0.0, -0.5), false));
        assert_eq!(wall.nearest(Vector::new(5.0, 4.0)), point(Vector::new(3.0, 4.0), true));
        assert_eq!(wall.nearest(Vector::new(5.0, 4.0)).distance(), 5.0);
        assert_eq!(wall.nearest(Vector::new(1.0, 0.0)), point(Vector::Y * PARTED, false));
        assert_eq!(wall.crossing(Vector::new(1.0, 3.0), Vector::new(1.0, -1.0)), Some(0.75));
        assert_eq!(wall.crossing(Vector::new(3.0, 3.0), Vector::new(3.0, -1.0)), None);
    }
}
