//! `series.csv`: a row every `series.interval` seconds, and a row at the end of the run. Each row is flushed at once,
//! so that it survives a crash of the run. `COLUMNS`, `BALANCE` and `STATE` have the columns.
//!
//! The columns of the energy flows and of the balance error exist only if the scene tracks the energy balance. Further columns are those
//! that behaviours [register](crate::measure::outputs).

use bevy_app::{App, Plugin};
use bevy_ecs::prelude::*;

use crate::energy::EnergyFlows;
use crate::ledger::Ledger;
use crate::measure::outputs::{self, SeriesValues};
use crate::measure::totals::Totals;
use crate::measure::{ObserveStage, due, observe_every};
use crate::scene::outputs::Series;
use crate::writers::rows::{Rows, TakenOnce};
use siloflow_dem::gravity::Gravity;
use siloflow_dem::outcome::Outcome;
use siloflow_dem::persist::PersistApp as _;
use siloflow_dem::space::Space;
use siloflow_dem::step::{Clock, Step};
use siloflow_dem::survey::SurveyParam;
use siloflow_files::columns::Cell::{Decimal, Scientific, Whole};
use siloflow_files::columns::{Column, Columns};
use siloflow_files::growing::OutputPlace;

/// A row of the file.
#[derive(Debug)]
pub(crate) struct SeriesRow {
    /// s.
    time: f64,
    released: u32,
    inside: u32,
    out: u32,
    lost: u32,
    culled: u32,
    /// 1/s.
    outflow: f64,
    /// kg.
    out_mass: f64,
    totals: Totals,
    flows: EnergyFlows,
}

const FLOWS: &str = "energy flows since the start; absent without the energy balance";
const ENERGIES: &str = "energies now; the potential energy is 0 at the origin";

/// The columns up to the energies.
pub(crate) const COLUMNS: &[Column<SeriesRow>] = &[
    Column::new("time_s", "s", "simulated time", |row| Decimal(row.time)),
    Column::new("released", "grains", "grain accounting", |row| Whole(row.released.into())),
    Column::new("inside", "grains", "grain accounting", |row| Whole(row.inside.into())),
    Column::new("out", "grains", "grain accounting", |row| Whole(row.out.into())),
    Column::new("lost", "grains", "grain accounting", |row| Whole(row.lost.into())),
    Column::new("culled", "grains", "grains removed below the cull line, every 32 steps", |row| {
        Whole(row.culled.into())
    }),
    Column::new("outflow_per_s", "1/s", "grains out since the previous row, over the time since then", |row| {
        Decimal(row.outflow)
    }),
    Column::new("out_kg", "kg", "mass of the grains out", |row| Scientific(row.out_mass)),
    Column::new("kinetic_j", "J", ENERGIES, |row| Scientific(row.totals.kinetic)),
    Column::new("rotational_j", "J", ENERGIES, |row| Scientific(row.totals.rotational)),
    Column::new("potential_j", "J", ENERGIES, |row| Scientific(row.totals.potential)),
    Column::new("elastic_j", "J", ENERGIES, |row| Scientific(row.totals.elastic)),
];

/// The columns of the energy balance, which follow.
pub(crate) const BALANCE: &[Column<SeriesRow>] = &[
    Column::new("released_j", "J", FLOWS, |row| Scientific(row.flows.released)),
    Column::new("wall_work_j", "J", FLOWS, |row| Scientific(row.flows.wall_work)),
    Column::new("lifted_j", "J", FLOWS, |row| Scientific(row.flows.lifted)),
    Column::new("added_work_j", "J", FLOWS, |row| Scientific(row.flows.added_work)),
    Column::new("dissipated_j", "J", FLOWS, |row| Scientific(row.flows.dissipated)),
    Column::new("removed_j", "J", FLOWS, |row| Scientific(row.flows.removed)),
    Column::new(
        "balance_error_j",
        "J",
        "error of the energy balance: the present energy less the energy that the flows predict; absent like the flows",
        |row| Scientific(row.totals.energy() - row.flows.expected()),
    ),
];

