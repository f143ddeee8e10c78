//! Culler: removes grains that have fallen far enough. A grain there that has not crossed the orifice is lost.
//!
//! The culler runs every [`CULL_INTERVAL`] steps, so that grains leave together. Slots, neighbour list and contact memories are renumbered when a grain has left, which
//! takes as long as several steps, and a discharging silo loses a grain in nearly every step.

use std::marker::PhantomData;

use bevy_app::{App, Plugin};
use bevy_ecs::prelude::*;
use serde::{Deserialize, Serialize};

use crate::ledger::grain_accounting::{Culled, account_for_grains, count_released};
use crate::ledger::{GrainState, GrainStates, Ledger, watch_paths};
use siloflow_dem::displacement_trigger::DisplacementTrigger;
use siloflow_dem::messages::GrainLost;
use siloflow_dem::particles::Particles;
use siloflow_dem::persist::PersistApp as _;
use siloflow_dem::space::Space;
use siloflow_dem::step::{Clock, Phase, Step};
use siloflow_dem::store::PlainCommands;
use siloflow_dem::values::Finite;

/// The scene key `cull`.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Cull {
    /// Height below which grains are removed, by their centres, m.
    pub below: Finite,
}

/// Steps between two passes of the culler. A grain may fall below the line for as long.
const CULL_INTERVAL: u64 = 32;

/// Run condition: the culler is due.
fn is_due(clock: Res<Clock>) -> bool {
    clock.steps.is_multiple_of(CULL_INTERVAL)
}

/// Fires when a grain may be below the cull line.
#[derive(Resource, Default, Deserialize, Serialize)]
struct CullTrigger(DisplacementTrigger);

/// Height of `cull.below`, m.
#[derive(Resource)]
pub(super) struct CullLine(pub(super) f64);

fn cull<V: Space>(
    mut commands: Commands,
    particles: Particles<V>,
    (line, states): (Res<CullLine>, Option<Res<GrainStates<V>>>),
    mut ledger: ResMut<Ledger>,
    mut culled: ResMut<Culled>,
    mut lost: MessageWriter<GrainLost<V>>,
    mut trigger: ResMut<CullTrigger>,
) {
    if !trigger.0.has_fired(particles.travel_meter(), 0.0) {
        return;
    }
    let mut lowest = f64::INFINITY;
    for row in particles.all().filter(|&row| !particles.id(row).is_wall()) {
        let id = particles.id(row);
        let position = particles.position(row);
        lowest = lowest.min(position.height());
        if position.height() < line.0 {
            commands.entity(particles.entity(row)).despawn();
            culled.0.insert(id);
            ledger.culled += 1;
            let state = states.as_ref().and_then(|states| states.states.get(row));
            if state.is_none_or(|state| !matches!(state, GrainState::Out | GrainState::Lost)) {
                let way = "below the cull line, without having crossed the orifice".to_owned();
                lost.write(GrainLost { id, position, way, nearest: None });
            }
        }
    }
    // No grain can be below the line before one has moved this far.
    trigger.0 = DisplacementTrigger::for_distance(particles.travel_meter(), lowest - line.0);
}

/// Removes grains below the cull line.
pub struct CullPlugin<V: Space>(pub Cull, pub PhantomData<V>);

impl<V: Space> Plugin for CullPlugin<V> {
    fn build(&self, app: &mut App) {
        app.insert_resource(CullLine(self.0.below.get()))
            .init_resource::<CullTrigger>()
            .persist::<CullTrigger>()
            .add_systems(
                Step,
                cull::<V>
                    .run_if(is_due)
                    .in_set(Phase::Cull)
                    .in_set(PlainCommands)
                    .after(count_released)
                    .after(watch_paths::<V>)
                    .before(account_for_grains::<V>),
            );
    }
}
