//! Grain accounting: counts grains that enter, are out, lost or removed, and applies `on_loss`.
//!
//! It reads the messages `GrainReleased`, `GrainOut` and `GrainLost`. Requests of behaviours remove grains by [`Ledger::remove`]. A grain that any other
//! system despawns is lost.

use std::collections::HashSet;
use std::marker::PhantomData;

use bevy_app::{App, Plugin};
use bevy_ecs::prelude::*;
use serde::{Deserialize, Serialize};

use crate::ledger::departures::Departures;
use crate::ledger::format_position;
use siloflow_dem::messages::{GrainLost, GrainOut, GrainReleased};
use siloflow_dem::outcome::{Failure, Outcome};
use siloflow_dem::particle::GrainId;
use siloflow_dem::persist::{PersistApp as _, Problem};
use siloflow_dem::space::Space;
use siloflow_dem::step::{Clock, Phase, Step};
use siloflow_dem::store::{BeforeRenumbering, ParticleStore, Renumber};

/// Ids of grains that the culler has despawned, until the store reports their removal.
#[derive(Resource, Default, Deserialize, Serialize)]
pub(super) struct Culled(pub(super) HashSet<GrainId>);

/// The scene key `on_loss`: effect of a lost grain on the run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
pub enum OnLoss {
    /// The run stops as failed.
    #[default]
    Stop,
    /// The run goes on, but counts as failed when it ends.
    Continue,
}

/// Record of one lost grain.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LossRecord {
    /// Id of the grain.
    pub grain: u32,
    /// Step in which the loss was found.
    pub step: u64,
    /// Simulated time, s.
    pub time_s: f64,
    /// Position of the grain, m.
    pub position_m: Vec<f64>,
    /// How the grain was lost, in words.
    pub way: String,
    /// Nearest wall grain, by its number in the silo file.
    pub nearest_wall_grain: Option<u32>,
}

/// Counts of released, out and lost grains.
#[derive(Resource, Default, Debug, Deserialize, Serialize)]
pub struct Ledger {
    /// Number of grains that have entered.
    pub released: u32,
    /// Times at which grains crossed the orifice.
    pub departures: Departures,
    /// Lost grains, in order of time. An output that writes them to a file may have removed all but the first ones.
    pub lost: Vec<LossRecord>,
    /// Number of lost grains that are no longer in `lost`.
    written_losses: u32,
    /// Number of grains removed below the cull line, out or lost.
    pub culled: u32,
    /// Number of grains that requests of behaviours have removed from the inside.
    pub removed: u32,
    /// Ids of grains that requests have removed, until the store reports it.
    taken: HashSet<GrainId>,
    /// Ids of the present grains that are out or lost.
    gone: HashSet<GrainId>,
    /// Ids of grains that a behaviour removed, until their loss is counted.
    vanished: HashSet<GrainId>,
}

impl Ledger {
    /// Returns the number of grains that are out.
    #[must_use]
    pub fn out(&self) -> u32 {
        self.departures.count()
    }

    /// Returns the number of lost grains.
    #[must_use]
    pub fn lost(&self) -> u32 {
        self.written_losses + count(self.lost.len())
    }

    /// Removes all lost grains but the first `kept`, and returns them.
    pub(crate) fn take_losses(&mut self, kept: usize) -> Vec<LossRecord> {
        let taken = self.lost.split_off(kept.min(self.lost.len()));
        self.written_losses += count(taken.len());
        taken
    }

    /// Returns whether a grain that is present is out or lost.
    #[must_use]
    pub fn is_gone(&self, grain: GrainId) -> bool {
        self.gone.contains(&grain)
    }

    /// Counts a grain that a request removes. A grain that `is_gone` already, out or lost, stays counted as such.
    pub(crate) fn remove(&mut self, grain: GrainId, is_gone: bool) {
        self.taken.insert(grain);
        self.removed += u32::from(!is_gone);
    }

    /// Returns the number of grains inside: released, and neither out, lost nor removed.
    #[must_use]
    pub fn inside(&self) -> u32 {
        self.released.saturating_sub(self.out() + self.lost() + self.removed)
    }
}

fn count(n: usize) -> u32 {
    u32::try_from(n).expect("grain ids are 31 bits wide")
}

pub(super) fn count_released(mut ledger: ResMut<Ledger>, mut released: MessageReader<GrainReleased>) {
    ledger.released += count(released.read().count());
}

