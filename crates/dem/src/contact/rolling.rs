//! Rolling resistance: an elastic-plastic spring-dashpot against the relative rolling of two grains. [`AnyRolling`] has other
//! kinds.
//!
//! The rolling velocity v_r = R_eff (w_i - w_j) x n accumulates in a displacement xi (m), R_eff = R_i R_j/(R_i + R_j).
//! The rolling force is F_r = -k xi - c v_r, capped at mu_r |F_n| as in [`Slider`]. The torque on i is R_eff n x F_r,
//! and the opposite torque acts on j. There is no net force, and angular momentum is conserved. k in N/m, c in N s/m;
//! the torque's cap is mu_r R_eff |F_n|.
//!
//! Source: model C of Ai, Chen, Rotter and Ooi, Powder Technology 206, 269, 2011, in the units of LAMMPS's `rolling
//! sds`. Twisting about the normal is resisted by [`twisting`](super::twisting).

mod any;

use serde::{Deserialize, Serialize};

pub use self::any::{AnyRolling, RollingKeys, RollingKind};

use crate::contact::centred::normal_load::NormalLoad;
use crate::contact::centred::slider::TangentialMotion;
use crate::contact::law::Bounce;
use crate::contact::pair::{Pair, VelocityPrediction};
use crate::contact::pair_force::Resistance;
use crate::contact::spring::{Slider, SliderForce, lost_at_contact_end};
use crate::contact::spring_memory::SpringMemory;
use crate::space::Space;
use crate::values::{NonNegative, Positive};

/// A spring and a dashpot against rolling: the kind `Spring`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RollingResistance {
    /// Stiffness k, N/m.
    pub k: Positive,
    /// Damping of the rolling velocity.
    pub damping: RollingDamping,
    /// Coefficient mu_r.
    pub friction: NonNegative,
}

/// How a scene gives the dashpot coefficient of rolling, N s/m.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
pub enum RollingDamping {
    /// c = b, N s/m.
    B(NonNegative),
    /// c = gamma m_eff for this gamma, 1/s.
    PerMass(NonNegative),
}

impl RollingDamping {
    /// Returns c, N s/m.
    #[inline(always)]
    pub(super) fn of(self, reduced_mass: f64) -> f64 {
        match self {
            Self::B(b) => b.get(),
            Self::PerMass(gamma) => gamma.get() * reduced_mass,
        }
    }
}

/// A term of rolling resistance.
pub trait Rolling: Copy + Send + Sync + 'static {
    /// Whether the term needs [`SpringMemory::rolling`].
    const ROLLING: bool;
    /// Whether the term needs [`SpringMemory::twist`].
    const TWISTING: bool = false;

    /// Adds the torque; `normal_force` in N.
    fn add<V: Space>(
        &self,
        pair: &Pair<V>,
        normal_force: f64,
        memory: &mut SpringMemory<V>,
        resistance: &mut Resistance<V>,
    );

    /// Adds the torque averaged over the step: [`super::centred`].
    fn add_centred<V: Space>(
        &self,
        pair: &Pair<V>,
        load: &NormalLoad,
        memory: &mut SpringMemory<V>,
        resistance: &mut Resistance<V>,
    );

    /// Returns the stored energy, J.
    fn energy<V: Space>(&self, pair: &Pair<V>, memory: &SpringMemory<V>) -> f64;

    /// Returns stiffness (N/m) and dashpot coefficient (N s/m) of rolling and of twisting. `tangential` is the stiffness of friction, N/m.
    fn modes(&self, bounce: &Bounce, tangential: f64) -> [[f64; 2]; 2];

    /// Returns the energy lost at the end of a contact, J; see
    /// [`PairLaw::on_contact_end`](crate::contact::PairLaw::on_contact_end).
    fn on_contact_end<V: Space>(&self, pair: &Pair<V>, memory: &SpringMemory<V>) -> f64;
}

/// Returns v_r = R_eff (w_i - w_j) x n, m/s.
#[inline(always)]
fn rolling_velocity<V: Space>(pair: &Pair<V>) -> V {
    pair.normal.turned_by((pair.spins[0] - pair.spins[1]) * pair.reduced_radius())
}

/// Returns the mobilities of rolling, 1/kg: R_eff^2/I summed over i and j, then only over lone grains.
#[inline(always)]
pub(super) fn mobilities<V: Space>(pair: &Pair<V>) -> [f64; 2] {
    let VelocityPrediction { inverse_inertias: [i, j], lone, .. } = pair.ahead;
    let squared = pair.reduced_radius().powi(2);
    [squared * (i + j), squared * (lone[0] * i + lone[1] * j)]
}

/// Returns the rolling motion of a contact near an event.
#[inline(always)]
fn rolling_motion<V: Space>(pair: &Pair<V>) -> TangentialMotion<V> {
    let middle = rolling_velocity(pair);
    TangentialMotion {
        middle,
        gained: rolling_velocity(&pair.predicted()) - middle,
        mobilities: mobilities(pair),
        pushed: pair.pushed(rolling_velocity),
    }
}

