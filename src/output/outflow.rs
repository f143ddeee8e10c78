//! Observes the grains that leave, for the figures [`outflow`](crate::measure::outflow) of `summary.json`.

use std::collections::BTreeMap;
use std::marker::PhantomData;

use bevy_app::{App, Plugin};
use bevy_ecs::prelude::*;
use serde::{Deserialize, Serialize};

use crate::door::DoorState;
use crate::ledger::{GrainsAccounted, Ledger};
use crate::measure::ObserveStage;
use crate::measure::moment::{Events, Moment};
use crate::measure::outflow::{Exit, Outflow, OutflowFigures, OutflowSums, SAMPLES, Window};
use crate::rest::RestDetector;
use siloflow_dem::messages::{GrainOut, GrainReleased};
use siloflow_dem::particle::GrainId;
use siloflow_dem::particles::Motion;
use siloflow_dem::persist::{PersistApp as _, Problem};
use siloflow_dem::space::Space;
use siloflow_dem::step::{Clock, Phase, Step};
use siloflow_dem::store::register_predictable;

/// The window of the scene, and its largest species.
#[derive(Resource)]
pub(crate) struct OutflowWindow(Outflow, usize);

/// Observations so far.
#[derive(Resource, Deserialize, Serialize)]
pub(crate) struct OutflowState {
    sums: OutflowSums,
    /// Times at which the grains that are inside entered, s. Grains of the start have no entry: they entered at 0.
    entered: BTreeMap<GrainId, f64>,
}

/// Returns the figures of a world, if its scene asks for them, and if the events of the window have happened.
pub(crate) fn figures(world: &World) -> Option<OutflowFigures> {
    let OutflowWindow(outflow, _) = world.get_resource::<OutflowWindow>()?;
    let sums = &world.get_resource::<OutflowState>()?.sums;
    let events = Events::of(world.get_resource::<DoorState>(), world.get_resource::<RestDetector>());
    let released = world.resource::<Ledger>().released;
    let time = |moment: Moment| moment.time(events, |share| sums.time_of(share, released));
    let window = Window { from: time(outflow.from)?, to: time(outflow.to)? };
    (window.from < window.to).then(|| sums.figures(window, world.resource::<Clock>().time()))
}

fn observe<V: Space>(
    (clock, window): (Res<Clock>, Res<OutflowWindow>),
    mut released: MessageReader<GrainReleased>,
    mut out: MessageReader<GrainOut<V>>,
    mut state: ResMut<OutflowState>,
) {
    let now = clock.time();
    let OutflowState { sums, entered } = &mut *state;
    if now > 0.0 {
        entered.extend(released.read().map(|grain| (grain.id, now)));
    } else {
        released.clear();
    }
    // Grains that leave in the same step are added in the order of their ids, independent of ECS tables.
    let mut out: Vec<_> = out.read().collect();
    out.sort_unstable_by_key(|grain| grain.id);
    for grain in out {
        let stay = now - entered.remove(&grain.id).unwrap_or(0.0);
        sums.add(window.0.fixed(), Exit { time: now, species: grain.species.0.into(), mass: grain.mass, stay });
    }
}

/// Run condition: a sample of velocities is due. An event of this very step does not count yet, so that the answer is known before the step.
fn sample_is_due(
    clock: Res<Clock>,
    window: Res<OutflowWindow>,
    state: Res<OutflowState>,
    door: Option<Res<DoorState>>,
    rest: Option<Res<RestDetector>>,
) -> bool {
    let before = |event: &f64| *event < clock.time();
    let Events { door, rest } = Events::of(door.as_deref(), rest.as_deref());
    let Some(Window { from, to }) = window.0.after(Events { door: door.filter(before), rest: rest.filter(before) })
    else {
        return false;
    };
    let samples = u32::try_from(state.sums.samples()).unwrap_or(u32::MAX);
    window.0.mass_flow.is_some()
        && samples < SAMPLES
        && clock.has_reached(from + (to - from) * f64::from(samples) / f64::from(SAMPLES))
}

fn sample<V: Space>(window: Res<OutflowWindow>, motion: Motion<V>, mut state: ResMut<OutflowState>) {
    let Some(zones) = window.0.mass_flow else { return };
    for grain in motion.grains() {
        if let Some(zone) = zones.zone(motion.position(grain)) {
            state.sums.add_velocity(zone, motion.mass(grain), -motion.velocity(grain).height());
        }
    }
    state.sums.end_sample();
}

/// Refuses restored sums of other blocks or species than those of the scene.
fn check_outflow(world: &mut World) -> Result<(), Problem> {
    let (Some(state), Some(window)) = (world.get_resource::<OutflowState>(), world.get_resource::<OutflowWindow>())
    else {
        return Ok(());
    };
    if state.sums.fit(window.1) { Ok(()) } else { Err("the blocks or the species of the outflow differ".to_owned()) }
}

/// Observes the outflow of a scene.
pub struct OutflowPlugin<V: Space> {
    /// The scene key.
    pub window: Outflow,
    /// Largest species of the scene.
    pub species: usize,
    /// The space.
    pub space: PhantomData<V>,
}

impl<V: Space> Plugin for OutflowPlugin<V> {
    fn build(&self, app: &mut App) {
        let state = OutflowState { sums: OutflowSums::new(self.species), entered: BTreeMap::new() };
        app.insert_resource(OutflowWindow(self.window, self.species))
            .insert_resource(state)
            .persist_sound::<OutflowState>()
            .check_restored(check_outflow);
        register_predictable(app, sample_is_due, sample_is_due);
        app.add_systems(
            Step,
            (
                observe::<V>.in_set(Phase::Cull).after(GrainsAccounted),
                sample::<V>.in_set(ObserveStage::Measure).run_if(sample_is_due),
            ),
        );
    }
}
