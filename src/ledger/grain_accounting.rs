//! The books: who has entered, who is out and when, who is lost and how, and what a loss does to the run.
//!
//! Told by messages: `GrainReleased`, `GrainOut` and `GrainLost`. A grain that somebody else removed is lost too.

use std::collections::HashSet;
use std::marker::PhantomData;

use bevy_app::{App, Plugin};
use bevy_ecs::prelude::*;
use serde::{Deserialize, Serialize};

use crate::ledger::cull::Culled;
use crate::ledger::shown;
use crate::messages::{GrainLost, GrainOut, GrainReleased};
use crate::outcome::{Failure, Outcome};
use crate::particle::GrainId;
use crate::space::Space;
use crate::step::{Clock, Phase, Step};
use crate::store::{BeforeRenumbering, ParticleStore, Renumber};

/// The scene's `on_loss`: what a lost grain does to the run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
pub enum OnLoss {
    /// The run stops and has failed.
    #[default]
    Stop,
    /// The run goes on; it has failed all the same when it ends.
    Continue,
}

/// One lost grain.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LossRecord {
    /// Its id.
    pub grain: u32,
    /// The step in which it was noticed.
    pub step: u64,
    /// Simulated time, s.
    pub time_s: f64,
    /// Where it was, m.
    pub position_m: Vec<f64>,
    /// How it went.
    pub way: String,
    /// The nearest wall grain, by its number in the silo file.
    pub nearest_wall_grain: Option<u32>,
}

/// The books.
#[derive(Resource, Default, Debug)]
pub struct Ledger {
    /// Grains that have entered.
    pub released: u32,
    /// When each grain that is out crossed the orifice, s, in order.
    pub out_times: Vec<f64>,
    /// Who was lost, in order.
    pub lost: Vec<LossRecord>,
    /// Grains removed below the cull line, whether out or lost.
    pub culled: u32,
    /// Who is out or lost.
    gone: HashSet<GrainId>,
}

impl Ledger {
    /// Grains that are out.
    #[must_use]
    pub fn out(&self) -> u32 {
        count(self.out_times.len())
    }

    /// Grains that are lost.
    #[must_use]
    pub fn lost(&self) -> u32 {
        count(self.lost.len())
    }

    /// Whether a grain is out or lost.
    #[must_use]
    pub fn is_gone(&self, grain: GrainId) -> bool {
        self.gone.contains(&grain)
    }

    /// Grains that are inside: released, neither out nor lost.
    #[must_use]
    pub fn inside(&self) -> u32 {
        self.released.saturating_sub(self.out() + self.lost())
    }
}

fn count(n: usize) -> u32 {
    u32::try_from(n).expect("grain ids are 31 bits wide")
}

pub(super) fn count_released(mut ledger: ResMut<Ledger>, mut released: MessageReader<GrainReleased>) {
    ledger.released += count(released.read().count());
}

/// Grains that left the world otherwise are lost too; the store still knows their names.
fn miss_vanished<V: Space>(
    mut expected: ResMut<Culled>,
    store: Res<ParticleStore<V>>,
    mut lost: MessageWriter<GrainLost<V>>,
    ledger: Res<Ledger>,
) {
    for &row in store.vacated() {
        let id = store.id[row];
        if !expected.0.remove(&id) && !id.is_wall() && !ledger.gone.contains(&id) {
            let way = "out of the world, removed by a behaviour".to_owned();
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
    let (step, time_s) = (clock.steps, clock.time());
    // Whoever leaves in the same step is booked in the order of the ids, whatever tables the grains are in.
    let mut out: Vec<_> = out.read().collect();
    out.sort_unstable_by_key(|grain| grain.id);
    let mut lost: Vec<_> = lost.read().collect();
    lost.sort_unstable_by_key(|grain| grain.id);
    for grain in out {
        ledger.gone.insert(grain.id);
        ledger.out_times.push(time_s);
    }
    for grain in lost {
        tracing::debug!("t = {time_s:.3} s: {} was lost {}", grain.id, grain.way);
        ledger.gone.insert(grain.id);
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
            outcome.fail(Failure::GrainLost { step, grain: id, position: shown(position), way });
        }
    }
}

#[derive(Resource)]
pub(super) struct OnLossSetting(OnLoss);

/// Systems of [`Phase::Cull`] that act on a settled ledger run after this set.
#[derive(SystemSet, Clone, Debug, PartialEq, Eq, Hash)]
pub struct GrainsAccounted;

/// The ledger, with what a loss does.
pub struct LedgerPlugin<V: Space>(pub OnLoss, pub PhantomData<V>);

impl<V: Space> Plugin for LedgerPlugin<V> {
    fn build(&self, app: &mut App) {
        app.init_resource::<Ledger>()
            .insert_resource(OnLossSetting(self.0))
            .init_resource::<Culled>()
            .add_systems(Renumber, miss_vanished::<V>.in_set(BeforeRenumbering))
            .add_systems(
                Step,
                (count_released, account_for_grains::<V>).chain().in_set(Phase::Cull).in_set(GrainsAccounted),
            );
    }
}
