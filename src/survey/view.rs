//! The contacts as users see them: who touches whom, how deep, with which forces, sticking or sliding.
//!
//! Read-only, for measurements and pictures. In a system of [`Phase::Observe`](crate::step::Phase::Observe):
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
//! [`ContactView::iter`] takes a fraction of the time of [`ContactView::all`], which evaluates the law for every
//! contact and sorts.
//!
//! Forces are the law's at the positions and velocities of the full step, with the springs as the force pass left them;
//! a contact slides if the law, moved on by the time step that was, cuts its friction.

use bevy_ecs::prelude::*;
use bevy_ecs::system::SystemParam;

use crate::contact::Memory;
use crate::particle::GrainId;
use crate::space::{Plane, Space};
use crate::step::Clock;
use crate::survey::touching::Touching;
use crate::survey::{Partner, Survey, SurveyParam};

/// With whom a grain is in contact.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Touched {
    /// A grain or a wall grain.
    Particle(GrainId),
    /// A flat wall, by its number in the scene, from 1, discs not counted.
    Wall(usize),
}

/// One contact, SI.
#[derive(Clone, Copy, Debug)]
pub struct ContactState<V: Space = Plane> {
    /// The grain from whose side it is seen.
    pub grain: GrainId,
    /// What it touches.
    pub with: Touched,
    /// Centre of the grain, m.
    pub from: V,
    /// From there to the centre of the partner, or to the foot on the wall, m.
    pub to_partner: V,
    /// Overlap, m.
    pub overlap: f64,
    /// Unit vector from the partner to the grain.
    pub normal: V,
    /// Normal force, N; positive where it pushes.
    pub normal_force: f64,
    /// Friction on the grain, N.
    pub friction: V,
    /// |F_t| over mu |F_n|, from 0 to 1; 0 without friction.
    pub mobilised: f64,
    /// Whether friction is at its cap.
    pub is_sliding: bool,
    /// What it remembers.
    pub memory: Memory<V>,
}

impl<V: Space> Survey<'_, V> {
    /// All contacts, in ascending order of the ids; contacts with flat walls come after all others. `dt` in s.
    #[must_use]
    pub fn view(&self, dt: f64) -> Vec<ContactState<V>> {
        // Large and written once: a second copy would take most of the time.
        let mut states = Vec::with_capacity(self.search.list.pairs().len());
        let mut order = Vec::with_capacity(states.capacity());
        let (mut of_pairs, mut of_walls) = (self.history.read_pairs(), self.history.read_walls());
        self.touching().for_each(|contact| {
            let memory = match contact.partner() {
                Partner::Particle(j) => of_pairs.look_up(contact.row(), j),
                Partner::Wall(wall) => of_walls.look_up(contact.row(), wall),
            };
            let state = contact.state_with(&memory.unwrap_or_default(), dt);
            order.push((matches!(state.with, Touched::Wall(_)), state.grain, state.with, states.len()));
            states.push(state);
        });
        order.sort_unstable();
        for place in 0..order.len() {
            let mut from = order[place].3;
            // It was exchanged when an earlier place was filled.
            while from < place {
                from = order[from].3;
            }
            states.swap(place, from);
        }
        states
    }
}

/// The contacts, for systems.
#[derive(SystemParam)]
pub struct ContactView<'w, V: Space = Plane> {
    survey_param: SurveyParam<'w, V>,
    clock: Res<'w, Clock>,
}

impl<V: Space> ContactView<'_, V> {
    /// The contacts one by one, in the order of the store: their geometry is found as they come by, their memory and
    /// their force only on request. Contacts with flat walls come after all others.
    pub fn iter(&self) -> impl Iterator<Item = Touching<'_, V>> {
        self.survey_param.survey().touching()
    }

    /// All contacts with all that is known of them, in ascending order of the ids. The law is evaluated for each:
    /// [`ContactView::iter`] takes less time.
    #[must_use]
    pub fn all(&self) -> Vec<ContactState<V>> {
        self.survey_param.survey().view(self.clock.dt)
    }

    /// Number of rows of the store. The row of a particle in a contact is less.
    #[must_use]
    pub fn rows(&self) -> usize {
        self.survey_param.survey().store.len()
    }
}
