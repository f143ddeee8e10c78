//! The spring slider of a contact near an event: its force averaged over the step ([`window`](super::window)).
//!
//! The force is F = cut(-k S theta_k - C v), C being the mean of the dashpot coefficient over the step centred on the evaluation,
//! and v the velocity at the evaluation. The cap is mu times the normal force averaged over that step. A stiffness that does not
//! depend on the overlap jumps to zero where the contact opens; then theta_k is the share theta of the step in contact. A
//! stiffness that goes to zero with the overlap has theta_k = 1.
//!
//! Where the force at the evaluation is beyond its own cap, the spring is set to this cap, as in any slip. The force is then the
//! averaged cap if the normal dashpot coefficient goes to zero with the overlap, as in Hertz's law: the cap at the evaluation differs from it by
//! O(dt^(1/4)) where a contact begins. Otherwise it is theta times the force at the evaluation; the difference is O(dt) in
//! a single step, and the error a few per cent smaller in most cases.
//!
//! **Turning slip.** A slider that slips loses displacement along its force. In solid space the force may turn. Let f be the force where the slip
//! begins, p the force at the end if nothing slipped, and f' the force at the end. f' = p - l (f/|f| + f'/|f'|) loses it along the mean of
//! both directions, which is of second order; a cut of p along its own direction is of first. |f'| is the cap C, hence
//! l = (|p|^2 - C^2)/(2 (C + p.f/|f|)). Where the force turns by more than 37 degrees in a step, p is cut.
//!
//! **Release.** If the contact still sticks when the normal force reaches zero, the spring is released at that moment and F drops
//! to zero. Let s be the share of the centred step before this moment, P the force of the slider in the middle of that
//! share, and C = mu times the normal force averaged over the step. The normal force falls linearly, so that the slider sticks
//! until P is reached by the cap and slips from then on. The mean force is s P (1 - s |P|/(4 C)) for s |P| < 2 C. Otherwise
//! the slider slips during the whole share, so that there is nothing to release, and the rule above is of second order.

use crate::contact::centred::window::cut;
use crate::contact::spring::{Slider, SliderForce};
use crate::space::Space;

/// The motion of a centred contact in its tangent plane.
#[derive(Clone, Copy, Debug)]
pub struct TangentialMotion<V> {
    /// Velocity in the middle of the step, m/s.
    pub middle: V,
    /// Velocity gained from the middle to the end of the step by the forces at its beginning, m/s.
    pub gained: V,
    /// Mobilities, 1/kg: the change of the velocity per momentum that the contact transfers. First 1/m_t of the pair,
    /// then only of its lone grains.
    pub mobilities: [f64; 2],
    /// Changes of the velocity per momentum along the normal, 1/kg, of the pair and of its lone grains: zero for spheres.
    pub pushed: [V; 2],
}

impl<V: Space> TangentialMotion<V> {
    /// Returns the spring at the beginning of the step, m, from the stored spring, which is `springs_ahead` (s) ahead of it. A new
    /// contact has no spring.
    #[inline(always)]
    pub(in crate::contact) fn at_evaluation(&self, spring: V, springs_ahead: f64) -> V {
        if spring == V::ZERO { spring } else { spring - (self.middle - self.gained) * springs_ahead }
    }
}

/// The motion and the forces of a centred contact in its tangent plane during a step.
#[derive(Clone, Copy, Debug)]
pub struct TangentialStep<V> {
    /// The motion.
    pub motion: TangentialMotion<V>,
    /// Length of the step, s.
    pub dt: f64,
    /// Time by which the stored spring is ahead of the evaluation, s.
    pub springs_ahead: f64,
    /// The event within the step, if there is one.
    pub event: Option<Event>,
    /// Time during which the spring accumulates, s: the whole step, or from the event to its end, or 0 across a gap.
    pub gathering: f64,
    /// Fractions of the steps centred on the beginning and the end in which the contact exists.
    pub shares: [f64; 2],
    /// The fractions by which the spring force counts: `shares`, or 1 if the stiffness goes to zero with the overlap.
    pub spring_shares: [f64; 2],
    /// Mean dashpot coefficients of these two steps, N s/m. [`Slider::dashpot`] is the coefficient at the evaluation.
    pub mean_dashpots: [f64; 2],
    /// Caps from the normal forces averaged over these two steps, N. [`Slider::cap`] uses the normal force at the
    /// evaluation.
    pub averaged_caps: [f64; 2],
    /// The normal forces averaged over these two steps, N.
    pub averaged_loads: [f64; 2],
    /// Whether the dashpot coefficient of the normal force goes to zero with the overlap.
    pub normal_fades: bool,
    /// Spring force at the beginning, N.
    pub pulled: V,
    /// The end of the normal force in the step centred on the end, if there is one.
    pub release: Option<Release>,
}

