//! Friction: the force in the tangent plane of a contact, with Coulomb's cap mu |F_n|.
//!
//! With the sliding velocity v_t = v_ij - v_n n - (l_i w_i + l_j w_j) x n of the surfaces:
//!
//! * [`Dashpot`]: F_t = -c_t v_t, without memory. A heap of grains with this friction creeps.
//! * [`SpringSlider`]: F_t = -k_t S - c_t v_t, elastic-plastic as in [`Slider`](super::spring::Slider). The spring S
//!   remembers how far the surfaces have moved against each other while the contact lasts. Source: Cundall and Strack
//!   1979; also used in soft-particle codes and LAMMPS's `hooke/history`.
//!
//! The opposite force acts on j; each grain gets the torque -l n x F_t. [`Lever`] selects the arm l. An arm equal to
//! the radius is simple and used by most codes, but a contact then exerts the net torque -delta n x F_t on the pair. An
//! arm to the contact point conserves angular momentum. c_t in N s/m by [`TangentialDamping`], k_t in N/m by
//! [`Modulus`].

mod dashpot;
mod spring_slider;

use serde::{Deserialize, Serialize};

pub use self::dashpot::Dashpot;
pub(super) use self::spring_slider::mean_of;
pub use self::spring_slider::{ConstantStiffness, Modulus, SpringSlider};
use crate::contact::centred::normal_load::NormalLoad;
use crate::contact::centred::slider::TangentialMotion;
use crate::contact::damping::Coefficient;
use crate::contact::law::Bounce;
use crate::contact::pair::{Pair, VelocityPrediction};
use crate::contact::pair_force::Resistance;
use crate::contact::spring_memory::SpringMemory;
use crate::space::Space;
use crate::values::NonNegative;

/// The point at which the tangential force acts.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
pub enum Lever {
    /// At one radius from the centre.
    #[default]
    Radius,
    /// At the contact point: l_i = R_i - delta R_j/(R_i + R_j); R - delta on a wall surface.
    ContactPoint,
}

impl Lever {
    /// Returns the arms of i and j, m; the arm of a wall surface is 0.
    #[inline(always)]
    #[must_use]
    pub fn arms<V: Space>(self, pair: &Pair<V>) -> [f64; 2] {
        let [i, j] = pair.radii;
        // A factor: a choice would take a mask in vector code.
        let to_contact = match self {
            Self::Radius => 0.0,
            Self::ContactPoint => 1.0,
        };
        let share = to_contact * (pair.overlap * pair.inverse_reach);
        let is_wall = j == f64::INFINITY;
        let shorter = if is_wall { to_contact * pair.overlap } else { share * j };
        [i - shorter, if is_wall { 0.0 } else { j - share * i }]
    }
}

/// How a scene gives the dashpot coefficient c_t of the tangential force, N s/m.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
pub enum TangentialDamping {
    /// c_t = b, N s/m.
    B(NonNegative),
    /// c_t = gamma_t m_eff for this gamma_t, 1/s, as in LAMMPS.
    PerMass(NonNegative),
    /// c_t is this share of the normal c, dimensionless.
    OfNormal(NonNegative),
}

/// Converts to the coefficient c_t; its x is the normal c.
impl From<TangentialDamping> for Coefficient {
    fn from(damping: TangentialDamping) -> Self {
        match damping {
            TangentialDamping::B(b) => Self { constant: b.get(), ..Self::default() },
            TangentialDamping::PerMass(gamma) => Self { per_mass: gamma.get(), ..Self::default() },
            TangentialDamping::OfNormal(share) => Self { per_other: share.get(), ..Self::default() },
        }
    }
}

impl<V: Space> Pair<V> {
    /// Returns the sliding motion of a contact near an event. A mobility is 1/m + l^2/I, and what bodies add, summed over i and j.
    #[inline(always)]
    fn sliding(&self, arms: [f64; 2]) -> TangentialMotion<V> {
        let middle = self.sliding_velocity(arms);
        let VelocityPrediction { inverse_masses: m, inverse_inertias: i, lone, beside, .. } = self.ahead;
        let mobility = |side: usize| m[side] + arms[side] * arms[side] * i[side] + beside.mobilities[side];
        let [a, b] = [mobility(0), mobility(1)];
        TangentialMotion {
            middle,
            gained: self.predicted().sliding_velocity(arms) - middle,
            mobilities: [a + b, lone[0] * a + lone[1] * b],
            pushed: self.pushed(|pair| pair.sliding_velocity(arms)),
        }
    }
}

