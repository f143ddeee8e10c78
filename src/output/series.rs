//! `series.csv`: one row every `series.interval` seconds, and one at the end. Each row is flushed, so that a run that
//! dies leaves all of them.
//!
//! | column | unit | meaning |
//! |---|---|---|
//! | `time_s` | s | simulated time |
//! | `released`, `inside`, `out`, `lost`, `culled` | grains | the ledger |
//! | `outflow_per_s` | 1/s | grains out since the row before, over the time since then |
//! | `kinetic_j`, `rotational_j`, `potential_j`, `elastic_j` | J | energies now; potential is 0 at the origin |
//! | `released_j`, `wall_work_j`, `lifted_j`, `added_work_j`, `dissipated_j`, `removed_j` | J | flows since the start, where books are kept |
//! | `balance_error_j` | J | energies now less what the flows leave, where books are kept |
//! | `largest_speed_m_per_s` | m/s | of all grains |
//! | `largest_overlap_ratio` | | now, over the smaller radius of the pair |
//! | `coordination` | | contacts a grain |

use std::path::Path;

use bevy_app::{App, Plugin};
use bevy_ecs::prelude::*;

use crate::energy::EnergyFlows;
use crate::gravity::Gravity;
use crate::ledger::Ledger;
use crate::measure::totals::Totals;
use crate::measure::{ObserveStage, due, observe_every};
use crate::outcome::Outcome;
use crate::scene::outputs::Series;
use crate::space::Space;
use crate::step::{Clock, Step};
use crate::survey::SurveyParam;
use crate::writers::rows::{Parcel, Rows};

/// The names of all columns, and among them, or not, those of the books.
fn header(tracks_energy: bool) -> String {
    let books = if tracks_energy { BOOKS } else { "" };
    format!(
        "time_s,released,inside,out,lost,culled,outflow_per_s,kinetic_j,rotational_j,potential_j,elastic_j{books},\
         largest_speed_m_per_s,largest_overlap_ratio,coordination"
    )
}

const BOOKS: &str = ",released_j,wall_work_j,lifted_j,added_work_j,dissipated_j,removed_j,balance_error_j";

#[derive(Resource)]
struct SeriesFile {
    rows: Rows,
    last: Option<(f64, u32)>,
}

fn write_row<V: Space>(
    (clock, survey_param): (Res<Clock>, SurveyParam<V>),
    (gravity, flows, ledger): (Res<Gravity<V>>, Option<Res<EnergyFlows>>, Res<Ledger>),
    mut series: ResMut<SeriesFile>,
    mut outcome: ResMut<Outcome>,
) {
    let (time, out) = (clock.time(), ledger.out());
    let now = Totals::measure(&survey_param.survey(), gravity.0);
    let outflow = match series.last.replace((time, out)) {
        Some((before, out_before)) if time > before => f64::from(out - out_before) / (time - before),
        _ => 0.0,
    };
    let books = flows.map_or_else(String::new, |flows| {
        let EnergyFlows { released, wall_work, lifted, added_work, dissipated, removed } = *flows;
        let error = now.energy() - flows.expected();
        format!(",{released:e},{wall_work:e},{lifted:e},{added_work:e},{dissipated:e},{removed:e},{error:e}")
    });
    let row = format_args!(
        "{time:.9},{},{},{out},{},{},{outflow:.6},{:e},{:e},{:e},{:e}{books},{:e},{:e},{:.6}\n",
        ledger.released,
        ledger.inside(),
        ledger.lost(),
        ledger.culled,
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
    file: Parcel<SeriesFile>,
    space: std::marker::PhantomData<V>,
}

impl<V: Space> SeriesPlugin<V> {
    /// Creates the file at `path` with its header; `tracks_energy` tells whether books of energy are kept.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn create(config: Series, tracks_energy: bool, path: &Path) -> std::io::Result<Self> {
        let file = Parcel::new(SeriesFile { rows: Rows::create(path, &header(tracks_energy))?, last: None });
        Ok(Self { config, file, space: std::marker::PhantomData })
    }
}

impl<V: Space> Plugin for SeriesPlugin<V> {
    fn build(&self, app: &mut App) {
        let Some(file) = self.file.open() else { return };
        observe_every::<Series>(app, self.config.interval.get());
        app.insert_resource(file).add_systems(Step, write_row::<V>.in_set(ObserveStage::Write).run_if(due::<Series>));
    }
}
