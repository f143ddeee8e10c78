//! Adhesion of Johnson, Kendall and Roberts: soft elastic spheres whose contact also holds across a gap.
//!
//! With the work of adhesion w (J/m^2), E* and R* as in [`hertz`](super::hertz), the radius a of the contact gives
//!
//! * overlap delta = a^2/R* - sqrt(2 pi w a/E*),
//! * spring and pull F = 4 E* a^3/(3 R*) - sqrt(8 pi w E* a^3).
//!
//! A contact forms at touch, delta = 0, with F = -4/3 pi w R*. It breaks at the overlap -3 a^2/R* of
//! a^3 = pi w R*^2/(8 E*), below which no equilibrium exists at a given distance; there F = -5/6 pi w R*. The largest
//! tension, the pull-off force 3/2 pi w R*, lies between. A breaking contact loses the work
//! 7.09 (w^5 R*^4/E*^2)^(1/3) of the gap, which counts as dissipated.
//!
//! [`centred`](super::centred) contacts near their beginning or end take the exact mean of F over the step, the change of the stored energy over that of the overlap.
//! F is steep where the contact breaks: the order of `Centred` is 2 at coarse steps and falls at fine ones (`docs/explanation/accuracy.md`).
//!
//! Damping c = 2 z sqrt(S m_eff) with S = 2 E* a and z of Hertz's law. Friction has k_t = 8 G* a and c_t = 2 z sqrt(k_t m_eff),
//! and is capped with F_n + 3 pi w R*: twice the pull-off force is added ([`JkrFriction`]).
//!
//! In terms of y = sqrt(a/a_0), a_0^3 = 2 pi w R*^2/E* the radius at touch, delta R*/a_0^2 = y^4 - y and
//! F = pi w R* (8/3 y^6 - 4 y^3): the quartic is solved in closed form.
//!
//! Sources: Johnson, Kendall and Roberts, Proc. R. Soc. A 324, 301, 1971; Thornton and Ning, Powder Technology 99, 154, 1998.
//! Limits: LAMMPS breaks the contact at the largest tension instead.

use std::f64::consts::PI;

use crate::contact::adhesion::integrated_restitution;
use crate::contact::centred::window::Window;
use crate::contact::composite::Normal;
use crate::contact::damping::Attraction;
use crate::contact::hertz::Material;
use crate::contact::law::Bounce;
use crate::contact::pair::Pair;
use crate::contact::tangential::Modulus;
use crate::math;
use crate::space::Space;
use crate::values::{Positive, Restitution};

/// y where a contact breaks: 4^(-1/3).
const Y_BREAK: f64 = 0.629_960_524_947_436_6;
/// y^4 - y there.
const GAP_BREAK: f64 = -0.472_470_393_710_577_4;

/// The normal force of the law.
#[derive(Clone, Copy, Debug)]
pub struct Jkr {
    /// E*, Pa.
    modulus: f64,
    /// pi w, N/m.
    tension: f64,
    /// (2 pi w/E*)^(1/3), m^(1/3): a_0 = this times R*^(2/3).
    touch: f64,
    ratio: f64,
    floor: f64,
}

impl Jkr {
    /// Creates the law between two materials with the work of adhesion `work`, J/m^2.
    #[must_use]
    pub fn new(materials: [Material; 2], restitution: Restitution, attraction: Attraction, work: Positive) -> Self {
        let [a, b] = materials;
        let modulus = a.effective_modulus(b);
        let tension = PI * work.get();
        Self {
            modulus,
            tension,
            touch: math::cbrt(2.0 * tension / modulus),
            ratio: (5.0f64 / 6.0).sqrt() * attraction.damping_ratio(restitution),
            floor: attraction.floor(),
        }
    }

    /// Returns a_0, m.
    #[inline(always)]
    fn touching_radius(&self, reduced_radius: f64) -> f64 {
        let root = math::cbrt(reduced_radius);
        self.touch * root * root
    }

    /// Returns the gap at which a contact breaks, m.
    #[inline(always)]
    fn reach(reduced_radius: f64, a0: f64) -> f64 {
        -GAP_BREAK * a0 * a0 / reduced_radius
    }

