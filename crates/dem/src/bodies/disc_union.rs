//! Area and moments of a union of discs, from its boundary.
//!
//! The boundary consists of arcs, those parts of the circles that no other disc covers. By Green's theorem the moments are integrals
//! over the arcs:
//!
//! A = 1/2 (x dy - y dx), S_x = 1/2 x^2 dy, S_y = -1/2 y^2 dx, S_xx = 1/3 x^3 dy, S_yy = -1/3 y^3 dx, S_xy = 1/2 x^2 y dy.
//!
//! Gauss's rule with eight nodes on arcs of at most an eighth of a turn has no error beyond rounding for these integrands.

use std::f64::consts::{FRAC_PI_4, PI, TAU};

use crate::math;
use crate::space::{Linear, Plane};

/// A disc: its centre and its radius, m.
#[derive(Clone, Copy, Debug)]
pub struct Disc {
    /// Centre, m.
    pub centre: Plane,
    /// Radius, m.
    pub radius: f64,
}

/// Moments of an area: integrals of 1, x, y, x^2, y^2 and x y over it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct AreaMoments {
    /// Area, m^2.
    pub area: f64,
    /// First moments, m^3.
    pub first: Plane,
    /// Second moments of x^2 and y^2, m^4.
    pub second: Plane,
    /// Second moment of x y, m^4.
    pub mixed: f64,
}

/// Nodes (in the upper half of -1 to 1) and weights of Gauss's rule with eight nodes.
pub(super) const GAUSS: [[f64; 2]; 4] = [
    [0.183_434_642_495_649_8, 0.362_683_783_378_362],
    [0.525_532_409_916_329, 0.313_706_645_877_887_3],
    [0.796_666_477_413_626_7, 0.222_381_034_453_374_5],
    [0.960_289_856_497_536_3, 0.101_228_536_290_376_3],
];

/// An interval of directions on a circle, rad.
#[derive(Clone, Copy)]
struct Arc {
    from: f64,
    to: f64,
}

/// How much of a circle another disc covers.
enum Cover {
    None,
    Part(Arc),
    All,
}

/// Returns the part of the circle of `disc` that `other` covers. Of two equal discs the later covers the earlier one.
fn cover(disc: &Disc, other: &Disc, other_is_later: bool) -> Cover {
    let to_other = other.centre - disc.centre;
    let distance = Linear::length(to_other);
    if distance >= disc.radius + other.radius || distance + other.radius < disc.radius {
        return Cover::None;
    }
    if distance + disc.radius <= other.radius {
        let is_equal = distance + other.radius <= disc.radius;
        return if is_equal && !other_is_later { Cover::None } else { Cover::All };
    }
    let cosine = (distance * distance + disc.radius * disc.radius - other.radius * other.radius)
        / (2.0 * distance * disc.radius);
    let half = math::acos(cosine.clamp(-1.0, 1.0));
    let middle = math::atan2(to_other.y, to_other.x);
    Cover::Part(Arc { from: middle - half, to: middle + half })
}

/// Returns the parts of circle `number` on the boundary of the union.
fn free_arcs(discs: &[Disc], number: usize) -> Vec<Arc> {
    let mut covered = Vec::new();
    for (other, disc) in discs.iter().enumerate().filter(|&(other, _)| other != number) {
        match cover(&discs[number], disc, other > number) {
            Cover::None => {}
            Cover::All => return Vec::new(),
            Cover::Part(Arc { from, to }) => {
                // Directions are counted from -pi. An interval beyond the end continues at the beginning.
                let start = from + TAU * ((-PI - from) / TAU).ceil();
                let end = start + (to - from);
                covered.push(Arc { from: start, to: end.min(PI) });
                if end > PI {
                    covered.push(Arc { from: -PI, to: end - TAU });
                }
            }
        }
    }
    covered.sort_unstable_by(|a, b| a.from.total_cmp(&b.from));
    let mut free = Vec::new();
    let mut last = -PI;
    for Arc { from, to } in covered {
        if from > last {
            free.push(Arc { from: last, to: from });
        }
        last = last.max(to);
    }
    if last < PI {
        free.push(Arc { from: last, to: PI });
    }
    free
}

