//! `fields.csv`: means of the scene's [`fields`](crate::measure::fields), with their standard errors.
//!
//! | column | unit | meaning |
//! |---|---|---|
//! | `field` | | number of the field in the scene, from 1 |
//! | `from_s`, `to_s` | s | times of the first and last sample of the means |
//! | `samples`, `block_s` | , s | number of samples; time of a block of samples, from whose spread the errors follow |
//! | `x1_m`, `x2_m`, `x3_m` | m | middle of the cell, empty along an axis that the grid does not resolve |
//! | `solid_fraction` | | volume of grains over volume; in the plane, areas |
//! | `density` | kg/m^3 | mass over volume; in the plane kg/m^2 |
//! | `v1`, ... | m/s | mean velocity |
//! | `temperature` | m^2/s^2 | granular temperature |
//! | `kinetic_11`, ... | Pa | kinetic stress, symmetric; in the plane N/m |
//! | `contact_11`, ... | Pa | contact stress, the force as first index; in the plane N/m |
//! | `share_0`, ... | | share of each species in the mass, if the scene has several |
//!
//! Axes 1, 2, 3 are x, y, z, and on (r, z) grids the radius, the angle and z. Each column of a mean is followed by its standard error with
//! `_error` at the end of the name. A value is empty where no grain was, an error also below eight blocks.

use std::fmt::Write as _;

use bevy_app::{App, Plugin};
use bevy_ecs::prelude::*;

use crate::measure::ObserveStage;
use crate::measure::fields::{Blocks, FieldSampler};
use crate::outcome::Outcome;
use crate::persist::{PersistApp as _, Problem};
use crate::space::Space;
use crate::step::{Clock, Step};
use crate::store::register_predictable;
use crate::survey::SurveyParam;
use crate::values::{NonNegative, Positive};
use crate::writers::rows::{Rows, RowsPlace, TakenOnce};

/// A field that is being averaged.
struct Running<V: Space> {
    /// Number of the field in the scene, from 1.
    number: usize,
    sampler: FieldSampler<V>,
    /// Number of samples since the start of the run.
    samples_taken: u64,
    /// Times of the first and last sample of the present average, s.
    window: [f64; 2],
}

/// All fields of a scene and their file.
#[derive(Resource)]
struct Fields<V: Space> {
    file: Rows,
    running: Vec<Running<V>>,
}

fn sample<V: Space>(
    clock: Res<Clock>,
    survey: SurveyParam<V>,
    mut fields: ResMut<Fields<V>>,
    mut outcome: ResMut<Outcome>,
) {
    let (now, ends) = (clock.time(), outcome.end().is_some());
    let Fields { file, running } = &mut *fields;
    for field in running {
        if field.is_due(&clock) {
            field.samples_taken += 1;
            if field.sampler.blocks.samples() == 0 {
                field.window[0] = now;
            }
            field.window[1] = now;
            field.sampler.add(&survey.survey());
        }
        if field.sampler.blocks.samples() > 0 && (ends || field.is_full(&clock)) {
            file.append(format_args!("{}", field.take_rows()), &mut outcome);
        }
    }
}

/// Run condition: a sample is due, an average is complete, or the run ends.
fn has_work<V: Space>(clock: Res<Clock>, fields: Res<Fields<V>>, outcome: Res<Outcome>) -> bool {
    let mut running = fields.running.iter();
    outcome.end().is_some() || running.any(|field| field.is_due(&clock) || field.is_full(&clock))
}

/// State of a running average: its sums, the number of samples since the start, the times of its first and last sample.
type SavedAverage = (Blocks, u64, [f64; 2]);

impl<V: Space> Fields<V> {
    fn restore(&mut self, (length, averages): (u64, Vec<SavedAverage>)) -> Result<(), Problem> {
        let fits = |(running, (blocks, ..)): (&Running<V>, &SavedAverage)| running.sampler.blocks.len() == blocks.len();
        if averages.len() != self.running.len() || !self.running.iter().zip(&averages).all(fits) {
            return Err("the number of fields or of their cells differs".to_owned());
        }
        for (running, (blocks, samples_taken, window)) in self.running.iter_mut().zip(averages) {
            running.sampler.blocks = blocks;
            (running.samples_taken, running.window) = (samples_taken, window);
        }
        self.file.restore(length)
    }
}

impl<V: Space> Running<V> {
    fn saved(&self) -> SavedAverage {
        (self.sampler.blocks.clone(), self.samples_taken, self.window)
    }

    #[expect(clippy::cast_precision_loss, reason = "2^53 samples are out of reach")]
    fn is_due(&self, clock: &Clock) -> bool {
        let field = &self.sampler.field;
        clock.has_reached(field.from.map_or(0.0, NonNegative::get) + self.samples_taken as f64 * field.sample.get())
    }

    /// Returns whether the samples cover the whole averaging time.
    fn is_full(&self, clock: &Clock) -> bool {
        let field = &self.sampler.field;
        let is_over = |average: Positive| clock.has_reached(self.window[0] + average.get() - field.sample.get());
        self.sampler.blocks.samples() > 0 && field.average.is_some_and(is_over)
    }

    /// Returns the means as CSV rows and begins a new average. Writing to a string cannot fail.
    #[expect(clippy::cast_precision_loss, reason = "numbers of samples")]
    fn take_rows(&mut self) -> String {
        let FieldSampler { field, grid, layout, blocks } = &mut self.sampler;
        let blocks = std::mem::replace(blocks, Blocks::new(blocks.len()));
        let block = blocks.block() as f64 * field.sample.get();
        let (number, samples, [from, to]) = (self.number, blocks.samples(), self.window);
        let mut text = String::new();
        for cell in 0..grid.len() {
            let _ = write!(text, "{number},{from:.9},{to:.9},{samples},{block}");
            for place in grid.place(cell) {
                text.push_str(&place.map_or_else(|| ",".to_owned(), |place| format!(",{place:.9}")));
            }
            let sums = cell * layout.sums()..(cell + 1) * layout.sums();
            for (mean, error) in blocks.estimate(sums, |sums| layout.means_of(sums)) {
                for number in [Some(mean).filter(|mean| mean.is_finite()), error.filter(|_| mean.is_finite())] {
                    text.push_str(&number.map_or_else(|| ",".to_owned(), |number| format!(",{number:e}")));
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
    pub fn create(samplers: Vec<FieldSampler<V>>, place: &RowsPlace) -> std::io::Result<Self> {
        let mut header = "field,from_s,to_s,samples,block_s".to_owned();
        (1..=V::COMPONENTS).for_each(|axis| {
            let _ = write!(header, ",x{axis}_m");
        });
        for name in samplers.first().iter().flat_map(|sampler| sampler.layout.names()) {
            let _ = write!(header, ",{name},{name}_error");
        }
        let running = (1..).zip(samplers).map(|(number, sampler)| Running {
            number,
            sampler,
            samples_taken: 0,
            window: [0.0; 2],
        });
        let running = running.collect();
        Ok(Self(TakenOnce::new(Fields { file: Rows::at(place, &header)?, running })))
    }
}

impl<V: Space> Plugin for FieldsPlugin<V> {
    fn build(&self, app: &mut App) {
        let Some(fields) = self.0.open() else { return };
        app.persist_part::<Fields<V>, _>(
            |fields| Ok((fields.file.saved()?, fields.running.iter().map(Running::saved).collect())),
            Fields::restore,
        );
        app.insert_resource(fields);
        register_predictable(app, has_work::<V>, has_work::<V>);
        app.add_systems(Step, sample::<V>.in_set(ObserveStage::Measure).run_if(has_work::<V>));
    }
}
