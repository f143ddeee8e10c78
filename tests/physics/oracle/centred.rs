//! The forces of a contact under the centred scheme, as the docs of `siloflow::contact::centred` have it.
//!
//! With h = dt/2, u the closing speed in the middle of the step, w = h |u|, overlap delta now and delta_t = delta - dt u before:
//!
//! * a contact acts where delta + w > 0; its drag is the mean of c over delta - w to delta + w, for a constant c theta c with
//!   theta = clamp((delta + w)/(2 w), 0, 1);
//! * that drag sees u_now = (u + h A + h (F_t - F)/m' + h D_t/m)/(1 + h c_mean/m): A the closing acceleration of the step before, F and
//!   F_t the spring now and before, D_t = max(F_t + c_mean,t (u - h A), floor) - F_t, 1/m' of those of the two alone that had at most
//!   one contact;
//! * friction and rolling resistance are sliders ([`slide`]) whose springs gather from the event of this step on: the moment in which
//!   the contact opened, or in which the whole normal force, without theta, changed its sign.

use crate::oracle::law::{Normal, Rolling, Terms};
use crate::oracle::plain::{Action, Meeting, Memory, adapt, rolling_drag};
use crate::oracle::vector::V;

/// What velocities gain in half a step by the forces of its beginning, and how forces move the two.
#[derive(Clone, Copy, Debug)]
pub struct VelocityPrediction {
    /// h (a_i - a_j), m/s.
    pub velocity: V,
    /// h times the angular accelerations, rad/s.
    pub spins: [V; 2],
    /// 1/m and 1/I of i and j; 0 of what is fixed.
    pub inverse_masses: [f64; 2],
    pub inverse_inertias: [f64; 2],
    /// Whether i and j had at most one contact at the beginning of the step.
    pub lone: [bool; 2],
}

impl VelocityPrediction {
    /// h times the sum of what is given for i and j; and times that of those with at most one contact.
    fn halves(&self, dt: f64, of: [f64; 2]) -> [f64; 2] {
        let alone = |side: usize| if self.lone[side] { of[side] } else { 0.0 };
        [0.5 * dt * (of[0] + of[1]), 0.5 * dt * (alone(0) + alone(1))]
    }
}

/// The step along the normal.
#[derive(Clone, Copy)]
struct Stroke {
    /// u, m/s.
    closing: f64,
    /// w, m.
    half_width: f64,
    /// delta and delta_t.
    overlaps: [f64; 2],
}

impl Stroke {
    fn share(&self, overlap: f64) -> f64 {
        if overlap >= self.half_width {
            return 1.0;
        }
        ((overlap + self.half_width) / (2.0 * self.half_width)).clamp(0.0, 1.0)
    }

    /// c_mean now and before.
    fn mean_drags(&self, terms: &Terms, meeting: &Meeting) -> [f64; 2] {
        let (w, drag) = (self.half_width, |overlap| terms.drag(meeting.reduced, overlap));
        if !terms.law.is_hertz() {
            return self.overlaps.map(|overlap| drag(0.0) * self.share(overlap));
        }
        let overlap = self.overlaps[0];
        if overlap >= 8.0 * w {
            // Deep in a contact the law takes the first term of the mean's series, for the step before too.
            return [drag(overlap) * (1.0 - (w / overlap).powi(2) / 32.0); 2];
        }
        // c goes as delta^(1/4).
        let integral = |overlap: f64| if overlap > 0.0 { 0.8 * drag(overlap) * overlap } else { 0.0 };
        self.overlaps.map(|overlap| (integral(overlap + w) - integral(overlap - w)) / (2.0 * w))
    }
}

/// A moment in a step: how long before its end (s), the normal force (N), and whether the contact opened.
#[derive(Clone, Copy)]
struct Event {
    ago: f64,
    force: f64,
    opens: bool,
}

/// What sliders need to know of the normal force.
#[derive(Clone, Copy)]
struct NormalLoad {
    /// As it stands, N.
    whole: f64,
    /// Averaged: before and now, N.
    averaged: [f64; 2],
    /// theta before and now.
    shares: [f64; 2],
    event: Option<Event>,
    /// For how long springs gather, s.
    gathering: f64,
    dt: f64,
}

/// How a slider moves: its velocity in the middle, what that gains (m/s), h over its masses (s/kg), and its spring's force before (N).
#[derive(Clone, Copy)]
struct Motion {
    middle: V,
    gained: V,
    halves: [f64; 2],
    pulled: V,
}