    /// Returns y at an overlap, m, and a_0, m. Below the overlap of breaking it is that of breaking.
    #[inline(always)]
    fn state(&self, reduced_radius: f64, overlap: f64) -> [f64; 2] {
        let a0 = self.touching_radius(reduced_radius);
        // Counted from the break, so that y is exact there. It goes with the root of the overlap, and rounding of the difference would leave 1e-8.
        let from_break = overlap + Self::reach(reduced_radius, a0);
        [solve(GAP_BREAK + from_break * reduced_radius / (a0 * a0)), a0]
    }

    /// Returns the contact radius a, m.
    #[inline(always)]
    fn radius<V: Space>(&self, pair: &Pair<V>) -> f64 {
        let [y, a0] = self.state(pair.reduced_radius(), pair.overlap);
        a0 * y * y
    }

    /// Returns spring and pull, N, without the part of the pull in [`Normal::pull`].
    #[inline(always)]
    fn load(&self, reduced_radius: f64, y: f64) -> f64 {
        let cube = y * y * y;
        self.tension * reduced_radius * (8.0 / 3.0 * cube * cube - 4.0 * cube + 3.0)
    }

    /// Returns the energy gained from touch to y, J.
    #[inline(always)]
    fn stored([y, a0]: [f64; 2], tension: f64) -> f64 {
        let cube = y * y * y;
        let fourth = (y * y) * (y * y);
        tension * a0 * a0 * (fourth * (16.0 / 15.0 * cube * cube - 8.0 / 3.0 * cube + 1.0) + 0.6)
    }

    /// Returns y and a_0 at the deepest point of an undamped bounce.
    fn deepest_state(&self, bounce: &Bounce) -> [f64; 2] {
        let a0 = self.touching_radius(bounce.reduced_radius);
        let energy = 0.5 * bounce.reduced_mass * bounce.speed.powi(2);
        // The energy falls from touch to the equilibrium at y^3 = 3/2 and grows from there on.
        let mut low = math::cbrt(1.5);
        let mut high = 2.0;
        while Self::stored([high, a0], self.tension) < energy {
            high *= 2.0;
        }
        for _ in 0..100 {
            let middle = 0.5 * (low + high);
            if Self::stored([middle, a0], self.tension) < energy { low = middle } else { high = middle }
        }
        [high, a0]
    }

    /// Returns the energy lost where a contact breaks in a step (J). `overlap` (m) is that of the step's end.
    pub(super) fn lost_at_break<V: Space>(&self, pair: &Pair<V>) -> f64 {
        let radius = pair.reduced_radius();
        let tension = self.tension;
        if pair.is_predicted() {
            // The averaged force acts until the contact breaks.
            return Self::stored([Y_BREAK, self.touching_radius(radius)], tension);
        }
        // The force of the step's beginning still acts for half a step.
        let parted = pair.normal_velocity() * pair.dt;
        let [y, a0] = self.state(radius, pair.overlap + parted);
        let force = self.load(radius, y) - 3.0 * tension * radius;
        Self::stored([y, a0], tension) - 0.5 * force * parted
    }
}

/// Returns the y >= [`Y_BREAK`] with y^4 - y = d.
#[inline(always)]
fn solve(d: f64) -> f64 {
    let d = d.max(GAP_BREAK);
    // The real root m of the resolvent m^3 + d m = 1/8, with which y = (sqrt(2 m) + sqrt(sqrt(2/m) - 2 m))/2.
    let third = d / 3.0;
    let root = (third * third * third + 1.0 / 256.0).max(0.0).sqrt();
    let u = math::cbrt(0.0625 + root);
    let other = third / u;
    // u - other, which cancels at large d, where the difference of the cubes, 1/8, gives it.
    let m = if d > 1e4 { 0.125 / (u * u + third + other * other) } else { u - other };
    let twice = 2.0 * m;
    let mut y = 0.5 * (twice.sqrt() + ((2.0 / m).sqrt() - twice).max(0.0).sqrt());
    // Newton's method restores the last digits. Near the break the equation has a double root, and the closed
    // form is exact enough.
    for _ in 0..3 {
        let slope = 4.0 * y * y * y - 1.0;
        let step = (y * (y * y * y - 1.0) - d) / slope.max(1e-3);
        y = (y - if slope > 1e-3 { step } else { 0.0 }).max(Y_BREAK);
    }
    if d > GAP_BREAK { y } else { Y_BREAK }
}