/// Sets the torques of a rolling force with arm R_eff.
#[inline(always)]
fn set_torques<V: Space>(pair: &Pair<V>, pull: &SliderForce<V>, resistance: &mut Resistance<V>) {
    let arm = pair.normal * pair.reduced_radius();
    resistance.rolling = arm.cross(pull.force);
    resistance.rolling_dashpot = arm.cross(pull.dashpot);
    resistance.lost_by_rolling = pull.lost;
}

/// No rolling resistance.
#[derive(Clone, Copy, Debug)]
pub struct NoRolling;

impl Rolling for NoRolling {
    const ROLLING: bool = false;

    #[inline(always)]
    fn add<V: Space>(&self, _: &Pair<V>, _: f64, _: &mut SpringMemory<V>, _: &mut Resistance<V>) {}

    #[inline(always)]
    fn add_centred<V: Space>(&self, _: &Pair<V>, _: &NormalLoad, _: &mut SpringMemory<V>, _: &mut Resistance<V>) {}

    fn energy<V: Space>(&self, _: &Pair<V>, _: &SpringMemory<V>) -> f64 {
        0.0
    }

    fn modes(&self, _: &Bounce, _: f64) -> [[f64; 2]; 2] {
        [[0.0; 2]; 2]
    }

    fn on_contact_end<V: Space>(&self, _: &Pair<V>, _: &SpringMemory<V>) -> f64 {
        0.0
    }
}

impl Rolling for RollingResistance {
    const ROLLING: bool = true;

    #[inline(always)]
    fn add<V: Space>(
        &self,
        pair: &Pair<V>,
        normal_force: f64,
        memory: &mut SpringMemory<V>,
        resistance: &mut Resistance<V>,
    ) {
        let velocities = [pair, &pair.gathering()].map(rolling_velocity);
        let dashpot = self.damping.of(pair.reduced_mass);
        let slider = Slider { stiffness: self.k.get(), dashpot, cap: self.friction.get() * normal_force.abs() };
        let pull = slider.pull(&mut memory.rolling, velocities, pair.normal, [pair.dt, pair.springs_ahead]);
        set_torques(pair, &pull, resistance);
    }

    #[inline(always)]
    fn add_centred<V: Space>(
        &self,
        pair: &Pair<V>,
        load: &NormalLoad,
        memory: &mut SpringMemory<V>,
        resistance: &mut Resistance<V>,
    ) {
        let dashpot = self.damping.of(pair.reduced_mass);
        let friction = self.friction.get();
        let slider = Slider { stiffness: self.k.get(), dashpot, cap: friction * load.whole.abs() };
        let motion = rolling_motion(pair);
        memory.rolling = motion.at_evaluation(memory.rolling, pair.springs_ahead);
        let mut sweep = load.sweep(motion, friction, [pair.dt, pair.springs_ahead]);
        sweep.pulled = memory.rolling * -slider.stiffness;
        sweep.mean_dashpots = load.mean_dashpots(|share, _| dashpot * share);
        let modulus = |_: &Pair<V>| (slider.stiffness, dashpot);
        sweep.release = load.unloading.map(|unloading| unloading.release(pair, friction, modulus));
        let pull = slider.pull_centred(&mut memory.rolling, &sweep, pair.normal);
        set_torques(pair, &pull, resistance);
    }

    fn energy<V: Space>(&self, pair: &Pair<V>, memory: &SpringMemory<V>) -> f64 {
        0.5 * self.k.get() * (memory.rolling - rolling_velocity(pair) * pair.springs_ahead).length_squared()
    }

    fn modes(&self, bounce: &Bounce, _: f64) -> [[f64; 2]; 2] {
        [[self.k.get(), self.damping.of(bounce.reduced_mass)], [0.0; 2]]
    }

    fn on_contact_end<V: Space>(&self, pair: &Pair<V>, memory: &SpringMemory<V>) -> f64 {
        let velocity = rolling_velocity(&pair.gathering());
        lost_at_contact_end(self.k.get(), memory.rolling - velocity * pair.springs_ahead, velocity, pair.dt)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::pair::tests::pair;
    use crate::space::Vector;

    #[test]
    fn torque_is_odd_and_displacement_even_under_exchange() {
        let law = RollingResistance {
            k: 1e3.try_into().unwrap(),
            damping: RollingDamping::B(2.0.try_into().unwrap()),
            friction: 0.1.try_into().unwrap(),
        };
        let of_i = Pair { normal: Vector::Y, spins: [3.0, -1.0], ..pair() };
        let of_j = Pair { normal: -of_i.normal, spins: [of_i.spins[1], of_i.spins[0]], ..of_i };
        let mut on = [of_i, of_j].map(|pair| {
            let mut memory = SpringMemory::default();
            let mut resistance = Resistance::default();
            law.add(&pair, 100.0, &mut memory, &mut resistance);
            (resistance.rolling, memory.rolling)
        });
        assert!(on[0].0 < 0.0);
        on[1].0 = -on[1].0;
        assert_eq!(on[0], on[1], "the torque changes sign, the displacement does not");
    }
}
