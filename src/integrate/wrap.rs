//! Setting back: a particle that has left a periodic box goes on at the place in it which stands for the same.
//!
//! The drift sets positions back itself. Where gravity acts along a periodic axis and books of energy are kept, a pass of its own does, for
//! what is set back by L along gravity is lifted by m g L.

use bevy_app::{App, Plugin};
use bevy_ecs::prelude::*;

use crate::columns::{Columns, Late, SpinsDrifted};
use crate::gravity::Gravity;
use crate::periodic::Periodic;
use crate::space::Space;
use crate::step::{Drifted, Part, Phase, Step};

/// Sets back what has left the box, where gravity acts along a periodic axis, and sums the potential energy that this takes.
fn wrap_and_lift<V: Space>(mut columns: ResMut<Columns<V>>, gravity: Res<Gravity<V>>) {
    let Columns { body, mass, periodic: Some(periodic), movable_end: end, .. } = &mut *columns else { return };
    let mut lifted = 0.0;
    for (body, mass) in body[..*end].iter_mut().zip(mass) {
        let wrapped = periodic.wrapped(body.position);
        if wrapped != body.position {
            lifted += -*mass * gravity.0.dot(wrapped - body.position);
            body.position = wrapped;
        }
    }
    columns.lifted = lifted;
}

/// Positions are in the box, and [`Columns::lifted`] is the energy of this step, after this set of [`Phase::Drift`].
#[derive(SystemSet, Clone, Debug, PartialEq, Eq, Hash)]
pub(crate) struct Wrapped;

/// The sides of a periodic scene.
pub struct PeriodicPlugin<V: Space> {
    /// The box.
    pub periodic: Periodic<V>,
    /// Whether books of energy are kept.
    pub has_books: bool,
}

impl<V: Space> Plugin for PeriodicPlugin<V> {
    fn build(&self, app: &mut App) {
        let gravity = app.world().resource::<Gravity<V>>().0;
        let books_lifts = self.has_books && self.periodic.lifts(gravity);
        let mut columns = app.world_mut().resource_mut::<Columns<V>>();
        (columns.periodic, columns.sets_back_later) = (Some(self.periodic), books_lifts);
        if books_lifts {
            // Else the drift sets positions back.
            let wrap = wrap_and_lift::<V>.in_set(Part::Engine(Phase::Drift)).in_set(Wrapped);
            app.add_systems(Step, wrap.after(Drifted).before(SpinsDrifted).before(Late));
        }
    }
}
