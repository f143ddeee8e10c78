//! A value that a behaviour keeps for each contact while the contact lasts.
//!
//! A behaviour holds a [`PairMap`] in a resource. Once per step a system visits all contacts with [`PairMap::visit`]. A
//! new contact starts with the default value; the value of a contact that has ended is dropped. Keys are grain ids, so
//! renumbering does not affect them.
//!
//! ```
//! use siloflow::prelude::*;
//!
//! /// For how long each contact has lasted, s.
//! #[derive(Resource, Default, serde::Serialize, serde::Deserialize)]
//! struct Ages(PairMap<f64>);
//!
//! fn age(contacts: ContactView, clock: Res<Clock>, mut ages: ResMut<Ages>) {
//!     ages.0.visit(&contacts, |_, age| *age += clock.dt);
//! }
//!
//! # fn build(app: &mut App) {
//! app.init_resource::<Ages>().persist::<Ages>().add_systems(Step, age.in_set(Phase::Observe));
//! # }
//! ```
//!
//! A contact law uses [`Memory`](crate::contact::Memory) instead, which is part of the force pass.

use rustc_hash::FxHashMap;
use serde::{Deserialize, Serialize};

use crate::particle::GrainId;
use crate::space::Space;
use crate::survey::contact_state::Touched;
use crate::survey::touching::Touching;
use crate::survey::view::ContactView;

/// A value of type `T` for each contact.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub struct PairMap<T> {
    /// Values of the last visit.
    values: FxHashMap<(GrainId, Touched), T>,
    /// Values of the previous visit; empty between visits.
    #[serde(skip)]
    previous: FxHashMap<(GrainId, Touched), T>,
}

impl<T> Default for PairMap<T> {
    fn default() -> Self {
        Self { values: FxHashMap::default(), previous: FxHashMap::default() }
    }
}

/// Returns the key of a contact. It does not depend on the particle from which the contact is seen.
fn key(grain: GrainId, with: Touched) -> (GrainId, Touched) {
    match with {
        Touched::Particle(partner) if partner < grain => (partner, Touched::Particle(grain)),
        _ => (grain, with),
    }
}

impl<T: Default> PairMap<T> {
    /// Calls `each` with every contact and its value, in the order of the store, and drops the values of ended
    /// contacts.
    pub fn visit<V: Space>(&mut self, contacts: &ContactView<'_, V>, mut each: impl FnMut(&Touching<'_, V>, &mut T)) {
        std::mem::swap(&mut self.values, &mut self.previous);
        self.values.reserve(self.previous.len());
        contacts.iter().for_each(|contact| {
            let key = key(contact.grain(), contact.with());
            let mut value = self.previous.remove(&key).unwrap_or_default();
            each(&contact, &mut value);
            self.values.insert(key, value);
        });
        self.previous.clear();
    }
}

impl<T> PairMap<T> {
    /// Returns the value of a contact at the last visit.
    #[must_use]
    pub fn get(&self, grain: GrainId, with: Touched) -> Option<&T> {
        self.values.get(&key(grain, with))
    }

    /// Returns the number of contacts at the last visit.
    #[must_use]
    pub fn len(&self) -> usize {
        self.values.len()
    }

    /// Returns whether there were no contacts at the last visit.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.values.is_empty()
    }
}
