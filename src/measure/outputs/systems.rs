//! Computes registered columns in the steps in which they are due, and registered values at the end.

use std::collections::BTreeMap;

use bevy_app::App;
use bevy_ecs::prelude::*;
use bevy_ecs::schedule::SystemCondition;
use bevy_ecs::system::BoxedSystem;
use serde::Serialize;

use crate::measure::ObserveStage;
use crate::measure::outputs::BehaviourOutputs;
use siloflow_dem::particle::Slot;
use siloflow_dem::persist::PersistApp as _;
use siloflow_dem::step::Step;

/// The numbers of the columns of grains at the last frame: for each column, by row of the particle store.
#[derive(Resource, Default)]
pub(crate) struct GrainValues(Vec<Vec<f64>>);

impl GrainValues {
    /// Sets the numbers of a column. Particles that have no row yet are left out.
    pub(super) fn fill(&mut self, column: usize, numbers: impl Iterator<Item = (Slot, f64)>) {
        let rows = &mut self.0[column];
        rows.clear();
        for (slot, number) in numbers.filter(|(slot, _)| *slot != Slot::default()) {
            if rows.len() <= slot.index() {
                rows.resize(slot.index() + 1, f64::NAN);
            }
            rows[slot.index()] = number;
        }
    }

    pub(super) fn set(&mut self, column: usize, rows: Vec<f64>) {
        self.0[column] = rows;
    }

    /// The number of a row in a column; NaN if there is none.
    pub fn get(&self, column: usize, row: usize) -> f64 {
        self.0.get(column).and_then(|rows| rows.get(row)).copied().unwrap_or(f64::NAN)
    }
}

/// The numbers of the columns of the series at the last row.
#[derive(Resource, Default)]
pub(crate) struct SeriesValues(pub Vec<f64>);

/// Returns the cells of the registered columns of a row, each after a comma.
pub(crate) fn cells(values: Option<Res<SeriesValues>>) -> String {
    let numbers = values.iter().flat_map(|values| &values.0);
    numbers.fold(String::new(), |row, value| row + &format!(",{value:e}"))
}

/// Returns the names of the registered columns of the series, each after a comma.
pub(crate) fn names(world: &World) -> String {
    let columns = BehaviourOutputs::of_series(world).iter();
    columns.fold(String::new(), |header, column| header + "," + &column.quantity.name)
}

/// Adds the systems that compute the columns of grains, run if `due` holds. Without columns nothing is added.
pub(crate) fn compute_grain_columns<M>(app: &mut App, due: impl SystemCondition<M> + Clone) {
    let columns = BehaviourOutputs::of_grains(app.world());
    let systems: Vec<_> = columns.iter().enumerate().map(|(place, column)| (column.make)(place)).collect();
    let values = GrainValues(vec![Vec::new(); systems.len()]);
    compute(app, systems, values, due);
}

/// Adds the systems that compute the columns of the series, run if `due` holds. Without columns nothing is added.
pub(crate) fn compute_series<M>(app: &mut App, due: impl SystemCondition<M> + Clone) {
    let columns = BehaviourOutputs::of_series(app.world());
    let systems: Vec<_> = columns.iter().enumerate().map(|(place, column)| (column.make)(place)).collect();
    let values = SeriesValues(vec![f64::NAN; systems.len()]);
    compute(app, systems, values, due);
}

/// Adds systems that each write a column of their own in `values`. Checkpoints leave the values out.
fn compute<R: Resource, M>(app: &mut App, systems: Vec<BoxedSystem>, values: R, due: impl SystemCondition<M> + Clone) {
    if systems.is_empty() {
        return;
    }
    app.insert_resource(values).derived::<R>().allow_ambiguous_resource::<R>();
    for system in systems {
        app.add_systems(Step, system.in_set(ObserveStage::Columns).run_if(due.clone()));
    }
}

/// A value of a behaviour in the summary.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Value {
    /// The number; `null` if it is not finite.
    pub value: f64,
    /// Its unit; empty for a number without one.
    pub unit: String,
    /// Its label.
    pub label: String,
}

/// Values by behaviour and name.
pub type Values = BTreeMap<String, BTreeMap<String, Value>>;

/// Computes the values of the summary from a world whose components are up to date.
pub(crate) fn summary_values(world: &mut World) -> Values {
    let mut all = Values::new();
    if !world.contains_resource::<BehaviourOutputs>() {
        return all;
    }
    world.resource_scope(|world, mut outputs: Mut<BehaviourOutputs>| {
        for registered in &mut outputs.values {
            registered.system.initialize(world);
            // A system that cannot run, for example because a resource is missing, has no value.
            let value = registered.system.run_readonly((), world).unwrap_or(f64::NAN);
            let quantity = &registered.quantity;
            let name = quantity.name.clone();
            let unit = quantity.unit.clone();
            let label = quantity.label.clone();
            all.entry(quantity.behaviour.clone()).or_default().insert(name, Value { value, unit, label });
        }
    });
    all
}
