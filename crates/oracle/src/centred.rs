//! Forces of a contact under the centred scheme, as documented in `siloflow::dem::contact::centred`.
//!
//! Most contacts of a bed act by `plain` with velocities v + beta h a, predicted for the end of the step, and with springs
//! stored half a step ahead. A contact takes the averaged force below if its overlap is less than 3 w (8 w for Hertz's
//! law), with w from the predicted velocity, or if one of its particles is lone: contacts are counted in every
//! eighth step, and a particle is lone from a count without contact, or from the start, until a count of two. A gap acts only
//! if it is also less than 1.25 h |v_n| with the predicted velocity.
//!
//! With h = dt/2, closing speed u in the middle of the step, w = h |u|, current overlap delta and previous overlap
//! delta_t = delta - dt u:
//!
//! * A contact acts where delta + w > 0. Its damping coefficient is the mean of c over delta - w to delta + w. For
//!   constant c that is theta c with theta = clamp((delta + w)/(2 w), 0, 1).
//! * The damping uses u_now = (u + h A + h (F_t - F)/m' + h D_t/m)/(1 + h c_mean/m). A is the closing acceleration of
//!   the step before; F and F_t are the current and previous spring force. D_t = max(F_t + c_mean,t (u - h A), floor) -
//!   F_t. 1/m' sums 1/m over the lone particles.
//! * Friction and rolling resistance are sliders (`slide`). Their springs accumulate displacement from the event of
//!   this step on. The event is the moment at which the contact opened, or at which the full normal force, without
//!   theta, changed sign.
//! * A momentum along the normal at a clump changes its sliding velocity, too (`Pushed`). A slip that turns is along the mean direction (`slipped`).
//! * If the normal force, as a linear function of time, falls to zero before now + h, a slider that sticks until then acts
//!   only before this moment (`Unloading`).

use crate::law::{Normal, Rolling, RollingKind, Terms};
use crate::plain::{Action, Memory, PairState, Times, UP, adapt, mean_of, plain};
use crate::vector::V;

/// Velocity change of both particles in half a step by the forces of its beginning, and their mobilities.
#[derive(Clone, Copy, Debug, Default)]
pub struct VelocityPrediction {
    /// h (a_i - a_j), m/s.
    pub velocity: V,
    /// h times the angular accelerations, rad/s.
    pub spins: [V; 2],
    /// 1/m and 1/I of i and j; 0 for a fixed particle.
    pub inverse_masses: [f64; 2],
    pub inverse_inertias: [f64; 2],
    /// Whether i and j are lone.
    pub lone: [bool; 2],
    /// Additions of clumps to these numbers.
    pub pushed: Pushed,
}

/// Changes of motion by a momentum along the normal on i, and the opposite one on j, at a contact of clumps, beyond those at a contact of spheres.
#[derive(Clone, Copy, Debug, Default)]
pub struct Pushed {
    /// Changes of the relative velocity of the spheres' centres by the turn of i and of j, 1/kg.
    pub velocities: [V; 2],
    /// Changes of the spins, 1/(kg m).
    pub spins: [V; 2],
    /// The mobilities of a momentum along the sliding velocity, less 1/m + R^2/I of the sphere, 1/kg.
    pub mobilities: [f64; 2],
}

impl VelocityPrediction {
    /// Returns h times the sum of the two values, and h times the sum over the lone particles.
    fn halves(&self, dt: f64, of: [f64; 2]) -> [f64; 2] {
        let alone = |side: usize| if self.lone[side] { of[side] } else { 0.0 };
        [0.5 * dt * (of[0] + of[1]), 0.5 * dt * (alone(0) + alone(1))]
    }
}

impl VelocityPrediction {
    /// Returns what `velocity` makes of the velocities and spins of a momentum along the normal: of both particles, and of the lone ones.
    fn pushed(&self, velocity: impl Fn(V, [V; 2]) -> V) -> [V; 2] {
        let of = |counts: [bool; 2]| {
            let counted = |side: usize, change: V| if counts[side] { change } else { V::default() };
            let [i, j] = self.pushed.velocities;
            let [w_i, w_j] = self.pushed.spins;
            velocity(counted(0, i) + counted(1, j), [counted(0, w_i), counted(1, w_j)])
        };
        [of([true; 2]), of(self.lone)]
    }
}

