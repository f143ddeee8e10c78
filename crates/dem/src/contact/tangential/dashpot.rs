//! Friction without memory: a dashpot in the tangent plane, F_t = -c_t v_t, capped at mu |F_n|.

use crate::contact::centred::normal_load::NormalLoad;
use crate::contact::damping::Coefficient;
use crate::contact::law::Bounce;
use crate::contact::pair::Pair;
use crate::contact::pair_force::Resistance;
use crate::contact::spring::Slider;
use crate::contact::spring_memory::SpringMemory;
use crate::contact::tangential::{Lever, Tangential};
use crate::space::Space;

/// A dashpot capped at mu |F_n|.
#[derive(Clone, Copy, Debug)]
pub struct Dashpot {
    /// c_t, from the effective mass and the normal c.
    pub damping: Coefficient,
    /// Coefficient mu.
    pub friction: f64,
    /// Point at which friction acts.
    pub lever: Lever,
}

impl Tangential for Dashpot {
    #[inline(always)]
    fn add<V: Space>(
        &self,
        pair: &Pair<V>,
        normal_force: f64,
        normal_dashpot: f64,
        _: &mut SpringMemory<V>,
        resistance: &mut Resistance<V>,
    ) {
        resistance.arms = self.lever.arms(pair);
        let velocity = pair.sliding_velocity(resistance.arms);
        let dashpot = self.damping.of(pair.reduced_mass, normal_dashpot);
        let cap = self.friction * normal_force.abs();
        let squared = velocity.length_squared() * dashpot * dashpot;
        resistance.is_sliding = squared > cap * cap;
        let cut = if resistance.is_sliding { cap / squared.sqrt() } else { 1.0 };
        resistance.friction = velocity * (-dashpot * cut);
        resistance.friction_dashpot = resistance.friction;
    }

    #[inline(always)]
    fn add_centred<V: Space>(
        &self,
        pair: &Pair<V>,
        load: &NormalLoad,
        _: &mut SpringMemory<V>,
        resistance: &mut Resistance<V>,
    ) {
        resistance.arms = self.lever.arms(pair);
        let motion = pair.sliding(resistance.arms);
        let dashpot = self.damping.of(pair.reduced_mass, load.dashpot);
        let slider = Slider { stiffness: 0.0, dashpot, cap: self.friction * load.whole.abs() };
        let mut sweep = load.sweep(motion, self.friction, [pair.dt, pair.springs_ahead]);
        sweep.mean_dashpots = load.mean_dashpots(|share, normal| self.damping.mean(pair.reduced_mass, share, normal));
        let modulus = |_: &Pair<V>| (0.0, dashpot);
        sweep.release = load.unloading.map(|unloading| unloading.release(pair, self.friction, modulus));
        let pull = slider.pull_centred(&mut V::default(), &sweep, pair.normal);
        resistance.is_sliding = pull.is_sliding;
        (resistance.friction, resistance.friction_dashpot) = (pull.force, pull.force);
    }

    fn mode(&self, bounce: &Bounce, normal_dashpot: f64) -> [f64; 2] {
        [0.0, self.damping.of(bounce.reduced_mass, normal_dashpot)]
    }

    fn friction(&self) -> f64 {
        self.friction
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::pair::tests::pair;
    use crate::contact::tangential::TangentialDamping;
    use crate::space::Vector;
    use crate::values::NonNegative;

    #[test]
    fn a_dashpot_is_cut_at_the_cap() {
        let dashpot = NonNegative::try_from(2.0).unwrap();
        let law = Dashpot { damping: TangentialDamping::B(dashpot).into(), friction: 0.5, lever: Lever::Radius };
        let slow = Pair { relative_velocity: Vector::new(0.0, 1.0), ..pair() };
        let fast = Pair { relative_velocity: Vector::new(0.0, 10.0), ..pair() };
        let mut resistance = Resistance::default();
        law.add(&slow, 10.0, 0.0, &mut SpringMemory::default(), &mut resistance);
        assert_eq!((resistance.friction, resistance.is_sliding), (Vector::new(0.0, -2.0), false));
        law.add(&fast, -10.0, 0.0, &mut SpringMemory::default(), &mut resistance);
        assert_eq!((resistance.friction, resistance.is_sliding), (Vector::new(0.0, -5.0), true));
    }
}