/// The last columns.
pub(crate) const STATE: &[Column<SeriesRow>] = &[
    Column::new("largest_speed_m_per_s", "m/s", "largest speed of a grain", |row| Scientific(row.totals.largest_speed)),
    Column::new("largest_overlap_ratio", "", "largest overlap now, over the smaller radius of the pair", |row| {
        Scientific(row.totals.largest_overlap_ratio)
    }),
    Column::new(
        "mean_overlap_ratio",
        "",
        "mean overlap now of contacts between grains, over the mean radius of the pair",
        |row| Scientific(row.totals.mean_overlap_ratio),
    ),
    Column::new("coordination", "", "mean number of contacts per grain", |row| Decimal(row.totals.coordination)),
];

/// Returns siloflow's own columns of the file; `tracks_energy` adds those of the energy balance.
fn columns(tracks_energy: bool) -> Columns<SeriesRow> {
    let balance = if tracks_energy { BALANCE } else { &[] };
    Columns::of(true, &[COLUMNS, balance, STATE])
}

/// Returns the names of siloflow's own columns; `tracks_energy` adds those of the energy balance.
pub(crate) fn header(tracks_energy: bool) -> String {
    columns(tracks_energy).header()
}

#[derive(Resource)]
struct SeriesFile {
    rows: Rows,
    columns: Columns<SeriesRow>,
    /// Time (s) and number of grains out at the previous row.
    last: Option<(f64, u32)>,
}

fn write_row<V: Space>(
    (clock, survey_param): (Res<Clock>, SurveyParam<V>),
    (gravity, flows, ledger): (Res<Gravity<V>>, Option<Res<EnergyFlows>>, Res<Ledger>),
    registered: Option<Res<SeriesValues>>,
    mut series: ResMut<SeriesFile>,
    mut outcome: ResMut<Outcome>,
) {
    let time = clock.time();
    let out = ledger.out();
    let totals = Totals::measure(&survey_param.survey(), gravity.0);
    let outflow = match series.last.replace((time, out)) {
        Some((before, out_before)) if time > before => f64::from(out - out_before) / (time - before),
        _ => 0.0,
    };
    let row = SeriesRow {
        time,
        released: ledger.released,
        inside: ledger.inside(),
        out,
        lost: ledger.lost(),
        culled: ledger.culled,
        outflow,
        out_mass: ledger.departures.mass(),
        totals,
        flows: flows.map_or_else(EnergyFlows::default, |flows| *flows),
    };
    let registered = outputs::cells(registered);
    let SeriesFile { rows, columns, .. } = &mut *series;
    rows.append(format_args!("{}{registered}\n", columns.cells(&row)), &mut outcome);
}

/// Writes `series.csv`.
pub struct SeriesPlugin<V: Space> {
    config: Series,
    file: TakenOnce<SeriesFile>,
    space: std::marker::PhantomData<V>,
}

impl<V: Space> SeriesPlugin<V> {
    /// Creates the file with its header, or continues it. `tracks_energy` must be set if the scene tracks the energy balance. The
    /// world has the columns that behaviours have registered.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn create(config: Series, tracks_energy: bool, world: &World, place: &OutputPlace) -> std::io::Result<Self> {
        let columns = columns(tracks_energy);
        let header = columns.header() + &outputs::names(world);
        let file = TakenOnce::new(SeriesFile { rows: Rows::at(place, &header)?, columns, last: None });
        Ok(Self { config, file, space: std::marker::PhantomData })
    }
}

impl<V: Space> Plugin for SeriesPlugin<V> {
    fn build(&self, app: &mut App) {
        let Some(file) = self.file.open() else { return };
        observe_every::<Series>(app, self.config.interval.get());
        outputs::compute_series(app, due::<Series>);
        app.persist_sound_part::<SeriesFile, _>(
            |series| Ok((series.rows.saved()?, series.last)),
            |series, (length, last)| {
                series.last = last;
                series.rows.restore(length)
            },
        );
        app.insert_resource(file).add_systems(Step, write_row::<V>.in_set(ObserveStage::Write).run_if(due::<Series>));
    }
}
