//! Friction without memory: a dashpot in the tangent plane, F_t = -c_t v_t, capped at mu |F_n|.

use crate::contact::damping::Coefficient;
use crate::contact::spring::Slider;
use crate::contact::tangential::{Lever, NormalLoad, Tangential};
use crate::contact::{Bounce, Memory, Pair, Turning};
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
        normal_drag: f64,
        _: &mut Memory<V>,
        turning: &mut Turning<V>,
    ) {
        turning.arms = self.lever.arms(pair);
        let velocity = pair.sliding_velocity(turning.arms);
        let drag = self.damping.of(pair.reduced_mass, normal_drag);
        let cap = self.friction * normal_force.abs();
        let squared = velocity.length_squared() * drag * drag;
        turning.is_sliding = squared > cap * cap;
        let cut = if turning.is_sliding { cap / squared.sqrt() } else { 1.0 };
        turning.friction = velocity * (-drag * cut);
        turning.friction_drag = turning.friction;
    }

    #[inline(always)]
    fn add_centred<V: Space>(&self, pair: &Pair<V>, load: &NormalLoad, _: &mut Memory<V>, turning: &mut Turning<V>) {
        turning.arms = self.lever.arms(pair);
        let (motion, mobilities) = pair.sliding(turning.arms);
        let drag = self.damping.of(pair.reduced_mass, load.drag);
        let slider = Slider { stiffness: 0.0, drag, cap: self.friction * load.whole.abs() };
        let mut sweep = load.sweep(motion, mobilities, self.friction, [pair.dt, pair.lead]);
        sweep.mean_drags = load.mean_drags(|share, normal| self.damping.mean(pair.reduced_mass, share, normal));
        let modulus = |_: &Pair<V>| (0.0, drag);
        sweep.release = load.unloading.map(|unloading| unloading.release(pair, self.friction, modulus));
        let pull = slider.pull_centred(&mut V::default(), &sweep, pair.normal);
        turning.is_sliding = pull.is_sliding;
        (turning.friction, turning.friction_drag) = (pull.force, pull.force);
    }

    fn mode(&self, bounce: &Bounce, normal_drag: f64) -> [f64; 2] {
        [0.0, self.damping.of(bounce.reduced_mass, normal_drag)]
    }

    fn friction(&self) -> f64 {
        self.friction
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::tangential::TangentialDamping;
    use crate::contact::tests::pair;
    use crate::space::Vector;
    use crate::values::NonNegative;

    #[test]
    fn a_dashpot_is_cut_at_the_cap() {
        let drag = NonNegative::try_from(2.0).unwrap();
        let law = Dashpot { damping: TangentialDamping::B(drag).into(), friction: 0.5, lever: Lever::Radius };
        let slow = Pair { relative_velocity: Vector::new(0.0, 1.0), ..pair() };
        let fast = Pair { relative_velocity: Vector::new(0.0, 10.0), ..pair() };
        let mut turning = Turning::default();
        law.add(&slow, 10.0, 0.0, &mut Memory::default(), &mut turning);
        assert_eq!((turning.friction, turning.is_sliding), (Vector::new(0.0, -2.0), false));
        law.add(&fast, -10.0, 0.0, &mut Memory::default(), &mut turning);
        assert_eq!((turning.friction, turning.is_sliding), (Vector::new(0.0, -5.0), true));
    }
}
