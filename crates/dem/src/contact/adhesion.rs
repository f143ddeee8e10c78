//! Adhesion of touching bodies: a pull between the centres while they overlap.
//!
//! F_n = max(spring - c v_n, floor) - P(delta), with the spring and the dashpot of another law and one of these pulls:
//!
//! | key | P | source |
//! |---|---|---|
//! | `Force(F)` | F, N, the same for every pair | constant pull, as in Gilabert, Roux and Castellanos, Phys. Rev. E 75, 011303, 2007 |
//! | `Dmt(w)` | 2 pi w R*, with the work of adhesion w in J/m^2 | Derjaguin, Muller and Toporov, J. Colloid Interface Sci. 53, 314, 1975 |
//! | `Area(q)` | q A, with the cohesion energy density q in J/m^3 and the area A = 2 pi R* delta of the circle in which the spheres intersect, to first order in delta/R | "linear cohesion" of EDEM and `sjkr` of LIGGGHTS |
//!
//! Friction and rolling resistance are capped with F_n + P, so that a contact in which pull and spring cancel resists
//! sliding (Thornton, J. Phys. D 24, 1942, 1991). This sum begins at zero where the bodies touch.
//!
//! The pull has the potential -P delta (`Area`: half of it), so that without a dashpot a bounce loses nothing: bodies stick
//! because of the dashpot. `Force` and `Dmt` jump to their value at touch. [`centred`](super::centred) contacts take the
//! mean of the jump over the step, so that they keep their second order. Velocity Verlet is of first order in P.
//!
//! Limits: no force beyond touch; [`jkr`](super::jkr) has one. The work of adhesion is twice the surface energy of one material.

use std::f64::consts::PI;

use serde::{Deserialize, Serialize};

use crate::contact::centred::window::Window;
use crate::contact::composite::Normal;
use crate::contact::law::Bounce;
use crate::contact::pair::{Pair, VelocityPrediction};
use crate::particle::Species;
use crate::space::{Plane, Space};
use crate::values::{NonNegative, Positive};

/// The scene's `contact.adhesion`.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub enum Adhesion {
    /// A constant pull while two bodies touch, N.
    Force(NonNegative),
    /// The pull 2 pi w R* of a work of adhesion w, J/m^2.
    Dmt(NonNegative),
    /// The pull q A of a density of cohesion energy q, J/m^3, where A = 2 pi R* delta: linear cohesion.
    Area(NonNegative),
    /// The law of Johnson, Kendall and Roberts, [`jkr`](super::jkr), in place of Hertz's force, with a work of adhesion w, J/m^2.
    Jkr(Positive),
}

/// A normal force with adhesion.
#[derive(Clone, Copy, Debug)]
pub struct Adhesive<N> {
    /// Spring and dashpot.
    normal: N,
    /// Pull from touch on, N, and the part of it per R*, N/m.
    constant: f64,
    per_radius: f64,
    /// Pull per R* and overlap, N/m^2.
    per_area: f64,
}

impl<N: Normal> Adhesive<N> {
    /// Adds adhesion to a normal force.
    #[must_use]
    pub fn new(normal: N, adhesion: Option<Adhesion>) -> Self {
        let [constant, per_radius, per_area] = match adhesion {
            None | Some(Adhesion::Jkr(_)) => [0.0; 3],
            Some(Adhesion::Force(force)) => [force.get(), 0.0, 0.0],
            Some(Adhesion::Dmt(work)) => [0.0, 2.0 * PI * work.get(), 0.0],
            Some(Adhesion::Area(density)) => [0.0, 0.0, 2.0 * PI * density.get()],
        };
        Self { normal, constant, per_radius, per_area }
    }

    #[inline(always)]
    fn jump(&self, reduced_radius: f64) -> f64 {
        self.constant + self.per_radius * reduced_radius
    }

    /// Returns the energy released by the pull up to an overlap, J.
    #[inline(always)]
    fn released(&self, reduced_radius: f64, overlap: f64) -> f64 {
        (self.jump(reduced_radius) + 0.5 * self.per_area * reduced_radius * overlap) * overlap
    }

    /// Returns the bounce without adhesion that is as deep as this one: with the speed that the pull adds up to the
    /// deepest point.
    fn without_pull(&self, bounce: &Bounce) -> Bounce {
        let mut faster = Bounce { speed: bounce.speed.max(1.0), ..*bounce };
        // The deepest point grows less than in proportion to the energy, so that this converges.
        for _ in 0..200 {
            let before = faster.speed;
            let released = self.released(bounce.reduced_radius, self.normal.deepest(&faster));
            faster.speed = (bounce.speed * bounce.speed + 2.0 * released / bounce.reduced_mass).sqrt();
            if faster.speed.to_bits() == before.to_bits() {
                break;
            }
        }
        faster
    }
}

impl<N: Normal> Normal for Adhesive<N> {
    const OVERLAP_WITHOUT_EVENTS: f64 = N::OVERLAP_WITHOUT_EVENTS;
    const FADES: bool = N::FADES;
    const PULLS: bool = true;

    #[inline(always)]
    fn spring<V: Space>(&self, pair: &Pair<V>) -> f64 {
        self.normal.spring(pair)
    }

    #[inline(always)]
    fn dashpot<V: Space>(&self, pair: &Pair<V>) -> f64 {
        self.normal.dashpot(pair)
    }

    #[inline(always)]
    fn mean_dashpot<V: Space>(&self, pair: &Pair<V>, window: &Window, overlap: f64) -> f64 {
        self.normal.mean_dashpot(pair, window, overlap)
    }

    #[inline(always)]
    fn mean_dashpot_without_events(&self, dashpot: f64, window: &Window, overlap: f64) -> f64 {
        self.normal.mean_dashpot_without_events(dashpot, window, overlap)
    }

