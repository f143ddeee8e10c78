//! Area of a wall between two heights, m^2; in the plane its length, m.
//!
//! Flat walls are clipped, which is exact. A surface of revolution about a vertical axis is a frustum between the two heights:
//! pi (r_0 + r_1) s, with s the length of its line between them, and a spherical zone has 2 pi R h between heights that differ by h. About another axis
//! both are cut into flat strips, with a relative error of about 1e-5 for a surface with a straight line, 1e-4 for a
//! spherical zone. So is a surface with a hole, with an error of about 1e-4.

use std::f64::consts::{PI, TAU};

use crate::space::{Dimension, Space};
use crate::walls::clip::{area, clip};
use crate::walls::shapes::ball::Ball;
use crate::walls::shapes::revolved::Revolved;
use crate::walls::shapes::spherical_zone::SphericalZone;
use crate::walls::shapes::turned;
use crate::walls::surfaces::Surface;

/// Number of strips round a surface of revolution.
const STRIPS: u32 = 720;

/// Number of flat pieces about the axis of a surface with a hole, and of sides of a round hole.
const CUT_FACETS: u32 = 240;

/// Number of pieces from pole to pole of a sphere.
const ZONE_PIECES: u32 = 180;

/// Returns the area of a wall between two heights; `None` for a half-plane, which has no ends.
pub fn area_between<V: Space>(surface: &Surface<V>, low: f64, high: f64) -> Option<f64> {
    match surface {
        Surface::HalfPlane(_) => None,
        Surface::Segment(wall) if V::DIMENSION == Dimension::Plane => {
            let heights = [wall.from, wall.to].map(Space::height);
            Some(wall.from.distance(wall.to) * share_between(heights, low, high))
        }
        // A rod has no area.
        Surface::Segment(_) => Some(0.0),
        Surface::Panel(wall) => Some(clipped_area(&wall.corners(), low, high)),
        Surface::Triangle(wall) => Some(clipped_area(&wall.0, low, high)),
        Surface::Revolved(wall) => Some(revolved_area(wall, low, high)),
        Surface::SphericalZone(wall) => Some(zone_area(wall, low, high)),
        Surface::Ball(wall) => Some(ball_area(wall, low, high)),
        Surface::Trimmed(wall) => {
            Some(wall.pieces(CUT_FACETS).iter().map(|piece| clipped_area(piece, low, high)).sum())
        }
    }
}

/// Returns the share of a line between two heights.
fn share_between([from, to]: [f64; 2], low: f64, high: f64) -> f64 {
    let bottom = from.min(to);
    let top = from.max(to);
    if bottom >= top {
        return if (low..high).contains(&bottom) { 1.0 } else { 0.0 };
    }
    ((top.min(high) - bottom.max(low)) / (top - bottom)).max(0.0)
}

/// Returns the area of a flat polygon between two heights. A level polygon belongs to the heights from `low` to below `high`.
fn clipped_area<V: Space>(corners: &[V], low: f64, high: f64) -> f64 {
    let heights = || corners.iter().map(|corner| corner.height());
    let bottom = heights().fold(f64::INFINITY, f64::min);
    let top = heights().fold(f64::NEG_INFINITY, f64::max);
    if bottom >= top {
        return if (low..high).contains(&bottom) { area(corners) } else { 0.0 };
    }
    let above = clip(corners, |x| x.height() - low);
    area(&clip(&above, |x| high - x.height()))
}

