//! Setting back: a particle that has left a periodic box goes on at the place in it which stands for the same.
//!
//! The drift sets positions back itself. Where gravity acts along a periodic axis and books of energy are kept, a pass
//! of its own does, for what is set back by L along gravity is lifted by m g L.

use bevy_app::{App, Plugin};
use bevy_ecs::prelude::*;

use crate::gravity::Gravity;
use crate::periodic::Periodic;
use crate::space::Space;
use crate::step::{Drifted, Part, Phase, Step};
use crate::store::{AfterDeferredKick, ParticleStore, SpinsDrifted};

/// Sets back what has left the box, where gravity acts along a periodic axis, and sums the potential energy that this
/// takes.
fn wrap_and_lift<V: Space>(mut store: ResMut<ParticleStore<V>>, gravity: Res<Gravity<V>>) {
    let ParticleStore { body, mass, periodic: Some(periodic), movable_end: end, .. } = &mut *store else { return };
    let mut lifted = 0.0;
    for (body, mass) in body[..*end].iter_mut().zip(mass) {
        let wrapped = periodic.wrapped(body.position);
        if wrapped != body.position {
            lifted += -*mass * gravity.0.dot(wrapped - body.position);
            body.position = wrapped;
        }
    }
    store.lifted = lifted;
}

/// Positions are in the box, and [`ParticleStore::lifted`] is the energy of this step, after this set of
/// [`Phase::Drift`].
#[derive(SystemSet, Clone, Debug, PartialEq, Eq, Hash)]
pub(crate) struct Wrapped;

/// The sides of a periodic scene.
pub struct PeriodicPlugin<V: Space> {
    /// The box.
    pub periodic: Periodic<V>,
    /// Whether books of energy are kept.
    pub tracks_energy: bool,
}

impl<V: Space> Plugin for PeriodicPlugin<V> {
    fn build(&self, app: &mut App) {
        let gravity = app.world().resource::<Gravity<V>>().0;
        let books_lifts = self.tracks_energy && self.periodic.lifts(gravity);
        let mut store = app.world_mut().resource_mut::<ParticleStore<V>>();
        (store.periodic, store.sets_back_later) = (Some(self.periodic), books_lifts);
        if books_lifts {
            // Else the drift sets positions back.
            let wrap = wrap_and_lift::<V>.in_set(Part::Engine(Phase::Drift)).in_set(Wrapped);
            app.add_systems(Step, wrap.after(Drifted).before(SpinsDrifted).before(AfterDeferredKick));
        }
    }
}
