//! Results that behaviours add to the outputs of a run: columns of grains, columns of `series.csv`, values in the summary, and
//! files of their own.
//!
//! A behaviour registers them in [`Behaviour::build`](crate::behaviour::Behaviour::build), a line for each:
//!
//! ```
//! use siloflow::prelude::*;
//!
//! /// Temperature of a grain, K.
//! #[derive(Component)]
//! struct Temperature(f64);
//!
//! fn mean_temperature(grains: Query<&Temperature>) -> f64 {
//!     grains.iter().map(|temperature| temperature.0).sum::<f64>() / grains.iter().count() as f64
//! }
//!
//! # fn build(app: &mut App) {
//! app.grain_column::<Temperature>("temperature", "K", |temperature| temperature.0)
//!     .column_scale("temperature", Scale { from: 300.0, to: 400.0, palette: Palette::Viridis })
//!     .series_column("mean_temperature_k", "K", mean_temperature)
//!     .summary_value("mean_temperature", "K", mean_temperature);
//! # }
//! ```
//!
//! | registered | appears in |
//! |---|---|
//! | a column of grains | the table `grains` of `frames.bin`, and every format that `export` makes of it |
//! | a column of the series | `series.csv` |
//! | a value | `summary.json`, as `behaviours.<behaviour>.<name>` |
//!
//! Columns are computed in [`ObserveStage::Columns`], in steps in which a row or a frame is due, and not at all in a scene without
//! the output. The systems that compute them read the world and cannot change it. `state.csv` has no such columns, because scenes
//! read it as a grain file; a component that a behaviour saves with `app.persist_component` is part of the state of a run.
//!
//! Limit: a column has one number for each grain.

mod check;
mod systems;

use bevy_app::App;
use bevy_ecs::prelude::*;
use bevy_ecs::system::{BoxedReadOnlySystem, BoxedSystem, ReadOnlySystem};

pub(crate) use self::check::{Reserved, refuse};
pub(crate) use self::systems::{
    GrainValues, SeriesValues, cells, compute_grain_columns, compute_series, names, summary_values,
};
pub use self::systems::{Value, Values};
#[cfg(doc)]
use crate::measure::ObserveStage;
use siloflow_dem::particle::Slot;
use siloflow_files::frames::scale::Scale;

/// Name, unit and label of a registered quantity.
#[derive(Clone, Debug, PartialEq)]
pub struct Quantity {
    /// The behaviour that registers it.
    pub behaviour: String,
    /// Name: letters from a to z, digits and `_`.
    pub name: String,
    /// Unit, for example `K`; empty for a number without one.
    pub unit: String,
    /// Label of axes and colour bars. Default: the name with spaces.
    pub label: String,
}

type MakeSystem = Box<dyn Fn(usize) -> BoxedSystem + Send + Sync>;

/// A column of grains.
pub(crate) struct GrainColumn {
    pub quantity: Quantity,
    pub scale: Option<Scale>,
    /// Returns the system that computes the column with this number.
    make: MakeSystem,
}

/// A column of the series.
pub(crate) struct SeriesColumn {
    pub quantity: Quantity,
    make: MakeSystem,
}

/// A value in the summary.
struct SummaryValue {
    quantity: Quantity,
    system: BoxedReadOnlySystem<(), f64>,
}

/// The outputs that the behaviours of a run have registered.
#[derive(Resource, Default)]
pub struct BehaviourOutputs {
    /// The behaviour that is being built.
    owner: String,
    grain_columns: Vec<GrainColumn>,
    series_columns: Vec<SeriesColumn>,
    values: Vec<SummaryValue>,
    /// Behaviour and name of each file.
    files: Vec<(String, String)>,
    /// Behaviour and text of each wrong call.
    problems: Vec<(String, String)>,
}

impl BehaviourOutputs {
    /// Names the behaviour that registers outputs from now on.
    pub(crate) fn begin(app: &mut App, behaviour: &str) {
        behaviour.clone_into(&mut app.world_mut().get_resource_or_init::<Self>().owner);
    }

