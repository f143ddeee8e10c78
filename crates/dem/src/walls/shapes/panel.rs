//! Panel: a thin rectangle of solid space.

use crate::space::{Linear, Plane, Space};
use crate::walls::area::clipped_area;
use crate::walls::drawing::{Detail, Drawing};
use crate::walls::pose::Pose;
use crate::walls::shapes::{Nearest, Shape, box_around, foot_share, is_along, is_end};

/// A thin rectangle.
#[derive(Clone, Copy, Debug)]
pub struct Panel<V: Space = Plane> {
    /// One corner, m.
    pub corner: V,
    /// One edge, m.
    pub along: V,
    /// The other edge, m.
    pub across: V,
}

impl<V: Space> Panel<V> {
    /// Returns the corners in order round the panel, m.
    pub(crate) fn corners(&self) -> [V; 4] {
        let Self { corner, along, across } = *self;
        [corner, corner + along, corner + along + across, corner + across]
    }

    /// Returns the unit normal.
    pub(super) fn normal(&self) -> V {
        V::narrow(self.along.spread().cross(self.across.spread())).unit_or_zero()
    }
}

impl<V: Space> Shape<V> for Panel<V> {
    #[inline(always)]
    fn nearest(&self, x: V) -> Nearest<V> {
        let Self { corner, along, across } = *self;
        let a = foot_share(x - corner, along);
        let b = foot_share(x - corner, across);
        Nearest::flat(x - (corner + along * a + across * b), is_end(a) || is_end(b), || self.normal())
    }

    fn bounds(&self) -> Option<[V; 2]> {
        box_around(&self.corners())
    }

    fn placed(&self, pose: &Pose<V>) -> Self {
        Self { corner: pose.point(self.corner), along: pose.direction(self.along), across: pose.direction(self.across) }
    }

    fn crossing(&self, from: V, to: V) -> Option<f64> {
        let [corner, along, across, from, to] = [self.corner, self.along, self.across, from, to].map(Linear::spread);
        let normal = along.cross(across);
        let before = (from - corner).dot(normal);
        let after = (to - corner).dot(normal);
        if (before < 0.0) == (after < 0.0) {
            return None;
        }
        let share = before / (before - after);
        let at = from + (to - from) * share - corner;
        let inside = |edge| (0.0..=1.0).contains(&(Linear::dot(at, edge) / Linear::length_squared(edge)));
        (inside(along) && inside(across)).then_some(share)
    }

    fn reference(&self) -> V {
        self.corner
    }

    fn area_between(&self, low: f64, high: f64) -> Option<f64> {
        Some(clipped_area(&self.corners(), low, high))
    }

    fn drawing(&self, _: &Detail) -> Drawing {
        Drawing::quadrangle(self.corners().map(Linear::spread))
    }

    fn runs_along(&self, axis: usize) -> bool {
        is_along(self.along, axis) || is_along(self.across, axis)
    }
}

#[cfg(test)]
#[expect(clippy::float_cmp, reason = "exact values")]
mod tests {
    use super::*;
    use crate::space::{PARTED, Solid};

    #[test]
    fn a_panel_has_a_face_edges_and_corners() {
        let wall = Panel { corner: Solid::ZERO, along: Solid::new(2.0, 0.0, 0.0), across: Solid::new(0.0, 1.0, 0.0) };
        let point = |away, at_edge| Nearest::Point { away, curvature: 0.0, at_edge };
        assert_eq!(wall.nearest(Solid::new(1.0, 0.5, 0.3)), point(Solid::Z * 0.3, false));
        assert_eq!(wall.nearest(Solid::new(1.0, 0.5, -0.3)), point(Solid::Z * -0.3, false));
        assert_eq!(wall.nearest(Solid::new(1.0, 4.0, 4.0)), point(Solid::new(0.0, 3.0, 4.0), true));
        assert_eq!(wall.nearest(Solid::new(-2.0, -1.0, 2.0)).distance(), 3.0);
        assert_eq!(wall.nearest(Solid::new(1.0, 0.5, 0.0)), point(Solid::Z * PARTED, false));
        assert_eq!(wall.crossing(Solid::new(1.0, 0.5, 1.0), Solid::new(1.0, 0.5, -3.0)), Some(0.25));
        assert_eq!(wall.crossing(Solid::new(1.0, 1.5, 1.0), Solid::new(1.0, 1.5, -3.0)), None);
    }
}
