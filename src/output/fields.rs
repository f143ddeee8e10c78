//! `fields.csv`: means of the scene's [`fields`](crate::measure::fields), with their standard errors.
//!
//! `CELLS` has the first columns, [`MEANS`](crate::measure::fields::MEANS) those of the means, each followed by its standard error with
//! `_error` at the end of the name. Axes 1, 2, 3 are x, y, z, and on (r, z) grids the radius, the angle and z.
//! A value is empty where no grain was, an error also below eight blocks.

use std::fmt::Write as _;

use bevy_app::{App, Plugin};
use bevy_ecs::prelude::*;

use crate::measure::ObserveStage;
use crate::measure::averaging::{Averaging, Progress};
use crate::measure::fields::{Blocks, FieldSampler};
use crate::writers::rows::{Rows, TakenOnce};
use siloflow_dem::outcome::Outcome;
use siloflow_dem::persist::{PersistApp as _, Problem};
use siloflow_dem::space::{Dimension, Space};
use siloflow_dem::step::{Clock, Step};
use siloflow_dem::store::register_predictable;
use siloflow_dem::survey::SurveyParam;
use siloflow_files::columns::Cell::{Decimal, Empty, Scientific, Whole};
use siloflow_files::columns::{Cell, Column, Columns};
use siloflow_files::growing::OutputPlace;

/// The first cells of a row.
#[derive(Debug)]
pub(crate) struct CellRow {
    field: usize,
    /// s.
    window: [f64; 2],
    samples: u64,
    /// s.
    block: f64,
    /// m.
    place: Vec<Option<f64>>,
}

const PLACE: &str = "middle of the cell; empty along an axis that the grid does not resolve";

/// The first columns.
pub(crate) const CELLS: &[Column<CellRow>] = &[
    Column::new("field", "", "number of the field in the scene, from 1", |row| Whole(row.field as u64)),
    Column::new("from_s", "s", "times of the first and the last sample", |row| Decimal(row.window[0])),
    Column::new("to_s", "s", "times of the first and the last sample", |row| Decimal(row.window[1])),
    Column::new("samples", "", "number of samples", |row| Whole(row.samples)),
    Column::new(
        "block_s",
        "s",
        "time of a block of samples: the errors are sound if samples so far apart are independent",
        |row| Decimal(row.block),
    ),
    Column::new("x1_m", "m", PLACE, |row| coordinate(row, 0)),
    Column::new("x2_m", "m", PLACE, |row| coordinate(row, 1)),
    Column::solid("x3_m", "m", PLACE, |row| coordinate(row, 2)),
];

fn coordinate(row: &CellRow, axis: usize) -> Cell<'_> {
    row.place[axis].map_or(Empty, Decimal)
}

/// A field that is being averaged.
struct Running<V: Space> {
    /// Number of the field in the scene, from 1.
    number: usize,
    sampler: FieldSampler<V>,
    averaging: Averaging,
}

/// All fields of a scene and their file.
#[derive(Resource)]
struct Fields<V: Space> {
    file: Rows,
    columns: Columns<CellRow>,
    running: Vec<Running<V>>,
}

fn sample<V: Space>(
    clock: Res<Clock>,
    survey: SurveyParam<V>,
    mut fields: ResMut<Fields<V>>,
    mut outcome: ResMut<Outcome>,
) {
    let ends = outcome.end().is_some();
    let Fields { file, columns, running } = &mut *fields;
    for field in running {
        if field.averaging.is_due(&clock) {
            field.averaging.count(&clock);
            field.sampler.add(&survey.survey());
        }
        if let Some(done) = field.averaging.complete(&clock, ends) {
            file.append(format_args!("{}", field.take_rows(columns, done)), &mut outcome);
        }
    }
}

/// Run condition: a sample is due, an average is complete, or the run ends.
fn has_work<V: Space>(clock: Res<Clock>, fields: Res<Fields<V>>, outcome: Res<Outcome>) -> bool {
    outcome.end().is_some() || fields.running.iter().any(|field| field.averaging.has_work(&clock))
}

impl<V: Space> Fields<V> {
    fn restore(&mut self, (length, averages): (u64, Vec<(Blocks, Progress)>)) -> Result<(), Problem> {
        let fits =
            |(running, (blocks, _)): (&Running<V>, &(Blocks, Progress))| blocks.fit(running.sampler.blocks.len());
        if averages.len() != self.running.len() || !self.running.iter().zip(&averages).all(fits) {
            return Err("the number of fields or of their cells differs".to_owned());
        }
        for (running, (blocks, progress)) in self.running.iter_mut().zip(averages) {
            running.sampler.blocks = blocks;
            running.averaging.restore(progress);
        }
        self.file.restore(length)
    }
}

impl<V: Space> Running<V> {
    fn saved(&self) -> (Blocks, Progress) {
        (self.sampler.blocks.clone(), self.averaging.saved())
    }

    /// Returns the means as CSV rows and begins a new average. Writing to a string cannot fail.
    #[expect(clippy::cast_precision_loss, reason = "numbers of samples")]
    fn take_rows(&mut self, columns: &Columns<CellRow>, Progress { samples, window, .. }: Progress) -> String {
        let FieldSampler { field, grid, layout, blocks } = &mut self.sampler;
        let blocks = std::mem::replace(blocks, Blocks::new(blocks.len()));
        let block = blocks.block() as f64 * field.sample.get();
        let mut text = String::new();
        for cell in 0..grid.len() {
            let row = CellRow { field: self.number, window, samples, block, place: grid.place(cell) };
            let _ = write!(text, "{}", columns.cells(&row));
            let sums = cell * layout.sums()..(cell + 1) * layout.sums();
            for (mean, error) in blocks.estimate(sums, |sums| layout.means_of(sums)) {
                for number in [Some(mean).filter(|mean| mean.is_finite()), error.filter(|_| mean.is_finite())] {
                    let _ = write!(text, ",{}", number.map_or(Empty, Scientific));
                }
            }
            text.push('\n');
        }
        text
    }
}

/// Measures and writes fields.
pub struct FieldsPlugin<V: Space>(TakenOnce<Fields<V>>);

impl<V: Space> FieldsPlugin<V> {
    /// Creates the file with its header, or continues it. All samplers have the same number of species.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn create(samplers: Vec<FieldSampler<V>>, place: &OutputPlace) -> std::io::Result<Self> {
        let columns = Columns::of(V::DIMENSION == Dimension::Solid, &[CELLS]);
        let mut header = columns.header();
        for name in samplers.first().iter().flat_map(|sampler| sampler.layout.names()) {
            let _ = write!(header, ",{name},{name}_error");
        }
        let running = (1..).zip(samplers).map(|(number, sampler)| {
            let averaging = Averaging::new(sampler.field.sample, sampler.field.from, sampler.field.average);
            Running { number, sampler, averaging }
        });
        let running = running.collect();
        Ok(Self(TakenOnce::new(Fields { file: Rows::at(place, &header)?, columns, running })))
    }
}

impl<V: Space> Plugin for FieldsPlugin<V> {
    fn build(&self, app: &mut App) {
        let Some(fields) = self.0.open() else { return };
        app.persist_sound_part::<Fields<V>, _>(
            |fields| Ok((fields.file.saved()?, fields.running.iter().map(Running::saved).collect())),
            Fields::restore,
        );
        app.insert_resource(fields);
        register_predictable(app, has_work::<V>, has_work::<V>);
        app.add_systems(Step, sample::<V>.in_set(ObserveStage::Measure).run_if(has_work::<V>));
    }
}