/// Reports grains that another system has removed as lost. Before the renumbering the store still holds their ids.
fn report_vanished_grains<V: Space>(
    mut culled: ResMut<Culled>,
    store: Res<ParticleStore<V>>,
    mut lost: MessageWriter<GrainLost<V>>,
    mut ledger: ResMut<Ledger>,
) {
    // A grain of several spheres has left once.
    for &row in store.vacated().iter().filter(|&&row| store.is_whole(row)) {
        let id = store.id[row];
        // Nothing is kept of a grain that is counted and no longer present, so that the memory of a long run is bounded.
        let is_counted = culled.0.remove(&id) | ledger.gone.remove(&id) | ledger.taken.remove(&id);
        if !is_counted && !id.is_wall() {
            ledger.vanished.insert(id);
            let way = "despawned by a behaviour without a request (`GrainRequests`)".to_owned();
            lost.write(GrainLost { id, position: store.body[row].position, way, nearest: None });
        }
    }
}

pub(super) fn account_for_grains<V: Space>(
    clock: Res<Clock>,
    on_loss: Res<OnLossSetting>,
    mut ledger: ResMut<Ledger>,
    mut out: MessageReader<GrainOut<V>>,
    mut lost: MessageReader<GrainLost<V>>,
    mut outcome: ResMut<Outcome>,
) {
    let step = clock.steps;
    let time_s = clock.time();
    // Grains that leave in the same step are counted in the order of their ids, independent of ECS tables.
    let mut out: Vec<_> = out.read().collect();
    out.sort_unstable_by_key(|grain| grain.id);
    let mut lost: Vec<_> = lost.read().collect();
    lost.sort_unstable_by_key(|grain| grain.id);
    for grain in out {
        ledger.gone.insert(grain.id);
        ledger.departures.add(time_s, grain.mass);
    }
    for grain in lost {
        tracing::debug!("t = {time_s:.3} s: {} was lost: {}", grain.id, grain.way);
        if !ledger.vanished.remove(&grain.id) {
            ledger.gone.insert(grain.id);
        }
        ledger.lost.push(LossRecord {
            grain: grain.id.number(),
            step,
            time_s,
            position_m: grain.position.components(),
            way: grain.way.clone(),
            nearest_wall_grain: grain.nearest.map(GrainId::number),
        });
        if on_loss.0 == OnLoss::Stop {
            let GrainLost { id, position, way, .. } = grain.clone();
            outcome.fail(Failure::GrainLost { step, grain: id, position: format_position(position), way });
        }
    }
}

/// Refuses restored counts that cannot be those of a run.
fn check_ledger(world: &mut World) -> Result<(), Problem> {
    let Some(ledger) = world.get_resource::<Ledger>() else { return Ok(()) };
    let lost = u64::from(ledger.written_losses) + ledger.lost.len() as u64;
    let gone = u64::from(ledger.out()) + lost + u64::from(ledger.removed);
    let most = u64::from(GrainId::MAX_GRAIN);
    // A behaviour may remove grains of the start, which were not released.
    if u64::from(ledger.released).max(gone).max(ledger.culled.into()) > most || !ledger.departures.is_sound() {
        return Err("its counts of grains cannot be those of a run".to_owned());
    }
    Ok(())
}

/// The scene key `on_loss` as a resource.
#[derive(Resource)]
pub(super) struct OnLossSetting(OnLoss);

/// Systems of [`Phase::Cull`] that need the final counts of the step run after this set.
#[derive(SystemSet, Clone, Debug, PartialEq, Eq, Hash)]
pub struct GrainsAccounted;

/// Adds the grain accounting, with the effect of a loss.
pub struct LedgerPlugin<V: Space>(pub OnLoss, pub PhantomData<V>);

impl<V: Space> Plugin for LedgerPlugin<V> {
    fn build(&self, app: &mut App) {
        app.init_resource::<Ledger>()
            .insert_resource(OnLossSetting(self.0))
            .init_resource::<Culled>()
            .persist_sound::<Ledger>()
            .check_restored(check_ledger)
            .persist::<Culled>()
            .add_systems(Renumber, report_vanished_grains::<V>.in_set(BeforeRenumbering))
            .add_systems(
                Step,
                (count_released, account_for_grains::<V>).chain().in_set(Phase::Cull).in_set(GrainsAccounted),
            );
    }
}