/// A term of the force in the tangent plane.
pub trait Tangential: Copy + Send + Sync + 'static {
    /// Whether the term exerts torques.
    const SPIN: bool = true;
    /// Whether the term needs [`SpringMemory::spring`].
    const SPRING: bool = false;
    /// Whether the term needs [`SpringMemory::stiffness`].
    const STIFFNESS: bool = false;

    /// Adds friction; `normal_force` (N) and `normal_dashpot` (N s/m) belong to the normal force.
    fn add<V: Space>(
        &self,
        pair: &Pair<V>,
        normal_force: f64,
        normal_dashpot: f64,
        memory: &mut SpringMemory<V>,
        resistance: &mut Resistance<V>,
    );

    /// Adds friction averaged over the step: [`super::centred`].
    fn add_centred<V: Space>(
        &self,
        pair: &Pair<V>,
        load: &NormalLoad,
        memory: &mut SpringMemory<V>,
        resistance: &mut Resistance<V>,
    );

    /// Returns the stored energy, J.
    fn energy<V: Space>(&self, _pair: &Pair<V>, _memory: &SpringMemory<V>) -> f64 {
        0.0
    }

    /// Returns the energy lost at the end of a contact, J; see
    /// [`PairLaw::on_contact_end`](crate::contact::PairLaw::on_contact_end).
    fn on_contact_end<V: Space>(&self, _pair: &Pair<V>, _memory: &SpringMemory<V>) -> f64 {
        0.0
    }

    /// Returns stiffness (N/m) and dashpot coefficient (N s/m) at the deepest point of a bounce; `normal_dashpot` is the
    /// normal c.
    fn mode(&self, bounce: &Bounce, normal_dashpot: f64) -> [f64; 2];

    /// Returns the coefficient mu.
    fn friction(&self) -> f64;
}

/// No friction.
#[derive(Clone, Copy, Debug)]
pub struct NoFriction;

impl Tangential for NoFriction {
    const SPIN: bool = false;

    #[inline(always)]
    fn add<V: Space>(&self, _: &Pair<V>, _: f64, _: f64, _: &mut SpringMemory<V>, _: &mut Resistance<V>) {}

    #[inline(always)]
    fn add_centred<V: Space>(&self, _: &Pair<V>, _: &NormalLoad, _: &mut SpringMemory<V>, _: &mut Resistance<V>) {}

    fn mode(&self, _: &Bounce, _: f64) -> [f64; 2] {
        [0.0, 0.0]
    }

    fn friction(&self) -> f64 {
        0.0
    }
}

#[cfg(test)]
#[expect(clippy::float_cmp, reason = "exact values")]
mod tests {
    use super::*;
    use crate::contact::pair::tests::pair;
    use crate::space::Vector;

    #[test]
    fn arms_meet_at_the_contact_point() {
        let pair = Pair { radii: [0.03, 0.05], inverse_reach: 12.5, overlap: 0.004, ..pair() };
        let [i, j] = Lever::ContactPoint.arms(&pair);
        // Both arms together span the distance of the centres, and split the overlap in the ratio of the other radii.
        assert!((i + j - 0.076).abs() < 1e-16 && (i - 0.0275).abs() < 1e-16, "{i} {j}");
        assert_eq!(Lever::Radius.arms(&pair), [0.03, 0.05]);
        assert_eq!(
            Lever::ContactPoint.arms(&Pair { radii: [0.03, f64::INFINITY], inverse_reach: 0.0, ..pair }),
            [0.026, 0.0]
        );
    }

    #[test]
    fn a_rolling_contact_does_not_slide() {
        // A disc on a floor that rolls to the right turns clockwise.
        let pair = Pair {
            normal: Vector::Y,
            relative_velocity: Vector::new(0.6, -0.2),
            radii: [0.04, f64::INFINITY],
            inverse_reach: 0.0,
            spins: [-15.0, 0.0],
            ..pair()
        };
        assert!(pair.sliding_velocity(Lever::Radius.arms(&pair)).length() < 1e-16);
    }
}
