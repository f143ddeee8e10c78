//! Friction: the force in the tangent plane of a contact, with Coulomb's cap mu |F_n|.
//!
//! With the sliding velocity v_t = v_ij - v_n n - (l_i w_i + l_j w_j) x n of the surfaces:
//!
//! * [`Dashpot`]: F_t = -c_t v_t, without memory. A heap of such grains creeps.
//! * [`SpringSlider`]: a spring S that remembers how far the surfaces have moved against each other while the contact lasts,
//!   F_t = -k_t S - c_t v_t, elastic-plastic as [`Slider`](super::spring::Slider) has it. Source: Cundall and Strack 1979, as in the
//!   soft-particle codes and LAMMPS's `hooke/history`.
//!
//! The force on j is the opposite; each grain gets the torque -l n x F_t. By [`Lever`] the arm l is the radius (simple,
//! and what most codes have: a contact then leaks the angular momentum -delta n x F_t) or reaches to the contact point,
//! which keeps angular momentum. c_t in N s/m by [`TangentialDamping`], k_t in N/m by [`Modulus`].

mod dashpot;
mod spring_slider;

use serde::{Deserialize, Serialize};

pub use self::dashpot::Dashpot;
pub use self::spring_slider::{ConstantStiffness, Modulus, SpringSlider};
use crate::contact::damping::Coefficient;
use crate::contact::spring::{Event, TangentialStep};
use crate::contact::{Bounce, Memory, Pair, Turning, VelocityPrediction};
use crate::space::Space;
use crate::values::NonNegative;

/// Where the tangential force acts.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
pub enum Lever {
    /// A radius away from the centre.
    #[default]
    Radius,
    /// At the contact point: l_i = R_i - delta R_j/(R_i + R_j); R - delta on a flat wall.
    ContactPoint,
}

impl Lever {
    /// The arms of i and j, m; none for a flat wall.
    #[inline(always)]
    #[must_use]
    pub fn arms<V: Space>(self, pair: &Pair<V>) -> [f64; 2] {
        let [i, j] = pair.radii;
        match (self, j.is_infinite()) {
            (Self::Radius, false) => pair.radii,
            (Self::Radius, true) => [i, 0.0],
            (Self::ContactPoint, false) => {
                let share = pair.overlap * pair.inverse_reach;
                [i - share * j, j - share * i]
            }
            (Self::ContactPoint, true) => [i - pair.overlap, 0.0],
        }
    }
}

/// The drag coefficient c_t of the tangential force, N s/m.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
pub enum TangentialDamping {
    /// c_t = b, N s/m.
    B(NonNegative),
    /// c_t = gamma_t m_eff, gamma_t in 1/s, as LAMMPS has it.
    PerMass(NonNegative),
    /// c_t is this share of the normal c.
    OfNormal(NonNegative),
}

/// c_t: what it is given besides the effective mass is the normal c.
impl From<TangentialDamping> for Coefficient {
    fn from(damping: TangentialDamping) -> Self {
        match damping {
            TangentialDamping::B(b) => Self { constant: b.get(), ..Self::default() },
            TangentialDamping::PerMass(gamma) => Self { per_mass: gamma.get(), ..Self::default() },
            TangentialDamping::OfNormal(share) => Self { per_other: share.get(), ..Self::default() },
        }
    }
}

/// What the normal force of a centred contact leaves to its tangent plane.
#[derive(Clone, Copy, Debug)]
pub struct NormalLoad {
    /// The normal force of the contact as it stands, N.
    pub whole: f64,
    /// The normal forces averaged over the steps centred on the beginning and on the end, N.
    pub averaged: [f64; 2],
    /// The shares of those steps in which there is a contact.
    pub shares: [f64; 2],
    /// The normal drag coefficient c as it stands, N s/m.
    pub drag: f64,
    /// For how long springs gather, s: from the event on.
    pub gathering: f64,
    /// The moment of this step in which the contact opened or the normal force changed its sign, s before the end, with
    /// the normal force just after, N, and whether it opened.
    pub event: Option<(f64, f64, bool)>,
}

