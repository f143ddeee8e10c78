//! A number, or anything else, that a behaviour keeps for each contact as long as the contact lasts.
//!
//! A [`PairMap`] is part of a resource of the behaviour. Once a step a system goes through the contacts with
//! [`PairMap::visit`]: a contact that is new begins with the default, one that has ended is forgotten. Names of
//! particles are the keys, so renumbering is no concern.
//!
//! ```
//! use siloflow::prelude::*;
//!
//! /// For how long each contact has lasted, s.
//! #[derive(Resource, Default)]
//! struct Ages(PairMap<f64>);
//!
//! fn age(contacts: ContactView, clock: Res<Clock>, mut ages: ResMut<Ages>) {
//!     ages.0.visit(&contacts, |_, age| *age += clock.dt);
//! }
//!
//! # fn build(app: &mut App) {
//! app.init_resource::<Ages>().add_systems(Step, age.in_set(Phase::Observe));
//! # }
//! ```
//!
//! A law of one's own remembers in [`Memory`](crate::contact::Memory) instead, which is part of the force pass.

use rustc_hash::FxHashMap;

use crate::particle::GrainId;
use crate::space::Space;
use crate::survey::touching::Touching;
use crate::survey::view::{ContactView, Touched};

/// A `T` for each contact.
#[derive(Clone, Debug)]
pub struct PairMap<T> {
    of: FxHashMap<(GrainId, Touched), T>,
    /// Those of the visit before.
    before: FxHashMap<(GrainId, Touched), T>,
}

impl<T> Default for PairMap<T> {
    fn default() -> Self {
        Self { of: FxHashMap::default(), before: FxHashMap::default() }
    }
}

/// A contact has one key, whichever particle it is seen from.
fn key(grain: GrainId, with: Touched) -> (GrainId, Touched) {
    match with {
        Touched::Particle(partner) if partner < grain => (partner, Touched::Particle(grain)),
        _ => (grain, with),
    }
}

impl<T: Default> PairMap<T> {
    /// Shows each contact with what is kept for it, in the order of the store, and forgets contacts that have ended.
    pub fn visit<V: Space>(&mut self, contacts: &ContactView<'_, V>, mut each: impl FnMut(&Touching<'_, V>, &mut T)) {
        std::mem::swap(&mut self.of, &mut self.before);
        self.of.reserve(self.before.len());
        contacts.iter().for_each(|contact| {
            let key = key(contact.grain(), contact.with());
            let mut value = self.before.remove(&key).unwrap_or_default();
            each(&contact, &mut value);
            self.of.insert(key, value);
        });
        self.before.clear();
    }
}

impl<T> PairMap<T> {
    /// What is kept for a contact, as of the last visit.
    #[must_use]
    pub fn get(&self, grain: GrainId, with: Touched) -> Option<&T> {
        self.of.get(&key(grain, with))
    }

    /// How many contacts there were in the last visit.
    #[must_use]
    pub fn len(&self) -> usize {
        self.of.len()
    }

    /// Whether there was none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.of.is_empty()
    }
}
