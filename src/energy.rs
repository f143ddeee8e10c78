//! Energy balance, in J:
//!
//! kinetic (translation and rotation) + gravitational + elastic
//! = released + work of moving walls + lifted by periodic sides + work of added forces - dissipated - removed + error.
//!
//! *Released* is the energy of grains that enter, also by requests of behaviours. *Removed* is the energy of everything that leaves the world: culled
//! grains with their contacts, and the elastic energy of contacts with a removed door. *Dissipated* is the work of drag
//! forces. Work is the time integral of power by the trapezoidal rule, with the acting force and the full-step
//! velocity.
//!
//! In velocity Verlet m (v(t+dt/2)^2 - v(t-dt/2)^2)/2 = dt F(t).v(t) exactly. So dt F_d(t).v(t) is exactly the energy
//! that the drag takes from the scheme's own kinetic energy. The balance is therefore second order in dt, although the
//! drag force is evaluated with a velocity half a step old. The rest (`balance_error`) is the error of the elastic and
//! gravitational parts, plus about k v^2 dt^2 for each contact that opens or closes within a step. In scenes with many
//! grains only some steps sum the dissipation, and the error of these samples adds to it ([`sampling`]).
//!
//! If grains spin, [`SpinEnergyPlugin`] adds the losses of friction. The work of the tangential and rolling dashpots is
//! integrated in the same way. Sliding and rolling beyond their caps take energy out of the springs, as
//! [`siloflow_dem::contact::spring`] describes. The division into [`Channels`] is summed contact by contact. There, the work
//! of tangential dashpots is force times sliding velocity times dt, with the velocity used for the force. It differs
//! from the total by an error of the scheme's own order, about c v^2 dt/4 for each contact in plain velocity Verlet.
//!
//! With `energy_balance: false` a scene has no energy balance: no plugin of this file, no resource, and no memory in the store.
//!
//! # Parts
//!
//! The left side of the balance is measured when an output or the watchdog needs it. The right side is summed in every step. The force pass
//! and the kicks of `siloflow_dem` sum the powers while they have the numbers at hand, so that the balance needs no pass of its own.
//!
//! | term | numbers of a step | added to [`EnergyFlows`] by |
//! |---|---|---|
//! | kinetic, gravitational, elastic | | not summed: [`Totals`](crate::measure::totals::Totals), `ending::watchdog`; elastic energy of a contact: `PairLaw::elastic_energy` |
//! | released, removed | | `energy_flows`, at a renumbering; of walls that leave: [`LeavingWallsEnergyPlugin`] |
//! | work of moving walls | forces on fixed particles (`Loads`) and on walls (`walls::surfaces`, `with_loads`) | `work::add_contact_work` |
//! | lifted | `ParticleStore::lifted`, by `integrate::wrap` | `work::add_lifted_energy` ([`LiftPlugin`]) |
//! | work of added forces | `ParticleStore::added_power`, by `store/component_sync.rs` | `work::add_behaviour_work` ([`AddedWorkPlugin`]) |
//! | dissipated by normal and tangential dashpots | the dissipative half of each `Accumulator`, by the force pass; `ParticleStore::kick_sum`, by the kick or drift (`integrate/verlet.rs`) | `work::add_contact_work` |
//! | dissipated by torques of dashpots | `ParticleStore::spin_kick_sum` (`integrate/rotation.rs`), `Loads::rolling_drag` | `work::add_friction_loss` ([`SpinEnergyPlugin`]) |
//! | dissipated by sliding, rolling and breaking | `ContactLosses` of the contact history | `work::add_friction_loss` |
//!
//! | file | content |
//! |---|---|
//! | `sampling` | which steps sum dissipation, and the standard error of their sum ([`ParticleStore::track_energy`] switches the force pass) |
//! | `activity` | how many contacts begin or end in a step, which decides about further samples |
//! | `sampled_sum` | the time integral of a power that some steps measure |
//! | `store/deferred_kick.rs` | when the sums of a step are complete: a deferred kick completes them in the next drift ([`after_kicks`], [`EngineBalance`]) |
//! | `output::series`, `output::summary`, `ending::finite` | read the balance |
//!
//! Limit: if a behaviour fixes or frees a grain, the grain's kinetic energy leaves or enters the balance and appears as
//! error. The work of a fixed grain that spins appears as error too.

mod activity;
mod energy_flows;
mod sampled_sum;
pub mod sampling;
mod work;

use std::marker::PhantomData;
use std::num::NonZeroU32;

use bevy_app::{App, Plugin};
use bevy_ecs::prelude::*;
use serde::{Deserialize, Serialize};

use self::activity::Activity;
pub(crate) use self::energy_flows::energy_of;
use self::energy_flows::{
    add_initial_overlap_energy, add_leaving_wall_energy, add_released_energy, add_removed_energy,
};
use self::sampling::{Sampling, choose, note_contacts};
use self::work::{Powers, TurningPowers, add_behaviour_work, add_contact_work, add_friction_loss, add_lifted_energy};
use siloflow_dem::integrate::wrap::Wrapped;
use siloflow_dem::persist::PersistApp as _;
use siloflow_dem::space::Space;
use siloflow_dem::step::{ForceStage, Part, Phase, Step, is_step_zero};
use siloflow_dem::store::{
    AfterDeferredKick, AfterRenumbering, BeforeRenumbering, EngineBalance, FirstRenumbering, ParticleStore, Renumber,
    SpinsDrifted, after_kicks, reads_velocities_when,
};
use siloflow_dem::walls::leaving::walls_leave;