impl NormalLoad {
    /// The step, for a motion with this velocity in its middle and what that gains (m/s), the mobilities (1/kg) of such a
    /// motion, and a coefficient of friction.
    #[inline(always)]
    #[must_use]
    pub fn sweep<V: Space>(&self, motion: [V; 2], mobilities: [f64; 2], friction: f64, dt: f64) -> TangentialStep<V> {
        let [middle, gained] = motion;
        TangentialStep {
            middle,
            gained,
            mobilities,
            dt,
            event: self.event.map(|(ago, force, opens)| Event { ago, cap: friction * force.abs(), opens }),
            gathering: self.gathering,
            shares: self.shares,
            averaged_caps: self.averaged.map(|force| friction * force.abs()),
            pulled: V::ZERO,
        }
    }
}

impl<V: Space> Pair<V> {
    /// The sliding velocity in the middle of the step and what it gains until its end, m/s, and how fast a tangential
    /// force changes it, of all and of lone grains, 1/kg: 1/m + l^2/I of i and j.
    #[inline(always)]
    fn sliding(&self, arms: [f64; 2]) -> ([V; 2], [f64; 2]) {
        let middle = self.sliding_velocity(arms);
        let VelocityPrediction { inverse_masses: m, inverse_inertias: i, only_contact, .. } = self.ahead;
        let [a, b] = [m[0] + arms[0] * arms[0] * i[0], m[1] + arms[1] * arms[1] * i[1]];
        ([middle, self.predicted().sliding_velocity(arms) - middle], [a + b, only_contact[0] * a + only_contact[1] * b])
    }
}

/// A term in the tangent plane.
pub trait Tangential: Copy + Send + Sync + 'static {
    /// Whether it turns grains.
    const SPIN: bool = true;
    /// Whether it remembers a spring.
    const SPRING: bool = false;
    /// Whether it remembers that spring's stiffness.
    const STIFFNESS: bool = false;

    /// Adds friction; `normal_force` (N) and `normal_drag` (N s/m) are those of the normal force.
    fn add<V: Space>(
        &self,
        pair: &Pair<V>,
        normal_force: f64,
        normal_drag: f64,
        memory: &mut Memory<V>,
        turning: &mut Turning<V>,
    );

    /// Adds friction averaged over the step: [`super::centred`].
    fn add_centred<V: Space>(
        &self,
        pair: &Pair<V>,
        load: &NormalLoad,
        memory: &mut Memory<V>,
        turning: &mut Turning<V>,
    );

    /// Energy stored, J.
    fn energy<V: Space>(&self, _memory: &Memory<V>) -> f64 {
        0.0
    }

    /// See [`PairLaw::on_contact_end`](crate::contact::PairLaw::forget), J.
    fn on_contact_end<V: Space>(&self, _pair: &Pair<V>, _memory: &Memory<V>) -> f64 {
        0.0
    }

    /// Stiffness (N/m) and drag coefficient (N s/m) at the deepest point of a bounce; `normal_drag` is the normal c.
    fn mode(&self, bounce: &Bounce, normal_drag: f64) -> [f64; 2];

    /// The coefficient mu.
    fn friction(&self) -> f64;
}

/// No friction.
#[derive(Clone, Copy, Debug)]
pub struct NoFriction;

impl Tangential for NoFriction {
    const SPIN: bool = false;

    #[inline(always)]
    fn add<V: Space>(&self, _: &Pair<V>, _: f64, _: f64, _: &mut Memory<V>, _: &mut Turning<V>) {}

    #[inline(always)]
    fn add_centred<V: Space>(&self, _: &Pair<V>, _: &NormalLoad, _: &mut Memory<V>, _: &mut Turning<V>) {}

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
    use crate::contact::tests::pair;
    use crate::space::Vector;

    #[test]
    fn arms_reach_to_the_contact_point_and_meet_there() {
        let pair = Pair { radii: [0.03, 0.05], inverse_reach: 12.5, overlap: 0.004, ..pair() };
        let [i, j] = Lever::ContactPoint.arms(&pair);
        // Both arms together span the distance of the centres, and split the overlap in the other one's proportion.
        assert!((i + j - 0.076).abs() < 1e-16 && (i - 0.0275).abs() < 1e-16, "{i} {j}");
        assert_eq!(Lever::Radius.arms(&pair), [0.03, 0.05]);
        assert_eq!(
            Lever::ContactPoint.arms(&Pair { radii: [0.03, f64::INFINITY], inverse_reach: 0.0, ..pair }),
            [0.026, 0.0]
        );
    }

    #[test]
    fn a_rolling_contact_does_not_slide() {
        // Over a floor below, a disc that rolls to the right turns clockwise.
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
