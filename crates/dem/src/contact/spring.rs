//! Spring slider: the elastic-plastic spring-dashpot in the tangent plane of a contact, shared by friction and rolling
//! resistance.
//!
//! A displacement S (m) accumulates the velocity v (m/s) in the tangent plane while the contact lasts:
//!
//! 1. S <- S + v dt, then S <- S - (S.n) n, so that S turns with the contact plane;
//! 2. F = -k S - c v;
//! 3. where |F| exceeds the cap, F is shortened to the cap along its direction and S = -(F + c v)/k. So the spring
//!    stays loaded exactly as far as the cap allows.
//!
//! The order is that of LAMMPS's `gran/hooke/history`.
//!
//! In velocity Verlet the spring takes k (S_old + S_new)/2 . v dt from the motion in a step, with v at the half step.
//! The part that is not stored is lost: k (S_old + S_new)/2 . (S_old + v dt - S_new). This is exact for a straight
//! slide, and includes the energy lost when the spring turns. The energy balance computes the dissipation of the
//! dashpot with the particle velocities at the full step (module `energy` of `siloflow`). [`slider`](crate::contact::centred::slider) has the slider of contacts near
//! an event.

use crate::contact::centred::window::cut;
use crate::space::Space;

/// A spring-dashpot with a cap on its force.
#[derive(Clone, Copy, Debug)]
pub struct Slider {
    /// k, N/m.
    pub stiffness: f64,
    /// c, N s/m.
    pub dashpot: f64,
    /// Largest force, N.
    pub cap: f64,
}

/// The result of a spring slider in one step.
#[derive(Clone, Copy, Debug)]
pub struct SliderForce<V> {
    /// F, N.
    pub force: V,
    /// The part -c v, N.
    pub dashpot: V,
    /// Energy lost other than in the dashpot, J.
    pub lost: f64,
    /// Whether the force is at its cap.
    pub is_sliding: bool,
}

impl Slider {
    /// Advances `spring` (m) by the velocity `gathered` (m/s) for `dt` (s) and returns the force, with the dashpot at `velocity`
    /// (m/s). `spring` is `springs_ahead` (s) ahead of the evaluation, by `velocity`. `normal` is the normal of the tangent plane.
    #[inline(always)]
    #[must_use]
    pub fn pull<V: Space>(
        &self,
        spring: &mut V,
        [velocity, gathered]: [V; 2],
        normal: V,
        [dt, springs_ahead]: [f64; 2],
    ) -> SliderForce<V> {
        let before = *spring;
        let moved = before + gathered * dt;
        let mut after = moved - normal * moved.dot(normal);
        // The force beside that of the stored spring, which is ahead: -k (S - v t) - c v = -k S + (k t - c) v.
        let beside = velocity * (self.stiffness * springs_ahead - self.dashpot);
        let (is_sliding, force) = cut(after * -self.stiffness + beside, self.cap);
        if is_sliding {
            after = (force - beside) * (-1.0 / self.stiffness);
        }
        *spring = after;
        // That this time is zero is known to the compiler. In step zero a spring only gets ahead.
        let both_ahead = if springs_ahead > 0.0 {
            velocity * (springs_ahead + springs_ahead.min(dt - springs_ahead))
        } else {
            V::ZERO
        };
        let lost = 0.5 * self.stiffness * (before + after - both_ahead).dot(moved - after);
        SliderForce { force, dashpot: velocity * -self.dashpot, lost, is_sliding }
    }
}

/// Returns the energy lost with the spring of an ended contact, J. `stiffness` in N/m; `velocity` (m/s) is the velocity
/// of the last step, `dt` (s).
pub(super) fn lost_at_contact_end<V: Space>(stiffness: f64, spring: V, velocity: V, dt: f64) -> f64 {
    0.5 * stiffness * spring.dot(spring + velocity * dt)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::space::Solid;

    const SLIDER: Slider = Slider { stiffness: 1e4, dashpot: 3.0, cap: 2.0 };

    #[test]
    fn slider_sticks_below_the_cap_and_slides_at_it() {
        let mut spring = Solid::ZERO;
        let stuck = SLIDER.pull(&mut spring, [Solid::X * 0.1; 2], Solid::Z, [1e-3, 0.0]);
        assert!(!stuck.is_sliding && spring.distance(Solid::X * 1e-4) < 1e-19);
        assert!(stuck.force.distance(Solid::X * -1.3) < 1e-15, "{}", stuck.force);
        let slid = SLIDER.pull(&mut spring, [Solid::X * 0.5; 2], Solid::Z, [1e-3, 0.0]);
        assert!(slid.is_sliding && (slid.force + Solid::X * 2.0).length() < 1e-15);
        // The spring carries the part that the dashpot does not: 2.0 = 1e4 S + 3 x 0.5.
        assert!((spring.x - 5e-5).abs() < 1e-18, "{}", spring.x);
    }

    #[test]
    fn energy_taken_is_energy_stored_and_lost() {
        // Motion back, forth and sideways in a fixed plane. The work of the spring force is summed by the trapezoidal
        // rule.
        let mut spring = Solid::ZERO;
        let mut taken = 0.0;
        let mut lost = 0.0;
        let dt = 1e-3;
        let mut before = Solid::ZERO;
        for step in 0..400 {
            let angle = 0.02 * f64::from(step);
            let velocity = Solid::new(0.6 * angle.sin(), 0.2 * (2.0 * angle).cos(), 0.0);
            let pull = SLIDER.pull(&mut spring, [velocity; 2], Solid::Z, [dt, 0.0]);
            let elastic = pull.force - pull.dashpot;
            taken -= 0.5 * dt * (before + elastic).dot(velocity);
            before = elastic;
            lost += pull.lost;
        }
        let stored = 0.5 * SLIDER.stiffness * spring.length_squared();
        // Tolerance: 400 roundings of sums of up to 0.1 J.
        assert!((taken - stored - lost).abs() < 400.0 * 0.1 * f64::EPSILON && lost > 0.0, "{taken} {stored} {lost}");
    }

    #[test]
    fn the_spring_turns_with_the_plane() {
        let mut spring = Solid::new(1e-5, 1e-5, 0.0);
        let _ = SLIDER.pull(&mut spring, [Solid::ZERO; 2], Solid::X, [1e-3, 0.0]);
        assert_eq!(spring, Solid::new(0.0, 1e-5, 0.0));
    }
}
