//! The watchdog: stops a run whose figures mean nothing any more, and names step, grain and remedy.
//!
//! Finite values are checked in every step by [`crate::finite`]. This file watches two more things.
//!
//! * **Energy that nobody put in.** Every `every` steps, and at the end: kinetic, gravitational and part of the elastic
//!   energy, less what the books expect ([`EnergyFlows::expected`]), all in J. Velocity Verlet conserves
//!   K + (1 - q) E_elastic with q = (w0 dt)^2/4, so that a contact under way seems to gain up to q of what it holds:
//!   [`APPARENT`] of it, which is q at three quarters of the stability limit, is not counted. Drag cannot give energy back,
//!   so the largest amount ever dissipated counts as gone, and what is missing from it as created: a drag that is
//!   unstable books negative work. Unless springs hold it: a sliding contact whose dashpot alone is beyond the cap
//!   stretches its spring against it, and books what that holds as taken back. The scale is what has been put in: energy
//!   of motion and of springs of grains that entered, work of gravity, walls, belts and added forces, or
//!   expected - gravitational + dissipated, the largest so far; and what an attraction between grains has given, whose elastic energy is
//!   below zero. It does not depend on where heights count from. More
//!   than the share `energy` of it stops the run. A round-off of
//!   1e-9 sum m |g.x| is let pass. Healthy runs stay a hundred times below: looked at every 100 steps, `silo1` with its mixture
//!   and polydisperse variants, `couette`, `column`, and the first tenths of a second of `silo2d`, `chute3d` and `bed3d` create
//!   less than 1e-3 of it (`--set 'watchdog=(every: 100, energy: 1.0e-3)'` does not stop them).
//! * **Overlap beyond the law.** Every step, by the largest overlap of the force pass, over the smaller radius. Both laws
//!   are meant for small overlaps. From 0.586 (2 - sqrt 2, solid space) or 0.845 (2 - 2/sqrt 3, plane) on, equal grains in
//!   dense order touch their second neighbours through the first; at 1 the centre of a grain has reached the surface of
//!   its partner, a thin wall would push it on to the other side, and the direction of the force means nothing. That is
//!   the default limit. From 0.3 on a run warns, once. (The assignment's silo reaches 0.73, where a grain falls 4 m.)
//!
//! Limits: what a drag that is not quite unstable creates is not told from what it takes. Energy is judged as a whole, so a few wild grains among many that carry much are seen late, by their overlap or by
//! the ledger, and without books (`energy_books: false`) not at all. A behaviour that sets velocities, or fixes and frees grains, changes energy without a force, which looks
//! like growth: such a scene says `watchdog: (energy: None)`. Nothing is undone: what was written stands.

use std::marker::PhantomData;
use std::num::NonZeroU32;

use bevy_app::{App, Plugin};
use bevy_ecs::prelude::*;
use serde::{Deserialize, Serialize};

use crate::contact::{Bounce, LargestOverlap};
use crate::ending::Endings;
use crate::energy::EnergyFlows;
use crate::gravity::Gravity;
use crate::ledger::GrainsAccounted;
use crate::outcome::{End, Failure, Outcome};
use crate::particle::GrainId;
use crate::space::Space;
use crate::step::{Clock, Phase, Step};
use crate::store::register_predictable;
use crate::survey::{Partner, Survey, SurveyParam};
use crate::values::Positive;

/// The scene's `watchdog`.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct Watchdog {
    /// Steps between two looks at the energy.
    pub every: NonZeroU32,
    /// The share of the energy put in that may appear from nowhere; `None` does not look.
    pub energy: Option<Positive>,
    /// The largest overlap over the smaller radius; `None` does not look.
    pub overlap: Option<Positive>,
}

impl Default for Watchdog {
    fn default() -> Self {
        let share = |number: f64| Positive::try_from(number).ok();
        Self { every: NonZeroU32::new(500).unwrap_or(NonZeroU32::MIN), energy: share(0.1), overlap: share(1.0) }
    }
}

