//! The contact law of the assignment: a spring along the normal, and a drag on the full relative velocity.
//!
//! F on i = k delta n - b (v_i - v_j) while the discs overlap; k in N/m, b in N s/m. The drag also acts along the
//! tangent, so grains that slide past each other slow down, without friction and without spin. A contact lasts as long
//! as its overlap; near its end the drag may pull.
//!
//! Source: Remmers, "The grain silo", 2009. The force "that i exerts on j" in that text is the force on i.

use crate::contact::centred::window::Window;
use crate::contact::damping::Attraction;
use crate::contact::law::{Bounce, LawRequirements, PairLaw};
use crate::contact::memory::Memory;
use crate::contact::pair::{Pair, VelocityPrediction};
use crate::contact::pair_force::PairForce;
use crate::space::Space;
use crate::values::{NonNegative, Positive};

/// The law F = k delta n - b (v_i - v_j).
#[derive(Clone, Copy, Debug)]
pub struct Assignment {
    k: f64,
    b: f64,
}

impl Assignment {
    /// Creates the law with stiffness `k` (N/m) and drag `b` (N s/m).
    #[must_use]
    pub fn new(k: Positive, b: NonNegative) -> Self {
        Self { k: k.get(), b: b.get() }
    }
}

impl LawRequirements for Assignment {
    const RADII: bool = false;
}

impl<V: Space> PairLaw<V> for Assignment {
    #[inline(always)]
    fn force(&self, pair: &Pair<V>, _: &mut Memory) -> PairForce<V> {
        PairForce::new(pair.normal * (self.k * pair.overlap), pair.relative_velocity * -self.b)
    }

    /// Like the normal force of [`Composite`](crate::contact::composite::Composite), but with vectors: this drag acts
    /// on the whole relative velocity.
    #[inline(always)]
    fn centred(&self, pair: &Pair<V>, _: &mut Memory) -> PairForce<V> {
        let window = Window::of(pair);
        let before = pair.overlap - window.moved;
        let [drag, drag_before] = if pair.overlap >= 3.0 * window.half_width {
            [self.b; 2]
        } else {
            [pair.overlap, before].map(|overlap| self.b * window.share(overlap))
        };
        // h times the mobility (1/kg) of the pair, and of its lone grains.
        let VelocityPrediction { velocity: gained, inverse_masses, .. } = pair.ahead;
        let [half, half_lone] =
            [inverse_masses[0] + inverse_masses[1], pair.ahead.lone_mobility()].map(|m| 0.5 * pair.dt * m);
        let spring = self.k * pair.overlap.max(0.0);
        // To first order, the normal of the previous step was this normal.
        let change = pair.normal * (half_lone * (spring - self.k * before.max(0.0)));
        let drag_then = (pair.relative_velocity - gained) * (half * drag_before);
        let velocity = pair.relative_velocity + gained + change + drag_then;
        PairForce::new(pair.normal * spring, velocity * (-drag / (1.0 + half * drag)))
    }

    fn elastic_energy(&self, pair: &Pair<V>, _: &Memory) -> f64 {
        0.5 * self.k * pair.overlap * pair.overlap
    }

    fn stiffness(&self, _: &Bounce) -> f64 {
        self.k
    }

    fn damping(&self, _: &Bounce) -> f64 {
        self.b
    }

    fn modes(&self, _: &Bounce) -> [[f64; 2]; 4] {
        // The drag acts along the tangent too, where there is no spring.
        [[self.k, self.b], [0.0, self.b], [0.0; 2], [0.0; 2]]
    }

    fn contact_duration(&self, bounce: &Bounce) -> f64 {
        let law: &dyn PairLaw<V> = self;
        Attraction::Allowed.duration(law.damping_ratio(bounce)) / law.frequency(bounce)
    }

    fn restitution(&self, bounce: &Bounce) -> f64 {
        let law: &dyn PairLaw<V> = self;
        Attraction::Allowed.restitution(law.damping_ratio(bounce))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::pair::tests::pair;
    use crate::space::Vector;

    fn law() -> Assignment {
        Assignment::new(Positive::try_from(1e4).unwrap(), NonNegative::try_from(5.0).unwrap())
    }

    #[test]
    fn pushes_apart_and_drags_along_the_whole_relative_velocity() {
        let pair = Pair { overlap: 1e-3, relative_velocity: Vector::new(-2.0, 3.0), ..pair() };
        let force = law().force(&pair, &mut Memory::default());
        assert_eq!(force.elastic(), Vector::new(10.0, 0.0));
        assert_eq!(force.dashpot, Vector::new(10.0, -15.0));
    }

    #[test]
    fn the_silo_s_grains_bounce_with_restitution_0_76() {
        // k = 1e4 N/m, b = 5 N s/m, m = 0.16 kg: exp(-pi zeta/sqrt(1 - zeta^2)) with zeta = 5/(2 sqrt(1e4 0.08)).
        let law: &dyn PairLaw = &law();
        let e = law.restitution(&Bounce { reduced_mass: 0.08, reduced_radius: 0.02, speed: 1.0 });
        assert!((e - 0.756_71).abs() < 5e-6, "{e}");
    }
}