    #[inline(always)]
    fn floor(&self) -> f64 {
        self.normal.floor()
    }

    #[inline(always)]
    fn pull<V: Space>(&self, pair: &Pair<V>, share: f64) -> f64 {
        let radius = pair.reduced_radius();
        self.jump(radius) * share + self.per_area * radius * pair.overlap
    }

    fn needs_mass_root(&self) -> bool {
        self.normal.needs_mass_root()
    }

    fn energy<V: Space>(&self, pair: &Pair<V>) -> f64 {
        self.normal.energy(pair) - self.released(pair.reduced_radius(), pair.overlap)
    }

    fn stiffness(&self, bounce: &Bounce) -> f64 {
        self.normal.stiffness(&self.without_pull(bounce))
    }

    fn damping(&self, bounce: &Bounce) -> f64 {
        self.normal.damping(&self.without_pull(bounce))
    }

    fn deepest(&self, bounce: &Bounce) -> f64 {
        self.normal.deepest(&self.without_pull(bounce))
    }

    // A bounce with a pull lasts longer, so this is on the safe side.
    fn contact_duration(&self, bounce: &Bounce) -> f64 {
        self.normal.contact_duration(&self.without_pull(bounce))
    }

    // Without a pull the restitution is that of the other law.
    fn restitution(&self, bounce: &Bounce) -> f64 {
        if self.constant + self.per_radius + self.per_area <= 0.0 {
            return self.normal.restitution(bounce);
        }
        integrated_restitution(self, bounce, 0.0)
    }
}

/// Returns the restitution of a head-on bounce that begins at touch and ends at the overlap `end` (m); 0 if the bodies
/// stick. Integrates the equation of motion with the classical Runge-Kutta scheme, 400 steps in a contact duration.
pub(super) fn integrated_restitution<N: Normal>(normal: &N, bounce: &Bounce, end: f64) -> f64 {
    let force = |overlap: f64, closing: f64| {
        let pair = head_on(bounce, overlap.max(end), closing);
        let load = (normal.spring(&pair) + normal.dashpot(&pair) * closing).max(normal.floor());
        (normal.pull(&pair, 1.0) - load) / bounce.reduced_mass
    };
    let h = normal.contact_duration(bounce) / 400.0;
    let mut overlap = 0.0;
    let mut closing = bounce.speed;
    // In ten durations a body that does not leave has lost its energy, or swings on.
    for _ in 0..4000 {
        let a1 = force(overlap, closing);
        let a2 = force(overlap + 0.5 * h * closing, closing + 0.5 * h * a1);
        let a3 = force(overlap + 0.5 * h * (closing + 0.5 * h * a1), closing + 0.5 * h * a2);
        let a4 = force(overlap + h * (closing + 0.5 * h * a2), closing + h * a3);
        overlap += h * (closing + h / 6.0 * (a1 + a2 + a3));
        closing += h / 6.0 * (a1 + 2.0 * (a2 + a3) + a4);
        if overlap <= end {
            return -closing / bounce.speed;
        }
    }
    0.0
}

/// Returns two equal grains that meet head-on with the masses and radii of a bounce.
fn head_on(bounce: &Bounce, overlap: f64, closing: f64) -> Pair {
    Pair {
        normal: Plane::X,
        overlap,
        relative_velocity: Plane::X * -closing,
        reduced_mass: bounce.reduced_mass,
        mass_root: bounce.reduced_mass.sqrt(),
        radii: [2.0 * bounce.reduced_radius; 2],
        inverse_reach: 0.25 / bounce.reduced_radius,
        spins: [0.0; 2],
        species: [Species(0); 2],
        dt: 0.0,
        springs_ahead: 0.0,
        gathered: None,
        ahead: VelocityPrediction::default(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::damping::{Attraction, Damping};
    use crate::contact::linear::LinearNormal;

    const BOUNCE: Bounce = Bounce { reduced_mass: 0.1, reduced_radius: 0.02, speed: 0.5 };

    fn law(e: f64, adhesion: Adhesion) -> Adhesive<LinearNormal> {
        let damping = Damping::Restitution(e.try_into().unwrap());
        Adhesive::new(LinearNormal::new(1e4.try_into().unwrap(), damping, Attraction::Allowed), Some(adhesion))
    }

    #[test]
    fn deepest_point_has_the_energy_of_the_impact() {
        // k d^2/2 - P d = m v^2/2.
        let pull = 3.0f64;
        let k = 1e4f64;
        let energy = 0.5 * 0.1 * 0.25;
        let exact = pull / k + ((pull / k).powi(2) + 2.0 * energy / k).sqrt();
        let deepest = law(1.0, Adhesion::Force(pull.try_into().unwrap())).deepest(&BOUNCE);
        assert!((deepest / exact - 1.0).abs() < 1e-12, "{deepest} {exact}");
    }

    #[test]
    fn slow_bodies_stick_and_fast_ones_bounce() {
        let strong = law(0.8, Adhesion::Force(20.0.try_into().unwrap()));
        assert!(strong.restitution(&Bounce { speed: 0.01, ..BOUNCE }).abs() < f64::EPSILON);
        let fast = strong.restitution(&Bounce { speed: 100.0, ..BOUNCE });
        assert!((fast - 0.8).abs() < 0.01, "{fast}");
        let free = law(0.8, Adhesion::Dmt(1e-9.try_into().unwrap())).restitution(&BOUNCE);
        // The last step of the integration misses the end by up to a step, in which the dashpot takes 2 zeta w0 h.
        assert!((free - 0.8).abs() < 2e-3, "{free}");
    }
}
