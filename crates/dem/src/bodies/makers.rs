//! Shapes from a few numbers: chains of spheres (discs) inside ellipsoids of revolution (ellipses) and capsules.
//!
//! All spheres touch the surface asked for from inside, so length and width of the shape are exact. Between two spheres there is a valley. The
//! positions are chosen so that all valleys are equally deep, which makes the deepest one as shallow as possible.
//!
//! A sphere in an ellipsoid of half-length a and half-width b, with its centre at x on the axis, touches the surface with the radius
//! b sqrt(1 - x^2/(a^2 - b^2)), up to x = (a^2 - b^2)/a. There it touches the tip, with its radius of curvature b^2/a.

use crate::math;

/// A sphere of a chain: its place along the axis from the middle, and its radius, m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Link {
    /// Place along the axis, m.
    pub x: f64,
    /// Radius, m.
    pub radius: f64,
}

/// How far the surface of a chain is from the one asked for, m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Deviation {
    /// The largest distance.
    pub largest: f64,
    /// The root of the mean square, over the length of the profile.
    pub rms: f64,
}

/// The profile of a body of revolution.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Profile {
    /// An ellipse of this half-length and half-width, m; the half-length is not the smaller one.
    Ellipse {
        /// Half-length, m.
        a: f64,
        /// Half-width, m.
        b: f64,
    },
    /// A straight piece with round ends.
    Capsule {
        /// Half of the whole length, m.
        half_length: f64,
        /// Radius, m.
        radius: f64,
    },
}

/// Number of points of a profile at which its deviation is measured.
const SAMPLES: u32 = 2000;

impl Profile {
    /// Returns the place of the outermost sphere, m.
    fn end(&self) -> f64 {
        match *self {
            Self::Ellipse { a, b } => (a * a - b * b) / a,
            Self::Capsule { half_length, radius } => half_length - radius,
        }
    }

    /// Returns the sphere that touches the profile from inside, with its centre at `x`, m.
    fn inscribed(&self, x: f64) -> Link {
        let radius = match *self {
            Self::Ellipse { a, b } if a > b => b * (1.0 - x * x / (a * a - b * b)).max(0.0).sqrt(),
            Self::Ellipse { b, .. } => b,
            Self::Capsule { radius, .. } => radius,
        };
        Link { x, radius }
    }

    /// Returns half the width at `x`, m.
    fn half_width(&self, x: f64) -> f64 {
        match *self {
            Self::Ellipse { a, b } => b * (1.0 - (x / a).powi(2)).max(0.0).sqrt(),
            Self::Capsule { half_length, radius } => {
                let beyond = (x.abs() - (half_length - radius)).max(0.0);
                (radius * radius - beyond * beyond).max(0.0).sqrt()
            }
        }
    }

    /// Returns how deep the valley between two spheres is, measured across the axis, m.
    fn valley(&self, left: Link, right: Link) -> f64 {
        let distance = right.x - left.x;
        if distance >= left.radius + right.radius {
            return f64::INFINITY;
        }
        if distance <= 0.0 {
            return 0.0;
        }
        let along = (distance * distance + left.radius.powi(2) - right.radius.powi(2)) / (2.0 * distance);
        let height = (left.radius.powi(2) - along * along).max(0.0).sqrt();
        self.half_width(left.x + along) - height
    }

    /// Returns where the chain with valleys of this depth (m) reaches with `count` spheres, from the left end.
    fn marched(&self, depth: f64, count: usize) -> Vec<Link> {
        let mut links = vec![self.inscribed(-self.end())];
        for _ in 1..count {
            let last = links[links.len() - 1];
            let [mut low, mut high] = [last.x, 2.0 * self.end().max(last.radius) + last.x];
            for _ in 0..80 {
                let middle = 0.5 * (low + high);
                let is_beyond = middle > self.end() || self.valley(last, self.inscribed(middle)) > depth;
                [low, high] = if is_beyond { [low, middle] } else { [middle, high] };
            }
            links.push(self.inscribed(low));
        }
        links
    }

