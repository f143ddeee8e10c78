//! Friction with memory: a spring and a dashpot in the tangent plane, F_t = -k_t S - c_t v_t, capped together at mu
//! |F_n|.
//!
//! A [`Modulus`] gives stiffness and dashpot coefficient, constant or dependent on the contact.

use crate::contact::centred::normal_load::NormalLoad;
use crate::contact::damping::Coefficient;
use crate::contact::law::Bounce;
use crate::contact::pair::Pair;
use crate::contact::pair_force::Resistance;
use crate::contact::spring::{Slider, lost_at_contact_end};
use crate::contact::spring_memory::SpringMemory;
use crate::contact::tangential::{Lever, Tangential};
use crate::space::Space;

/// The tangential stiffness and dashpot coefficient of a contact.
pub trait Modulus: Copy + Send + Sync + 'static {
    /// Whether the stiffness changes while a contact lasts.
    const VARIES: bool;
    /// Whether a stiffness that changes goes to zero where a contact begins and ends.
    const FADES: bool = true;

    /// Returns k_t (N/m) and c_t (N s/m); `normal_dashpot` is the normal c, N s/m.
    fn of<V: Space>(&self, pair: &Pair<V>, normal_dashpot: f64) -> (f64, f64);

    /// Returns the mean of c_t over a step that has a contact in the fraction `share`, N s/m. `normal_dashpot` is the mean of the
    /// normal c.
    fn mean_dashpot<V: Space>(&self, pair: &Pair<V>, share: f64, normal_dashpot: f64) -> f64;

    /// Returns the k_t of the last evaluation of a spring, N/m. `memory` is [`SpringMemory::stiffness`], set if the stiffness
    /// varies.
    fn remembered(&self, memory: f64) -> f64;

    /// Returns k_t (N/m) and c_t (N s/m) at the deepest point of a bounce.
    fn at(&self, bounce: &Bounce, normal_dashpot: f64) -> [f64; 2];
}

/// A constant k_t in every contact.
#[derive(Clone, Copy, Debug)]
pub struct ConstantStiffness {
    /// k_t, N/m.
    pub k: f64,
    /// c_t, from the effective mass and the normal c.
    pub damping: Coefficient,
}

impl Modulus for ConstantStiffness {
    const VARIES: bool = false;

    #[inline(always)]
    fn of<V: Space>(&self, pair: &Pair<V>, normal_dashpot: f64) -> (f64, f64) {
        (self.k, self.damping.of(pair.reduced_mass, normal_dashpot))
    }

    #[inline(always)]
    fn mean_dashpot<V: Space>(&self, pair: &Pair<V>, share: f64, normal_dashpot: f64) -> f64 {
        self.damping.mean(pair.reduced_mass, share, normal_dashpot)
    }

    fn remembered(&self, _: f64) -> f64 {
        self.k
    }

    fn at(&self, bounce: &Bounce, normal_dashpot: f64) -> [f64; 2] {
        [self.k, self.damping.of(bounce.reduced_mass, normal_dashpot)]
    }
}

/// A spring with memory and a dashpot, capped together at mu |F_n|.
///
/// If the stiffness varies, a stiffening spring keeps its force and a softening spring its displacement, so that
/// neither gains energy (Thornton, Cummins and Cleary, Powder Technology 233, 30, 2013). The energy lost in this way
/// counts as lost to sliding.
#[derive(Clone, Copy, Debug)]
pub struct SpringSlider<M> {
    /// k_t and c_t.
    pub modulus: M,
    /// Coefficient mu.
    pub friction: f64,
    /// Point at which friction acts.
    pub lever: Lever,
}

/// Returns the mean stiffness of a step divided by the stiffness at its end. Displacement accumulated while a
/// spring stiffens keeps its force. The stiffness grows with the square root of the overlap, so that its mean between a
/// and b is 2/3 (a^2 + a b + b^2)/(a + b). The trapezoidal rule instead would be of order 3/2 where a contact begins.
#[inline(always)]
pub(in crate::contact) fn mean_stiffness(before: f64, now: f64) -> f64 {
    let ratio = before / now;
    if before >= now { 1.0 } else { 2.0 / 3.0 * (1.0 + ratio + ratio * ratio) / (1.0 + ratio) }
}

/// Like [`mean_stiffness`]. A stiffness that does not go to zero where a contact begins is constant in its first step.
#[inline(always)]
pub(in crate::contact) fn mean_of(fades: bool, before: f64, now: f64) -> f64 {
    if !fades && before <= 0.0 { 1.0 } else { mean_stiffness(before, now) }
}

impl<M: Modulus> SpringSlider<M> {
    /// Adapts the spring to a changed stiffness; returns the energy that it loses, J.
    #[inline(always)]
    fn adapt<V: Space>(k: f64, memory: &mut SpringMemory<V>) -> f64 {
        let before = memory.stiffness * memory.spring.length_squared();
        if k > memory.stiffness {
            memory.spring = memory.spring * (memory.stiffness / k);
        }
        memory.stiffness = k;
        0.5 * (before - k * memory.spring.length_squared())
    }
}

impl<M: Modulus> Tangential for SpringSlider<M> {
    const SPRING: bool = true;
    const STIFFNESS: bool = M::VARIES;

