//! Orientations of grains with shapes.
//!
//! The *director* of a grain is a unit vector u along a long shape and across a flat one
//! ([`RigidShape::director`](siloflow_dem::bodies::RigidShape)). u and -u mean the same.
//!
//! * *Inclination*: the angle between u and the vertical, from 0 to pi/2 rad. The vertical is the line of gravity; without gravity, the last axis.
//! * *Nematic order*: the largest eigenvalue of the mean of (D u u - 1)/(D - 1), with D = 2 or 3 components. It is 1 if all directors are
//!   parallel and 0 if no direction stands out. N random directors have about 1/sqrt(N) (de Gennes and Prost, The Physics of Liquid
//!   Crystals, 1993).

use serde::{Deserialize, Serialize};

use siloflow_dem::bodies::symmetric::Symmetric;
use siloflow_dem::math;
use siloflow_dem::space::{Solid, Space};

/// Returns the unit vector upwards, in `gravity`, m/s^2.
#[must_use]
pub fn vertical<V: Space>(gravity: V) -> V {
    let length = gravity.length();
    if length > 0.0 { -gravity * (1.0 / length) } else { V::ZERO.with_axis(V::COMPONENTS - 1, 1.0) }
}

/// Returns the inclination of a director, rad.
#[must_use]
pub fn inclination<V: Space>(director: V, vertical: V) -> f64 {
    math::acos(director.dot(vertical).abs().min(1.0))
}

/// Sums over directors.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize, Serialize)]
pub struct DirectorSums {
    count: u64,
    /// rad.
    inclination: f64,
    /// Of x^2, y^2, z^2, y z, z x, x y.
    products: [f64; 6],
}

/// Means over directors.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MeanOrientation {
    /// Mean inclination, rad; 0 without grains.
    pub inclination: f64,
    /// Nematic order; 0 without grains.
    pub order: f64,
}

impl DirectorSums {
    /// Adds a director.
    pub fn add<V: Space>(&mut self, director: V, vertical: V) {
        self.count += 1;
        self.inclination += inclination(director, vertical);
        let Solid { x, y, z } = director.spread();
        for (sum, product) in self.products.iter_mut().zip([x * x, y * y, z * z, y * z, z * x, x * y]) {
            *sum += product;
        }
    }

    /// Returns the means, for directors with `components` components.
    #[must_use]
    pub fn means(&self, components: usize) -> MeanOrientation {
        if self.count == 0 {
            return MeanOrientation::default();
        }
        #[expect(clippy::cast_precision_loss, reason = "counts are far below 2^53")]
        let [count, axes] = [self.count as f64, components as f64];
        let [xx, yy, zz, yz, zx, xy] = self.products.map(|sum| axes * sum / count);
        let mean = Symmetric { diagonal: Solid::new(xx, yy, zz), beside: Solid::new(yz, zx, xy) };
        // In the plane the third eigenvalue is zero, and the largest one at least 1.
        let order = (mean.eigen().values.max_element() - 1.0) / (axes - 1.0);
        MeanOrientation { inclination: self.inclination / count, order: order.max(0.0) }
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::{FRAC_PI_2, FRAC_PI_3, FRAC_PI_4};

    use super::*;
    use siloflow_dem::space::{Plane, Quaternion, Rotor};

    fn means<V: Space>(directors: &[V], vertical: V) -> MeanOrientation {
        let mut sums = DirectorSums::default();
        for &director in directors {
            sums.add(director, vertical);
        }
        sums.means(V::COMPONENTS)
    }

    #[test]
    fn parallel_directors_have_order_one_and_their_inclination() {
        let along = Plane::from_angle(FRAC_PI_3);
        let of_plane = means(&[along, -along, along], vertical(Plane::new(0.0, -9.81)));
        assert!((of_plane.order - 1.0).abs() < 1e-14 && (of_plane.inclination - (FRAC_PI_2 - FRAC_PI_3)).abs() < 1e-14);
        let along = Solid::new(0.6, 0.0, 0.8);
        let of_solid = means(&[along, -along], vertical(Solid::ZERO));
        assert!((of_solid.order - 1.0).abs() < 1e-13 && (of_solid.inclination - 0.8_f64.acos()).abs() < 1e-14);
    }

    #[test]
    fn directors_in_all_directions_have_no_order() {
        let plane: Vec<_> = (0..8).map(|k| Plane::from_angle(FRAC_PI_4 * f64::from(k))).collect();
        assert!(means(&plane, Plane::Y).order < 1e-14);
        let axes = means(&[Solid::X, Solid::Y, Solid::Z], Solid::Z);
        assert!(axes.order < 1e-14 && (axes.inclination - FRAC_PI_3).abs() < 1e-14);
        assert_eq!(means::<Solid>(&[], Solid::Z), MeanOrientation::default());
    }

    #[test]
    fn random_directors_have_the_order_and_the_mean_angle_of_theory() {
        // A mean angle of 1 rad: the density of the inclination is its sine.
        let step = |number: u32, factor: f64| (f64::from(number) * factor).fract();
        let director = |number: u32| {
            let numbers = [0.754_877_666, 0.569_840_291, 0.438_579_021].map(|factor| step(number, factor));
            <Quaternion as Rotor<Solid>>::from_uniform(numbers) * Solid::X
        };
        let all: Vec<_> = (0..20_000).map(director).collect();
        let random = means(&all, Solid::Z);
        assert!((random.inclination - 1.0).abs() < 0.01 && random.order < 0.02, "{random:?}");
    }
}
