//! The check of the watchdog for overlaps beyond the contact law, in every step, by the largest ratio of overlap to the smaller radius in
//! the force pass.
//!
//! Contact laws are meant for small overlaps. From 0.586 (2 - sqrt 2, solid space) or 0.845 (2 - 2/sqrt 3,
//! plane) on, equal grains in dense order touch their second neighbours through the first. At 1 the centre of a grain
//! reaches the surface of its partner, a thin wall would push it to the other side, and the direction of the force is
//! meaningless. The default limit is 1. From 0.3 on the run warns once. (The silo of the course assignment, scene
//! `silo1`, reaches 0.73, where a grain falls 4 m; `docs/assignment.md` describes the assignment.)

use serde::{Deserialize, Serialize};

use siloflow_dem::outcome::Failure;
use siloflow_dem::particle::GrainId;
use siloflow_dem::space::Space;
use siloflow_dem::step::Clock;
use siloflow_dem::survey::{Partner, Survey};

/// Overlap ratio from which on a run warns.
pub(crate) const LARGE_OVERLAP: f64 = 0.3;

/// Limit and state of the check.
#[derive(Debug, Deserialize, Serialize)]
pub(super) struct OverlapCheck {
    /// Largest overlap ratio; infinite if it is not checked.
    limit: f64,
    has_warned: bool,
}

impl OverlapCheck {
    /// Returns the check with a limit, at the start of a run. Without a limit it does not warn either.
    pub(super) fn new(limit: Option<f64>) -> Self {
        Self { limit: limit.unwrap_or(f64::INFINITY), has_warned: limit.is_none() }
    }

    /// Returns whether an overlap ratio calls for a failure or for the first warning.
    pub(super) fn is_due(&self, ratio: f64) -> bool {
        ratio > self.limit || (ratio > LARGE_OVERLAP && !self.has_warned)
    }

    /// Returns a failure if the overlap ratio exceeds the limit, and warns otherwise.
    pub(super) fn failure<V: Space>(&mut self, survey: &Survey<V>, clock: &Clock, ratio: f64) -> Option<Failure> {
        self.has_warned = true;
        let step = clock.steps;
        let (grain, partner) = deepest(survey)?;
        if ratio > self.limit {
            let remedy = if clock.is_step_zero() {
                "they overlap at the start: move them apart"
            } else {
                "stiffen the contacts, lower `step`, or let grains fall less far"
            };
            return Some(Failure::TooDeep { step, grain, partner, ratio, limit: self.limit, remedy });
        }
        tracing::warn!(
            "step {step}: {grain} and {partner} overlap by {ratio:.2} of the smaller radius; the contact law is meant for \
             small overlaps"
        );
        None
    }
}

/// Returns the grain of the deepest present contact, and its partner in words.
fn deepest<V: Space>(survey: &Survey<V>) -> Option<(GrainId, String)> {
    let mut deepest = 0.0;
    let mut contact = None;
    survey.contacts(|i, partner, pair, _| {
        let ratio = pair.overlap / pair.radii[0].min(pair.radii[1]);
        if ratio > deepest {
            (deepest, contact) = (ratio, Some((i, partner)));
        }
    });
    let store = survey.store;
    contact.map(|(i, partner)| match partner {
        Partner::Particle(j) => (store.id[i], store.id[j].to_string()),
        Partner::Wall(_) => (store.id[i], "a wall surface".to_owned()),
    })
}