/// Motion along the normal in this step.
#[derive(Clone, Copy)]
struct NormalMotion {
    /// u, m/s.
    closing: f64,
    /// w, m.
    half_width: f64,
    /// delta and delta_t, m. For a contact that exists beyond touch they count from where it breaks.
    overlaps: [f64; 2],
    /// The range beyond touch, m, of a contact that exists.
    range: f64,
}

impl NormalMotion {
    /// Returns the overlap at which the law is evaluated.
    fn at(&self, overlap: f64) -> f64 {
        overlap.max(0.0) - self.range
    }

    fn share(&self, overlap: f64) -> f64 {
        if overlap >= self.half_width {
            return 1.0;
        }
        ((overlap + self.half_width) / (2.0 * self.half_width)).clamp(0.0, 1.0)
    }

    /// Returns c_mean of now and of the step before, N s/m.
    fn mean_drags(&self, terms: &Terms, pair_state: &PairState) -> [f64; 2] {
        let w = self.half_width;
        let drag = |overlap| terms.drag(pair_state.reduced, overlap);
        if terms.reaches() && self.overlaps[0] >= 16.0 * w {
            return [drag(self.at(self.overlaps[0])); 2];
        }
        if !terms.law.is_hertz() {
            return self.overlaps.map(|overlap| drag(self.at(overlap)) * self.share(overlap));
        }
        let overlap = self.overlaps[0];
        if overlap >= 8.0 * w {
            // Deep in a contact the law uses the first term of the series of the mean, for the step before too.
            return [drag(overlap) * (1.0 - (w / overlap).powi(2) / 32.0); 2];
        }
        // c is proportional to delta^(1/4).
        let integral = |overlap: f64| if overlap > 0.0 { 0.8 * drag(overlap) * overlap } else { 0.0 };
        self.overlaps.map(|overlap| (integral(overlap + w) - integral(overlap - w)) / (2.0 * w))
    }
}

/// An event within a step: its time before the end of the step (s), the normal force (N), and whether the contact
/// opened.
#[derive(Clone, Copy)]
struct Event {
    ago: f64,
    force: f64,
    /// The force per closing speed, N s/m.
    drag: f64,
    opens: bool,
}

/// Normal load of a contact as the sliders need it.
#[derive(Clone, Copy)]
struct NormalLoad {
    /// Current force without averaging, N.
    whole: f64,
    /// Averaged force before and now, N.
    averaged: [f64; 2],
    /// Averaged pull, which is not part of these forces, N.
    pull: f64,
    /// theta before and now.
    shares: [f64; 2],
    /// c_mean before and now, N s/m.
    mean_drags: [f64; 2],
    is_hertz: bool,
    event: Option<Event>,
    unloading: Option<Unloading>,
    /// Time during which springs accumulate displacement, s.
    accumulation_time: f64,
    dt: f64,
    /// Time by which springs are stored ahead of the evaluation, s.
    lead: f64,
}

/// The end of the normal force in the step centred on now.
#[derive(Clone, Copy)]
struct Unloading {
    /// Time from now - h to the end of the force, s.
    lasts: f64,
    /// Overlap in the middle of this time, m.
    overlap: f64,
    /// Loss of normal force per time, N/s.
    rate: f64,
}

/// Motion of a slider: its velocity in the middle of the step and its gain (m/s), h over its masses (s/kg), and its
/// previous spring force (N).
#[derive(Clone, Copy)]
struct Motion {
    middle: V,
    gained: V,
    halves: [f64; 2],
    pulled: V,
    /// c_mean of the slider before and now, N s/m, and the shares by which its spring force counts.
    mean_drags: [f64; 2],
    spring_shares: [f64; 2],
    /// Stiffness (N/m) and damping (N s/m) at the overlap of the unloading.
    unloaded: [f64; 2],
    /// Changes of the velocity by a momentum along the normal, 1/kg: of both particles, and of the lone ones.
    pushed: [V; 2],
}

