//! `wall_bands.csv`: means of the scene's [`wall_bands`](crate::measure::wall_bands), pressure and wall friction by height. `COLUMNS` has the
//! columns.

use std::fmt::Write as _;

use bevy_app::{App, Plugin};
use bevy_ecs::prelude::*;

use crate::measure::ObserveStage;
use crate::measure::averaging::{Averaging, Progress};
use crate::measure::wall_bands::{BandMeans, BandSampler, SavedBands, WallBands};
use crate::writers::rows::{Rows, TakenOnce};
use siloflow_dem::outcome::Outcome;
use siloflow_dem::persist::{PersistApp as _, Problem};
use siloflow_dem::space::{Dimension, Space};
use siloflow_dem::step::{Clock, Step};
use siloflow_dem::store::register_predictable;
use siloflow_dem::survey::SurveyParam;
use siloflow_files::columns::Cell::{Decimal, Scientific, Whole};
use siloflow_files::columns::{Column, Columns};
use siloflow_files::growing::OutputPlace;

/// Bands that are being averaged.
struct Running {
    sampler: BandSampler,
    averaging: Averaging,
}

#[derive(Resource)]
struct BandsFile {
    file: Rows,
    columns: Columns<BandRow>,
    running: Vec<Running>,
}

impl BandsFile {
    fn restore(&mut self, (length, averages): (u64, Vec<(SavedBands, Progress)>)) -> Result<(), Problem> {
        if averages.len() != self.running.len() {
            return Err("the number of wall bands differs".to_owned());
        }
        for (running, (sums, progress)) in self.running.iter_mut().zip(averages) {
            running.averaging.restore(progress);
            running.sampler.restore(sums)?;
        }
        self.file.restore(length)
    }
}

/// A row of the file.
#[derive(Debug)]
pub(crate) struct BandRow {
    bands: usize,
    /// s.
    window: [f64; 2],
    samples: u64,
    means: BandMeans,
}

const PRESSURE: &str =
    "normal force over the area of the walls in the bin, at their places at the start; `NaN` without walls in the bin";
const PLANAR_PRESSURE: &str = "in the plane: normal force over that length";
const TRACTION: &str = "downward friction on the wall over that area";
const PLANAR_TRACTION: &str = "in the plane: downward friction on the wall over that length";

/// The columns.
pub(crate) const COLUMNS: &[Column<BandRow>] = &[
    Column::new("bands", "", "number of the entry in the scene, from 1", |row| Whole(row.bands as u64)),
    Column::new("from_s", "s", "times of the first and the last sample", |row| Decimal(row.window[0])),
    Column::new("to_s", "s", "times of the first and the last sample", |row| Decimal(row.window[1])),
    Column::new("samples", "", "number of samples", |row| Whole(row.samples)),
    Column::new("low_m", "m", "ends of the bin", |row| Decimal(row.means.heights[0])),
    Column::new("high_m", "m", "ends of the bin", |row| Decimal(row.means.heights[1])),
    Column::solid("area_m2", "m^2", "area of the walls in the bin", |row| Scientific(row.means.area)),
    Column::planar("length_m", "m", "in the plane: length of the walls in the bin", |row| Scientific(row.means.area)),
    Column::new("contacts", "", "contacts per sample", |row| Decimal(row.means.contacts)),
    Column::solid("pressure_pa", "Pa", PRESSURE, |row| Scientific(row.means.pressure)),
    Column::planar("pressure_n_per_m", "N/m", PLANAR_PRESSURE, |row| Scientific(row.means.pressure)),
    Column::solid("downward_traction_pa", "Pa", TRACTION, |row| Scientific(row.means.downward_traction)),
    Column::planar("downward_traction_n_per_m", "N/m", PLANAR_TRACTION, |row| Scientific(row.means.downward_traction)),
];

/// Run condition: a sample is due, an average is complete, or the run ends.
fn has_work(clock: Res<Clock>, bands: Res<BandsFile>, outcome: Res<Outcome>) -> bool {
    outcome.end().is_some() || bands.running.iter().any(|bands| bands.averaging.has_work(&clock))
}

fn sample<V: Space>(
    clock: Res<Clock>,
    survey: SurveyParam<V>,
    mut bands: ResMut<BandsFile>,
    mut outcome: ResMut<Outcome>,
) {
    let ends = outcome.end().is_some();
    let BandsFile { file, columns, running } = &mut *bands;
    for (number, Running { sampler, averaging }) in (1..).zip(running) {
        if averaging.is_due(&clock) {
            averaging.count(&clock);
            sampler.add(survey.survey());
        }
        if let Some(done) = averaging.complete(&clock, ends) {
            let mut text = String::new();
            for means in sampler.take(done.samples) {
                let row = BandRow { bands: number, window: done.window, samples: done.samples, means };
                // Writing to a string cannot fail.
                let _ = writeln!(text, "{}", columns.cells(&row));
            }
            file.append(format_args!("{text}"), &mut outcome);
        }
    }
}

/// Measures and writes loads on walls by height.
pub struct WallBandsPlugin<V: Space>(TakenOnce<BandsFile>, std::marker::PhantomData<V>);

impl<V: Space> WallBandsPlugin<V> {
    /// Creates the file with its header, or continues it.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn create(samplers: Vec<BandSampler>, place: &OutputPlace) -> std::io::Result<Self> {
        let columns = Columns::of(V::DIMENSION == Dimension::Solid, &[COLUMNS]);
        let running = samplers.into_iter().map(|sampler| {
            let WallBands { sample, from, average, .. } = sampler.bands;
            Running { sampler, averaging: Averaging::new(sample, from, average) }
        });
        let file = BandsFile { file: Rows::at(place, &columns.header())?, columns, running: running.collect() };
        Ok(Self(TakenOnce::new(file), std::marker::PhantomData))
    }
}

impl<V: Space> Plugin for WallBandsPlugin<V> {
    fn build(&self, app: &mut App) {
        let Some(bands) = self.0.open() else { return };
        app.persist_sound_part::<BandsFile, _>(
            |bands| {
                let of = |running: &Running| (running.sampler.saved(), running.averaging.saved());
                Ok((bands.file.saved()?, bands.running.iter().map(of).collect()))
            },
            BandsFile::restore,
        );
        app.insert_resource(bands);
        register_predictable(app, has_work, has_work);
        app.add_systems(Step, sample::<V>.in_set(ObserveStage::Measure).run_if(has_work));
    }
}
