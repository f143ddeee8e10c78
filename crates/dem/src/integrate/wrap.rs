//! Periodic wrapping: moves a particle that has left the periodic box to the equivalent position inside.
//!
//! The drift usually wraps positions itself. If gravity acts along a periodic axis and the energy balance is kept, a
//! separate pass wraps them. It also sums the potential energy: wrapping by L against gravity adds m g L.

use bevy_app::{App, Plugin};
use bevy_ecs::prelude::*;

use crate::gravity::Gravity;
use crate::periodic::Periodic;
use crate::space::Space;
use crate::step::{Drifted, Part, Phase, Step};
use crate::store::{AfterDeferredKick, ParticleStore, SpinsDrifted};

/// Wraps positions into the box, and sums the potential energy that this adds (J).
fn wrap_and_lift<V: Space>(mut store: ResMut<ParticleStore<V>>, gravity: Res<Gravity<V>>) {
    let end = store.integrated_rows().end;
    let ParticleStore { body, mass, periodic: Some(periodic), .. } = &mut *store else { return };
    let mut lifted = 0.0;
    for (body, mass) in body[..end].iter_mut().zip(mass) {
        let wrapped = periodic.wrapped(body.position);
        if wrapped != body.position {
            lifted += -*mass * gravity.0.dot(wrapped - body.position);
            body.position = wrapped;
        }
    }
    store.lifted = lifted;
}

/// After this set of [`Phase::Drift`], positions are in the box and [`ParticleStore::lifted`] holds the energy of the
/// step.
#[derive(SystemSet, Clone, Debug, PartialEq, Eq, Hash)]
pub struct Wrapped;

/// Periodic sides of a scene.
pub struct PeriodicPlugin<V: Space> {
    /// The box.
    pub periodic: Periodic<V>,
    /// Whether the energy balance is kept.
    pub tracks_energy: bool,
}

impl<V: Space> Plugin for PeriodicPlugin<V> {
    fn build(&self, app: &mut App) {
        let gravity = app.world().resource::<Gravity<V>>().0;
        let tracks_lift = self.tracks_energy && self.periodic.lifts(gravity);
        let mut store = app.world_mut().resource_mut::<ParticleStore<V>>();
        store.periodic = Some(self.periodic);
        store.wraps_after_drift = tracks_lift;
        if tracks_lift {
            // Otherwise the drift wraps positions.
            let wrap = wrap_and_lift::<V>.in_set(Part::Engine(Phase::Drift)).in_set(Wrapped);
            app.add_systems(Step, wrap.after(Drifted).before(SpinsDrifted).before(AfterDeferredKick));
        }
    }
}