fn revolved_area<V: Space>(wall: &Revolved<V>, low: f64, high: f64) -> f64 {
    let [[r_0, z_0], [r_1, z_1]] = [wall.from, wall.to];
    let upwards = wall.axis.height();
    if (upwards.abs() - 1.0).abs() < 1e-12 {
        let length = (r_1 - r_0).hypot(z_1 - z_0);
        let height = |z: f64| wall.base.height() + upwards * z;
        let from = height(z_0);
        let to = height(z_1);
        if from.min(to) >= from.max(to) {
            let is_inside = (low..high).contains(&from);
            return if is_inside { PI * (r_0 + r_1) * length } else { 0.0 };
        }
        let share_at = |height: f64| ((height - from) / (to - from)).clamp(0.0, 1.0);
        let a = share_at(low);
        let b = share_at(high);
        let radius = |share: f64| r_0 + share * (r_1 - r_0);
        return PI * (radius(a) + radius(b)) * length * (b - a).abs();
    }
    strips_area((wall.base, wall.axis), &[wall.from, wall.to], low, high)
}

fn zone_area<V: Space>(wall: &SphericalZone<V>, low: f64, high: f64) -> f64 {
    let upwards = wall.axis.height();
    if (upwards.abs() - 1.0).abs() < 1e-12 {
        let [from, to] = wall.ends().map(|height| wall.centre.height() + upwards * height);
        let within = from.max(to).min(high) - from.min(to).max(low);
        return TAU * wall.radius * within.max(0.0);
    }
    strips_area((wall.centre, wall.axis), &wall.profile(ZONE_PIECES), low, high)
}

/// Returns the area of a sphere between two heights; in the plane the length of both arcs of a circle.
fn ball_area<V: Space>(wall: &Ball<V>, low: f64, high: f64) -> f64 {
    let [low, high] = [low, high].map(|height| ((height - wall.centre.height()) / wall.radius).clamp(-1.0, 1.0));
    match V::DIMENSION {
        Dimension::Plane => 2.0 * wall.radius * (high.asin() - low.asin()),
        Dimension::Solid => TAU * wall.radius * wall.radius * (high - low),
    }
}

/// Returns the area between two heights of the surface that the line through `profile`, points (r, z), makes about an axis.
fn strips_area<V: Space>(axis: (V, V), profile: &[[f64; 2]], low: f64, high: f64) -> f64 {
    // The chord of a strip is shorter than its arc.
    let stretch = (PI / f64::from(STRIPS)) / (PI / f64::from(STRIPS)).sin();
    let piece = |from: [f64; 2], to: [f64; 2], n: u32| {
        let [[a, d], [b, c]] = [n, n + 1].map(|n| turned(axis, [from, to], (n, STRIPS)));
        clipped_area(&[a, b, c, d], low, high)
    };
    let pieces = profile.windows(2).flat_map(|ends| (0..STRIPS).map(move |n| piece(ends[0], ends[1], n)));
    stretch * pieces.sum::<f64>()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::space::{Plane, Solid};
    use crate::walls::shapes::half_plane::HalfPlane;
    use crate::walls::shapes::panel::Panel;
    use crate::walls::shapes::segment::Segment;
    use crate::walls::shapes::triangle::Triangle;

    /// Asserts the area between two heights, and that bands make up the whole.
    fn assert_area<V: Space>(surface: &Surface<V>, (low, high): (f64, f64), expected: f64, tolerance: f64) {
        let found = area_between(surface, low, high).unwrap();
        assert!((found - expected).abs() <= tolerance * expected, "{surface:?}: {found}, not {expected}");
        let bands = (0..7).map(|n| low + (high - low) * f64::from(n) / 7.0);
        let sum: f64 = bands.map(|band| area_between(surface, band, band + (high - low) / 7.0).unwrap()).sum();
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
        assert_eq!(
            area_between(&Surface::HalfPlane(HalfPlane { point: Solid::ZERO, normal: Solid::Z }), 0.0, 1.0),
            None
        );
    }

    #[test]
    fn a_zone_has_the_area_of_archimedes_whichever_way_it_lies() {
        let area = |axis: Solid, (low, high)| {
            let zone = SphericalZone::new(Solid::new(0.0, 0.0, 1.0), axis, 2.0, [-2.0, 0.0]);
            area_between(&Surface::SphericalZone(zone), low, high).unwrap()
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