/// Energy flows since the start, J. This resource exists if the energy balance is kept.
#[derive(Resource, Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub struct EnergyFlows {
    /// Energy of grains that entered.
    pub released: f64,
    /// Work on grains by moving fixed particles and belts.
    pub wall_work: f64,
    /// Potential energy of grains that were wrapped at a periodic side along gravity.
    pub lifted: f64,
    /// Work on grains by forces that behaviours added.
    pub added_work: f64,
    /// Work of the drag of contacts.
    pub dissipated: f64,
    /// Energy of particles and contacts that left the world.
    pub removed: f64,
}

impl EnergyFlows {
    /// Returns the present energy of the system according to the flows, J.
    #[must_use]
    pub fn expected(&self) -> f64 {
        self.released + self.wall_work + self.lifted + self.added_work - self.dissipated - self.removed
    }
}

/// Parts of `dissipated` that normal damping has not caused, in scenes with spin, J.
#[derive(Resource, Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub struct Channels {
    /// Loss by friction: tangential dashpots and sliding.
    pub tangential: f64,
    /// Loss by rolling resistance.
    pub rolling: f64,
}

/// After this set, the energy flows of the step are complete. The set runs in [`Phase::Control`] or with the second
/// kick (`store/deferred_kick.rs`).
#[derive(SystemSet, Clone, Debug, PartialEq, Eq, Hash)]
pub struct EnergyBalanced;

/// Adds the energy balance.
pub struct EnergyPlugin<V: Space> {
    /// At least one of so many steps sums dissipation; with `None` the number of grains alone decides ([`sampling`]).
    pub every: Option<NonZeroU32>,
    /// The space.
    pub space: PhantomData<V>,
}

impl<V: Space> Plugin for EnergyPlugin<V> {
    fn build(&self, app: &mut App) {
        app.insert_resource(Sampling::new(self.every))
            .init_resource::<EnergyFlows>()
            .init_resource::<Powers>()
            .init_resource::<Activity>()
            .persist_sound::<EnergyFlows>()
            .persist_sound::<Powers>()
            .persist_sound::<Activity>()
            .add_systems(
                Renumber,
                (add_removed_energy::<V>.in_set(BeforeRenumbering), add_released_energy::<V>.in_set(AfterRenumbering)),
            )
            .add_systems(Step, add_initial_overlap_energy::<V>.in_set(Part::Engine(Phase::Cull)).run_if(is_step_zero));
        app.add_systems(
            Step,
            (
                choose::<V>.in_set(Part::Engine(Phase::Forces)).before(ForceStage::Contacts),
                note_contacts::<V>.in_set(Part::Engine(Phase::Forces)).after(ForceStage::Contacts),
            ),
        );
        after_kicks(app, || add_contact_work::<V>.in_set(EnergyBalanced).into_configs());
    }
}

/// Adds losses by friction and rolling resistance, if grains spin.
pub struct SpinEnergyPlugin<V: Space>(pub PhantomData<V>);

impl<V: Space> Plugin for SpinEnergyPlugin<V> {
    fn build(&self, app: &mut App) {
        app.init_resource::<Channels>()
            .init_resource::<TurningPowers>()
            .persist_sound::<Channels>()
            .persist_sound::<TurningPowers>();
        after_kicks(app, || add_friction_loss::<V>.in_set(EnergyBalanced).after(add_contact_work::<V>).into_configs());
        // The loss by rolling resistance depends on spins, and no kick sums it. It is empty in steps that do not sum
        // dissipation.
        reads_velocities_when(app, |store: Res<ParticleStore<V>>| !store.loads.rolling_drag.is_empty());
    }
}

/// Adds the elastic energy of contacts with removed walls.
pub struct LeavingWallsEnergyPlugin<V: Space>(pub PhantomData<V>);

impl<V: Space> Plugin for LeavingWallsEnergyPlugin<V> {
    fn build(&self, app: &mut App) {
        let add = add_leaving_wall_energy::<V>.in_set(Part::Engine(Phase::Spawn)).before(FirstRenumbering);
        app.add_systems(Step, add.run_if(walls_leave));
    }
}

/// Adds the work of periodic sides along gravity.
pub struct LiftPlugin<V: Space>(pub PhantomData<V>);

impl<V: Space> Plugin for LiftPlugin<V> {
    fn build(&self, app: &mut App) {
        app.add_systems(
            Step,
            add_lifted_energy::<V>
                .in_set(Part::Engine(Phase::Drift))
                .after(Wrapped)
                .before(SpinsDrifted)
                .before(AfterDeferredKick),
        );
    }
}

/// Adds the work of forces that behaviours add.
pub struct AddedWorkPlugin<V: Space>(pub PhantomData<V>);

impl<V: Space> Plugin for AddedWorkPlugin<V> {
    fn build(&self, app: &mut App) {
        app.add_systems(Step, add_behaviour_work::<V>.in_set(EngineBalance));
    }
}