/// From this overlap on a run warns.
const DEEP: f64 = 0.3;

/// The share of the elastic energy that may only seem to be there: 0.75^2.
pub const APPARENT: f64 = 0.5625;

/// Of sum m |g.x|: far above the round-off of the sums, far below any energy that matters.
const ROUND_OFF: f64 = 1e-9;

/// What the watchdog remembers.
#[derive(Resource, Debug)]
struct Watch {
    every: u64,
    energy: f64,
    overlap: f64,
    /// Largest energy dissipated so far, J.
    dissipated: f64,
    /// Largest energy put in so far, J.
    put_in: f64,
    /// Largest energy that attraction of contacts has given so far, J: how far the elastic energy was below zero.
    bound: f64,
    has_warned: bool,
}

/// The energy of all grains, J.
#[derive(Clone, Copy, Debug, Default)]
struct Held {
    kinetic: f64,
    potential: f64,
    elastic: f64,
    /// Sum of m |g.x|.
    magnitude: f64,
}

impl Held {
    fn of<V: Space>(survey: &Survey<V>, gravity: V) -> Self {
        let store = survey.store;
        let mut held = Self { elastic: survey.elastic_energy(|_, _| true), ..Self::default() };
        for i in (0..store.movable_end).filter(|&i| !store.is_fixed(i)) {
            let body = &store.body[i];
            let fall = store.mass[i] * gravity.dot(body.position);
            held.kinetic += 0.5 * store.mass[i] * body.velocity.length_squared() + store.rotational_energy(i);
            held.potential -= fall;
            held.magnitude += fall.abs();
        }
        held
    }
}

impl Watch {
    /// Energy from nowhere, J, if it is too much.
    fn created(&mut self, held: &Held, flows: &EnergyFlows) -> Option<f64> {
        self.dissipated = self.dissipated.max(flows.dissipated);
        self.bound = self.bound.max(-held.elastic);
        let in_springs = held.elastic.max(0.0);
        let given_back = (self.dissipated - flows.dissipated - in_springs).max(0.0);
        let expected = flows.expected() - given_back;
        self.put_in = self.put_in.max(expected - held.potential + flows.dissipated + given_back);
        let elastic = if held.elastic > 0.0 { (1.0 - APPARENT) * held.elastic } else { held.elastic };
        let counted = held.kinetic + held.potential + elastic;
        let created = if counted - expected < given_back { given_back } else { counted - expected };
        // Written so that sums too large for a double, and their differences, are too much.
        let is_right = created <= self.energy * (self.put_in + self.bound) + ROUND_OFF * held.magnitude;
        (!is_right).then_some(created)
    }
}

impl Watch {
    /// Whether an overlap (over the smaller radius) is new to the watch.
    fn is_deep(&self, ratio: f64) -> bool {
        ratio > self.overlap || (ratio > DEEP && !self.has_warned)
    }
}

/// Run condition, and all that most steps cost: is there something to look at?
fn is_called(clock: Res<Clock>, largest: Res<LargestOverlap>, watch: Res<Watch>, outcome: Res<Outcome>) -> bool {
    clock.steps.is_multiple_of(watch.every) || watch.is_deep(largest.0) || outcome.end().is_some()
}

fn look<V: Space>(
    (clock, gravity, flows): (Res<Clock>, Res<Gravity<V>>, Option<Res<EnergyFlows>>),
    largest: Res<LargestOverlap>,
    survey_param: SurveyParam<V>,
    mut watch: ResMut<Watch>,
    mut outcome: ResMut<Outcome>,
) {
    let is_time = clock.steps.is_multiple_of(watch.every) || outcome.end().is_some();
    if matches!(outcome.end(), Some(End::Failed(_))) {
        return;
    }
    let (survey, ratio) = (survey_param.survey(), largest.0);
    if watch.is_deep(ratio) {
        watch.has_warned = true;
        if let Some(failure) = judge_overlap(&survey, &clock, ratio, watch.overlap) {
            outcome.fail(failure);
        }
    }
    if is_time
        && watch.energy < f64::INFINITY
        && let Some(flows) = flows
        && let Some(created_j) = watch.created(&Held::of(&survey, gravity.0), &flows)
        && let Some(failure) = energy_grew(&survey, &clock, created_j, watch.put_in)
    {
        outcome.fail(failure);
    }
}