/// Returns the action of a contact, or `None` if it does not act. Advances its memory by `dt`.
pub fn centred(
    terms: &Terms,
    pair_state: &PairState,
    ahead: &VelocityPrediction,
    memory: &mut Memory,
    [dt, lead]: [f64; 2],
) -> Option<Action> {
    let closing = -pair_state.velocity.dot(pair_state.normal);
    let half_width = 0.5 * dt * closing.abs();
    let exists = memory.stiffness > 0.0;
    let range = if exists { terms.range(pair_state.reduced) } else { 0.0 };
    let overlap = pair_state.overlap + range;
    let normal_motion = NormalMotion { closing, half_width, overlaps: [overlap, overlap - dt * closing], range };
    if overlap + half_width <= 0.0 {
        return None;
    }
    if let Normal::Assignment { .. } = terms.law.normal {
        return Some(assignment(terms, pair_state, ahead, &normal_motion, dt));
    }
    let [half, half_lone] = ahead.halves(dt, ahead.inverse_masses);
    let [spring, spring_before] =
        normal_motion.overlaps.map(|overlap| terms.spring(pair_state.reduced, normal_motion.at(overlap)));
    let mean_spring_of = |step: usize| {
        let overlap = normal_motion.overlaps[step];
        if !terms.reaches() || normal_motion.overlaps[0] >= 16.0 * half_width {
            return [spring, spring_before][step];
        }
        let ends = [overlap - half_width, overlap + half_width].map(|overlap| normal_motion.at(overlap));
        let share = normal_motion.share(overlap);
        share * terms.mean_spring(pair_state.reduced, ends) + terms.pull(pair_state.reduced, overlap, share)
    };
    let [mean_spring, mean_spring_before] = [0, 1].map(mean_spring_of);
    let [mean, mean_before] = normal_motion.mean_drags(terms, pair_state);
    let [pull, pull_before] =
        normal_motion.overlaps.map(|overlap| terms.pull(pair_state.reduced, overlap, normal_motion.share(overlap)));
    let gained = -ahead.velocity.dot(pair_state.normal);
    let before = (mean_spring_before + mean_before * (closing - gained)).max(terms.floor());
    let predicted = closing
        + gained
        + half_lone * (mean_spring_before - pull_before - mean_spring + pull)
        + half * (before - mean_spring_before);
    let now = predicted / (1.0 + half * mean);
    let total = (mean_spring + mean * now).max(terms.floor());
    let drag = terms.drag(pair_state.reduced, normal_motion.at(overlap));
    let whole = (spring + drag * now).max(terms.floor());
    let mut load = NormalLoad {
        whole,
        averaged: [before, total],
        pull,
        shares: [normal_motion.share(normal_motion.overlaps[1]), normal_motion.share(normal_motion.overlaps[0])],
        mean_drags: [mean_before, mean],
        is_hertz: terms.law.is_hertz(),
        event: None,
        unloading: None,
        accumulation_time: if overlap > 0.0 { dt } else { 0.0 },
        dt,
        lead,
    };
    let at_before = normal_motion.at(normal_motion.overlaps[1]);
    let earlier = spring_before + terms.drag(pair_state.reduced, at_before) * (closing - gained);
    if overlap > 0.0 {
        let forces = [earlier.max(terms.floor()), whole];
        load.event = event(terms, pair_state, &normal_motion, memory, [gained, half * before], forces, dt);
        load.accumulation_time = load.event.map_or(dt, |event| event.ago);
    }
    // The load of a contact beyond touch does not fall to zero before it breaks.
    if !terms.reaches() && !begins_now(terms, &normal_motion, memory, dt) {
        let [later, time] = if pair_state.overlap > 0.0 {
            [spring + drag * now, dt]
        } else {
            [terms.drag(pair_state.reduced, 0.0) * (closing + gained), normal_motion.overlaps[1] / -closing]
        };
        load.unloading = unloading([earlier, later], time, &normal_motion, dt);
    }
    let action = turn(terms, pair_state, ahead, memory, &load, (drag, normal_motion.at(overlap)));
    if terms.reaches() && !exists && overlap <= 0.0 {
        // It forms after this evaluation.
        *memory = Memory::default();
    }
    Some(action)
}