/// A moment within a step at which the cap jumps or is zero.
#[derive(Clone, Copy, Debug)]
pub struct Event {
    /// Time from the event to the end of the step, s.
    pub ago: f64,
    /// Cap at the event, N.
    pub cap: f64,
    /// The cap at the event per closing speed, N s/m.
    pub cap_per_speed: f64,
    /// Whether the contact opens at the event.
    pub opens: bool,
}

/// The end of the normal force within the step centred on the evaluation.
#[derive(Clone, Copy, Debug)]
pub struct Release {
    /// Share of the centred step before this moment.
    pub share: f64,
    /// Time from the middle of that share to the evaluation, s.
    pub ago: f64,
    /// Stiffness (N/m) and dashpot coefficient (N s/m) in the middle of that share.
    pub modulus: [f64; 2],
    /// Cap averaged over the centred step, N.
    pub cap: f64,
}

impl Release {
    /// Returns the force averaged over the centred step, N, if the slider sticks in a part of the share. `spring` is the one
    /// at the beginning of the step, m.
    #[inline(always)]
    fn force<V: Space>(&self, spring: V, sweep: &TangentialStep<V>, normal: V) -> Option<V> {
        let [stiffness, dashpot] = self.modulus;
        let TangentialMotion { middle, gained, .. } = sweep.motion;
        let velocity = middle + gained * (1.0 - 2.0 * self.ago / sweep.dt);
        let stretch = spring + middle * (sweep.dt - self.ago);
        let stuck = (stretch * stiffness + velocity * dashpot) * -self.share;
        let stuck = stuck - normal * stuck.dot(normal);
        let size = stuck.length();
        (size < 2.0 * self.cap).then(|| stuck * (1.0 - 0.25 * size / self.cap))
    }
}

/// A slider where it begins to gather in a step.
struct Begun<V> {
    /// The spring, m.
    spring: V,
    /// The force, N.
    force: V,
}

/// Cosines of the smallest and of the largest turn of a force in a step that are treated as a turn: about 1e-6, which exceeds rounding, and 0.64.
const TURNS: [f64; 2] = [1.0 - 1e-12, 0.8];

/// Like [`cut`], for a slider whose force was `began` where it began to slip, N: it slips along the mean of the directions of both forces in the
/// tangent plane.
#[inline(always)]
fn returned<V: Space>(force: V, cap: f64, began: V, normal: V) -> (bool, V) {
    let (is_beyond, along) = cut(force, cap);
    // In the plane no force turns.
    if V::COMPONENTS == 2 || !is_beyond {
        return (is_beyond, along);
    }
    let [force, began] = [force, began].map(|force| force - normal * force.dot(normal));
    let [size, before] = [force.length(), began.length()];
    let component = force.dot(began) / before;
    let [least, most] = TURNS.map(|cosine| cosine * size);
    if !(component < least && component > most) {
        return (true, along);
    }
    let slip = 0.5 * (size * size - cap * cap) / (cap + component);
    (true, (force - began * (slip / before)) * (cap / (cap + slip)))
}

