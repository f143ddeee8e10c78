//! `series.csv`: a row every `series.interval` seconds, and a row at the end of the run. Each row is flushed at once,
//! so that it survives a crash of the run.
//!
//! | column | unit | meaning |
//! |---|---|---|
//! | `time_s` | s | simulated time |
//! | `released`, `inside`, `out`, `lost`, `culled` | grains | grain accounting |
//! | `outflow_per_s` | 1/s | grains out since the previous row, divided by the time since then |
//! | `out_kg` | kg | mass of the grains out |
//! | `kinetic_j`, `rotational_j`, `potential_j`, `elastic_j` | J | present energies; potential is 0 at the origin |
//! | `released_j`, `wall_work_j`, `lifted_j`, `added_work_j`, `dissipated_j`, `removed_j` | J | [`EnergyFlows`] |
//! | `balance_error_j` | J | present energy less the energy that the flows predict |
//! | `largest_speed_m_per_s` | m/s | largest speed of a grain |
//! | `largest_overlap_ratio` | | largest present overlap over the smaller radius of the pair |
//! | `coordination` | | coordination number: contacts per grain |
//! | further columns | | those that behaviours [register](crate::measure::outputs) |
//!
//! The columns of the flows and of the balance error exist only if the scene tracks the energy balance.

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
use siloflow_files::growing::OutputPlace;

/// Returns siloflow's own columns of the file; `tracks_energy` adds those of the energy balance.
pub(crate) fn header(tracks_energy: bool) -> String {
    let balance = if tracks_energy { BALANCE_COLUMNS } else { "" };
    format!(
        "time_s,released,inside,out,lost,culled,outflow_per_s,out_kg,kinetic_j,rotational_j,potential_j,elastic_j{balance},\
         largest_speed_m_per_s,largest_overlap_ratio,coordination"
    )
}

const BALANCE_COLUMNS: &str = ",released_j,wall_work_j,lifted_j,added_work_j,dissipated_j,removed_j,balance_error_j";

#[derive(Resource)]
struct SeriesFile {
    rows: Rows,
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
    let now = Totals::measure(&survey_param.survey(), gravity.0);
    let outflow = match series.last.replace((time, out)) {
        Some((before, out_before)) if time > before => f64::from(out - out_before) / (time - before),
        _ => 0.0,
    };
    let balance = flows.map_or_else(String::new, |flows| {
        let EnergyFlows { released, wall_work, lifted, added_work, dissipated, removed } = *flows;
        let error = now.energy() - flows.expected();
        format!(",{released:e},{wall_work:e},{lifted:e},{added_work:e},{dissipated:e},{removed:e},{error:e}")
    });
    let registered = outputs::cells(registered);
    let row = format_args!(
        "{time:?},{},{},{out},{},{},{outflow:?},{:e},{:e},{:e},{:e},{:e}{balance},{:e},{:e},{:?}{registered}\n",
        ledger.released,
        ledger.inside(),
        ledger.lost(),
        ledger.culled,
        ledger.departures.mass(),
        now.kinetic,
        now.rotational,
        now.potential,
        now.elastic,
        now.largest_speed,
        now.largest_overlap_ratio,
        now.coordination,
    );
    series.rows.append(row, &mut outcome);
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
        let header = header(tracks_energy) + &outputs::names(world);
        let file = TakenOnce::new(SeriesFile { rows: Rows::at(place, &header)?, last: None });
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