impl Normal for Jkr {
    // The force changes with the root of the distance from the break. A sum over steps that takes its values there misses
    // 0.2 (2 w)^(3/2) of its integral in units of that root; the mean over each step in the last eight steps leaves 0.007.
    const OVERLAP_WITHOUT_EVENTS: f64 = 16.0;
    const PULLS: bool = true;
    const REACHES: bool = true;

    #[inline(always)]
    fn spring<V: Space>(&self, pair: &Pair<V>) -> f64 {
        let radius = pair.reduced_radius();
        self.load(radius, self.state(radius, pair.overlap)[0])
    }

    #[inline(always)]
    fn dashpot<V: Space>(&self, pair: &Pair<V>) -> f64 {
        2.0 * self.ratio * (2.0 * self.modulus * self.radius(pair) * pair.reduced_mass).sqrt()
    }

    #[inline(always)]
    fn mean_dashpot<V: Space>(&self, pair: &Pair<V>, window: &Window, overlap: f64) -> f64 {
        self.dashpot(pair) * window.share(overlap)
    }

    #[inline(always)]
    fn mean_dashpot_without_events(&self, dashpot: f64, _: &Window, _: f64) -> f64 {
        dashpot
    }

    #[inline(always)]
    fn floor(&self) -> f64 {
        self.floor
    }

    #[inline(always)]
    fn pull<V: Space>(&self, pair: &Pair<V>, share: f64) -> f64 {
        3.0 * self.tension * pair.reduced_radius() * share
    }

    #[inline(always)]
    fn range(&self, reduced_radius: f64) -> f64 {
        Self::reach(reduced_radius, self.touching_radius(reduced_radius))
    }

    fn mean_spring<V: Space>(&self, low: &Pair<V>, high: &Pair<V>) -> f64 {
        let radius = low.reduced_radius();
        let [a, b] = [low, high].map(|pair| self.state(radius, pair.overlap)[0]);
        // (x^n - y^n)/(x - y), so that the difference of nearly equal energies does not cancel.
        let quotient = |n: i32| (0..n).map(|k| a.powi(k) * b.powi(n - 1 - k)).sum::<f64>();
        let way = quotient(4) - 1.0;
        let mean = if way > 1e-12 {
            (16.0 / 15.0 * quotient(10) - 8.0 / 3.0 * quotient(7) + quotient(4)) / way
        } else {
            // Both ends are where the contact breaks.
            -5.0 / 6.0
        };
        self.tension * radius * (mean + 3.0)
    }

    fn lost_at_break<V: Space>(&self, pair: &Pair<V>) -> f64 {
        self.lost_at_break(pair)
    }

    fn energy<V: Space>(&self, pair: &Pair<V>) -> f64 {
        Self::stored(self.state(pair.reduced_radius(), pair.overlap), self.tension)
    }

    fn stiffness(&self, bounce: &Bounce) -> f64 {
        let [y, a0] = self.deepest_state(bounce);
        // dF/dy over d(delta)/dy.
        let rise = self.tension * bounce.reduced_radius * (16.0 * y.powi(5) - 12.0 * y * y);
        rise * bounce.reduced_radius / (a0 * a0 * (4.0 * y.powi(3) - 1.0))
    }

    fn damping(&self, bounce: &Bounce) -> f64 {
        let [y, a0] = self.deepest_state(bounce);
        2.0 * self.ratio * (2.0 * self.modulus * a0 * y * y * bounce.reduced_mass).sqrt()
    }

    fn deepest(&self, bounce: &Bounce) -> f64 {
        let [y, a0] = self.deepest_state(bounce);
        a0 * a0 / bounce.reduced_radius * (y.powi(4) - y)
    }

    fn contact_duration(&self, bounce: &Bounce) -> f64 {
        // The duration of Hertz's law with the same stiffness at the deepest point: 2.943 sqrt(15/8) sqrt(m/S).
        4.030_2 * (bounce.reduced_mass / self.stiffness(bounce)).sqrt()
    }

    fn restitution(&self, bounce: &Bounce) -> f64 {
        integrated_restitution(self, bounce, -self.range(bounce.reduced_radius))
    }
}

/// Tangential stiffness and dashpot coefficient for use with [`Jkr`].
#[derive(Clone, Copy, Debug)]
pub struct JkrFriction {
    shear_modulus: f64,
    /// c_t/c.
    dashpot_share: f64,
    normal: Jkr,
}

