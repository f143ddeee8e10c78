//! Areas of shapes of walls between two heights, m^2.
//!
//! A flat shape is clipped at both heights, which is exact. A surface of revolution about a vertical axis is a frustum between the two
//! heights: pi (r_0 + r_1) s, with s the length of its line between them. A spherical zone with a vertical axis has 2 pi R h between heights that
//! differ by h. About another axis both are cut into flat strips, with a relative error of about 1e-5 for a surface with a straight
//! line and 1e-4 for a spherical zone. A surface with a hole is cut into flat pieces, with a relative error of about 1e-4.

use std::f64::consts::PI;

use crate::math;
use crate::space::Space;
use crate::walls::clip::{area, clip};
use crate::walls::shapes::revolution::Axis;

/// Number of strips round a surface of revolution.
const STRIPS: u32 = 720;

/// Returns the share of a line between two heights.
pub(super) fn share_between([from, to]: [f64; 2], low: f64, high: f64) -> f64 {
    let bottom = from.min(to);
    let top = from.max(to);
    if bottom >= top {
        return if (low..high).contains(&bottom) { 1.0 } else { 0.0 };
    }
    ((top.min(high) - bottom.max(low)) / (top - bottom)).max(0.0)
}

/// Returns the area of a flat polygon between two heights. A level polygon belongs to the heights from `low` to below `high`.
pub(super) fn clipped_area<V: Space>(corners: &[V], low: f64, high: f64) -> f64 {
    let heights = || corners.iter().map(|corner| corner.height());
    let bottom = heights().fold(f64::INFINITY, f64::min);
    let top = heights().fold(f64::NEG_INFINITY, f64::max);
    if bottom >= top {
        return if (low..high).contains(&bottom) { area(corners) } else { 0.0 };
    }
    let above = clip(corners, |x| x.height() - low);
    area(&clip(&above, |x| high - x.height()))
}

/// Returns the area between two heights of the surface that the line through `profile`, points (r, z), makes about an axis.
pub(super) fn strips_area<V: Space>(axis: &Axis<V>, profile: &[[f64; 2]], low: f64, high: f64) -> f64 {
    // The chord of a strip is shorter than its arc.
    let stretch = (PI / f64::from(STRIPS)) / math::sin(PI / f64::from(STRIPS));
    let piece = |from: [f64; 2], to: [f64; 2], n: u32| {
        let [[a, d], [b, c]] = [n, n + 1].map(|n| axis.turned([from, to], n, STRIPS));
        clipped_area(&[a, b, c, d], low, high)
    };
    let pieces = profile.windows(2).flat_map(|ends| (0..STRIPS).map(move |n| piece(ends[0], ends[1], n)));
    stretch * pieces.sum::<f64>()
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;
    use crate::space::{Plane, Solid};
    use crate::walls::shapes::Shape as _;
    use crate::walls::shapes::ball::Ball;
    use crate::walls::shapes::half_plane::HalfPlane;
    use crate::walls::shapes::panel::Panel;
    use crate::walls::shapes::revolved::Revolved;
    use crate::walls::shapes::segment::Segment;
    use crate::walls::shapes::spherical_zone::SphericalZone;
    use crate::walls::shapes::triangle::Triangle;
    use crate::walls::surface::Surface;

    /// Asserts the area between two heights, and that bands make up the whole.
    fn assert_area<V: Space>(surface: &Surface<V>, (low, high): (f64, f64), expected: f64, tolerance: f64) {
        let found = surface.shape().area_between(low, high).unwrap();
        assert!((found - expected).abs() <= tolerance * expected, "{surface:?}: {found}, not {expected}");
        let bands = (0..7).map(|n| low + (high - low) * f64::from(n) / 7.0);
        let sum: f64 = bands.map(|band| surface.shape().area_between(band, band + (high - low) / 7.0).unwrap()).sum();
        assert!((sum - found).abs() <= 1e-12 * expected, "{surface:?}: {sum}, not {found}");
    }

    #[test]
    fn areas_are_those_of_the_closed_forms() {
        let slope = Segment { from: Plane::new(0.0, 0.0), to: Plane::new(3.0, 4.0) };
        assert_area(&Surface::Segment(slope), (1.0, 3.0), 2.5, 1e-14);
        let panel = Panel { corner: Solid::ZERO, along: Solid::new(2.0, 0.0, 0.0), across: Solid::new(0.0, 3.0, 4.0) };
        assert_area(&Surface::Panel(panel), (-1.0, 2.0), 5.0, 1e-14);
        // Similar triangles: half the height from the tip has a quarter of the area.
        let triangle = Triangle([Solid::ZERO, Solid::new(2.0, 0.0, 0.0), Solid::new(1.0, 0.0, 2.0)]);
        assert_area(&Surface::Triangle(triangle), (1.0, 5.0), 0.5, 1e-14);
        let cone = Revolved::between(Solid::ZERO, Solid::new(0.0, 0.0, 4.0), [1.0, 4.0]);
        // Radii 1.75 and 2.5 at the heights 1 and 2; the slant is 5/4 of the height.
        assert_area(&Surface::Revolved(cone), (1.0, 2.0), PI * 4.25 * 1.25, 1e-14);
        let plate = Revolved::ring(Solid::new(0.0, 0.0, 0.5), Solid::Z, [1.0, 2.0]);
        assert_area(&Surface::Revolved(plate), (0.0, 1.0), 3.0 * PI, 1e-14);
        // Heights of half the radius are at 30 degrees, so the arcs between them make up a third of the circle.
        assert_area(&Surface::Ball(Ball { centre: Plane::Y, radius: 2.0 }), (0.0, 2.0), TAU * 2.0 / 3.0, 1e-14);
        assert_area(&Surface::Ball(Ball { centre: Solid::Z, radius: 2.0 }), (0.0, 9.0), TAU * 2.0 * 3.0, 1e-14);
        assert_eq!(HalfPlane { point: Solid::ZERO, normal: Solid::Z }.area_between(0.0, 1.0), None);
    }

    #[test]
    fn a_zone_has_the_area_of_archimedes_whichever_way_it_lies() {
        let area = |axis: Solid, (low, high)| {
            let zone = SphericalZone::new(Solid::new(0.0, 0.0, 1.0), axis, 2.0, [-2.0, 0.0]);
            zone.area_between(low, high).unwrap()
        };
        let upright = SphericalZone::new(Solid::new(0.0, 0.0, 1.0), Solid::Z, 2.0, [-2.0, 0.0]);
        assert_area(&Surface::SphericalZone(upright), (-0.5, 0.25), TAU * 2.0 * 0.75, 1e-14);
        // Half of a sphere on its side has half of the area of any band of the sphere.
        for (band, expected) in [((-2.0, 4.0), TAU * 4.0), ((0.0, 0.5), TAU * 0.5)] {
            assert!((area(Solid::X, band) / expected - 1.0).abs() < 1e-4, "{}", area(Solid::X, band));
        }
    }

    #[test]
    fn a_drum_on_its_side_has_the_area_of_its_arcs() {
        let drum = Revolved::between(Solid::ZERO, Solid::new(0.0, 2.0, 0.0), [0.5, 0.5]);
        assert_area(&Surface::Revolved(drum), (-1.0, 1.0), TAU * 0.5 * 2.0, 2e-5);
        // From the lowest point to a quarter of the height: an angle of 60 degrees to each side.
        assert_area(&Surface::Revolved(drum), (-0.5, -0.25), TAU / 3.0 * 0.5 * 2.0, 2e-5);
    }
}