/// The action of a contact, if it acts; what it remembers moves on by `dt`.
pub fn centred(
    terms: &Terms,
    meeting: &Meeting,
    ahead: &VelocityPrediction,
    memory: &mut Memory,
    dt: f64,
) -> Option<Action> {
    let closing = -meeting.velocity.dot(meeting.normal);
    let half_width = 0.5 * dt * closing.abs();
    let stroke = Stroke { closing, half_width, overlaps: [meeting.overlap, meeting.overlap - dt * closing] };
    if meeting.overlap + half_width <= 0.0 {
        return None;
    }
    if let Normal::Assignment { .. } = terms.law.normal {
        return Some(assignment(terms, meeting, ahead, &stroke, dt));
    }
    let [half, half_lone] = ahead.halves(dt, ahead.inverse_masses);
    let [spring, spring_before] = stroke.overlaps.map(|overlap| terms.spring(meeting.reduced, overlap));
    let [mean, mean_before] = stroke.mean_drags(terms, meeting);
    let gained = -ahead.velocity.dot(meeting.normal);
    let before = (spring_before + mean_before * (closing - gained)).max(terms.floor());
    let foreseen = closing + gained + half_lone * (spring_before - spring) + half * (before - spring_before);
    let now = foreseen / (1.0 + half * mean);
    let total = (spring + mean * now).max(terms.floor());
    let drag = terms.drag(meeting.reduced, meeting.overlap);
    let whole = (spring + drag * now).max(terms.floor());
    let mut load = NormalLoad {
        whole,
        averaged: [before, total],
        shares: [stroke.share(stroke.overlaps[1]), stroke.share(stroke.overlaps[0])],
        event: None,
        gathering: if meeting.overlap > 0.0 { dt } else { 0.0 },
        dt,
    };
    if meeting.overlap > 0.0 {
        let earlier = (spring_before + drag * (closing - gained)).max(terms.floor());
        load.event = event(terms, meeting, &stroke, memory, [gained, half * before], [earlier, whole], dt);
        load.gathering = load.event.map_or(dt, |event| event.ago);
    }
    Some(turn(terms, meeting, ahead, memory, &load, drag))
}

/// The assignment's law: the same with vectors, for its drag acts on the whole velocity.
fn assignment(terms: &Terms, meeting: &Meeting, ahead: &VelocityPrediction, stroke: &Stroke, dt: f64) -> Action {
    let [half, half_lone] = ahead.halves(dt, ahead.inverse_masses);
    let [spring, spring_before] = stroke.overlaps.map(|overlap| terms.spring(meeting.reduced, overlap));
    let [drag, drag_before] = stroke.mean_drags(terms, meeting);
    let pushed = meeting.normal * (half_lone * (spring - spring_before));
    let dragged = (meeting.velocity - ahead.velocity) * (half * drag_before);
    let now = (meeting.velocity + ahead.velocity + pushed + dragged) * (1.0 / (1.0 + half * drag));
    Action { force: meeting.normal * spring - now * drag, torques: [V::default(); 2] }
}

/// What happened within the step to a contact that overlaps: `gains` are what the closing speed gains by all forces and what it has
/// gained by the contact's own; `forces` are the whole normal forces before and now.
fn event(
    terms: &Terms,
    meeting: &Meeting,
    stroke: &Stroke,
    memory: &Memory,
    gains: [f64; 2],
    forces: [f64; 2],
    dt: f64,
) -> Option<Event> {
    let [gained, own] = gains;
    let before = stroke.overlaps[1];
    // A contact that holds nothing and whose last overlap is less than one step has begun in this one.
    let holds_nothing = terms.has_spring() && memory.spring == V::default();
    if before <= 0.0 || holds_nothing && before < dt * stroke.closing {
        let ago = dt.min(meeting.overlap / stroke.closing);
        // Its own averaged force has acted before its time.
        let speed = stroke.closing + (gained + own) * (1.0 - 2.0 * ago / dt) + 2.0 * own;
        let force = (terms.drag(meeting.reduced, 0.0) * speed).max(terms.floor());
        return Some(Event { ago, force, opens: true });
    }
    let [earlier, whole] = forces;
    (earlier * whole < 0.0).then(|| Event { ago: dt * whole / (whole - earlier), force: 0.0, opens: false })
}