    #[inline(always)]
    fn add<V: Space>(
        &self,
        pair: &Pair<V>,
        normal_force: f64,
        normal_dashpot: f64,
        memory: &mut SpringMemory<V>,
        resistance: &mut Resistance<V>,
    ) {
        let (stiffness, dashpot) = self.modulus.of(pair, normal_dashpot);
        resistance.arms = self.lever.arms(pair);
        let velocity = pair.sliding_velocity(resistance.arms);
        let gathered = pair.gathering().sliding_velocity(resistance.arms);
        let mut dt = pair.dt;
        if M::VARIES {
            if pair.is_predicted() {
                dt *= mean_of(M::FADES, memory.stiffness, stiffness);
            }
            resistance.stiffness_before = memory.stiffness;
            let ahead = velocity * pair.springs_ahead;
            memory.spring -= ahead;
            resistance.lost_by_sliding = Self::adapt(stiffness, memory);
            memory.spring += ahead;
        }
        let slider = Slider { stiffness, dashpot, cap: self.friction * normal_force.abs() };
        let pull = slider.pull(&mut memory.spring, [velocity, gathered], pair.normal, [dt, pair.springs_ahead]);
        resistance.friction = pull.force;
        resistance.friction_dashpot = pull.dashpot;
        resistance.lost_by_sliding += pull.lost;
        resistance.is_sliding = pull.is_sliding;
    }

    #[inline(always)]
    fn add_centred<V: Space>(
        &self,
        pair: &Pair<V>,
        load: &NormalLoad,
        memory: &mut SpringMemory<V>,
        resistance: &mut Resistance<V>,
    ) {
        // The arms meet across a gap too, so that arms to the contact point conserve angular momentum there as well.
        // A stiffness that does not fade exists beyond touch.
        let at = if M::FADES { pair.at_overlap(pair.overlap) } else { *pair };
        let (stiffness, dashpot) = self.modulus.of(&at, load.dashpot);
        resistance.arms = self.lever.arms(pair);
        let motion = pair.sliding(resistance.arms);
        memory.spring = motion.at_evaluation(memory.spring, pair.springs_ahead);
        let mut sweep = load.sweep(motion, self.friction, [pair.dt, pair.springs_ahead]);
        sweep.pulled = memory.spring * -self.modulus.remembered(memory.stiffness);
        sweep.mean_dashpots = load.mean_dashpots(|share, normal| self.modulus.mean_dashpot(pair, share, normal));
        let modulus = |pair: &Pair<V>| self.modulus.of(pair, load.dashpot);
        sweep.release = load.unloading.map(|unloading| unloading.release(pair, self.friction, modulus));
        if M::VARIES {
            resistance.stiffness_before = memory.stiffness;
            sweep.gathering *= mean_of(M::FADES, memory.stiffness, stiffness);
            if M::FADES {
                // The stiffness is zero when a contact opens, and so is the dashpot coefficient: that event has no effect.
                sweep.event = sweep.event.filter(|_| memory.stiffness > 0.0);
                // So the force of the spring needs no share.
                sweep.spring_shares = [1.0; 2];
            }
            resistance.lost_by_sliding = Self::adapt(stiffness, memory);
        }
        let slider = Slider { stiffness, dashpot, cap: self.friction * load.whole.abs() };
        let pull = slider.pull_centred(&mut memory.spring, &sweep, pair.normal);
        resistance.friction = pull.force;
        resistance.friction_dashpot = pull.dashpot;
        resistance.lost_by_sliding += pull.lost;
        resistance.is_sliding = pull.is_sliding;
    }

    fn energy<V: Space>(&self, pair: &Pair<V>, memory: &SpringMemory<V>) -> f64 {
        let spring = memory.spring - pair.sliding_velocity(self.lever.arms(pair)) * pair.springs_ahead;
        0.5 * self.modulus.remembered(memory.stiffness) * spring.length_squared()
    }

    fn on_contact_end<V: Space>(&self, pair: &Pair<V>, memory: &SpringMemory<V>) -> f64 {
        let velocity = pair.gathering().sliding_velocity(self.lever.arms(pair));
        let spring = memory.spring - velocity * pair.springs_ahead;
        lost_at_contact_end(self.modulus.remembered(memory.stiffness), spring, velocity, pair.dt)
    }

    fn mode(&self, bounce: &Bounce, normal_dashpot: f64) -> [f64; 2] {
        self.modulus.at(bounce, normal_dashpot)
    }

    fn friction(&self) -> f64 {
        self.friction
    }
}

#[cfg(test)]
#[expect(clippy::float_cmp, reason = "exact values")]
mod tests {
    use super::*;
    use crate::space::Vector;

    #[test]
    fn a_spring_of_changing_stiffness_gains_no_energy() {
        let mut memory = SpringMemory { spring: Vector::new(0.0, 1e-5), stiffness: 1e4, ..SpringMemory::default() };
        let stiffer = SpringSlider::<ConstantStiffness>::adapt(2e4, &mut memory);
        assert_eq!((memory.spring.y, memory.stiffness), (5e-6, 2e4));
        let softer = SpringSlider::<ConstantStiffness>::adapt(1e4, &mut memory);
        assert_eq!(memory.spring.y, 5e-6);
        assert!(stiffer > 0.0 && softer > 0.0);
        assert!((stiffer + softer - 0.5e4 * (1e-10 - 0.25e-10)).abs() < 1e-21);
    }
}