/// Returns the action of a contact at the start of the run, averaged over the first half step `half` (s): the spring acts as
/// it is, drag and friction with their mean over the part of the half step in which there is a contact.
/// Springs are stored `lead` (s) ahead.
pub fn start(terms: &Terms, pair_state: &PairState, memory: &mut Memory, [half, lead]: [f64; 2]) -> Option<Action> {
    let times = Times { dt: lead, lead, is_centred: true };
    let moved = -half * pair_state.velocity.dot(pair_state.normal);
    let low = pair_state.overlap.min(pair_state.overlap + moved);
    let high = pair_state.overlap.max(pair_state.overlap + moved);
    if high <= 0.0 {
        return None;
    }
    let begin = PairState { overlap: pair_state.overlap.max(0.0), ..*pair_state };
    if terms.reaches() {
        // The force at touch acts in the share of the half step after it.
        return Some(if pair_state.overlap > 0.0 {
            plain(terms, [pair_state; 2], memory, times)
        } else {
            let share = (high / moved.abs()).min(1.0);
            let touching = plain(terms, [&begin; 2], &mut Memory::default(), times);
            Action { force: touching.force * share, torques: touching.torques.map(|torque| torque * share) }
        });
    }
    let mut action = plain(terms, [&begin; 2], memory, times);
    if moved != 0.0 {
        let normal = pair_state.normal;
        let pull = |overlap: f64| terms.pull(pair_state.reduced, overlap, 1.0);
        let spring = |overlap: f64| normal * (terms.spring(pair_state.reduced, overlap) - pull(overlap));
        let low = low.max(0.0);
        let share = (high / moved.abs()).min(1.0);
        let missing = normal * ((1.0 - share) * pull(begin.overlap));
        action = Action { force: spring(begin.overlap) + missing, torques: [V::default(); 2] };
        // Gauss's rule in the fourth root of the rise of the overlap.
        let root = 0.6_f64.sqrt();
        for (node, weight) in [(0.5 - 0.5 * root, 5.0), (0.5, 8.0), (0.5 + 0.5 * root, 5.0)] {
            let at = PairState { overlap: low + (high - low) * node.powi(4), ..*pair_state };
            let part = share * weight / 18.0 * 4.0 * node.powi(3);
            let now = plain(terms, [&at; 2], &mut Memory::default(), times);
            action.force += (now.force - spring(at.overlap)) * part;
            // The lever is that of the beginning.
            let moment = normal.cross(now.force.across(normal));
            for side in [0, 1] {
                let lever = at.levers(terms.law.at_point)[side] - begin.levers(terms.law.at_point)[side];
                action.torques[side] += (now.torques[side] + moment * lever) * part;
            }
        }
    }
    if pair_state.overlap <= 0.0 {
        *memory = Memory::default();
    }
    Some(action)
}

/// The assignment's law. Like [`centred`], but with vectors, because its damping acts on the full velocity.
fn assignment(
    terms: &Terms,
    pair_state: &PairState,
    ahead: &VelocityPrediction,
    normal_motion: &NormalMotion,
    dt: f64,
) -> Action {
    let [half, half_lone] = ahead.halves(dt, ahead.inverse_masses);
    let [spring, spring_before] = normal_motion.overlaps.map(|overlap| terms.spring(pair_state.reduced, overlap));
    let [drag, drag_before] = normal_motion.mean_drags(terms, pair_state);
    let pushed = pair_state.normal * (half_lone * (spring - spring_before));
    let dragged = (pair_state.velocity - ahead.velocity) * (half * drag_before);
    let now = (pair_state.velocity + ahead.velocity + pushed + dragged) * (1.0 / (1.0 + half * drag));
    Action { force: pair_state.normal * spring - now * drag, torques: [V::default(); 2] }
}

