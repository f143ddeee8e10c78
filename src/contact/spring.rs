//! The elastic-plastic spring-dashpot in the tangent plane of a contact: what friction and rolling resistance share.
//!
//! A displacement S (m) gathers the velocity v (m/s) in the tangent plane while the contact lasts:
//!
//! 1. S <- S + v dt, then S <- S - (S.n) n: it turns with the contact plane;
//! 2. F = -k S - c v;
//! 3. where |F| exceeds the cap, F is cut to it along itself and S = -(F + c v)/k, so that the spring stays loaded as far
//!    as the cap allows and no farther.
//!
//! The order is that of LAMMPS's `gran/hooke/history`. In velocity Verlet the spring takes k (S_old + S_new)/2 . v dt from
//! the motion in a step, with v at the half step; what of it is not stored is lost:
//! k (S_old + S_new)/2 . (S_old + v dt - S_new). That is exact for a straight slide, and counts what turning the
//! spring takes as well. The dashpot's part is booked by the particles' velocities at the full step ([`crate::energy`]).

use crate::space::Space;

/// Stiffness (N/m), drag coefficient (N s/m) and largest force (N).
#[derive(Clone, Copy, Debug)]
pub struct Slider {
    /// k, N/m.
    pub stiffness: f64,
    /// c, N s/m.
    pub drag: f64,
    /// Largest force, N.
    pub cap: f64,
}

/// What it does in a step.
#[derive(Clone, Copy, Debug)]
pub struct Pull<V> {
    /// F, N.
    pub force: V,
    /// The part -c v, N.
    pub drag: V,
    /// What was lost other than to the dashpot, J.
    pub lost: f64,
    /// Whether the force is at its cap.
    pub is_sliding: bool,
}

impl Slider {
    /// Moves `spring` (m) on by `velocity` (m/s) for `dt` (s) and gives the force; `normal` is the plane's.
    #[inline]
    #[must_use]
    pub fn pull<V: Space>(&self, spring: &mut V, velocity: V, normal: V, dt: f64) -> Pull<V> {
        let before = *spring;
        let moved = before + velocity * dt;
        let mut after = moved - normal * moved.dot(normal);
        let drag = velocity * -self.drag;
        let mut force = after * -self.stiffness + drag;
        let squared = force.length_squared();
        let is_sliding = squared > self.cap * self.cap;
        if is_sliding {
            force = force * (self.cap / squared.sqrt());
            after = (force - drag) / -self.stiffness;
        }
        *spring = after;
        let lost = 0.5 * self.stiffness * (before + after).dot(moved - after);
        Pull { force, drag, lost, is_sliding }
    }
}

/// What is lost with a spring of this stiffness (N/m) that is gone after a step in which it had this velocity, J.
pub(super) fn lost_at_the_end<V: Space>(stiffness: f64, spring: V, velocity: V, dt: f64) -> f64 {
    0.5 * stiffness * spring.dot(spring + velocity * dt)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::space::Solid;

    const SLIDER: Slider = Slider { stiffness: 1e4, drag: 3.0, cap: 2.0 };

    #[test]
    fn it_sticks_below_the_cap_and_slides_at_it() {
        let mut spring = Solid::ZERO;
        let stuck = SLIDER.pull(&mut spring, Solid::X * 0.1, Solid::Z, 1e-3);
        assert!(!stuck.is_sliding && spring.distance(Solid::X * 1e-4) < 1e-19);
        assert!(stuck.force.distance(Solid::X * -1.3) < 1e-15, "{}", stuck.force);
        let slid = SLIDER.pull(&mut spring, Solid::X * 0.5, Solid::Z, 1e-3);
        assert!(slid.is_sliding && (slid.force + Solid::X * 2.0).length() < 1e-15);
        // The spring carries what the dashpot does not: 2.0 = 1e4 S + 3 x 0.5.
        assert!((spring.x - 5e-5).abs() < 1e-18, "{}", spring.x);
    }

    #[test]
    fn energy_taken_is_energy_stored_and_lost() {
        // Back and forth and sideways in a fixed plane: the work of the spring force by the trapezoidal rule.
        let (mut spring, mut taken, mut lost, dt) = (Solid::ZERO, 0.0, 0.0, 1e-3);
        let mut before = Solid::ZERO;
        for step in 0..400 {
            let angle = 0.02 * f64::from(step);
            let velocity = Solid::new(0.6 * angle.sin(), 0.2 * (2.0 * angle).cos(), 0.0);
            let pull = SLIDER.pull(&mut spring, velocity, Solid::Z, dt);
            let elastic = pull.force - pull.drag;
            taken -= 0.5 * dt * (before + elastic).dot(velocity);
            before = elastic;
            lost += pull.lost;
        }
        let stored = 0.5 * SLIDER.stiffness * spring.length_squared();
        // 400 roundings of sums of up to 0.1 J.
        assert!((taken - stored - lost).abs() < 400.0 * 0.1 * f64::EPSILON && lost > 0.0, "{taken} {stored} {lost}");
    }

    #[test]
    fn the_spring_turns_with_the_plane() {
        let mut spring = Solid::new(1e-5, 1e-5, 0.0);
        let _ = SLIDER.pull(&mut spring, Solid::ZERO, Solid::X, 1e-3);
        assert_eq!(spring, Solid::new(0.0, 1e-5, 0.0));
    }
}