impl JkrFriction {
    /// Creates the term between two materials. `share` is c_t/c; without it c_t has the damping ratio of the normal force.
    #[must_use]
    pub fn new(materials: [Material; 2], normal: Jkr, share: Option<f64>) -> Self {
        let [a, b] = materials;
        let shear_modulus = a.effective_shear_modulus(b);
        let usual = (4.0 * shear_modulus / normal.modulus).sqrt();
        Self { shear_modulus, dashpot_share: share.unwrap_or(usual), normal }
    }
}

impl Modulus for JkrFriction {
    const VARIES: bool = true;
    const FADES: bool = false;

    #[inline(always)]
    fn of<V: Space>(&self, pair: &Pair<V>, normal_dashpot: f64) -> (f64, f64) {
        (8.0 * self.shear_modulus * self.normal.radius(pair), self.dashpot_share * normal_dashpot)
    }

    #[inline(always)]
    fn mean_dashpot<V: Space>(&self, _: &Pair<V>, _: f64, normal_dashpot: f64) -> f64 {
        self.dashpot_share * normal_dashpot
    }

    fn remembered(&self, memory: f64) -> f64 {
        memory
    }

    fn at(&self, bounce: &Bounce, normal_dashpot: f64) -> [f64; 2] {
        let [y, a0] = self.normal.deepest_state(bounce);
        [8.0 * self.shear_modulus * a0 * y * y, self.dashpot_share * normal_dashpot]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn law() -> Jkr {
        let material = Material { young: 1e7.try_into().unwrap(), poisson: 0.3.try_into().unwrap() };
        let [e, work] = [1.0, 0.5];
        Jkr::new([material; 2], e.try_into().unwrap(), Attraction::Allowed, work.try_into().unwrap())
    }

    #[test]
    fn quartic_is_solved_from_the_break_to_deep_overlaps() {
        for y in [Y_BREAK + 1e-9, 0.64, 0.8, 1.0, 1.1447, 2.0, 17.0, 1e3] {
            let d = y * (f64::powi(y, 3) - 1.0);
            // Near the double root the rounding of d is amplified to its square root.
            let tolerance = if y < 0.63 { 1e-7 } else { 1e-13 };
            assert!((solve(d) / y - 1.0).abs() < tolerance, "{y}: {}", solve(d));
        }
        let law = law();
        for radius in [1e-4, 0.005, 0.03, 0.7] {
            assert_eq!(law.state(radius, -law.range(radius))[0].to_bits(), Y_BREAK.to_bits());
        }
    }

    #[test]
    fn forces_energies_and_limits_are_those_of_the_theory() {
        let law = law();
        let radius = 0.005;
        let work = 0.5;
        let a0 = law.touching_radius(radius);
        let force = |y: f64| law.load(radius, y) - 3.0 * PI * work * radius;
        // Largest tension 3/2 pi w R, at the break 5/6, at touch 4/3.
        let least = (0..10_000).map(|n| force(Y_BREAK + 1e-4 * f64::from(n))).fold(0.0, f64::min);
        for (force, part) in [(least, 1.5), (force(Y_BREAK), 5.0 / 6.0), (force(1.0), 4.0 / 3.0)] {
            assert!((force / (PI * work * radius) + part).abs() < 1e-7, "{force} {part}");
        }
        // Thornton and Ning: 7.09 (w^5 R^4/E^2)^(1/3).
        let lost = Jkr::stored([Y_BREAK, a0], law.tension);
        let published = 7.09 * (work.powi(5) * radius.powi(4) / law.modulus.powi(2)).cbrt();
        assert!((lost / published - 1.0).abs() < 1e-3, "{lost} {published}");
        // The energy is the integral of the force over the overlap.
        let at = |overlap: f64| law.state(radius, overlap);
        for overlap in [-0.3 * law.range(radius), 1e-6, 1e-4] {
            let h = 1e-4 * f64::abs(overlap);
            let slope =
                (Jkr::stored(at(overlap + h), law.tension) - Jkr::stored(at(overlap - h), law.tension)) / (2.0 * h);
            assert!((slope / force(at(overlap)[0]) - 1.0).abs() < 1e-5, "{overlap}: {slope}");
        }
    }
}