/// Whether a contact has begun in this step: one with an empty memory and an earlier overlap of less than one step, too.
fn begins_now(terms: &Terms, normal_motion: &NormalMotion, memory: &Memory, dt: f64) -> bool {
    if terms.reaches() {
        return memory.stiffness == 0.0;
    }
    let before = normal_motion.overlaps[1];
    let holds_nothing = terms.has_spring() && memory.spring == V::default();
    before <= 0.0 || holds_nothing && before < dt * normal_motion.closing
}

/// Returns the end of a normal force that changes from the first to the second of `forces` within `time`.
fn unloading([earlier, later]: [f64; 2], time: f64, normal_motion: &NormalMotion, dt: f64) -> Option<Unloading> {
    if earlier <= 0.0 || later >= earlier {
        return None;
    }
    let rate = (earlier - later) / time;
    let lasts = (earlier / rate - 0.5 * dt).max(0.0);
    let overlap = normal_motion.overlaps[0] - normal_motion.closing * 0.5 * (dt - lasts);
    (lasts < dt).then_some(Unloading { lasts, overlap, rate })
}

/// Returns the event of an overlapping contact within the step. `gains` are the gain of the closing speed by all forces
/// and the part of the contact's own force. `forces` are the full normal forces before and now.
fn event(
    terms: &Terms,
    pair_state: &PairState,
    normal_motion: &NormalMotion,
    memory: &Memory,
    gains: [f64; 2],
    forces: [f64; 2],
    dt: f64,
) -> Option<Event> {
    let [gained, own] = gains;
    if begins_now(terms, normal_motion, memory, dt) {
        let ago = dt.min(pair_state.overlap / normal_motion.closing);
        // The contact's own averaged force acted before the contact began.
        let speed = normal_motion.closing + (gained + own) * (1.0 - 2.0 * ago / dt) + 2.0 * own;
        let at_touch = if terms.reaches() { terms.spring(pair_state.reduced, 0.0) } else { 0.0 };
        let drag = terms.drag(pair_state.reduced, 0.0);
        let force = (at_touch + drag * speed).max(terms.floor());
        return Some(Event { ago, force, drag, opens: true });
    }
    let [earlier, whole] = forces;
    (earlier * whole < 0.0).then(|| Event { ago: dt * whole / (whole - earlier), force: 0.0, drag: 0.0, opens: false })
}

