//! Contacts for users: which particles touch, with which overlap and forces, sticking or sliding.
//!
//! Read-only, for measurements and pictures, in a system of [`Phase::Observe`](crate::step::Phase::Observe):
//!
//! ```
//! use siloflow::prelude::*;
//!
//! fn deepest(contacts: ContactView) {
//!     let largest = contacts.iter().map(|contact| contact.overlap()).fold(0.0, f64::max); // m
//!     # let _ = largest;
//! }
//!
//! fn strongest(contacts: ContactView) {
//!     let forces = contacts.all().into_iter().map(|contact| contact.normal_force);
//!     let largest = forces.fold(0.0, f64::max); // N
//!     # let _ = largest;
//! }
//! ```
//!
//! [`ContactView::iter`] takes a fraction of the time of [`ContactView::all`], which evaluates the contact law for
//! every contact and sorts.
//!
//! Forces are the contact law at the positions and velocities of the full step, with the springs left by the force
//! pass. A contact slides if the law caps its friction when evaluated for one more time step.

use bevy_ecs::prelude::*;
use bevy_ecs::system::SystemParam;

use crate::space::{Plane, Space};
use crate::step::Clock;
use crate::survey::contact_state::{ContactState, Touched};
use crate::survey::touching::Touching;
use crate::survey::{Partner, Survey, SurveyParam};

impl<V: Space> Survey<'_, V> {
    /// Returns all contacts in ascending order of ids; contacts with wall surfaces come last. `dt` is the time step, s.
    #[must_use]
    pub fn view(&self, dt: f64) -> Vec<ContactState<V>> {
        // The states are large. Sorting them by a second copy would take most of the time.
        let mut states = Vec::with_capacity(self.search.list.pairs().len());
        let mut order = Vec::with_capacity(states.capacity());
        let mut pair_cursor = self.history.read_pairs();
        let mut wall_cursor = self.history.read_walls();
        self.touching().for_each(|contact| {
            let memory = match contact.partner() {
                Partner::Particle(j) => pair_cursor.look_up(j, contact.row()),
                Partner::Wall(wall) => wall_cursor.look_up(contact.row(), wall),
            };
            let state = contact.state_with(&memory.unwrap_or_default(), dt);
            order.push((matches!(state.with, Touched::Wall(_)), state.grain, state.with, states.len()));
            states.push(state);
        });
        order.sort_unstable();
        for place in 0..order.len() {
            let mut source = order[place].3;
            // The state was moved when an earlier place was filled.
            while source < place {
                source = order[source].3;
            }
            states.swap(place, source);
        }
        states
    }
}

/// System parameter: all contacts.
#[derive(SystemParam)]
pub struct ContactView<'w, V: Space = Plane> {
    survey_param: SurveyParam<'w, V>,
    clock: Res<'w, Clock>,
}

impl<V: Space> ContactView<'_, V> {
    /// Iterates over the contacts in the order of the store; contacts with wall surfaces come last. The geometry of each
    /// contact is computed, its memory and force only on request.
    pub fn iter(&self) -> impl Iterator<Item = Touching<'_, V>> {
        self.survey_param.survey().touching()
    }

    /// Returns the full state of all contacts, in ascending order of ids. It evaluates the contact law for each
    /// contact, so [`ContactView::iter`] takes less time.
    #[must_use]
    pub fn all(&self) -> Vec<ContactState<V>> {
        self.survey_param.survey().view(self.clock.dt)
    }

    /// Returns the number of slots of the store. The slots of the particles in a contact are smaller.
    #[must_use]
    pub fn rows(&self) -> usize {
        self.survey_param.survey().store.len()
    }
}
