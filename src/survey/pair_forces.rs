//! One more force between particles that touch, on top of the scene's contact law, whichever it is.
//!
//! A system of [`ForceStage::Added`](crate::step::ForceStage::Added) with [`PairForces`] gives the force for each
//! contact; it acts on the first particle, and its opposite on the partner:
//!
//! ```
//! use siloflow::prelude::*;
//!
//! /// Constant attraction, 0.1 N.
//! fn attract(mut contacts: PairForces) {
//!     contacts.add(|contact| contact.normal() * -0.1);
//! }
//!
//! # fn build(app: &mut App) {
//! app.add_systems(Step, attract.in_set(ForceStage::Added));
//! # }
//! ```
//!
//! Limits: such a force is no part of the law. Friction is not capped by it, its potential energy is no elastic energy
//! (the balance books its work as `added_work`), `check` does not know its stiffness, and what flat walls bear
//! (`walls.csv`) is without it. Velocities are v(t+dt/2), so a damping of this kind is of first order. A force that
//! needs more than that is a [`PairLaw`](crate::contact::PairLaw) of one's own.

use bevy_ecs::prelude::*;
use bevy_ecs::system::SystemParam;

use crate::particle::{Force, Slot};
use crate::space::{Plane, Space};
use crate::survey::touching::Touching;
use crate::survey::view::ContactView;

/// The contacts, and the forces on particles, which a system adds to.
#[derive(SystemParam)]
pub struct PairForces<'w, 's, V: Space = Plane> {
    contacts: ContactView<'w, V>,
    forces: Query<'w, 's, (&'static Slot, &'static mut Force<V>)>,
    sums: Local<'s, Vec<V>>,
}

impl<V: Space> PairForces<'_, '_, V> {
    /// Adds the force (N) that `on_first` gives for each contact to its first particle, and the opposite one to the
    /// partner. A flat wall does not move. Contacts come by in the order of the store, so the sum of a particle is the
    /// same on every machine.
    pub fn add(&mut self, mut on_first: impl FnMut(&Touching<'_, V>) -> V) {
        let Self { contacts, forces, sums } = self;
        sums.clear();
        sums.resize(contacts.rows(), V::ZERO);
        contacts.iter().for_each(|contact| {
            let force = on_first(&contact);
            sums[contact.row()] += force;
            if let Some(partner) = contact.partner_row() {
                sums[partner] += -force;
            }
        });
        for (slot, mut force) in forces {
            if let Some(&sum) = sums.get(slot.index()).filter(|&&sum| sum != V::ZERO) {
                force.0 += sum;
            }
        }
    }

    /// The contacts.
    #[must_use]
    pub fn contacts(&self) -> &ContactView<'_, V> {
        &self.contacts
    }
}