/// Evaluates friction and rolling resistance and returns the action of the contact.
fn turn(
    terms: &Terms,
    pair_state: &PairState,
    ahead: &VelocityPrediction,
    memory: &mut Memory,
    load: &NormalLoad,
    (drag, overlap): (f64, f64),
) -> Action {
    let levers = pair_state.levers(terms.law.at_point);
    let spins = pair_state.spins;
    let mut friction = V::default();
    let mut rolling = V::default();
    let mut tangential_stiffness = [memory.stiffness; 2];
    if let Some([stiffness, damping, mu]) = terms.tangential(pair_state.reduced, overlap, drag) {
        let mobility = |side: usize| {
            let of_sphere = ahead.inverse_masses[side] + levers[side].powi(2) * ahead.inverse_inertias[side];
            of_sphere + ahead.pushed.mobilities[side]
        };
        let mut motion = Motion {
            middle: pair_state.sliding(pair_state.velocity, spins, levers),
            gained: pair_state.sliding(ahead.velocity, ahead.spins, levers),
            halves: ahead.halves(load.dt, [mobility(0), mobility(1)]),
            pulled: V::default(),
            mean_drags: terms.mean_tangential_drags(pair_state.reduced, load.shares, load.mean_drags),
            spring_shares: load.shares,
            unloaded: load.unloading.map_or([0.0; 2], |unloading| {
                let [stiffness, damping, _] =
                    terms.tangential(pair_state.reduced, unloading.overlap, drag).unwrap_or_default();
                [stiffness, damping]
            }),
            pushed: ahead.pushed(|velocity, spins| pair_state.sliding(velocity, spins, levers)),
        };
        tangential_stiffness[1] = stiffness;
        if !terms.stiffness_varies() {
            tangential_stiffness[0] = stiffness;
        }
        memory.spring = at_start(memory.spring, &motion, load.lead);
        motion.pulled = memory.spring * -stiffness;
        let mut load = *load;
        if terms.stiffness_varies() {
            let before = memory.stiffness;
            motion.pulled = memory.spring * -before;
            load.accumulation_time *= mean_of(terms, before, stiffness);
            if !terms.reaches() {
                // The force of a spring whose stiffness fades with the overlap does not jump.
                motion.spring_shares = [1.0; 2];
                // Where a contact opens it has neither stiffness nor damping.
                load.event = load.event.filter(|_| before > 0.0);
            }
            adapt(memory, stiffness);
        }
        friction = slide(&mut memory.spring, [stiffness, damping, mu], &motion, &load, pair_state.normal);
    }
    if let Some(Rolling { mu, kind, .. }) = terms.law.rolling {
        let mobilities = ahead.inverse_inertias.map(|inverse| pair_state.reduced.radius.powi(2) * inverse);
        let [[k_before, _], [k, c]] =
            tangential_stiffness.map(|tangential| terms.rolling(pair_state.reduced, tangential, load.dt));
        let mut motion = Motion {
            middle: pair_state.rolling(spins),
            gained: pair_state.rolling(ahead.spins),
            halves: ahead.halves(load.dt, mobilities),
            pulled: V::default(),
            mean_drags: load.shares.map(|share| share * c),
            spring_shares: load.shares,
            unloaded: [k, c],
            pushed: ahead.pushed(|_, spins| pair_state.rolling(spins)),
        };
        let mut load = *load;
        memory.rolling = at_start(memory.rolling, &motion, load.lead);
        motion.pulled = memory.rolling * -k_before;
        if kind == RollingKind::Elastic && terms.stiffness_varies() {
            load.accumulation_time *= mean_of(terms, k_before, k);
            if !terms.reaches() {
                motion.spring_shares = [1.0; 2];
                load.event = load.event.filter(|_| k_before > 0.0);
            }
            if k > k_before {
                memory.rolling = memory.rolling * (k_before / k);
            }
        }
        rolling = slide(&mut memory.rolling, [k, c, mu], &motion, &load, pair_state.normal);
        if kind == RollingKind::Torque {
            memory.rolling = V::default();
        }
    }
    let action = pair_state.act(load.averaged[1] - load.pull, friction, levers, rolling);
    let Some(Rolling { k, damping, mu, .. }) = terms.law.twisting else { return action };
    let c = damping.drag(pair_state.reduced.mass, 0.0);
    let mobility = pair_state.reduced.radius.powi(2);
    let mut motion = Motion {
        middle: pair_state.twisting(spins),
        gained: pair_state.twisting(ahead.spins),
        halves: ahead.halves(load.dt, ahead.inverse_inertias.map(|inverse| mobility * inverse)),
        pulled: V::default(),
        mean_drags: load.shares.map(|share| share * c),
        spring_shares: load.shares,
        unloaded: [k, c],
        pushed: ahead.pushed(|_, spins| pair_state.twisting(spins)),
    };
    memory.twist = at_start(memory.twist, &motion, load.lead);
    motion.pulled = memory.twist * -k;
    let force = slide(&mut memory.twist, [k, c, mu], &motion, load, UP);
    pair_state.twist(action, force)
}

/// Returns the stretch of a spring at the beginning of the step. Springs are stored `lead` (s) ahead; a new one is empty.
fn at_start(stored: V, motion: &Motion, lead: f64) -> V {
    if stored == V::default() { stored } else { stored - (motion.middle - motion.gained) * lead }
}

/// Cuts a force at `cap`. A slip that turns it by more than rounding and less than acos 0.8 from the force `from` is along the mean of both directions.
fn slipped(force: V, cap: f64, from: V, normal: V) -> (V, bool) {
    let (along, is_beyond) = force.cut(cap);
    let [force, from] = [force, from].map(|force| force.across(normal));
    let unit = from * (1.0 / from.length());
    let component = force.dot(unit);
    let turn = component / force.length();
    if !is_beyond || from.length() == 0.0 || !(0.8..1.0 - 1e-12).contains(&turn) {
        return (along, is_beyond);
    }
    let slip = (force.dot(force) - cap * cap) / (2.0 * (cap + component));
    ((force - unit * slip) * (cap / (cap + slip)), true)
}