    /// The registered columns of grains.
    pub(crate) fn of_grains(world: &World) -> &[GrainColumn] {
        world.get_resource::<Self>().map_or(&[], |outputs| &outputs.grain_columns)
    }

    /// The registered columns of the series.
    pub(crate) fn of_series(world: &World) -> &[SeriesColumn] {
        world.get_resource::<Self>().map_or(&[], |outputs| &outputs.series_columns)
    }

    /// The names of the files that behaviours write.
    pub(crate) fn files(world: &World) -> Vec<String> {
        let files = world.get_resource::<Self>().map_or(&[][..], |outputs| &outputs.files);
        files.iter().map(|(_, name)| name.clone()).collect()
    }

    fn quantity(&self, name: &str, unit: &str) -> Quantity {
        Quantity {
            behaviour: self.owner.clone(),
            name: name.to_owned(),
            unit: unit.to_owned(),
            label: name.replace('_', " "),
        }
    }

    /// Returns the columns and values of this name that the present behaviour has registered.
    fn mine<'a>(&'a mut self, name: &str) -> impl Iterator<Item = (&'a mut Quantity, Option<&'a mut Option<Scale>>)> {
        let grains = self.grain_columns.iter_mut().map(|column| (&mut column.quantity, Some(&mut column.scale)));
        let series = self.series_columns.iter_mut().map(|column| (&mut column.quantity, None));
        let values = self.values.iter_mut().map(|value| (&mut value.quantity, None));
        let owner = self.owner.clone();
        let name = name.to_owned();
        grains.chain(series).chain(values).filter(move |(of, _)| of.behaviour == owner && of.name == name)
    }

    fn problem(&mut self, text: String) {
        self.problems.push((self.owner.clone(), text));
    }
}

/// Registration of outputs in an [`App`]. Names have letters from a to z, digits and `_`, and begin with a letter. A name that is
/// taken or not allowed is an error before the run begins.
pub trait OutputApp {
    /// Adds a column to the grains of frames: a number of the component `C`. Grains without the component have NaN.
    fn grain_column<C: Component>(
        &mut self,
        name: &str,
        unit: &str,
        number: impl Fn(&C) -> f64 + Clone + Send + Sync + 'static,
    ) -> &mut Self;

    /// Adds a column to the grains of frames: a number for each row of the particle store, in the order of rows. Rows that are
    /// missing have NaN. [`Particles`](siloflow_dem::particles::Particles) and [`ContactView`](siloflow_dem::survey::view::ContactView) have the
    /// number of rows.
    fn grain_column_from<M: 'static, S>(&mut self, name: &str, unit: &str, system: S) -> &mut Self
    where
        S: IntoSystem<(), Vec<f64>, M, System: ReadOnlySystem> + Clone + Send + Sync + 'static;

    /// Adds a column to `series.csv`. By convention the name ends with the unit, for example `mean_temperature_k`.
    fn series_column<M: 'static, S>(&mut self, name: &str, unit: &str, system: S) -> &mut Self
    where
        S: IntoSystem<(), f64, M, System: ReadOnlySystem> + Clone + Send + Sync + 'static;

    /// Adds a value to the summary. It is computed at the end of the run.
    fn summary_value<M: 'static, S>(&mut self, name: &str, unit: &str, system: S) -> &mut Self
    where
        S: IntoSystem<(), f64, M, System: ReadOnlySystem>;

    /// Sets the label of a column or value that this behaviour has registered.
    fn column_label(&mut self, name: &str, label: &str) -> &mut Self;

    /// Suggests colours for a column of grains that this behaviour has registered.
    fn column_scale(&mut self, name: &str, scale: Scale) -> &mut Self;

    /// Declares a file that this behaviour writes at the top of the run directory
    /// ([`RunPath`](crate::writers::run_path::RunPath)). A later run in its place removes it.
    fn run_file(&mut self, name: &str) -> &mut Self;
}

