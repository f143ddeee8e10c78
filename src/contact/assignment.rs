//! The assignment's contact law: a spring along the normal and a drag on the full relative velocity.
//!
//! F on i = k delta n - b (v_i - v_j), while the discs overlap; k in N/m, b in N s/m. The drag acts along the
//! tangent too, so grains that slide past each other slow down, without friction and without spin. A contact
//! lasts as long as its overlap; near its end the drag may pull. Source: Remmers, "The grain silo", 2009. (There
//! the force "that i exerts on j" is the one on i.)

use crate::contact::damping::Attraction;
use crate::contact::{Pair, PairForce, PairLaw};
use crate::scene::values::{NonNegative, Positive};

/// k delta n - b (v_i - v_j).
#[derive(Clone, Copy, Debug)]
pub struct Assignment {
    k: f64,
    b: f64,
}

impl Assignment {
    /// The law with stiffness `k` (N/m) and drag `b` (N s/m).
    #[must_use]
    pub fn new(k: Positive, b: NonNegative) -> Self {
        Self { k: k.get(), b: b.get() }
    }
}

impl PairLaw for Assignment {
    #[inline]
    fn force(&self, pair: &Pair) -> PairForce {
        PairForce { elastic: self.k * pair.overlap * pair.normal, drag: -self.b * pair.relative_velocity }
    }

    fn elastic_energy(&self, overlap: f64) -> f64 {
        0.5 * self.k * overlap * overlap
    }

    fn stiffness(&self) -> f64 {
        self.k
    }

    fn damping(&self, _: f64) -> f64 {
        self.b
    }

    fn contact_duration(&self, reduced_mass: f64) -> f64 {
        Attraction::Allowed.duration(self.damping_ratio(reduced_mass)) / self.frequency(reduced_mass)
    }

    fn restitution(&self, reduced_mass: f64) -> f64 {
        Attraction::Allowed.restitution(self.damping_ratio(reduced_mass))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::space::Vector;

    #[test]
    fn pushes_apart_and_drags_along_the_whole_relative_velocity() {
        let law = Assignment::new(Positive::try_from(1e4).unwrap(), NonNegative::try_from(5.0).unwrap());
        let pair =
            Pair { normal: Vector::X, overlap: 1e-3, relative_velocity: Vector::new(-2.0, 3.0), reduced_mass: 0.08 };
        let force = law.force(&pair);
        assert_eq!(force.elastic, Vector::new(10.0, 0.0));
        assert_eq!(force.drag, Vector::new(10.0, -15.0));
    }

    #[test]
    fn the_silo_s_grains_bounce_with_restitution_0_76() {
        // k = 1e4 N/m, b = 5 N s/m, m = 0.16 kg: exp(-pi zeta/sqrt(1 - zeta^2)) with zeta = 5/(2 sqrt(1e4 0.08)).
        let law = Assignment::new(Positive::try_from(1e4).unwrap(), NonNegative::try_from(5.0).unwrap());
        assert!((law.restitution(0.08) - 0.756_71).abs() < 5e-6, "{}", law.restitution(0.08));
    }
}
