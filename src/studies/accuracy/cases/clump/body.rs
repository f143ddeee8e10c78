//! A rigid body of equal discs, with the closed form of its moment of inertia.
//!
//! Discs of radius R whose centres are d < 2 R apart share a lens of two segments of half angle α, cos α = d/(2 R). About the centre of its own
//! circle a segment has the area A, the first moment S along its axis and the polar second moment P:
//!
//! A = R² (α - sin α cos α), S = 2/3 R³ sin³ α, P = R⁴/2 (α - cos³ α sin α - cos α sin³ α/3).
//!
//! About its own middle the lens has 2 (P - d S + A d²/4), and about a point at the distance r from there 2 A r² more. The union is the sum of the
//! discs less the lenses, as long as no three discs share a point.

use std::f64::consts::PI;

use glam::DVec2;

use super::super::super::case::disc;
use super::super::super::reference::{Clump, Disc};

/// A body of equal discs.
pub(super) struct Body {
    /// Mass, kg.
    pub(super) mass: f64,
    /// Radius of each disc, m.
    pub(super) radius: f64,
    /// Centres of the discs along the axis of the body and across it, m; from the first to the last is along it. Their mean is zero.
    pub(super) places: Vec<DVec2>,
}

/// The place and the motion of a body.
pub(super) struct Motion {
    /// Centre of mass, m.
    pub(super) centre: DVec2,
    /// Direction of the axis.
    pub(super) axis: DVec2,
    /// Velocity of the centre, m/s.
    pub(super) v: DVec2,
}

impl Body {
    /// Returns a row of discs whose neighbours are `apart` (m) from each other.
    pub(super) fn row(mass: f64, radius: f64, count: u32, apart: f64) -> Self {
        let place = |n: u32| DVec2::X * (apart * (f64::from(n) - 0.5 * f64::from(count - 1)));
        Self { mass, radius, places: (0..count).map(place).collect() }
    }

    /// Returns a cross of five discs: one in the middle, and four at the distance `arm` (m) from it.
    pub(super) fn cross(mass: f64, radius: f64, arm: f64) -> Self {
        let places = [DVec2::NEG_X, DVec2::NEG_Y, DVec2::ZERO, DVec2::Y, DVec2::X].map(|place| place * arm);
        Self { mass, radius, places: places.into() }
    }

    /// Returns the square of the radius of gyration of the union about its centre of mass, m^2.
    pub(super) fn gyration(&self) -> f64 {
        let r = self.radius;
        let mut area = 0.0;
        let mut moment = 0.0;
        for (number, &place) in self.places.iter().enumerate() {
            area += PI * r * r;
            moment += PI * r * r * (0.5 * r * r + place.length_squared());
            for &other in &self.places[..number] {
                let distance = place.distance(other);
                if distance < 2.0 * r {
                    let angle = (0.5 * distance / r).acos();
                    let (sine, cosine) = angle.sin_cos();
                    let segment = r * r * (angle - sine * cosine);
                    let first = 2.0 / 3.0 * (r * sine).powi(3);
                    let polar = 0.5 * r.powi(4) * (angle - cosine.powi(3) * sine - cosine * sine.powi(3) / 3.0);
                    let about_middle = 2.0 * (polar - distance * first + segment * 0.25 * distance * distance);
                    area -= 2.0 * segment;
                    moment -= about_middle + 2.0 * segment * (0.5 * (place + other)).length_squared();
                }
            }
        }
        moment / area
    }

    /// Returns the centre and the discs of the body.
    pub(super) fn discs(&self, &Motion { centre, axis, v }: &Motion) -> Vec<Disc> {
        let member = |place: &DVec2| disc(self.radius, self.mass, centre + axis.rotate(*place), v);
        std::iter::once(disc(0.0, self.mass, centre, v)).chain(self.places.iter().map(member)).collect()
    }

    /// Returns the clump whose discs begin at the number `first`, with a spin, rad/s.
    pub(super) fn clump(&self, first: usize, spin: f64) -> Clump {
        let members = first + 1..first + 1 + self.places.len();
        Clump { centre: first, members, inertia: self.mass * self.gyration(), spin }
    }

    /// Returns 1/m (1/kg) for a force along n at the end of the arm r.
    pub(super) fn mobility(&self, arm: DVec2, n: DVec2) -> f64 {
        (1.0 + arm.perp_dot(n).powi(2) / self.gyration()) / self.mass
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Square of the radius of gyration by a sum over small squares, m^2.
    fn counted(body: &Body) -> f64 {
        let reach = body.places.iter().map(|place| place.length()).fold(0.0, f64::max) + body.radius;
        let count = 2000;
        let at = |n: u32| reach * ((2.0 * f64::from(n) + 1.0) / f64::from(count) - 1.0);
        let points = (0..count).flat_map(|i| (0..count).map(move |j| DVec2::new(at(i), at(j))));
        let inside = points.filter(|point| body.places.iter().any(|place| place.distance(*point) < body.radius));
        let (number, sum) =
            inside.fold((0.0, 0.0), |(number, sum), point| (number + 1.0, sum + point.length_squared()));
        sum / number
    }

    #[test]
    fn the_closed_form_of_the_inertia_is_a_sum_over_the_area() {
        let bodies = [
            Body::row(1.0, 0.03, 1, 0.0),
            Body::row(1.0, 0.03, 2, 0.05),
            Body::row(1.0, 0.03, 2, 0.09),
            Body::row(1.0, 0.03, 3, 0.035),
            Body::cross(1.0, 0.03, 0.045),
        ];
        for body in &bodies {
            // A rim that crosses squares of 1/1000 of the reach is seen to about 1e-5 of the area.
            let ratio = body.gyration() / counted(body);
            assert!((ratio - 1.0).abs() < 1e-4, "{:?}: {ratio}", body.places);
        }
        assert!((bodies[0].gyration() / (0.5 * 0.03 * 0.03) - 1.0).abs() < 1e-15, "a disc");
    }
}
