//! Additional force between touching particles, on top of the contact law of the scene.
//!
//! A system in [`ForceStage::Added`](crate::step::ForceStage::Added) takes [`PairForces`] and returns a force for each
//! contact. The force acts on the first particle, its opposite on the partner:
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
//! Limits: the force is no part of the contact law. Friction is not capped by it. Its potential energy does not count
//! as elastic; the energy balance counts its work as `added_work`. `check` does not know its stiffness. The wall loads
//! of `walls.csv` do not contain it. Velocities are v(t+dt/2), so damping by such a force is first
//! order, unless the scheme predicts velocities (`Centred`, with drag or friction in the contact law). A force
//! without these limits needs its own [`PairLaw`](crate::contact::PairLaw).

use bevy_ecs::prelude::*;
use bevy_ecs::system::SystemParam;

use crate::particle::{Force, Slot};
use crate::space::{Plane, Space};
use crate::store::AddsLoads;
use crate::survey::touching::Touching;
use crate::survey::view::ContactView;

/// System parameter: the contacts, and the forces on particles that a system adds to.
#[derive(SystemParam)]
pub struct PairForces<'w, 's, V: Space = Plane> {
    contacts: ContactView<'w, V>,
    forces: Query<'w, 's, (&'static Slot, &'static mut Force<V>)>,
    sums: Local<'s, Vec<V>>,
    _adds: Res<'w, AddsLoads>,
}

impl<V: Space> PairForces<'_, '_, V> {
    /// Adds the force (N) that `on_first` returns for each contact to its first particle, and the opposite force to the
    /// partner. A wall takes no part of it. Contacts are visited in the order of the store, so the sums are the same on
    /// every machine.
    pub fn add(&mut self, mut on_first: impl FnMut(&Touching<'_, V>) -> V) {
        let Self { contacts, forces, sums, .. } = self;
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

    /// Returns the contacts.
    #[must_use]
    pub fn contacts(&self) -> &ContactView<'_, V> {
        &self.contacts
    }
}