/// The failure, unless nobody is there any more.
fn energy_grew<V: Space>(survey: &Survey<V>, clock: &Clock, created_j: f64, put_in_j: f64) -> Option<Failure> {
    let store = survey.store;
    let movable = (0..store.movable_end).filter(|&i| !store.is_fixed(i));
    let fastest = movable.max_by(|&a, &b| {
        let speed = |i: usize| store.body[i].velocity.length_squared();
        speed(a).total_cmp(&speed(b))
    })?;
    let speed_m_s = store.body[fastest].velocity.length();
    let (reduced_mass, reduced_radius) = (store.mass[fastest], store.body[fastest].radius);
    let stiffness = clock.dt * survey.law.frequency(&Bounce { reduced_mass, reduced_radius, speed: speed_m_s });
    let grain = store.id[fastest];
    Some(Failure::EnergyGrew { step: clock.steps, grain, speed_m_s, created_j, put_in_j, stiffness })
}

/// A failure if the overlap is beyond `limit`, else a warning.
fn judge_overlap<V: Space>(survey: &Survey<V>, clock: &Clock, ratio: f64, limit: f64) -> Option<Failure> {
    let step = clock.steps;
    let (grain, partner) = deepest(survey)?;
    if ratio > limit {
        let remedy = if clock.is_step_zero() {
            "they start like that: move them apart"
        } else {
            "stiffen the contacts, lower `step`, or let grains fall less far"
        };
        return Some(Failure::TooDeep { step, grain, partner, ratio, limit, remedy });
    }
    tracing::warn!(
        "step {step}: {grain} and {partner} overlap by {ratio:.2} of the smaller radius; the contact law is meant for \
         small overlaps"
    );
    None
}

/// The deepest contact as it stands: its grain, and its partner in words.
fn deepest<V: Space>(survey: &Survey<V>) -> Option<(GrainId, String)> {
    let (mut deepest, mut who) = (0.0, None);
    survey.contacts(|i, partner, pair, _| {
        let ratio = pair.overlap / pair.radii[0].min(pair.radii[1]);
        if ratio > deepest {
            (deepest, who) = (ratio, Some((i, partner)));
        }
    });
    let store = survey.store;
    who.map(|(i, partner)| match partner {
        Partner::Particle(j) => (store.id[i], store.id[j].to_string()),
        Partner::Wall(_) => (store.id[i], "a flat wall".to_owned()),
    })
}

/// Watches energy and overlap.
pub struct WatchdogPlugin<V: Space>(pub Watchdog, pub PhantomData<V>);

