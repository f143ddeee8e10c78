//! The laws of Hertz and Mindlin: elastic spheres, with a damping that gives the same restitution at every speed.
//!
//! With 1/E* = (1 - nu_i^2)/E_i + (1 - nu_j^2)/E_j, 1/G* = (2 - nu_i)/G_i + (2 - nu_j)/G_j, G = E/(2 (1 + nu)), and
//! R* = R_i R_j/(R_i + R_j):
//!
//! * spring F = 4/3 E* sqrt(R* delta) delta, tangent stiffness S_n = 2 E* sqrt(R* delta);
//! * damping c = 2 z sqrt(S_n m_eff), z = sqrt(5/6) zeta. zeta is the damping ratio that gives the linear law the
//!   restitution e, with attraction allowed or forbidden ([`Attraction`]). This is exact: a substitution of time turns
//!   the bounce into a linear one (Antypov and Elliott, EPL 94, 50004, 2011). The polynomial of Thornton, Cummins and
//!   Cleary, Powder Technology 233, 30, 2013, fits the forbidden case: its error in e is 3e-4 up to e = 0.9, and
//!   2e-2 at e = 1;
//! * tangential k_t = 8 G* sqrt(R* delta), c_t = 2 z sqrt(k_t m_eff) ([`Mindlin`]). This is the no-slip stiffness with
//!   one spring and Coulomb's cap; the partial slip of Mindlin and Deresiewicz is not modelled. A scene may give c_t as a
//!   share of c instead, as in LAMMPS and MFiX.
//!
//! E and G in Pa. In a planar scene discs interact like spheres.

use serde::{Deserialize, Serialize};

use crate::contact::centred::window::Window;
use crate::contact::composite::Normal;
use crate::contact::damping::Attraction;
use crate::contact::law::Bounce;
use crate::contact::pair::Pair;
use crate::contact::tangential::Modulus;
use crate::math;
use crate::space::Space;
use crate::values::{NonNegative, PoissonRatio, Positive, Restitution};

/// One of the scene's `materials`.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Material {
    /// Young's modulus E, Pa.
    pub young: Positive,
    /// Poisson's ratio nu.
    pub poisson: PoissonRatio,
}

impl Material {
    /// Returns E* of two materials, Pa.
    #[must_use]
    pub fn effective_modulus(self, other: Self) -> f64 {
        let compliance = |m: Self| (1.0 - m.poisson.get().powi(2)) / m.young.get();
        1.0 / (compliance(self) + compliance(other))
    }

    /// Returns G* of two materials, Pa.
    #[must_use]
    pub fn effective_shear_modulus(self, other: Self) -> f64 {
        let compliance = |m: Self| (2.0 - m.poisson.get()) * 2.0 * (1.0 + m.poisson.get()) / m.young.get();
        1.0 / (compliance(self) + compliance(other))
    }
}

/// Hertz's normal force with damping.
#[derive(Clone, Copy, Debug)]
pub struct Hertz {
    modulus: f64,
    ratio: f64,
    restitution: f64,
    floor: f64,
}

impl Hertz {
    /// Creates the law between two materials.
    #[must_use]
    pub fn new(materials: [Material; 2], restitution: Restitution, attraction: Attraction) -> Self {
        let [a, b] = materials;
        Self {
            modulus: a.effective_modulus(b),
            ratio: (5.0f64 / 6.0).sqrt() * attraction.damping_ratio(restitution),
            restitution: restitution.get(),
            floor: attraction.floor(),
        }
    }

    /// Returns S_n, N/m.
    fn tangent(&self, reduced_radius: f64, overlap: f64) -> f64 {
        2.0 * self.modulus * (reduced_radius * overlap).sqrt()
    }
}

impl Normal for Hertz {
    // `mean_dashpot_without_events` takes the mean of delta^(1/4) as its value in the middle times 1 - (w/delta)^2/32. The remainder is
    // 0.02 (w/delta)^4 at this ratio, below 1e-5.
    const OVERLAP_WITHOUT_EVENTS: f64 = 8.0;
    const FADES: bool = true;

    #[inline(always)]
    fn spring<V: Space>(&self, pair: &Pair<V>) -> f64 {
        2.0 / 3.0 * self.tangent(pair.reduced_radius(), pair.overlap) * pair.overlap
    }

    #[inline(always)]
    fn dashpot<V: Space>(&self, pair: &Pair<V>) -> f64 {
        2.0 * self.ratio * (self.tangent(pair.reduced_radius(), pair.overlap) * pair.reduced_mass).sqrt()
    }

    #[inline(always)]
    fn mean_dashpot<V: Space>(&self, pair: &Pair<V>, window: &Window, overlap: f64) -> f64 {
        // c = C delta^(1/4), whose integral is 4/5 C delta^(5/4) = 4/5 c delta.
        let w = window.half_width;
        let integral = |overlap: f64| 0.8 * self.dashpot(&pair.at_overlap(overlap)) * overlap.max(0.0);
        if w > 0.0 { 0.5 * (integral(overlap + w) - integral(overlap - w)) / w } else { self.dashpot(pair) }
    }

    #[inline(always)]
    fn mean_dashpot_without_events(&self, dashpot: f64, window: &Window, overlap: f64) -> f64 {
        dashpot * (1.0 - (window.half_width / overlap).powi(2) / 32.0)
    }

    #[inline(always)]
    fn floor(&self) -> f64 {
        self.floor
    }

    fn energy<V: Space>(&self, pair: &Pair<V>) -> f64 {
        // The integral of 4/3 E* sqrt(R*) delta^(3/2).
        4.0 / 15.0 * self.tangent(pair.reduced_radius(), pair.overlap) * pair.overlap * pair.overlap
    }

