//! The linear spring-dashpot along the normal.
//!
//! F on i = max(k delta - c v_n, floor) n with v_n = (v_i - v_j).n; k in N/m, c in N s/m by [`Damping`], floor 0 or
//! -inf by [`Attraction`]. Source: Cundall and Strack, Geotechnique 29, 47, 1979. The same normal force is used in
//! soft-particle codes and in LAMMPS's `hooke`.

use crate::contact::centred::window::Window;
use crate::contact::composite::Normal;
use crate::contact::damping::{Attraction, Coefficient, Damping};
use crate::contact::law::Bounce;
use crate::contact::pair::Pair;
use crate::space::Space;
use crate::values::Positive;

/// The law max(k delta - c v_n, floor) n.
#[derive(Clone, Copy, Debug)]
pub struct LinearNormal {
    k: f64,
    /// c, as a function of m_eff and its root.
    dashpot: Coefficient,
    attraction: Attraction,
    floor: f64,
}

impl LinearNormal {
    /// Creates the law with stiffness `k` (N/m).
    #[must_use]
    pub fn new(k: Positive, damping: Damping, attraction: Attraction) -> Self {
        let k = k.get();
        let dashpot = match damping {
            Damping::B(b) => Coefficient { constant: b.get(), ..Coefficient::default() },
            Damping::PerMass(gamma) => Coefficient { per_mass: gamma.get(), ..Coefficient::default() },
            Damping::Restitution(e) => {
                Coefficient { per_other: 2.0 * attraction.damping_ratio(e) * k.sqrt(), ..Coefficient::default() }
            }
        };
        Self { k, dashpot, attraction, floor: attraction.floor() }
    }

    #[inline(always)]
    fn coefficient<V: Space>(&self, pair: &Pair<V>) -> f64 {
        self.dashpot.of(pair.reduced_mass, pair.mass_root)
    }

    fn damping_ratio(&self, reduced_mass: f64) -> f64 {
        self.dashpot.of(reduced_mass, reduced_mass.sqrt()) / (2.0 * (self.k * reduced_mass).sqrt())
    }
}

impl Normal for LinearNormal {
    const RADII: bool = false;
    // From this overlap on, the contact exists during the whole previous step, too.
    const OVERLAP_WITHOUT_EVENTS: f64 = 3.0;

    #[inline(always)]
    fn spring<V: Space>(&self, pair: &Pair<V>) -> f64 {
        self.k * pair.overlap
    }

    #[inline(always)]
    fn dashpot<V: Space>(&self, pair: &Pair<V>) -> f64 {
        self.coefficient(pair)
    }

    #[inline(always)]
    fn mean_dashpot<V: Space>(&self, pair: &Pair<V>, window: &Window, overlap: f64) -> f64 {
        self.coefficient(pair) * window.share(overlap)
    }

    #[inline(always)]
    fn mean_dashpot_without_events(&self, dashpot: f64, _: &Window, _: f64) -> f64 {
        dashpot
    }

    #[inline(always)]
    fn floor(&self) -> f64 {
        self.floor
    }

    fn needs_mass_root(&self) -> bool {
        self.dashpot.per_other > 0.0
    }

    fn energy<V: Space>(&self, pair: &Pair<V>) -> f64 {
        0.5 * self.k * pair.overlap * pair.overlap
    }

    fn stiffness(&self, _: &Bounce) -> f64 {
        self.k
    }

    fn damping(&self, bounce: &Bounce) -> f64 {
        self.dashpot.of(bounce.reduced_mass, bounce.reduced_mass.sqrt())
    }

    fn deepest(&self, bounce: &Bounce) -> f64 {
        bounce.speed * (bounce.reduced_mass / self.k).sqrt()
    }

    fn contact_duration(&self, bounce: &Bounce) -> f64 {
        let m = bounce.reduced_mass;
        self.attraction.duration(self.damping_ratio(m)) * (m / self.k).sqrt()
    }

    fn restitution(&self, bounce: &Bounce) -> f64 {
        self.attraction.restitution(self.damping_ratio(bounce.reduced_mass))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::composite::Composite;
    use crate::contact::law::PairLaw;
    use crate::contact::memory::Memory;
    use crate::contact::pair::tests::pair;
    use crate::contact::pair_force::PairForce;
    use crate::contact::rolling::NoRolling;
    use crate::contact::tangential::NoFriction;
    use crate::space::Vector;
    use crate::values::NonNegative;

    fn separating_force(attraction: Attraction) -> PairForce {
        let damping = Damping::B(NonNegative::try_from(100.0).unwrap());
        let normal = LinearNormal::new(Positive::try_from(1e4).unwrap(), damping, attraction);
        let law = Composite { normal, tangential: NoFriction, rolling: NoRolling };
        law.force(&Pair { relative_velocity: Vector::new(1.0, 7.0), ..pair() }, &mut Memory::default())
    }

    #[test]
    fn a_separating_pair_pulls_only_if_attraction_is_allowed() {
        let pulled = separating_force(Attraction::Allowed);
        assert_eq!(pulled.normal, Vector::new(-90.0, 0.0));
        let cut = separating_force(Attraction::Forbidden);
        assert_eq!(cut.normal, Vector::ZERO);
    }

    #[test]
    fn restitution_does_not_depend_on_mass() {
        let damping = Damping::Restitution(0.5.try_into().unwrap());
        for attraction in [Attraction::Allowed, Attraction::Forbidden] {
            let law = LinearNormal::new(Positive::try_from(1e4).unwrap(), damping, attraction);
            for reduced_mass in [1e-6, 0.08, 40.0] {
                let bounce = Bounce { reduced_mass, reduced_radius: 0.02, speed: 1.0 };
                assert!((law.restitution(&bounce) - 0.5).abs() < 1e-12);
            }
        }
    }
}
