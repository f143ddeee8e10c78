//! Rolling resistance whose kind is a number, not a type, with twisting resistance: the loop over contacts is compiled once for all
//! kinds.
//!
//! | kind | rolling force F_r in v_r = R_eff (w_i - w_j) x n, capped at mu_r |F_n| | source |
//! |---|---|---|
//! | `Spring` | -k xi - c v_r ([`RollingResistance`]) | model C of Ai, Chen, Rotter and Ooi, Powder Technology 206, 269, 2011 |
//! | `Elastic` | the same with k = k_t, the tangential stiffness of the contact | Iwashita and Oda, J. Eng. Mech. 124, 285, 1998; `epsd2` of LIGGGHTS |
//! | `Torque` | -mu_r F_n v_r/abs(v_r), a constant torque against the rolling | model A of Ai et al. |
//!
//! Where k_t changes with the overlap, a stiffening spring keeps its force and a softening one its displacement, as in
//! [`SpringSlider`](crate::contact::tangential::SpringSlider).
//!
//! The torque of `Torque` jumps where the rolling changes its direction. Below the speed v* = mu_r F_n dt/(0.05 m_eff) it is
//! proportional to v_r, which stops a grain within some twenty steps and keeps beds stable: twelve contacts of one grain
//! together stop a rolling motion in no less than a step. So a grain on a slope that the torque could hold creeps with a
//! speed of the order of v*, which is proportional to the step, and such a contact is of first order once it has stopped.
//! `Spring` and `Elastic` hold.

use serde::{Deserialize, Serialize};

use crate::contact::centred::normal_load::NormalLoad;
use crate::contact::law::Bounce;
use crate::contact::pair::Pair;
use crate::contact::pair_force::Resistance;
use crate::contact::rolling::{
    Rolling, RollingDamping, RollingResistance, rolling_motion, rolling_velocity, set_torques,
};
use crate::contact::spring::{Slider, SliderForce, lost_at_contact_end};
use crate::contact::spring_memory::SpringMemory;
use crate::contact::tangential::mean_of;
use crate::contact::twisting::{Twisting, TwistingKeys};
use crate::space::Space;
use crate::values::{NonNegative, Positive};

/// c dt/m_eff of the dashpot that `Torque` is below v*.
const STOPPING: f64 = 0.05;

/// The kind of a rolling resistance.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
pub enum RollingKind {
    /// A spring of given stiffness and a dashpot.
    #[default]
    Spring,
    /// A spring with the tangential stiffness of the contact.
    Elastic,
    /// The constant torque mu_r R* F_n against the rolling.
    Torque,
}

/// The scene's `contact.rolling`.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct RollingKeys {
    /// The kind.
    #[serde(default)]
    pub kind: RollingKind,
    /// Stiffness k, N/m; only with `Spring`, which needs it.
    pub k: Option<Positive>,
    /// Damping of the rolling velocity; with `Spring`, which needs it, and `Elastic`.
    pub damping: Option<RollingDamping>,
    /// Coefficient mu_r, dimensionless: the torque is at most mu_r R* F_n.
    pub friction: NonNegative,
}

impl RollingKeys {
    /// Returns the spring and dashpot of kind `Spring`.
    #[must_use]
    pub fn spring(&self) -> Option<RollingResistance> {
        let Self { kind: RollingKind::Spring, k: Some(k), damping: Some(damping), friction } = *self else {
            return None;
        };
        Some(RollingResistance { k, damping, friction })
    }
}

/// Rolling resistance of any kind, or none.
#[derive(Clone, Copy, Debug)]
pub struct AnyRolling {
    /// The part of the stiffness that does not depend on the tangential stiffness, N/m.
    k: f64,
    /// The share of the tangential stiffness that is added to `k`.
    share: f64,
    damping: RollingDamping,
    /// mu_r.
    friction: f64,
    is_torque: bool,
    /// Whether the tangential stiffness goes to zero where a contact begins and ends.
    fades: bool,
    twisting: Twisting,
}

