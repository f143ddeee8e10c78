//! `losses.csv`: every lost grain, if more than [`IN_SUMMARY`] are lost. The first ones stand in `summary.json` too.
//!
//! `COLUMNS` has the columns.
//!
//! Rows are written together with the rows of `series.csv`. The file is made when the first rows are due, so that a run
//! without losses has no file.

use bevy_app::{App, Plugin};
use bevy_ecs::prelude::*;
use std::fmt::Write as _;

use crate::ledger::{Ledger, LossRecord};
use crate::measure::{ClocksRead, due};
use crate::scene::outputs::Series;
use crate::writers::rows::Rows;
use siloflow_dem::outcome::{Failure, Outcome};
use siloflow_dem::persist::PersistApp as _;
use siloflow_dem::persist::Problem;
use siloflow_dem::space::Dimension;
use siloflow_dem::step::{Part, Phase, Step};
use siloflow_files::columns::Cell::{Decimal, Empty, Quoted, Scientific, Whole};
use siloflow_files::columns::{Cell, Column, Columns};
use siloflow_files::growing::OutputPlace;
use siloflow_files::whole_file::remove_if_there;

/// Largest number of lost grains that the summary lists.
pub const IN_SUMMARY: usize = 100;

/// The columns. The description is quoted, because a behaviour may have written it.
pub(crate) const COLUMNS: &[Column<LossRecord>] = &[
    Column::new("grain", "", "id of the grain", |loss| Whole(loss.grain.into())),
    Column::new("step", "", "step at which the loss was found", |loss| Whole(loss.step)),
    Column::new("time_s", "s", "simulated time at which the loss was found", |loss| Decimal(loss.time_s)),
    Column::new("x_m", "m", "position", |loss| coordinate(loss, 0)),
    Column::new("y_m", "m", "position", |loss| coordinate(loss, 1)),
    Column::solid("z_m", "m", "position", |loss| coordinate(loss, 2)),
    Column::new("nearest_wall_grain", "", "number in the silo file; empty if there is none", |loss| {
        loss.nearest_wall_grain.map_or(Empty, |number| Whole(number.into()))
    }),
    Column::new("way", "", "how the grain was lost, in words", |loss| Quoted(&loss.way)),
];

fn coordinate(loss: &LossRecord, axis: usize) -> Cell<'_> {
    loss.position_m.get(axis).map_or(Empty, |&x| Scientific(x))
}

/// The file of lost grains.
#[derive(Resource)]
pub(crate) struct LossesFile {
    /// The place at which the file will be made.
    pub(crate) place: OutputPlace,
    rows: Option<Rows>,
    columns: Columns<LossRecord>,
}

impl LossesFile {
    /// Continues the file with the first `length` bytes, or removes it if there was none.
    fn restore(&mut self, length: Option<u64>) -> Result<(), Problem> {
        let failed = |error: std::io::Error| format!("could not continue {}: {error}", self.place.path.display());
        match length {
            // A file that is not there takes no part: the caller has accepted that, and the next loss begins a new one.
            Some(_) if self.place.path.symlink_metadata().is_err() => Ok(()),
            Some(length) => {
                self.rows.insert(Rows::at(&self.place, &self.columns.header()).map_err(failed)?).restore(length)
            }
            None => {
                self.place.record().is_removed();
                remove_if_there(&self.place.path).map_err(failed)
            }
        }
    }
}

fn write_rows(mut ledger: ResMut<Ledger>, mut file: ResMut<LossesFile>, mut outcome: ResMut<Outcome>) {
    if ledger.lost.len() <= IN_SUMMARY {
        return;
    }
    let mut text = String::new();
    let LossesFile { place, rows, columns } = &mut *file;
    let rows = match rows {
        Some(rows) => rows,
        None => match Rows::at(&OutputPlace { is_continued: false, ..place.clone() }, &columns.header()) {
            Ok(created) => {
                ledger.lost[..IN_SUMMARY].iter().for_each(|loss| add(&mut text, columns, loss));
                rows.insert(created)
            }
            Err(error) => {
                let path = place.path.file_name().unwrap_or_default().to_string_lossy().into_owned();
                return outcome.fail(Failure::Output { path, reason: error.to_string() });
            }
        },
    };
    ledger.take_losses(IN_SUMMARY).iter().for_each(|loss| add(&mut text, columns, loss));
    rows.append(format_args!("{text}"), &mut outcome);
}

/// Adds the row of a lost grain. Writing to a string cannot fail.
fn add(text: &mut String, columns: &Columns<LossRecord>, loss: &LossRecord) {
    let _ = writeln!(text, "{}", columns.cells(loss));
}

/// Writes `losses.csv`.
pub struct LossesPlugin {
    /// Place of the file.
    pub place: OutputPlace,
    /// The space of the scene.
    pub space: Dimension,
}

impl Plugin for LossesPlugin {
    fn build(&self, app: &mut App) {
        let columns = Columns::of(self.space == Dimension::Solid, &[COLUMNS]);
        // Before all observers, because these read the grain accounting.
        let stage = Part::Engine(Phase::Observe);
        app.persist_sound_part::<LossesFile, _>(
            |file| file.rows.as_ref().map(Rows::saved).transpose(),
            LossesFile::restore,
        );
        app.insert_resource(LossesFile { place: self.place.clone(), rows: None, columns })
            .add_systems(Step, write_rows.in_set(stage).after(ClocksRead).run_if(due::<Series>));
    }
}
