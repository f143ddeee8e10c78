//! Twisting resistance: an elastic-plastic spring-dashpot against the relative spin of two grains about their normal, in
//! solid space.
//!
//! The twisting velocity v_w = R_eff (w_i - w_j).n accumulates in a displacement (m), R_eff = R_i R_j/(R_i + R_j). The
//! twisting force is F_w = -k x - c v_w, capped at mu_w F_n as in [`Slider`]. The torque on i is R_eff F_w n, and the
//! opposite torque acts on j. k in N/m, c in N s/m; the torque's cap is mu_w R_eff F_n. Its units are those of
//! [`rolling`](super::rolling).
//!
//! Source: the twisting model of Luding, Granular Matter 10, 235, 2008, which treats twisting like rolling; LAMMPS's
//! `twisting sds` has the same form with k R_eff^2 as its stiffness. Marshall (J. Comput. Phys. 228, 1541, 2009) derives
//! mu_w R_eff = 2/3 mu a and k R_eff^2 = k_t a^2/2 for a contact of the radius a.

use serde::{Deserialize, Serialize};

use crate::contact::centred::normal_load::NormalLoad;
use crate::contact::centred::slider::TangentialMotion;
use crate::contact::pair::Pair;
use crate::contact::pair_force::Resistance;
use crate::contact::rolling::{RollingDamping, mobilities};
use crate::contact::spring::{Slider, SliderForce, lost_at_contact_end};
use crate::contact::spring_memory::SpringMemory;
use crate::space::{Linear, Plane, Space};
use crate::values::{NonNegative, Positive};

/// The scene's `contact.twisting`.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct TwistingKeys {
    /// Stiffness k, N/m.
    pub k: Positive,
    /// Damping of the twisting velocity.
    pub damping: RollingDamping,
    /// Coefficient mu_w, dimensionless: the torque is at most mu_w R* F_n.
    pub friction: NonNegative,
}

/// Twisting resistance, or none.
#[derive(Clone, Copy, Debug)]
pub struct Twisting {
    k: f64,
    damping: RollingDamping,
    friction: f64,
}

impl Twisting {
    /// Creates the term.
    #[must_use]
    pub fn new(keys: Option<TwistingKeys>) -> Self {
        match keys {
            Some(TwistingKeys { k, damping, friction }) => Self { k: k.get(), damping, friction: friction.get() },
            // Without a cap a stiffness has no effect, but must not be zero.
            None => Self { k: 1.0, damping: RollingDamping::B(NonNegative::ZERO), friction: 0.0 },
        }
    }

    /// Adds the torque to that of rolling resistance; `normal_force` in N.
    #[inline(always)]
    pub(super) fn add<V: Space>(
        &self,
        pair: &Pair<V>,
        normal_force: f64,
        memory: &mut SpringMemory<V>,
        resistance: &mut Resistance<V>,
    ) {
        if V::COMPONENTS == 2 {
            return;
        }
        let mut spring = along(memory.twist);
        let dashpot = self.damping.of(pair.reduced_mass);
        let slider = Slider { stiffness: self.k, dashpot, cap: self.friction * normal_force.abs() };
        let velocities = [pair, &pair.gathering()].map(|pair| along(velocity(pair)));
        let pull = slider.pull(&mut spring, velocities, Plane::Y, [pair.dt, pair.springs_ahead]);
        memory.twist = spring.x;
        add_torques(pair, &pull, resistance);
    }

    /// Adds the torque averaged over the step: [`super::centred`].
    #[inline(always)]
    pub(super) fn add_centred<V: Space>(
        &self,
        pair: &Pair<V>,
        load: &NormalLoad,
        memory: &mut SpringMemory<V>,
        resistance: &mut Resistance<V>,
    ) {
        if V::COMPONENTS == 2 {
            return;
        }
        let dashpot = self.damping.of(pair.reduced_mass);
        let slider = Slider { stiffness: self.k, dashpot, cap: self.friction * load.whole.abs() };
        let middle = velocity(pair);
        let motion = TangentialMotion {
            middle: along(middle),
            gained: along(velocity(&pair.predicted()) - middle),
            mobilities: mobilities(pair),
            pushed: pair.pushed(|pair| along(velocity(pair))),
        };
        let mut spring = motion.at_evaluation(along(memory.twist), pair.springs_ahead);
        let mut sweep = load.sweep(motion, self.friction, [pair.dt, pair.springs_ahead]);
        sweep.pulled = spring * -self.k;
        sweep.mean_dashpots = load.mean_dashpots(|share, _| dashpot * share);
        sweep.release = load.unloading.map(|unloading| unloading.release(pair, self.friction, |_| (self.k, dashpot)));
        let pull = slider.pull_centred(&mut spring, &sweep, Plane::Y);
        memory.twist = spring.x;
        add_torques(pair, &pull, resistance);
    }

    /// Returns the stored energy, J.
    pub(super) fn energy<V: Space>(&self, pair: &Pair<V>, memory: &SpringMemory<V>) -> f64 {
        0.5 * self.k * (memory.twist - velocity(pair) * pair.springs_ahead).powi(2)
    }

    /// Returns stiffness (N/m) and dashpot coefficient (N s/m).
    pub(super) fn mode(&self, reduced_mass: f64) -> [f64; 2] {
        if self.friction > 0.0 { [self.k, self.damping.of(reduced_mass)] } else { [0.0; 2] }
    }

    /// Returns the energy lost at the end of a contact, J.
    pub(super) fn on_contact_end<V: Space>(&self, pair: &Pair<V>, memory: &SpringMemory<V>) -> f64 {
        let velocity = along(velocity(&pair.gathering()));
        lost_at_contact_end(self.k, along(memory.twist) - velocity * pair.springs_ahead, velocity, pair.dt)
    }
}

/// Returns v_w, m/s.
#[inline(always)]
fn velocity<V: Space>(pair: &Pair<V>) -> f64 {
    (pair.spins[0] - pair.spins[1]).spread().dot(pair.normal.spread()) * pair.reduced_radius()
}

/// Returns a number as a vector for [`Slider`], in a tangent plane with the normal y.
#[inline(always)]
fn along(number: f64) -> Plane {
    Plane::new(number, 0.0)
}

/// Adds the torques of a twisting force with arm R_eff.
#[inline(always)]
fn add_torques<V: Space>(pair: &Pair<V>, pull: &SliderForce<Plane>, resistance: &mut Resistance<V>) {
    let arm = pair.normal.spread() * pair.reduced_radius();
    resistance.rolling += V::narrow_spin(arm * pull.force.x);
    resistance.rolling_dashpot += V::narrow_spin(arm * pull.dashpot.x);
    resistance.lost_by_rolling += pull.lost;
}