impl AnyRolling {
    /// Creates the term. `tangential` is the tangential stiffness of the law, N/m, or `None` if it depends on the overlap. In that case
    /// `fades` states whether the stiffness goes to zero where a contact begins and ends.
    #[must_use]
    pub fn new(
        keys: Option<RollingKeys>,
        twisting: Option<TwistingKeys>,
        tangential: Option<f64>,
        fades: bool,
    ) -> Self {
        let none = RollingKeys { kind: RollingKind::Spring, k: None, damping: None, friction: NonNegative::ZERO };
        let RollingKeys { kind, k, damping, friction } = keys.unwrap_or(none);
        // Without a cap a stiffness has no effect, but must not be zero.
        let k = k.map_or(1.0, Positive::get);
        let (k, share) = match kind {
            RollingKind::Spring | RollingKind::Torque => (k, 0.0),
            RollingKind::Elastic => (tangential.unwrap_or(0.0), if tangential.is_some() { 0.0 } else { 1.0 }),
        };
        Self {
            k,
            share,
            damping: damping.unwrap_or(RollingDamping::B(NonNegative::ZERO)),
            friction: friction.get(),
            is_torque: kind == RollingKind::Torque,
            fades,
            twisting: Twisting::new(twisting),
        }
    }

    /// Returns the stiffness at a tangential stiffness, both N/m.
    #[inline(always)]
    fn stiffness(&self, tangential: f64) -> f64 {
        self.k + self.share * tangential
    }

    /// Returns the force of a constant torque.
    #[inline(always)]
    fn torque<V: Space>(pair: &Pair<V>, velocity: V, cap: f64) -> SliderForce<V> {
        let slowest = cap * pair.dt / (STOPPING * pair.reduced_mass);
        // No force at rest, even if the evaluation does not advance time.
        let speed = velocity.length().max(slowest).max(1e-100);
        let force = velocity * (-cap / speed);
        SliderForce { force, dashpot: force, lost: 0.0, is_sliding: speed > slowest }
    }

    /// Adapts the spring to a stiffness that has changed from the first to the second, N/m; returns the energy that it loses, J.
    #[inline(always)]
    fn adapt<V: Space>(rolling: &mut V, [before, now]: [f64; 2]) -> f64 {
        let stored = before * rolling.length_squared();
        if now > before {
            *rolling = *rolling * (before / now);
        }
        0.5 * (stored - now * rolling.length_squared())
    }
}

impl Rolling for AnyRolling {
    const ROLLING: bool = true;
    const TWISTING: bool = true;

    #[inline(always)]
    fn add<V: Space>(
        &self,
        pair: &Pair<V>,
        normal_force: f64,
        memory: &mut SpringMemory<V>,
        resistance: &mut Resistance<V>,
    ) {
        let velocity = rolling_velocity(pair);
        let [before, k] = [resistance.stiffness_before, memory.stiffness].map(|k| self.stiffness(k));
        let cap = self.friction * normal_force.abs();
        let mut rolling = memory.rolling;
        let mut dt = pair.dt;
        let ahead = velocity * pair.springs_ahead;
        if pair.is_predicted() {
            dt *= mean_of(self.fades, before, k);
        }
        rolling -= ahead;
        let lost = Self::adapt(&mut rolling, [before, k]);
        rolling += ahead;
        let dashpot = self.damping.of(pair.reduced_mass);
        let slider = Slider { stiffness: k, dashpot, cap };
        let mut pull = slider.pull(
            &mut rolling,
            [velocity, rolling_velocity(&pair.gathering())],
            pair.normal,
            [dt, pair.springs_ahead],
        );
        pull.lost += lost;
        let torque = Self::torque(pair, velocity, cap);
        (memory.rolling, pull) = if self.is_torque { (V::ZERO, torque) } else { (rolling, pull) };
        set_torques(pair, &pull, resistance);
        self.twisting.add(pair, normal_force, memory, resistance);
    }

    #[inline(always)]
    fn add_centred<V: Space>(
        &self,
        pair: &Pair<V>,
        load: &NormalLoad,
        memory: &mut SpringMemory<V>,
        resistance: &mut Resistance<V>,
    ) {
        let [before, mut k] = [resistance.stiffness_before, memory.stiffness].map(|k| self.stiffness(k));
        let mut dashpot = self.damping.of(pair.reduced_mass);
        if self.is_torque {
            (k, dashpot) = (0.0, STOPPING * pair.reduced_mass / pair.dt);
        }
        let motion = rolling_motion(pair);
        memory.rolling = motion.at_evaluation(memory.rolling, pair.springs_ahead);
        let mut sweep = load.sweep(motion, self.friction, [pair.dt, pair.springs_ahead]);
        sweep.pulled = memory.rolling * -before;
        sweep.mean_dashpots = load.mean_dashpots(|share, _| dashpot * share);
        // Over a release the stiffness is that of the evaluation: there is none of a later overlap.
        sweep.release = load.unloading.map(|unloading| unloading.release(pair, self.friction, |_| (k, dashpot)));
        let mut lost = 0.0;
        if self.share > 0.0 {
            sweep.gathering *= mean_of(self.fades, before, k);
            if self.fades {
                // As for friction: the stiffness is zero where a contact opens.
                sweep.event = sweep.event.filter(|_| before > 0.0);
                sweep.spring_shares = [1.0; 2];
            }
            lost = Self::adapt(&mut memory.rolling, [before, k]);
        }
        let slider = Slider { stiffness: k, dashpot, cap: self.friction * load.whole.abs() };
        let mut pull = slider.pull_centred(&mut memory.rolling, &sweep, pair.normal);
        pull.lost += lost;
        if self.is_torque {
            memory.rolling = V::ZERO;
        }
        set_torques(pair, &pull, resistance);
        self.twisting.add_centred(pair, load, memory, resistance);
    }