impl<V: Space> Plugin for WatchdogPlugin<V> {
    fn build(&self, app: &mut App) {
        let Watchdog { every, energy, overlap } = self.0;
        let limit = |share: Option<Positive>| share.map_or(f64::INFINITY, Positive::get);
        app.insert_resource(Watch {
            every: u64::from(every.get()),
            energy: limit(energy),
            overlap: limit(overlap),
            dissipated: 0.0,
            put_in: 0.0,
            bound: 0.0,
            has_warned: overlap.is_none(),
        });
        // After the books of the step are closed, and before the end of the run is written.
        app.add_systems(Step, look::<V>.in_set(Phase::Cull).after(GrainsAccounted).after(Endings).run_if(is_called));
        register_predictable(app, is_called, is_called);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn fresh() -> Watch {
        Watch { every: 100, energy: 0.1, overlap: 1.0, dissipated: 0.0, put_in: 0.0, bound: 0.0, has_warned: false }
    }

    fn held(kinetic: f64, potential: f64) -> Held {
        Held { kinetic, potential, elastic: 0.0, magnitude: potential.abs() }
    }

    #[test]
    fn only_energy_that_nobody_put_in_counts() {
        // 2 J of motion enter at 10 J of height and fall to 4 J: 8 J have been put in, and K may be 8 J and a tenth.
        let flows = EnergyFlows { released: 12.0, ..EnergyFlows::default() };
        assert_eq!(fresh().created(&held(8.7, 4.0), &flows), None);
        let created = fresh().created(&held(8.9, 4.0), &flows).expect("too much");
        // Three sums of numbers around 10.
        assert!((created - 0.9).abs() < 1e-14, "{created}");
        // Of what springs seem to hold, 0.4375 is certain: 1.75 J of 4 J.
        let springs = |kinetic: f64| Held { elastic: 4.0, ..held(kinetic, 4.0) };
        assert_eq!(fresh().created(&springs(7.0), &flows), None);
        assert!(fresh().created(&springs(7.1), &flows).is_some());
        // Less than there should be is lost.
        assert_eq!(fresh().created(&held(1.0, 4.0), &flows), None);
        // A wall that works puts energy in.
        assert_eq!(fresh().created(&held(8.9, 4.0), &EnergyFlows { wall_work: 1.0, ..flows }), None);
    }

    #[test]
    fn drag_cannot_give_energy_back() {
        let mut watch = fresh();
        let flows = |dissipated: f64| EnergyFlows { released: 2.0, dissipated, ..EnergyFlows::default() };
        assert_eq!(watch.created(&held(1.0, 0.0), &flows(1.0)), None);
        // The books balance, 2 J = 1.5 J + 0.5 J, because an unstable drag has taken back what it dissipated.
        assert!(watch.created(&held(1.5, 0.0), &flows(0.5)).is_some());
        // Wherever that energy is now.
        assert_eq!(watch.created(&held(0.0, 0.0), &flows(0.5)), Some(0.5));
        // A spring that a sliding dashpot has stretched will give it to the drag again.
        assert_eq!(watch.created(&Held { elastic: 0.5, ..held(1.0, 0.0) }, &flows(0.5)), None);
    }

    #[test]
    fn grains_that_attract_each_other_may_be_bound() {
        let bound = |kinetic: f64, elastic: f64| Held { elastic, ..held(kinetic, 0.0) };
        let mut watch = fresh();
        // They start 1 J below zero, and move with what the attraction gives.
        let flows = EnergyFlows { released: -1.0, ..EnergyFlows::default() };
        assert_eq!(watch.created(&bound(0.0, -1.0), &flows), None);
        assert_eq!(watch.created(&bound(1.0, -2.0), &flows), None);
        assert_eq!(watch.created(&bound(1.1, -2.0), &flows), None);
        assert!(watch.created(&bound(1.3, -2.0), &flows).is_some());
        // A drag has taken it.
        assert_eq!(watch.created(&bound(0.0, -2.0), &EnergyFlows { dissipated: 1.0, ..flows }), None);
    }

    #[test]
    fn energies_too_large_for_a_double_are_too_much() {
        let flows = EnergyFlows { released: f64::INFINITY, ..EnergyFlows::default() };
        assert!(fresh().created(&held(f64::INFINITY, 0.0), &flows).is_some());
    }

    #[test]
    fn the_height_of_zero_does_not_matter_beyond_round_off() {
        for zero in [0.0, 1e6, -1e6] {
            let flows = EnergyFlows { released: zero + 1.0, ..EnergyFlows::default() };
            assert_eq!(fresh().created(&held(1.0, zero), &flows), None, "{zero}");
            assert!(fresh().created(&held(1.2, zero), &flows).is_some(), "{zero}");
        }
    }
}