/// Friction and rolling resistance.
fn turn(
    terms: &Terms,
    meeting: &Meeting,
    ahead: &VelocityPrediction,
    memory: &mut Memory,
    load: &NormalLoad,
    drag: f64,
) -> Action {
    let (levers, spins) = (meeting.levers(terms.law.at_point), meeting.spins);
    let (mut friction, mut rolling) = (V::default(), V::default());
    if let Some([stiffness, damping, mu]) = terms.tangential(meeting.reduced, meeting.overlap, drag) {
        let mobility = |side: usize| ahead.inverse_masses[side] + levers[side].powi(2) * ahead.inverse_inertias[side];
        let mut motion = Motion {
            middle: meeting.sliding(meeting.velocity, spins, levers),
            gained: meeting.sliding(ahead.velocity, ahead.spins, levers),
            halves: ahead.halves(load.dt, [mobility(0), mobility(1)]),
            pulled: memory.spring * -stiffness,
        };
        let mut load = *load;
        if terms.stiffness_varies() {
            let before = memory.stiffness;
            motion.pulled = memory.spring * -before;
            load.gathering *= mean_stiffness(before, stiffness);
            // Where a contact opens it has neither stiffness nor drag.
            load.event = load.event.filter(|_| before > 0.0);
            adapt(memory, stiffness);
        }
        friction = slide(&mut memory.spring, [stiffness, damping, mu], &motion, &load, meeting.normal);
    }
    if let Some(Rolling { k, damping, mu }) = terms.law.rolling {
        let mobilities = ahead.inverse_inertias.map(|inverse| meeting.reduced.radius.powi(2) * inverse);
        let motion = Motion {
            middle: meeting.rolling(spins),
            gained: meeting.rolling(ahead.spins),
            halves: ahead.halves(load.dt, mobilities),
            pulled: memory.rolling * -k,
        };
        let numbers = [k, rolling_drag(damping, meeting.reduced), mu];
        rolling = slide(&mut memory.rolling, numbers, &motion, load, meeting.normal);
    }
    meeting.act(load.averaged[1], friction, levers, rolling)
}

/// The mean stiffness of a step over that of its end; from nothing it grows like the root of time.
fn mean_stiffness(before: f64, now: f64) -> f64 {
    if before >= now {
        1.0
    } else if before > 0.0 {
        0.5 + 0.5 * before / now
    } else {
        2.0 / 3.0
    }
}

/// Moves a slider on and gives its averaged force.
///
/// The velocity of the end is solved for in the slider's own dashpot; the force is cut at the cap of the contact as it stands, weighed
/// with theta, and cut at the cap of the averaged normal force. Beyond the first cap S = -(F + c v)/k.
fn slide(spring: &mut V, [k, c, mu]: [f64; 3], motion: &Motion, load: &NormalLoad, normal: V) -> V {
    let Motion { middle, gained, halves: [half, half_lone], .. } = *motion;
    let [share_before, share] = load.shares;
    let pulled = motion.pulled * share_before;
    let (earlier, _) = (pulled - (middle - gained) * (c * share_before)).cut(mu * load.averaged[0].abs());
    let loaded = |force: V, velocity: V, otherwise: V| {
        if k > 0.0 { (force + velocity * c) * (-1.0 / k) } else { otherwise }
    };
    let mut began = *spring;
    if let Some(Event { ago, force, opens }) = load.event {
        let own = if opens { earlier * half } else { V::default() };
        let then = middle + (gained - own) * (1.0 - 2.0 * ago / load.dt) - own * 2.0;
        let (force, is_beyond) = (*spring * -k - then * c).cut(mu * force.abs());
        if is_beyond {
            began = loaded(force, then, *spring);
        }
    }
    let mut after = (began + middle * load.gathering).across(normal);
    let elastic = after * -k;
    let foreseen = middle + gained - (earlier - pulled) * half + (elastic * share - pulled) * half_lone;
    let end = foreseen * (1.0 / (1.0 + half * share * c));
    let (whole, is_beyond) = (elastic - end * c).cut(mu * load.whole.abs());
    if load.gathering <= 0.0 {
        after = V::default();
    } else if is_beyond {
        after = loaded(whole, middle + gained + (whole * share - earlier) * half_lone, after);
    }
    *spring = after;
    (whole * share).cut(mu * load.averaged[1].abs()).0
}
