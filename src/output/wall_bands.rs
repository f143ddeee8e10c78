//! `wall_bands.csv`: means of the scene's [`wall_bands`](crate::measure::wall_bands), pressure and wall friction by height.
//!
//! | column | unit | meaning |
//! |---|---|---|
//! | `bands` | | number of the entry in the scene, from 1 |
//! | `from_s`, `to_s`, `samples` | s | times of the first and last sample of the means, and number of samples |
//! | `low_m`, `high_m` | m | ends of the bin |
//! | `area_m2` | m^2 | area of the walls in the bin; in the plane `length_m`, m |
//! | `contacts` | | contacts per sample |
//! | `pressure_pa` | Pa | normal force over area; in the plane `pressure_n_per_m`, N/m |
//! | `downward_traction_pa` | Pa | downward friction on the wall over area; in the plane `downward_traction_n_per_m`, N/m |

use std::fmt::Write as _;

use bevy_app::{App, Plugin};
use bevy_ecs::prelude::*;

use crate::measure::ObserveStage;
use crate::measure::wall_bands::{BandSampler, SavedBands, WallBands};
use crate::outcome::Outcome;
use crate::persist::{PersistApp as _, Problem};
use crate::space::{Dimension, Space};
use crate::step::{Clock, Step};
use crate::store::register_predictable;
use crate::survey::SurveyParam;
use crate::values::NonNegative;
use crate::writers::rows::{Rows, RowsPlace, TakenOnce};

/// Bands that are being averaged.
#[derive(Clone)]
struct Running {
    sampler: BandSampler,
    /// Number of samples since the start of the run.
    samples_taken: u64,
    /// Time of the first sample of the present average, s.
    from: f64,
    /// Time of the last sample, s.
    to: f64,
}

#[derive(Resource)]
struct BandsFile {
    file: Rows,
    running: Vec<Running>,
}

/// State of a running average: its sums, the number of samples since the start, and the times of its first and last sample.
type SavedAverage = (SavedBands, u64, [f64; 2]);

impl BandsFile {
    fn restore(&mut self, (length, averages): (u64, Vec<SavedAverage>)) -> Result<(), Problem> {
        if averages.len() != self.running.len() {
            return Err("the number of wall bands differs".to_owned());
        }
        for (running, (sums, samples_taken, [from, to])) in self.running.iter_mut().zip(averages) {
            (running.samples_taken, running.from, running.to) = (samples_taken, from, to);
            running.sampler.restore(sums)?;
        }
        self.file.restore(length)
    }
}

impl Running {
    #[expect(clippy::cast_precision_loss, reason = "2^53 samples are out of reach")]
    fn is_due(&self, clock: &Clock) -> bool {
        let WallBands { sample, from, .. } = &self.sampler.bands;
        clock.has_reached(from.map_or(0.0, NonNegative::get) + self.samples_taken as f64 * sample.get())
    }

    /// Returns whether the samples cover the whole averaging time.
    fn is_full(&self, clock: &Clock) -> bool {
        let WallBands { sample, average, .. } = &self.sampler.bands;
        let is_over = |average: f64| clock.has_reached(self.from + average - sample.get());
        self.sampler.samples > 0 && average.is_some_and(|average| is_over(average.get()))
    }

    /// Returns the means as CSV rows and begins a new average.
    fn take_rows(&mut self, number: usize) -> String {
        let (from, to, samples) = (self.from, self.to, self.sampler.samples);
        let mut text = String::new();
        for bin in self.sampler.take() {
            let [low, high] = bin.heights;
            // Writing to a string cannot fail.
            let _ = writeln!(
                text,
                "{number},{from:.9},{to:.9},{samples},{low:.9},{high:.9},{:e},{:.6},{:e},{:e}",
                bin.area, bin.contacts, bin.pressure, bin.downward_traction
            );
        }
        text
    }
}

/// Run condition: a sample is due, an average is complete, or the run ends.
fn has_work(clock: Res<Clock>, bands: Res<BandsFile>, outcome: Res<Outcome>) -> bool {
    let mut running = bands.running.iter();
    outcome.end().is_some() || running.any(|bands| bands.is_due(&clock) || bands.is_full(&clock))
}

fn sample<V: Space>(
    clock: Res<Clock>,
    survey: SurveyParam<V>,
    mut bands: ResMut<BandsFile>,
    mut outcome: ResMut<Outcome>,
) {
    let (now, ends) = (clock.time(), outcome.end().is_some());
    let BandsFile { file, running } = &mut *bands;
    for (number, bands) in (1..).zip(running) {
        if bands.is_due(&clock) {
            bands.samples_taken += 1;
            if bands.sampler.samples == 0 {
                bands.from = now;
            }
            bands.to = now;
            bands.sampler.add(survey.survey());
        }
        if bands.sampler.samples > 0 && (ends || bands.is_full(&clock)) {
            file.append(format_args!("{}", bands.take_rows(number)), &mut outcome);
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
    pub fn create(samplers: Vec<BandSampler>, place: &RowsPlace) -> std::io::Result<Self> {
        let [area, unit] = if V::DIMENSION == Dimension::Solid { ["area_m2", "pa"] } else { ["length_m", "n_per_m"] };
        let header =
            format!("bands,from_s,to_s,samples,low_m,high_m,{area},contacts,pressure_{unit},downward_traction_{unit}");
        let running =
            samplers.into_iter().map(|sampler| Running { sampler, samples_taken: 0, from: 0.0, to: 0.0 }).collect();
        let file = BandsFile { file: Rows::at(place, &header)?, running };
        Ok(Self(TakenOnce::new(file), std::marker::PhantomData))
    }
}

impl<V: Space> Plugin for WallBandsPlugin<V> {
    fn build(&self, app: &mut App) {
        let Some(bands) = self.0.open() else { return };
        app.persist_part::<BandsFile, _>(
            |bands| {
                let of =
                    |running: &Running| (running.sampler.saved(), running.samples_taken, [running.from, running.to]);
                Ok((bands.file.saved()?, bands.running.iter().map(of).collect()))
            },
            BandsFile::restore,
        );
        app.insert_resource(bands);
        register_predictable(app, has_work, has_work);
        app.add_systems(Step, sample::<V>.in_set(ObserveStage::Measure).run_if(has_work));
    }
}