impl Slider {
    /// Like [`Slider::pull`], but takes the time of the event into account and uses the dashpot velocity at the end of
    /// the step. That velocity is solved for implicitly in this force; all other forces are lagged. The force is averaged over the
    /// step centred on the evaluation.
    #[inline(always)]
    #[must_use]
    pub fn pull_centred<V: Space>(&self, spring: &mut V, sweep: &TangentialStep<V>, normal: V) -> SliderForce<V> {
        let TangentialMotion { middle, gained, mobilities, pushed } = sweep.motion;
        let [counts_before, counts] = sweep.spring_shares;
        let [load_before, load] = sweep.averaged_loads;
        // The velocity at the end without this contact's own tangential force of this step.
        let free = middle + gained + pushed[1] * (0.5 * sweep.dt * (load - load_before));
        let [dashpot_before, dashpot] = sweep.mean_dashpots;
        let [cap_before, cap] = sweep.averaged_caps;
        let pulled = sweep.pulled * counts_before;
        let (_, earlier) = cut(pulled - (middle - gained) * dashpot_before, cap_before);
        let [half, half_lone] = mobilities.map(|mobility| 0.5 * sweep.dt * mobility);
        let before = *spring;
        let Begun { spring: held, force: began } = self.begin(before, sweep, earlier);
        let swept = held + middle * sweep.gathering;
        let mut after = swept - normal * swept.dot(normal);
        let elastic = after * -self.stiffness;
        let undamped = free - (earlier - pulled) * half + (elastic * counts - pulled) * half_lone;
        let end = undamped * (1.0 / (1.0 + half * dashpot));
        let (is_beyond, whole) = returned(elastic - end * self.dashpot, self.cap, began, normal);
        if sweep.gathering <= 0.0 {
            // Across a gap no spring is kept: an old contact has ended, and a new one starts at its event in the next
            // step.
            after = V::ZERO;
        } else if is_beyond {
            let end = free + (whole * sweep.shares[1] - earlier) * half_lone;
            after = self.spring_at_cap(whole, end, after);
        }
        let at_cap = is_beyond && !sweep.normal_fades;
        let average = if at_cap { whole * sweep.shares[1] } else { elastic * counts - end * dashpot };
        let (is_beyond_average, mut force) = returned(average, cap, began, normal);
        if let Some(release) = &sweep.release
            && let Some(stuck) = release.force(before, sweep, normal)
        {
            // With attraction the contact goes on after the event, from an empty spring.
            let rest = if sweep.event.is_some() { (sweep.shares[1] - release.share).max(0.0) } else { 0.0 };
            force = stuck + whole * rest;
        }
        let end = free + (force - earlier) * half_lone;
        *spring = if sweep.gathering > 0.0 { after + end * sweep.springs_ahead } else { after };
        // The loss is computed as if the spring pulled for the whole step; the difference of the averaged force counts as
        // dashpot force.
        let lost = 0.5 * self.stiffness * (before + after).dot(before + middle * sweep.dt - after);
        let dashpot = force + after * self.stiffness;
        SliderForce { force, dashpot, lost, is_sliding: is_beyond || is_beyond_average }
    }

    /// Returns the spring that, with a dashpot at `velocity`, gives `force` at the cap. Without stiffness it returns
    /// `spring`.
    #[inline(always)]
    fn spring_at_cap<V: Space>(&self, force: V, velocity: V, spring: V) -> V {
        if self.stiffness > 0.0 { (force + velocity * self.dashpot) / -self.stiffness } else { spring }
    }

    /// Returns how the slider begins to gather in this step, at its beginning or at the event. `earlier` is the averaged force of the previous
    /// step, N.
    #[inline(always)]
    fn begin<V: Space>(&self, spring: V, sweep: &TangentialStep<V>, earlier: V) -> Begun<V> {
        let Some(Event { ago, mut cap, cap_per_speed, opens }) = sweep.event else {
            return Begun { spring, force: earlier };
        };
        let TangentialMotion { middle, gained, mobilities, pushed } = sweep.motion;
        let left = 1.0 - 2.0 * ago / sweep.dt;
        // A contact that opens within this step has already received its averaged force before opening, over two half
        // steps. In this time friction has slowed down the approach of bodies, and the normal force has pushed them along the tangent plane.
        let mut own = V::ZERO;
        if opens {
            let half = 0.5 * sweep.dt;
            own = earlier * (half * mobilities[0]) + pushed[0] * (half * sweep.averaged_loads[0]);
            cap = (cap + cap_per_speed * (half * pushed[0].dot(earlier)) * (left + 2.0)).max(0.0);
        }
        let then = middle + (gained - own) * left - own * 2.0;
        let (is_beyond, force) = cut(spring * -self.stiffness - then * self.dashpot, cap);
        Begun { spring: if is_beyond { self.spring_at_cap(force, then, spring) } else { spring }, force }
    }
}