/// Adds the integrals over a short arc.
fn add_piece(disc: &Disc, arc: Arc, sum: &mut AreaMoments) {
    let middle = 0.5 * (arc.from + arc.to);
    let half = 0.5 * (arc.to - arc.from);
    for [node, weight] in GAUSS.into_iter().flat_map(|[node, weight]| [[-node, weight], [node, weight]]) {
        let outward = math::direction(middle + node * half);
        let at = disc.centre + outward * disc.radius;
        let length = weight * half * disc.radius;
        // dx = -r sin(angle), dy = r cos(angle) per angle.
        let dy = outward.x * length;
        let dx = -outward.y * length;
        sum.area += 0.5 * (at.x * dy - at.y * dx);
        sum.first += Plane::new(0.5 * at.x * at.x * dy, -0.5 * at.y * at.y * dx);
        sum.second += Plane::new(at.x.powi(3) * dy, -at.y.powi(3) * dx) / 3.0;
        sum.mixed += 0.5 * at.x * at.x * at.y * dy;
    }
}

/// Returns the moments of the union of `discs`.
#[must_use]
pub fn moments(discs: &[Disc]) -> AreaMoments {
    let mut sum = AreaMoments::default();
    for (number, disc) in discs.iter().enumerate() {
        for arc in free_arcs(discs, number) {
            let pieces = ((arc.to - arc.from) / FRAC_PI_4).ceil().max(1.0);
            let width = (arc.to - arc.from) / pieces;
            let mut from = arc.from;
            for _ in 0..8 {
                if from + 0.5 * width < arc.to {
                    add_piece(disc, Arc { from, to: from + width }, &mut sum);
                }
                from += width;
            }
        }
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    fn disc(x: f64, y: f64, radius: f64) -> Disc {
        Disc { centre: Plane::new(x, y), radius }
    }

    #[test]
    fn a_single_disc_has_its_area_and_moments() {
        let moments = moments(&[disc(0.3, -0.2, 0.5)]);
        let area = PI * 0.25;
        assert!((moments.area - area).abs() < 1e-15);
        assert!(Linear::length(moments.first - Plane::new(0.3, -0.2) * area) < 1e-15);
        let own = PI * 0.5_f64.powi(4) / 4.0;
        assert!(Linear::length(moments.second - Plane::new(own + 0.09 * area, own + 0.04 * area)) < 1e-15);
        assert!((moments.mixed + 0.06 * area).abs() < 1e-15);
    }

    #[test]
    fn two_discs_lose_the_lens_between_them() {
        let distance: f64 = 1.2;
        let moments = moments(&[disc(0.0, 0.0, 1.0), disc(distance, 0.0, 1.0)]);
        // The lens of two unit discs: 2 acos(d/2) - d/2 sqrt(4 - d^2).
        let lens = 2.0 * (0.5 * distance).acos() - 0.5 * distance * (4.0 - distance * distance).sqrt();
        assert!((moments.area - (2.0 * PI - lens)).abs() < 1e-14);
        assert!(Linear::length(moments.first / moments.area - Plane::new(0.6, 0.0)) < 1e-14);
    }

    #[test]
    fn covered_and_equal_discs_count_once() {
        let one = moments(&[disc(0.1, 0.0, 1.0)]);
        let three = moments(&[disc(0.1, 0.0, 1.0), disc(0.2, 0.3, 0.2), disc(0.1, 0.0, 1.0)]);
        assert!((one.area - three.area).abs() < 1e-14 && (one.second - three.second).abs().max_element() < 1e-14);
    }

    #[test]
    fn moments_agree_with_a_sum_over_small_squares() {
        let discs = [disc(0.0, 0.0, 1.0), disc(0.9, 0.5, 0.7), disc(-0.4, 0.8, 0.6), disc(0.4, -0.9, 0.5)];
        let exact = moments(&discs);
        let (mut sum, side) = (AreaMoments::default(), 2e-3);
        for (i, j) in (0..2000).flat_map(|i| (0..2000).map(move |j| (i, j))) {
            let at = Plane::new((f64::from(i) + 0.5) * side - 2.0, (f64::from(j) + 0.5) * side - 2.0);
            if discs.iter().any(|disc| disc.centre.distance_squared(at) < disc.radius * disc.radius) {
                let area = side * side;
                sum.area += area;
                sum.first += at * area;
                sum.second += at * at * area;
                sum.mixed += at.x * at.y * area;
            }
        }
        // A sum over squares has an error of about (side)^(3/2) of the boundary's length.
        assert!((exact.area - sum.area).abs() < 5e-4 && Linear::length(exact.first - sum.first) < 5e-4);
        assert!(Linear::length(exact.second - sum.second) < 1e-3 && (exact.mixed - sum.mixed).abs() < 5e-4);
    }
}