    fn stiffness(&self, bounce: &Bounce) -> f64 {
        self.tangent(bounce.reduced_radius, self.deepest(bounce))
    }

    fn damping(&self, bounce: &Bounce) -> f64 {
        2.0 * self.ratio * (self.stiffness(bounce) * bounce.reduced_mass).sqrt()
    }

    fn deepest(&self, bounce: &Bounce) -> f64 {
        let k = 4.0 / 3.0 * self.modulus * bounce.reduced_radius.sqrt();
        math::pow(1.25 * bounce.reduced_mass * bounce.speed.powi(2) / k, 0.4)
    }

    fn contact_duration(&self, bounce: &Bounce) -> f64 {
        // The factor is 2 int_0^1 dx/sqrt(1 - x^(5/2)) = 2.943, for the undamped bounce.
        2.943_275 * self.deepest(bounce) / bounce.speed
    }

    fn restitution(&self, _: &Bounce) -> f64 {
        self.restitution
    }
}

/// Mindlin's tangential stiffness and dashpot coefficient, for use with [`Hertz`].
#[derive(Clone, Copy, Debug)]
pub struct Mindlin {
    shear_modulus: f64,
    ratio: f64,
    /// c_t/c, the same at every overlap.
    dashpot_share: f64,
    normal: Hertz,
}

impl Mindlin {
    /// Creates the tangential term between two materials with the normal law `normal`.
    #[must_use]
    pub fn new(materials: [Material; 2], normal: Hertz) -> Self {
        let [a, b] = materials;
        let shear_modulus = a.effective_shear_modulus(b);
        Self {
            shear_modulus,
            ratio: normal.ratio,
            dashpot_share: (4.0 * shear_modulus / normal.modulus).sqrt(),
            normal,
        }
    }
}

impl Mindlin {
    /// Returns the term with c_t = `share` c.
    #[must_use]
    pub fn with_dashpot_share(self, share: f64) -> Self {
        // c_t/c = sqrt(k_t/S_n) at equal ratios.
        Self { ratio: self.ratio * share / self.dashpot_share, dashpot_share: share, ..self }
    }
}

/// How a scene gives the tangential damping of [`Mindlin`].
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
pub enum MindlinDamping {
    /// c_t is this share of the normal c, dimensionless.
    OfNormal(NonNegative),
}

impl Modulus for Mindlin {
    const VARIES: bool = true;

    #[inline(always)]
    fn of<V: Space>(&self, pair: &Pair<V>, _: f64) -> (f64, f64) {
        let k = 8.0 * self.shear_modulus * (pair.reduced_radius() * pair.overlap).sqrt();
        (k, 2.0 * self.ratio * (k * pair.reduced_mass).sqrt())
    }

    #[inline(always)]
    fn mean_dashpot<V: Space>(&self, _: &Pair<V>, _: f64, normal_dashpot: f64) -> f64 {
        self.dashpot_share * normal_dashpot
    }

    fn remembered(&self, memory: f64) -> f64 {
        memory
    }

    fn at(&self, bounce: &Bounce, _: f64) -> [f64; 2] {
        let k = 8.0 * self.shear_modulus * (bounce.reduced_radius * self.normal.deepest(bounce)).sqrt();
        [k, 2.0 * self.ratio * (k * bounce.reduced_mass).sqrt()]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    fn glass() -> Material {
        Material { young: 4.8e10.try_into().unwrap(), poisson: 0.2.try_into().unwrap() }
    }

    #[test]
    fn glass_sphere_impact_agrees_with_published_values() {
        // Chung and Ooi, Granular Matter 13, 643, 2011, test 1: R = 1 cm, 2800 kg/m^3, 10 m/s each: 274.1 um, 40.34 us.
        let mass = 2800.0 * 4.0 / 3.0 * PI * 1e-6;
        let bounce = Bounce { reduced_mass: 0.5 * mass, reduced_radius: 0.005, speed: 20.0 };
        let law = Hertz::new([glass(), glass()], Restitution::try_from(1.0).unwrap(), Attraction::Allowed);
        // Tolerances: half a unit in the last published digit.
        assert!((law.deepest(&bounce) - 274.1e-6).abs() < 0.05e-6, "{}", law.deepest(&bounce));
        assert!((law.contact_duration(&bounce) - 40.34e-6).abs() < 0.005e-6, "{}", law.contact_duration(&bounce));
    }

    #[test]
    fn damping_without_attraction_agrees_with_published_fit() {
        const THORNTON: [f64; 10] = [
            -6.918_798, -16.411_05, 146.804_9, -796.455_9, 2_928.711, -7_206.864, 11_494.29, -11_342.18, 6_276.757,
            -1_489.915,
        ];
        for e in [0.2, 0.4, 0.6, 0.8, 0.9] {
            let alpha = THORNTON.iter().rev().fold(0.0, |sum, h| e * (h + sum));
            let published = (1.0 / (1.0 - (1.0f64 + e).powi(2) * alpha.exp()) - 1.0).sqrt();
            let law = Hertz::new([glass(), glass()], e.try_into().unwrap(), Attraction::Forbidden);
            // The fit is 3e-4 off in e; de/dz is about -2 at these e.
            assert!((law.ratio - published).abs() < 1e-3, "{e}: {} {published}", law.ratio);
        }
    }

    #[test]
    fn moduli_of_equal_materials() {
        let g = 4.8e10 / 2.4;
        assert!((glass().effective_modulus(glass()) / (4.8e10 / (2.0 * 0.96)) - 1.0).abs() < 1e-15);
        assert!((glass().effective_shear_modulus(glass()) / (g / (2.0 * 1.8)) - 1.0).abs() < 1e-15);
    }
}
