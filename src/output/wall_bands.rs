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
use crate::measure::averaging::{Averaging, Progress};
use crate::measure::wall_bands::{BandSampler, SavedBands, WallBands};
use crate::writers::rows::{Rows, TakenOnce};
use siloflow_dem::outcome::Outcome;
use siloflow_dem::persist::{PersistApp as _, Problem};
use siloflow_dem::space::{Dimension, Space};
use siloflow_dem::step::{Clock, Step};
use siloflow_dem::store::register_predictable;
use siloflow_dem::survey::SurveyParam;
use siloflow_files::growing::OutputPlace;

/// Bands that are being averaged.
struct Running {
    sampler: BandSampler,
    averaging: Averaging,
}

#[derive(Resource)]
struct BandsFile {
    file: Rows,
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

/// Returns the means as CSV rows and resets the sums.
fn take_rows(
    sampler: &mut BandSampler,
    number: usize,
    Progress { samples, window: [from, to], .. }: Progress,
) -> String {
    let mut text = String::new();
    for bin in sampler.take(samples) {
        let [low, high] = bin.heights;
        // Writing to a string cannot fail.
        let _ = writeln!(
            text,
            "{number},{from:?},{to:?},{samples},{low:?},{high:?},{:e},{:?},{:e},{:e}",
            bin.area, bin.contacts, bin.pressure, bin.downward_traction
        );
    }
    text
}

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
    let BandsFile { file, running } = &mut *bands;
    for (number, Running { sampler, averaging }) in (1..).zip(running) {
        if averaging.is_due(&clock) {
            averaging.count(&clock);
            sampler.add(survey.survey());
        }
        if let Some(done) = averaging.complete(&clock, ends) {
            file.append(format_args!("{}", take_rows(sampler, number, done)), &mut outcome);
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
        let [area, unit] = if V::DIMENSION == Dimension::Solid { ["area_m2", "pa"] } else { ["length_m", "n_per_m"] };
        let header =
            format!("bands,from_s,to_s,samples,low_m,high_m,{area},contacts,pressure_{unit},downward_traction_{unit}");
        let running = samplers.into_iter().map(|sampler| {
            let WallBands { sample, from, average, .. } = sampler.bands;
            Running { sampler, averaging: Averaging::new(sample, from, average) }
        });
        let file = BandsFile { file: Rows::at(place, &header)?, running: running.collect() };
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