impl OutputApp for App {
    fn grain_column<C: Component>(
        &mut self,
        name: &str,
        unit: &str,
        number: impl Fn(&C) -> f64 + Clone + Send + Sync + 'static,
    ) -> &mut Self {
        add_grain_column(self, name, unit, move |place| {
            let number = number.clone();
            let fill = move |grains: Query<(&Slot, &C)>, mut values: ResMut<GrainValues>| {
                values.fill(place, grains.iter().map(|(slot, component)| (*slot, number(component))));
            };
            Box::new(IntoSystem::into_system(fill))
        })
    }

    fn grain_column_from<M: 'static, S>(&mut self, name: &str, unit: &str, system: S) -> &mut Self
    where
        S: IntoSystem<(), Vec<f64>, M, System: ReadOnlySystem> + Clone + Send + Sync + 'static,
    {
        add_grain_column(self, name, unit, move |place| {
            let keep = move |rows: In<Vec<f64>>, mut values: ResMut<GrainValues>| values.set(place, rows.0);
            Box::new(IntoSystem::into_system(system.clone().pipe(keep)))
        })
    }

    fn series_column<M: 'static, S>(&mut self, name: &str, unit: &str, system: S) -> &mut Self
    where
        S: IntoSystem<(), f64, M, System: ReadOnlySystem> + Clone + Send + Sync + 'static,
    {
        let mut outputs = self.world_mut().get_resource_or_init::<BehaviourOutputs>();
        let quantity = outputs.quantity(name, unit);
        let make = move |place: usize| -> BoxedSystem {
            let keep = move |value: In<f64>, mut values: ResMut<SeriesValues>| values.0[place] = value.0;
            Box::new(IntoSystem::into_system(system.clone().pipe(keep)))
        };
        outputs.series_columns.push(SeriesColumn { quantity, make: Box::new(make) });
        self
    }

    fn summary_value<M: 'static, S>(&mut self, name: &str, unit: &str, system: S) -> &mut Self
    where
        S: IntoSystem<(), f64, M, System: ReadOnlySystem>,
    {
        let mut outputs = self.world_mut().get_resource_or_init::<BehaviourOutputs>();
        let quantity = outputs.quantity(name, unit);
        outputs.values.push(SummaryValue { quantity, system: Box::new(IntoSystem::into_system(system)) });
        self
    }

    fn column_label(&mut self, name: &str, label: &str) -> &mut Self {
        let mut outputs = self.world_mut().get_resource_or_init::<BehaviourOutputs>();
        let count = outputs.mine(name).map(|(quantity, _)| label.clone_into(&mut quantity.label)).count();
        if count == 0 {
            outputs.problem(format!("the label of `{name}` is set, which this behaviour has not registered"));
        }
        self
    }

    fn column_scale(&mut self, name: &str, scale: Scale) -> &mut Self {
        let mut outputs = self.world_mut().get_resource_or_init::<BehaviourOutputs>();
        let of_grains = outputs.mine(name).find_map(|(_, old)| old);
        if let Some(old) = of_grains {
            *old = Some(scale);
        } else {
            outputs.problem(format!("the scale of `{name}` is set, which is no column of grains of this behaviour"));
        }
        if !(scale.from.is_finite() && scale.to.is_finite() && scale.from < scale.to) {
            let Scale { from, to, .. } = scale;
            outputs.problem(format!("the scale of `{name}` goes from {from} to {to}, but must go up"));
        }
        self
    }

    fn run_file(&mut self, name: &str) -> &mut Self {
        let mut outputs = self.world_mut().get_resource_or_init::<BehaviourOutputs>();
        let file = (outputs.owner.clone(), name.to_owned());
        outputs.files.push(file);
        self
    }
}

fn add_grain_column<'a>(
    app: &'a mut App,
    name: &str,
    unit: &str,
    make: impl Fn(usize) -> BoxedSystem + Send + Sync + 'static,
) -> &'a mut App {
    let mut outputs = app.world_mut().get_resource_or_init::<BehaviourOutputs>();
    let quantity = outputs.quantity(name, unit);
    outputs.grain_columns.push(GrainColumn { quantity, scale: None, make: Box::new(make) });
    app
}
