//! Volume and moments of a union of spheres.
//!
//! Every section at a height z is a union of discs, whose moments are exact ([`disc_union`](super::disc_union)). The integral over z is taken
//! between the heights at which spheres, or circles in which two spheres meet, begin or end. There the section changes as a square root, so z is
//! replaced by the sine of an angle. Gauss's rule is halved until the two halves agree with the whole to 1e-10 of the volume's size.

use std::f64::consts::FRAC_PI_2;

use crate::bodies::disc_union::{Disc, GAUSS, moments as area_moments};
use crate::bodies::symmetric::Symmetric;
use crate::math;
use crate::space::{Plane, Solid};

/// A sphere: its centre and its radius, m.
#[derive(Clone, Copy, Debug)]
pub struct Ball {
    /// Centre, m.
    pub centre: Solid,
    /// Radius, m.
    pub radius: f64,
}

/// Moments of a body of density one.
#[derive(Clone, Copy, Debug)]
pub struct VolumeMoments {
    /// Volume, m^3.
    pub volume: f64,
    /// Centre, m.
    pub centre: Solid,
    /// Inertia about the centre, divided by the volume, m^2.
    pub inertia: Symmetric,
}

/// Integrals over the body of 1, x, y, z, x^2, y^2, z^2, y z, z x, x y.
type Integrals = [f64; 10];

/// Largest number of halvings of an interval.
const MOST_HALVINGS: u32 = 24;

/// Relative difference at which an interval is not halved any more.
const TOLERANCE: f64 = 1e-10;

fn section(balls: &[Ball], z: f64) -> Integrals {
    let disc = |ball: &Ball| {
        let squared = ball.radius.powi(2) - (z - ball.centre.z).powi(2);
        (squared > 0.0).then(|| Disc { centre: ball.centre.truncate(), radius: squared.sqrt() })
    };
    let discs: Vec<_> = balls.iter().filter_map(disc).collect();
    let moments = area_moments(&discs);
    let Plane { x, y } = moments.first;
    let second = moments.second;
    [moments.area, x, y, z * moments.area, second.x, second.y, z * z * moments.area, z * y, z * x, moments.mixed]
}

/// Integrates over the angles `from` to `to`, which stand for heights between `low` and `high`.
fn gauss(balls: &[Ball], [low, high]: [f64; 2], [from, to]: [f64; 2]) -> Integrals {
    let [middle, half] = [0.5 * (from + to), 0.5 * (to - from)];
    let mut sum = [0.0; 10];
    for [node, weight] in GAUSS.into_iter().flat_map(|[node, weight]| [[-node, weight], [node, weight]]) {
        let angle = middle + node * half;
        let z = 0.5 * (low + high) + 0.5 * (high - low) * math::sin(angle);
        let width = weight * half * 0.5 * (high - low) * math::cos(angle);
        for (sum, number) in sum.iter_mut().zip(section(balls, z)) {
            *sum += width * number;
        }
    }
    sum
}

fn add([one, other]: [Integrals; 2]) -> Integrals {
    std::array::from_fn(|k| one[k] + other[k])
}

/// Like [`gauss`], with halving. `size` is the size of each integral at which [`TOLERANCE`] counts.
fn adaptive(
    balls: &[Ball],
    heights: [f64; 2],
    [from, to]: [f64; 2],
    whole: Integrals,
    size: &Integrals,
    left: u32,
) -> Integrals {
    let middle = 0.5 * (from + to);
    let halves = [[from, middle], [middle, to]].map(|angles| gauss(balls, heights, angles));
    let sum = add(halves);
    if left == 0 || (0..10).all(|k| (sum[k] - whole[k]).abs() <= TOLERANCE * size[k]) {
        return sum;
    }
    add([
        adaptive(balls, heights, [from, middle], halves[0], size, left - 1),
        adaptive(balls, heights, [middle, to], halves[1], size, left - 1),
    ])
}

/// Returns the heights at which the form of the section changes.
fn heights(balls: &[Ball]) -> Vec<f64> {
    let ends = |ball: &Ball| [ball.centre.z - ball.radius, ball.centre.z + ball.radius];
    let mut heights: Vec<_> = balls.iter().flat_map(ends).collect();
    for (number, one) in balls.iter().enumerate() {
        for other in &balls[number + 1..] {
            let to_other = other.centre - one.centre;
            let distance = to_other.length();
            if distance >= one.radius + other.radius || distance <= (one.radius - other.radius).abs() {
                continue;
            }
            // The circle in which the spheres meet.
            let along = (distance * distance + one.radius.powi(2) - other.radius.powi(2)) / (2.0 * distance);
            let radius = (one.radius.powi(2) - along * along).max(0.0).sqrt();
            let axis = to_other / distance;
            let reach = radius * (1.0 - axis.z * axis.z).max(0.0).sqrt();
            let middle = one.centre.z + axis.z * along;
            heights.extend([middle - reach, middle + reach]);
        }
    }
    heights.sort_unstable_by(f64::total_cmp);
    let extent = heights.last().zip(heights.first()).map_or(0.0, |(last, first)| last - first);
    heights.dedup_by(|b, a| *b - *a <= 1e-12 * extent);
    heights
}