    fn energy<V: Space>(&self, pair: &Pair<V>, memory: &SpringMemory<V>) -> f64 {
        let spring = memory.rolling - rolling_velocity(pair) * pair.springs_ahead;
        let k = if self.is_torque { 0.0 } else { self.stiffness(memory.stiffness) };
        0.5 * k * spring.length_squared() + self.twisting.energy(pair, memory)
    }

    fn modes(&self, bounce: &Bounce, tangential: f64) -> [[f64; 2]; 2] {
        // The dashpot coefficient of a constant torque depends on the step.
        let resists = !self.is_torque && self.friction > 0.0;
        let rolling = [self.stiffness(tangential), self.damping.of(bounce.reduced_mass)];
        [if resists { rolling } else { [0.0; 2] }, self.twisting.mode(bounce.reduced_mass)]
    }

    fn on_contact_end<V: Space>(&self, pair: &Pair<V>, memory: &SpringMemory<V>) -> f64 {
        let velocity = rolling_velocity(&pair.gathering());
        let spring = memory.rolling - velocity * pair.springs_ahead;
        let k = if self.is_torque { 0.0 } else { self.stiffness(memory.stiffness) };
        lost_at_contact_end(k, spring, velocity, pair.dt) + self.twisting.on_contact_end(pair, memory)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::pair::tests::pair;
    use crate::space::Vector;

    fn turn(keys: RollingKeys, spin: f64, dt: f64) -> Resistance {
        let law = AnyRolling::new(Some(keys), None, Some(1e4), true);
        let mut memory = SpringMemory::default();
        let mut resistance = Resistance::default();
        law.add(&Pair { normal: Vector::Y, spins: [spin, 0.0], dt, ..pair() }, 100.0, &mut memory, &mut resistance);
        resistance
    }

    #[test]
    fn a_constant_torque_has_its_cap_and_is_zero_at_rest() {
        let torque =
            RollingKeys { kind: RollingKind::Torque, k: None, damping: None, friction: 0.1.try_into().unwrap() };
        // R* = 2 cm: 0.1 100 N 0.02 m.
        for (spin, expected) in [(50.0, -0.2), (-50.0, 0.2), (0.0, 0.0)] {
            for dt in [0.0, 1e-6] {
                assert!((turn(torque, spin, dt).rolling - expected).abs() < 1e-12, "{spin} {dt}");
            }
        }
        // Half of v* = 10 N dt/(0.05 0.1 kg) = 2 mm/s at dt = 1e-6.
        let slow = turn(torque, 0.5 * 2e-3 / 0.02, 1e-6);
        assert!((slow.rolling + 0.1).abs() < 1e-12, "{}", slow.rolling);
    }

    #[test]
    fn a_spring_agrees_with_its_own_term() {
        let spring = RollingResistance {
            k: 2e3.try_into().unwrap(),
            damping: RollingDamping::B(3.0.try_into().unwrap()),
            friction: 0.1.try_into().unwrap(),
        };
        let keys = RollingKeys {
            kind: RollingKind::Spring,
            k: Some(spring.k),
            damping: Some(spring.damping),
            friction: spring.friction,
        };
        let mut memory = SpringMemory::default();
        let mut resistance = Resistance::default();
        spring.add(
            &Pair { normal: Vector::Y, spins: [0.3, 0.0], dt: 1e-4, ..pair() },
            100.0,
            &mut memory,
            &mut resistance,
        );
        let any = turn(keys, 0.3, 1e-4);
        assert!((any.rolling / resistance.rolling - 1.0).abs() < 1e-15);
    }
}