    /// Returns a chain of `count` spheres with equally deep valleys. `None` if neighbouring spheres would not overlap.
    #[must_use]
    pub fn chain(&self, count: usize) -> Option<Vec<Link>> {
        if self.end() <= 0.0 || count < 2 {
            // A round body is one sphere; a long one has at least a sphere at each end.
            return (self.end() <= 0.0 && count > 0).then(|| vec![self.inscribed(0.0)]);
        }
        let [mut low, mut high] = [0.0, self.inscribed(0.0).radius];
        let reaches = |depth: f64| self.marched(depth, count)[count - 1].x >= self.end() * (1.0 - 1e-9);
        if !reaches(high * (1.0 - 1e-9)) {
            return None;
        }
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            [low, high] = if reaches(middle) { [low, middle] } else { [middle, high] };
        }
        let links = self.marched(high, count);
        // The chain is symmetric up to rounding.
        let symmetric = |i: usize| self.inscribed(0.5 * (links[i].x - links[count - 1 - i].x));
        Some((0..count).map(symmetric).collect())
    }

    /// Returns how far the surface of a chain is from the profile.
    #[must_use]
    pub fn deviation(&self, links: &[Link]) -> Deviation {
        let half_length = match *self {
            Self::Ellipse { a, .. } => a,
            Self::Capsule { half_length, .. } => half_length,
        };
        let mut largest = 0.0_f64;
        let [mut squares, mut total] = [0.0; 2];
        let point = |number: u32| {
            let x = -half_length * math::cos(std::f64::consts::PI * f64::from(number) / f64::from(SAMPLES));
            [x, self.half_width(x)]
        };
        for number in 0..SAMPLES {
            let [from, to] = [point(number), point(number + 1)];
            let [x, y] = [0.5 * (from[0] + to[0]), 0.5 * (from[1] + to[1])];
            let length = math::hypot(to[0] - from[0], to[1] - from[1]);
            let outside =
                links.iter().map(|link| math::hypot(x - link.x, y) - link.radius).fold(f64::INFINITY, f64::min);
            largest = largest.max(outside.abs());
            squares += outside * outside * length;
            total += length;
        }
        Deviation { largest, rms: (squares / total).sqrt() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_capsule_has_equally_spaced_spheres_and_the_exact_length() {
        let profile = Profile::Capsule { half_length: 10.0, radius: 3.0 };
        let links = profile.chain(9).unwrap();
        for (number, link) in (0..9).zip(&links) {
            assert!((link.x - (-7.0 + 1.75 * f64::from(number))).abs() < 1e-6 && (link.radius - 3.0).abs() < 1e-15);
        }
        // The surface above the middle between two spheres of radius r at the distance s is sqrt(r^2 + s^2/4) - r outside both.
        let valley = (9.0 + 0.875_f64.powi(2)).sqrt() - 3.0;
        let deviation = profile.deviation(&links);
        assert!((deviation.largest / valley - 1.0).abs() < 0.01, "{deviation:?} {valley}");
        assert!(deviation.rms < deviation.largest);
    }

    #[test]
    fn an_ellipsoid_has_equally_deep_valleys_and_exact_axes() {
        let profile = Profile::Ellipse { a: 3.5, b: 1.1 };
        let links = profile.chain(7).unwrap();
        assert!((links[6].x + links[6].radius - 3.5).abs() < 1e-6 && (links[3].radius - 1.1).abs() < 1e-12);
        let depths: Vec<_> = links.windows(2).map(|pair| profile.valley(pair[0], pair[1])).collect();
        assert!(depths.iter().all(|depth| (depth / depths[0] - 1.0).abs() < 1e-4), "{depths:?}");
        // More spheres come closer, as the square of their distance.
        let [few, many] = [7, 14].map(|count| profile.deviation(&profile.chain(count).unwrap()).largest);
        assert!((3.0..6.0).contains(&(few / many)), "{few} {many}");
    }

    #[test]
    fn chains_that_fall_apart_are_none_and_round_bodies_are_one_sphere() {
        assert_eq!(Profile::Capsule { half_length: 10.0, radius: 1.0 }.chain(5), None);
        assert_eq!(Profile::Ellipse { a: 5.0, b: 1.0 }.chain(2), None);
        assert_eq!(Profile::Ellipse { a: 1.0, b: 1.0 }.chain(5).unwrap(), [Link { x: 0.0, radius: 1.0 }]);
        assert_eq!(Profile::Capsule { half_length: 2.0, radius: 1.0 }.chain(1), None);
    }
}