/// Returns the moments of the union of `balls`, of which there is at least one.
#[must_use]
pub fn moments(balls: &[Ball]) -> VolumeMoments {
    // Coordinates from the middle of the body keep rounding small.
    let origin =
        balls.iter().map(|ball| ball.centre).sum::<Solid>() / f64::from(u32::try_from(balls.len()).unwrap_or(u32::MAX));
    let balls: Vec<_> = balls.iter().map(|ball| Ball { centre: ball.centre - origin, ..*ball }).collect();
    let reach = balls.iter().map(|ball| ball.centre.length() + ball.radius).fold(0.0, f64::max);
    let largest = balls.iter().map(|ball| ball.radius).fold(0.0, f64::max);
    // The largest sphere is a lower bound of the volume; lengths are at most the reach.
    let volume = 4.0 * largest.powi(3);
    let size = std::array::from_fn(|k| volume * reach.powi([0, 1, 1, 1, 2, 2, 2, 2, 2, 2][k]));
    let angles = [-FRAC_PI_2, FRAC_PI_2];
    let parts = heights(&balls);
    let sum = parts.windows(2).fold([0.0; 10], |sum, part| {
        let part = [part[0], part[1]];
        let whole = gauss(&balls, part, angles);
        add([sum, adaptive(&balls, part, angles, whole, &size, MOST_HALVINGS)])
    });
    let [volume, x, y, z, xx, yy, zz, yz, zx, xy] = sum;
    let centre = Solid::new(x, y, z) / volume;
    let squares = Solid::new(xx, yy, zz) / volume - centre * centre;
    let mixed =
        Solid::new(yz, zx, xy) / volume - Solid::new(centre.y * centre.z, centre.z * centre.x, centre.x * centre.y);
    let diagonal = Solid::splat(squares.element_sum()) - squares;
    VolumeMoments { volume, centre: origin + centre, inertia: Symmetric { diagonal, beside: -mixed } }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;

    fn ball(x: f64, y: f64, z: f64, radius: f64) -> Ball {
        Ball { centre: Solid::new(x, y, z), radius }
    }

    #[test]
    fn a_sphere_has_its_volume_and_inertia_at_any_scale() {
        for scale in [1e-6, 1.0, 1e6] {
            let moments = moments(&[ball(0.3 * scale, -2.0 * scale, scale, 0.5 * scale)]);
            assert!((moments.volume / (PI / 6.0 * scale.powi(3)) - 1.0).abs() < 1e-12);
            assert!((moments.inertia.diagonal / (0.1 * scale * scale) - Solid::ONE).length() < 1e-11);
            assert!(moments.inertia.beside.length() < 1e-13 * scale * scale);
        }
    }

    #[test]
    fn two_overlapping_spheres_count_their_lens_once_in_any_direction() {
        let distance: f64 = 1.3;
        // Volume of the lens of two unit spheres: pi (4 + d) (2 - d)^2/12.
        let volume = 8.0 * PI / 3.0 - PI * (4.0 + distance) * (2.0 - distance).powi(2) / 12.0;
        // Second moment of a dome from z = -h to 1 about its axis, and along it, by hand: a ball cut at z = -h, h = d/2.
        let h = 0.5 * distance;
        let dome = |power: i32, section: fn(f64) -> f64| {
            let count = 200_000;
            let width = (1.0 + h) / f64::from(count);
            (0..count)
                .map(|k| -h + (f64::from(k) + 0.5) * width)
                .map(|z| section(z) * (z + h).powi(power) * width)
                .sum::<f64>()
        };
        let along = 2.0 * dome(2, |z| PI * (1.0 - z * z));
        let across = 2.0 * dome(0, |z| PI / 4.0 * (1.0 - z * z).powi(2));
        for axis in [Solid::X, Solid::Y, Solid::Z, Solid::new(0.6, -0.48, 0.64)] {
            let shift = Solid::new(0.2, 0.1, -0.7);
            let [a, b] = [shift, shift + axis * distance].map(|centre| Ball { centre, radius: 1.0 });
            let moments = moments(&[a, b]);
            assert!((moments.volume / volume - 1.0).abs() < 1e-9, "{axis}: {}", moments.volume / volume - 1.0);
            assert!((moments.centre - (shift + axis * h)).length() < 1e-9);
            let mut inertia = moments.inertia.eigen().values.to_array();
            inertia.sort_by(f64::total_cmp);
            let expected = [2.0 * across, across + along, across + along].map(|moment| moment / volume);
            assert!(
                inertia.iter().zip(expected).all(|(one, other)| (one / other - 1.0).abs() < 1e-8),
                "{inertia:?} {expected:?}"
            );
        }
    }

    #[test]
    fn a_cluster_agrees_with_random_points() {
        let balls =
            [ball(0.0, 0.0, 0.0, 1.0), ball(0.8, 0.3, 0.2, 0.7), ball(-0.3, 0.6, 0.7, 0.6), ball(0.2, -0.5, 0.9, 0.5)];
        let exact = moments(&balls);
        let (mut count, mut inside, mut sum) = (0.0, 0.0, Solid::ZERO);
        let step = 0.025;
        let steps = |from: f64| (0..160).map(move |k| from + (f64::from(k) + 0.5) * step);
        for (x, y) in steps(-2.0).flat_map(|x| steps(-2.0).map(move |y| (x, y))) {
            for z in steps(-2.0) {
                count += 1.0;
                let at = Solid::new(x, y, z);
                if balls.iter().any(|ball| ball.centre.distance_squared(at) < ball.radius.powi(2)) {
                    inside += 1.0;
                    sum += at;
                }
            }
        }
        assert!((exact.volume / (inside / count * 64.0) - 1.0).abs() < 2e-3);
        assert!((exact.centre - sum / inside).length() < 2e-3);
    }
}
