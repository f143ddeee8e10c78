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

use crate::contact::centred::cut;
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
pub struct SliderForce<V> {
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
    #[inline(always)]
    #[must_use]
    pub fn pull<V: Space>(&self, spring: &mut V, velocity: V, normal: V, dt: f64) -> SliderForce<V> {
        let before = *spring;
        let moved = before + velocity * dt;
        let mut after = moved - normal * moved.dot(normal);
        let drag = velocity * -self.drag;
        let (is_sliding, force) = cut(after * -self.stiffness + drag, self.cap);
        if is_sliding {
            after = (force - drag) * (-1.0 / self.stiffness);
        }
        *spring = after;
        let lost = 0.5 * self.stiffness * (before + after).dot(moved - after);
        SliderForce { force, drag, lost, is_sliding }
    }
}

/// How a centred contact moves in its tangent plane during a step ([`super::centred`]).
#[derive(Clone, Copy, Debug)]
pub struct TangentialStep<V> {
    /// Velocity in the middle of the step, m/s.
    pub middle: V,
    /// What it gains until the end by the forces of the beginning, m/s.
    pub gained: V,
    /// How fast a force on the contact changes that velocity, 1/m_t, and how fast counting only grains without another
    /// contact, 1/kg.
    pub mobilities: [f64; 2],
    /// The step, s.
    pub dt: f64,
    /// What happened within it, if anything did.
    pub event: Option<Event>,
    /// For how long the spring gathers, s: from that event on; 0 across a gap.
    pub gathering: f64,
    /// The shares of the steps centred on its beginning and end in which there is a contact.
    pub shares: [f64; 2],
    /// Largest forces averaged over those steps, N; [`Slider::cap`] is that of the contact as it stands.
    pub averaged_caps: [f64; 2],
    /// The spring's force at the beginning, N.
    pub pulled: V,
}

/// A moment within a step at which the cap jumps, or is zero.
#[derive(Clone, Copy, Debug)]
pub struct Event {
    /// How long before the end of the step, s.
    pub ago: f64,
    /// The cap then, N.
    pub cap: f64,
    /// Whether the contact opens.
    pub opens: bool,
}

impl Slider {
    /// As [`Slider::pull`], with the event's place in the step, and the dashpot at the velocity of the end: solved for in
    /// this force, with all others as they were. The force is weighed with the share, and cut at the averaged cap.
    #[inline(always)]
    #[must_use]
    pub fn pull_centred<V: Space>(&self, spring: &mut V, sweep: &TangentialStep<V>, normal: V) -> SliderForce<V> {
        let TangentialStep {
            middle, gained, dt, shares: [share_before, share], averaged_caps: [cap_before, cap], ..
        } = *sweep;
        let pulled = sweep.pulled * share_before;
        let (_, earlier) = cut(pulled - (middle - gained) * (self.drag * share_before), cap_before);
        let [half, half_lone] = sweep.mobilities.map(|mobility| 0.5 * dt * mobility);
        let before = *spring;
        let swept = self.started(before, sweep, earlier * half) + middle * sweep.gathering;
        let mut after = swept - normal * swept.dot(normal);
        let elastic = after * -self.stiffness;
        let undragged = middle + gained - (earlier - pulled) * half + (elastic * share - pulled) * half_lone;
        let end = undragged * (1.0 / (1.0 + half * share * self.drag));
        let (is_beyond, whole) = cut(elastic - end * self.drag, self.cap);
        if sweep.gathering <= 0.0 {
            // Across a gap nothing is kept: what ended is gone, and what will begin begins at its event in the next step.
            after = V::ZERO;
        } else if is_beyond {
            after = self.slipped(whole, middle + gained + (whole * share - earlier) * half_lone, after);
        }
        let (is_beyond_average, force) = cut(whole * share, cap);
        *spring = after;
        // The spring's books are kept as if it pulled for the whole step; what the share takes off stands with the dashpot.
        let lost = 0.5 * self.stiffness * (before + after).dot(before + middle * dt - after);
        let drag = force + after * self.stiffness;
        SliderForce { force, drag, lost, is_sliding: is_beyond || is_beyond_average }
    }

    /// The spring that, with a dashpot at this velocity, makes a force at the cap; without stiffness, as it was.
    #[inline(always)]
    fn slipped<V: Space>(&self, force: V, velocity: V, spring: V) -> V {
        if self.stiffness > 0.0 { (force + velocity * self.drag) / -self.stiffness } else { spring }
    }

    /// The spring after the event, if there was one; `own` is what the contact's own force of the step before has gained
    /// in half a step, m/s.
    #[inline(always)]
    fn started<V: Space>(&self, spring: V, sweep: &TangentialStep<V>, own: V) -> V {
        let Some(Event { ago, cap, opens }) = sweep.event else { return spring };
        // A contact that opens only now has had that force, averaged, before its time: twice half a step of it.
        let own = if opens { own } else { V::ZERO };
        let then = sweep.middle + (sweep.gained - own) * (1.0 - 2.0 * ago / sweep.dt) - own * 2.0;
        let (is_beyond, force) = cut(spring * -self.stiffness - then * self.drag, cap);
        if is_beyond { self.slipped(force, then, spring) } else { spring }
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
