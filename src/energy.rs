//! The energy balance: kinetic (of rotation too) + gravitational + elastic
//! = released + work of moving walls + lifted by periodic sides + work of added forces - dissipated - removed + error, in J.
//!
//! *Released* is what grains bring with them, *removed* what goes with whatever leaves the world: culled grains with
//! their contacts, the elastic energy held by a removed door. *Dissipated* is the work of the drag forces. Work is
//! the time integral of power by the trapezoidal rule, with the force as it acts and the full-step velocity:
//!
//! In velocity Verlet m (v(t+dt/2)^2 - v(t-dt/2)^2)/2 = dt F(t).v(t) exactly, so dt F_d(t).v(t) is just what the drag
//! takes from the scheme's own kinetic energy, and the balance is second order in dt although the drag force itself
//! is evaluated at a velocity half a step old. What remains (`balance_error`) is the error of the elastic and
//! gravitational part, plus k v^2 dt^2 or so for each contact that opens or closes within a step.
//!
//! Where grains spin, [`SpinEnergyPlugin`] books what friction takes: the work of the tangential and the
//! rolling dashpots in the same way, and what sliding and rolling beyond their caps take out of the springs as
//! [`crate::contact::spring`] says. How it divides into [`Channels`] is told contact by contact: there the work of tangential
//! dashpots is force times sliding velocity times dt, with the velocity that the force was evaluated with. It differs from what
//! the whole counts by an error of the scheme's own order: c v^2 dt/4 or so for each contact of plain velocity Verlet.
//!
//! What comes and goes is booked in `energy_flows`, work in `work`. A scene with `energy_books: false` has none of this: no plugin of
//! this file, no resource, and no room in the columns.
//!
//! Limit: a grain that a behaviour fixes or frees takes its kinetic energy out of or into the balance, which then shows as error;
//! so does the work of one that is fixed and spins.

mod energy_flows;
mod work;

use std::marker::PhantomData;

use bevy_app::{App, Plugin};
use bevy_ecs::prelude::*;
use serde::Serialize;

use self::energy_flows::{book_initial_overlaps, book_leaving_walls, book_released, book_removed};
use self::work::{Powers, TurningPowers, book_added_work, book_contact_work, book_friction, book_lifted};
use crate::integrate::wrap::Wrapped;
use crate::space::Space;
use crate::step::{Part, Phase, Step, is_step_zero};
use crate::store::{
    AfterDeferredKick, BeforeRenumbering, EngineBalance, FirstRenumbering, ParticleStore, Renumber, Renumbering,
    SpinsDrifted, after_kicks, reads_velocities_when, renumber,
};
use crate::walls::surfaces::walls_leave;

/// The flows of energy so far, J; a resource where books are kept.
#[derive(Resource, Clone, Copy, Debug, Default, Serialize)]
pub struct EnergyFlows {
    /// Brought in by grains that entered.
    pub released: f64,
    /// Done on grains by fixed particles and belts that move.
    pub wall_work: f64,
    /// Potential energy of grains that a periodic side has set back along gravity.
    pub lifted: f64,
    /// Done on grains by forces that behaviours added.
    pub added_work: f64,
    /// Taken by the drag of contacts.
    pub dissipated: f64,
    /// Gone with what left the world.
    pub removed: f64,
}

impl EnergyFlows {
    /// What the energy of the system should be now, J.
    #[must_use]
    pub fn expected(&self) -> f64 {
        self.released + self.wall_work + self.lifted + self.added_work - self.dissipated - self.removed
    }
}

/// What of `dissipated` went otherwise than by the damping of normal forces, in scenes with spin, J.
#[derive(Resource, Clone, Copy, Debug, Default, Serialize)]
pub struct Channels {
    /// By friction: tangential dashpots, and sliding.
    pub tangential: f64,
    /// By rolling resistance.
    pub rolling: f64,
}

/// The books of the step are kept after this set, in [`Phase::Control`] or with the second kick (`store/deferred_kick.rs`).
#[derive(SystemSet, Clone, Debug, PartialEq, Eq, Hash)]
pub struct EnergyBalanced;

/// Keeps the energy balance.
pub struct EnergyPlugin<V: Space>(pub PhantomData<V>);

impl<V: Space> Plugin for EnergyPlugin<V> {
    fn build(&self, app: &mut App) {
        app.world_mut().resource_mut::<ParticleStore<V>>().tracks_energy = true;
        app.init_resource::<EnergyFlows>()
            .init_resource::<Powers>()
            .add_systems(
                Renumber,
                (
                    book_removed::<V>.in_set(BeforeRenumbering),
                    book_released::<V>.in_set(Renumbering).after(renumber::<V>),
                ),
            )
            .add_systems(Step, book_initial_overlaps::<V>.in_set(Part::Engine(Phase::Cull)).run_if(is_step_zero));
        after_kicks(app, || book_contact_work::<V>.in_set(EnergyBalanced).into_configs());
    }
}

/// Books what friction and rolling resistance take, where grains spin.
pub struct SpinEnergyPlugin<V: Space>(pub PhantomData<V>);

impl<V: Space> Plugin for SpinEnergyPlugin<V> {
    fn build(&self, app: &mut App) {
        app.init_resource::<Channels>().init_resource::<TurningPowers>();
        after_kicks(app, || book_friction::<V>.in_set(EnergyBalanced).after(book_contact_work::<V>).into_configs());
        // What rolling resistance takes goes by spins that no kick has summed.
        reads_velocities_when(app, |store: Res<ParticleStore<V>>| !store.loads.rolling_drag.is_empty());
    }
}

/// Books the elastic energy of contacts with walls that leave.
pub struct LeavingWallsEnergyPlugin<V: Space>(pub PhantomData<V>);

impl<V: Space> Plugin for LeavingWallsEnergyPlugin<V> {
    fn build(&self, app: &mut App) {
        let book = book_leaving_walls::<V>.in_set(Part::Engine(Phase::Spawn)).before(FirstRenumbering);
        app.add_systems(Step, book.run_if(walls_leave));
    }
}

/// Books the work of periodic sides along gravity.
pub struct LiftPlugin<V: Space>(pub PhantomData<V>);

impl<V: Space> Plugin for LiftPlugin<V> {
    fn build(&self, app: &mut App) {
        app.add_systems(
            Step,
            book_lifted::<V>
                .in_set(Part::Engine(Phase::Drift))
                .after(Wrapped)
                .before(SpinsDrifted)
                .before(AfterDeferredKick),
        );
    }
}

/// Books the work of forces that behaviours add.
pub struct AddedWorkPlugin<V: Space>(pub PhantomData<V>);

impl<V: Space> Plugin for AddedWorkPlugin<V> {
    fn build(&self, app: &mut App) {
        app.add_systems(Step, book_added_work::<V>.in_set(EngineBalance));
    }
}
