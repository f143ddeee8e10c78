//! The linear spring-dashpot along the normal.
//!
//! F on i = max(k delta - c v_n, floor) n with v_n = (v_i - v_j).n; k in N/m, c in N s/m by [`Damping`], floor 0 or
//! -inf by [`Attraction`]. Grains are frictionless: no force along the tangent. Source: Cundall and Strack,
//! Geotechnique 29, 47, 1979; the normal part of the soft-particle codes and of LAMMPS's `hooke`.

use crate::contact::damping::{Attraction, Damping};
use crate::contact::{Pair, PairForce, PairLaw};
use crate::scene::values::Positive;

/// max(k delta - c v_n, floor) n.
#[derive(Clone, Copy, Debug)]
pub struct LinearNormal {
    k: f64,
    drag: Drag,
    attraction: Attraction,
    floor: f64,
}

/// c for a pair.
#[derive(Clone, Copy, Debug)]
enum Drag {
    /// c, N s/m.
    Constant(f64),
    /// c/m_eff, 1/s.
    PerMass(f64),
    /// c/sqrt(m_eff), N s/(m sqrt(kg)).
    PerRootMass(f64),
}

impl LinearNormal {
    /// The law with stiffness `k` (N/m).
    #[must_use]
    pub fn new(k: Positive, damping: Damping, attraction: Attraction) -> Self {
        let k = k.get();
        let drag = match damping {
            Damping::B(b) => Drag::Constant(b.get()),
            Damping::PerMass(gamma) => Drag::PerMass(gamma.get()),
            Damping::Restitution(e) => Drag::PerRootMass(2.0 * attraction.damping_ratio(e) * k.sqrt()),
        };
        Self { k, drag, attraction, floor: attraction.floor() }
    }
}

impl PairLaw for LinearNormal {
    #[inline]
    fn force(&self, pair: &Pair) -> PairForce {
        let spring = self.k * pair.overlap;
        let v_n = pair.relative_velocity.dot(pair.normal);
        let total = (spring - self.damping(pair.reduced_mass) * v_n).max(self.floor);
        PairForce { elastic: spring * pair.normal, drag: (total - spring) * pair.normal }
    }

    fn elastic_energy(&self, overlap: f64) -> f64 {
        0.5 * self.k * overlap * overlap
    }

    fn stiffness(&self) -> f64 {
        self.k
    }

    #[inline]
    fn damping(&self, reduced_mass: f64) -> f64 {
        match self.drag {
            Drag::Constant(b) => b,
            Drag::PerMass(gamma) => gamma * reduced_mass,
            Drag::PerRootMass(z) => z * reduced_mass.sqrt(),
        }
    }

    fn contact_duration(&self, reduced_mass: f64) -> f64 {
        self.attraction.duration(self.damping_ratio(reduced_mass)) / self.frequency(reduced_mass)
    }

    fn restitution(&self, reduced_mass: f64) -> f64 {
        self.attraction.restitution(self.damping_ratio(reduced_mass))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::values::NonNegative;
    use crate::space::Vector;

    fn parting(attraction: Attraction) -> PairForce {
        let damping = Damping::B(NonNegative::try_from(100.0).unwrap());
        let law = LinearNormal::new(Positive::try_from(1e4).unwrap(), damping, attraction);
        let relative_velocity = Vector::new(1.0, 7.0);
        law.force(&Pair { normal: Vector::X, overlap: 1e-3, relative_velocity, reduced_mass: 0.1 })
    }

    #[test]
    fn a_parting_pair_pulls_only_where_attraction_is_allowed() {
        let pulled = parting(Attraction::Allowed);
        assert_eq!(pulled.elastic + pulled.drag, Vector::new(-90.0, 0.0));
        let cut = parting(Attraction::Forbidden);
        assert_eq!(cut.elastic + cut.drag, Vector::ZERO);
    }

    #[test]
    fn restitution_does_not_depend_on_the_pair_s_mass() {
        let damping = Damping::Restitution(0.5.try_into().unwrap());
        for attraction in [Attraction::Allowed, Attraction::Forbidden] {
            let law = LinearNormal::new(Positive::try_from(1e4).unwrap(), damping, attraction);
            for mass in [1e-6, 0.08, 40.0] {
                assert!((law.restitution(mass) - 0.5).abs() < 1e-12);
            }
        }
    }
}
