//! Clipping of convex polygons by planes (Sutherland and Hodgman, Communications of the ACM 17, 1974).

use glam::DVec3;

/// A half-space: all x with `normal . x >= level`.
#[derive(Clone, Copy, Debug)]
pub(super) struct HalfSpace {
    pub normal: DVec3,
    pub level: f64,
}

impl HalfSpace {
    fn height(&self, x: DVec3) -> f64 {
        self.normal.dot(x) - self.level
    }
}

/// Returns the half-spaces whose intersection is a box.
pub(super) fn inside([low, high]: [DVec3; 2]) -> [HalfSpace; 6] {
    std::array::from_fn(|side| {
        let axis = [DVec3::X, DVec3::Y, DVec3::Z][side / 2];
        if side % 2 == 0 {
            HalfSpace { normal: axis, level: axis.dot(low) }
        } else {
            HalfSpace { normal: -axis, level: -axis.dot(high) }
        }
    })
}

/// Returns the part of a convex polygon that lies in a half-space; empty if no part does.
pub(super) fn polygon(corners: &[DVec3], half: HalfSpace) -> Vec<DVec3> {
    let mut part = Vec::with_capacity(corners.len() + 1);
    for (place, &corner) in corners.iter().enumerate() {
        let next = corners[(place + 1) % corners.len()];
        let heights = [half.height(corner), half.height(next)];
        if heights[0] >= 0.0 {
            part.push(corner);
        }
        if (heights[0] >= 0.0) != (heights[1] >= 0.0) {
            part.push(corner + (next - corner) * (heights[0] / (heights[0] - heights[1])));
        }
    }
    if part.len() < 3 { Vec::new() } else { part }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn area(corners: &[DVec3]) -> f64 {
        let fan = corners.windows(2).skip(1).map(|pair| (pair[0] - corners[0]).cross(pair[1] - corners[0]));
        0.5 * fan.sum::<DVec3>().length()
    }

    #[test]
    fn a_square_is_cut_to_the_box_that_it_passes() {
        let square = [[-5.0, -5.0], [5.0, -5.0], [5.0, 5.0], [-5.0, 5.0]].map(|[x, z]| DVec3::new(x, 1.0, z));
        let clip = |ends| inside(ends).into_iter().fold(square.to_vec(), |corners, half| polygon(&corners, half));
        let part = clip([DVec3::ZERO, DVec3::new(2.0, 3.0, 4.0)]);
        assert!((area(&part) - 8.0).abs() < 1e-12, "{part:?}");
        // A square in a side of the box belongs to it; a square outside does not.
        assert!((area(&clip([DVec3::Y, DVec3::new(2.0, 3.0, 4.0)])) - 8.0).abs() < 1e-12);
        assert!(clip([DVec3::Y * 2.0, DVec3::new(2.0, 3.0, 4.0)]).is_empty());
    }
}