/// Advances a slider and returns its averaged force.
///
/// The velocity at the end of the step is solved implicitly in the slider's own dashpot. The force takes the mean damping
/// coefficient and is cut at the cap of the averaged normal force. Where the force without averaging is beyond the cap of the
/// current normal force, S = -(F + c v)/k; except with Hertz's law, this force is then cut and weighted with theta instead.
fn slide(spring: &mut V, [k, c, mu]: [f64; 3], motion: &Motion, load: &NormalLoad, normal: V) -> V {
    let Motion { middle, gained, halves: [half, half_lone], .. } = *motion;
    let [counts_before, counts] = motion.spring_shares;
    let [c_before, c_mean] = motion.mean_drags;
    let share = load.shares[1];
    let pulled = motion.pulled * counts_before;
    let (earlier, _) = (pulled - (middle - gained) * c_before).cut(mu * load.averaged[0].abs());
    let loaded = |force: V, velocity: V, otherwise: V| {
        if k > 0.0 { (force + velocity * c) * (-1.0 / k) } else { otherwise }
    };
    let held = *spring;
    let mut began = held;
    let mut from = earlier;
    if let Some(Event { ago, force, drag, opens }) = load.event {
        // Without the contact's own averaged forces of the step before, along the tangent and along the normal.
        let push = motion.pushed[0] * (0.5 * load.dt);
        let own = if opens { earlier * half + push * load.averaged[0] } else { V::default() };
        let slowed = if opens { push.dot(earlier) * (3.0 - 2.0 * ago / load.dt) } else { 0.0 };
        let then = middle + (gained - own) * (1.0 - 2.0 * ago / load.dt) - own * 2.0;
        let cap = (mu * force.abs() + mu * drag * slowed).max(0.0);
        let (force, is_beyond) = (*spring * -k - then * c).cut(cap);
        from = force;
        if is_beyond {
            began = loaded(force, then, *spring);
        }
    }
    let mut after = (began + middle * load.accumulation_time).across(normal);
    let elastic = after * -k;
    // Without the friction of this step: the normal force has changed, too.
    let free = middle + gained + motion.pushed[1] * (0.5 * load.dt * (load.averaged[1] - load.averaged[0]));
    let predicted = free - (earlier - pulled) * half + (elastic * counts - pulled) * half_lone;
    let end = predicted * (1.0 / (1.0 + half * c_mean));
    let (whole, is_beyond) = slipped(elastic - end * c, mu * load.whole.abs(), from, normal);
    if load.accumulation_time <= 0.0 {
        after = V::default();
    } else if is_beyond {
        after = loaded(whole, free + (whole * share - earlier) * half_lone, after);
    }
    let average = if is_beyond && !load.is_hertz { whole * share } else { elastic * counts - end * c_mean };
    let mut force = slipped(average, mu * load.averaged[1].abs(), from, normal).0;
    if let Some(Unloading { lasts, rate, .. }) = load.unloading {
        // The force in the middle of the time before the release, if the slider sticks, averaged over the whole step.
        let [k, c] = motion.unloaded;
        let part = lasts / load.dt;
        let ago = 0.5 * (load.dt - lasts);
        let stretch = held + middle * (load.dt - ago);
        let stuck = ((stretch * k + (middle + gained * (1.0 - 2.0 * ago / load.dt)) * c) * -part).across(normal);
        // The cap falls linearly to zero, with this mean over the step.
        let size = stuck.length();
        let cap = 0.5 * mu * rate * lasts * part;
        if size < 2.0 * cap {
            let rest = if load.event.is_some() { (share - part).max(0.0) } else { 0.0 };
            force = stuck * (1.0 - size / (4.0 * cap)) + whole * rest;
        }
    }
    // Stored ahead, with the velocity of the step's end that this force gives.
    if load.accumulation_time > 0.0 {
        after += (free + (force - earlier) * half_lone) * load.lead;
    }
    *spring = after;
    force
}
