//! Activity of contacts: how many begin or end in a step, and which steps many of them share.
//!
//! The force pass counts contacts by blocks of rows. The differences between two steps, without their signs, are the contacts that have begun
//! or ended, less those that cancel within a block. Their usual number is a mean over some 64 steps. Independent events are spread around it by
//! its root, and a step with many more has events with one cause.
//!
//! A wall that changes its velocity at once changes the velocities in all its contacts, and none begins or ends. It is found by its velocity.

use bevy_ecs::prelude::*;
use serde::{Deserialize, Serialize};

use super::sampled_sum::Weight;
use siloflow_dem::space::{Linear, Space};
use siloflow_dem::walls::surfaces::Surfaces;

/// Number of steps that are summed after one in which many contacts have begun or ended.
const AFTER_EVENT: u32 = 2;

/// A contact that lasts counts as this share of one that begins or ends: its power changes little in a step.
const LASTING: f64 = 1.0 / 256.0;

/// Contacts per grain below which every step is summed: it costs little where there are few, and a layer that meets a floor is summed from its
/// first step on.
const DILUTE: f64 = 0.25;

/// Share of the velocity of a wall whose change in a step counts as a jump.
const JUMP: f64 = 0.1;

/// How much contacts have changed in the last step.
#[derive(Resource, Clone, Debug, Default, Deserialize, Serialize)]
pub(super) struct Activity {
    /// Contacts that have begun or ended in the last step, and a share of all others.
    last: f64,
    /// Number of contacts in the last step.
    contacts: f64,
    /// Whether contacts act in a part of their first step.
    are_centred: bool,
    /// Number of contacts in each block of rows.
    counts: Vec<u32>,
    /// The buffer of the counts of the step before. It is kept so that no step allocates.
    #[serde(skip)]
    before: Vec<u32>,
    /// The renumbering of rows that the counts belong to.
    generation: u64,
    /// Usual number of contacts that begin or end in a step.
    usual: f64,
    /// Number of steps on demand that are left.
    demanded: u32,
    /// Velocities and spins of walls.
    walls: Vec<f64>,
    /// Whether a wall has changed its velocity at once in this step.
    has_jumped: bool,
}

impl Activity {
    /// Whether no step has been noted.
    pub fn is_empty(&self) -> bool {
        self.counts.is_empty()
    }

    /// Returns the weight of the last step among those between two samples.
    pub fn weight(&self) -> Weight {
        Weight { activity: self.last, missing: if self.are_centred { 0.5 } else { 0.0 } }
    }

    /// Whether there are few contacts for this number of grains: fewer than [`DILUTE`] each.
    pub fn is_dilute(&self, grains: usize) -> bool {
        #[expect(clippy::cast_precision_loss, reason = "a number of grains")]
        let few = DILUTE * grains as f64;
        self.contacts < few
    }

    /// Returns whether the next step is to be summed on demand.
    pub fn take_demand(&mut self) -> bool {
        let is_demanded = self.demanded > 0;
        self.demanded = self.demanded.saturating_sub(1);
        is_demanded
    }

    /// Adds the number of contacts of a step in each block of rows. Contacts that begin and end in one block cancel, and those of a step after
    /// which rows were renumbered.
    pub fn note(&mut self, counts: impl Iterator<Item = u32>, generation: u64, are_centred: bool) {
        std::mem::swap(&mut self.counts, &mut self.before);
        self.counts.clear();
        self.counts.extend(counts);
        let before = &self.before;
        let total = |counts: &[u32]| counts.iter().map(|&count| f64::from(count)).sum::<f64>();
        let contacts = total(&self.counts);
        let changed = if before.is_empty() {
            0.0
        } else if (before.len(), self.generation) == (self.counts.len(), generation) {
            before.iter().zip(&self.counts).map(|(&before, &now)| f64::from(before.abs_diff(now))).sum()
        } else {
            (contacts - total(before)).abs()
        };
        self.generation = generation;
        self.contacts = contacts;
        self.are_centred = are_centred;
        // A jump of a wall changes its contacts far more than they change in the steps before.
        self.last = changed + contacts * if self.has_jumped { 1.0 / LASTING } else { LASTING };
        // Numbers of independent events spread by their root: six standard deviations, and some more where they are few.
        if self.has_jumped || changed > self.usual + 6.0 * self.usual.sqrt() + 8.0 {
            self.demanded = AFTER_EVENT;
        }
        self.usual += (changed - self.usual) / 64.0;
    }

    /// Compares the velocities of walls with those of the last step. Returns whether one has changed at once.
    pub fn compare<V: Space>(&mut self, walls: &Surfaces<V>) -> bool {
        let moving = walls.with_loads().flat_map(|(wall, _)| {
            let numbers = (0..V::COUNT).map(|axis| wall.velocity.component(axis));
            numbers.chain((0..V::Spin::COUNT).map(|axis| wall.spin.component(axis)))
        });
        let mut has_jumped = false;
        for (place, now) in moving.enumerate() {
            match self.walls.get_mut(place) {
                Some(before) => {
                    let largest = now.abs().max(before.abs());
                    has_jumped |= (now - std::mem::replace(before, now)).abs() > JUMP * largest;
                }
                None => self.walls.push(now),
            }
        }
        self.has_jumped = has_jumped;
        has_jumped
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Notes these counts of contacts in four blocks of rows, and returns whether they are an event.
    fn is_event(activity: &mut Activity, counts: [u32; 4], generation: u64) -> bool {
        activity.demanded = 0;
        activity.note(counts.into_iter(), generation, false);
        activity.demanded > 0
    }

    #[test]
    fn many_contacts_that_begin_or_end_together_are_an_event() {
        let mut activity = Activity::default();
        // Nothing is known of the first step.
        assert!(!is_event(&mut activity, [100; 4], 0));
        assert!(!is_event(&mut activity, [102, 98, 100, 100], 0));
        // 4 have changed, and 400 last.
        assert!((activity.last - (4.0 + 400.0 / 256.0)).abs() < 1e-12, "{}", activity.last);
        // A layer ends where another begins.
        assert!(is_event(&mut activity, [2, 98, 200, 100], 0));
        // Rows have other numbers.
        assert!(!is_event(&mut activity, [200, 100, 2, 98], 1));
        assert!(is_event(&mut activity, [0; 4], 2));
        // Changes that come in every step are no event.
        let steps = (0..200).map(|step| is_event(&mut activity, [if step % 2 == 0 { 100 } else { 0 }; 4], 2));
        assert!(!steps.skip(190).any(|is_event| is_event));
    }
}
