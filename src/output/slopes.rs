//! `slopes.csv`: the slopes of free surfaces ([`slopes`](crate::measure::slope)) at the times of the rows of `series.csv`, and their means in the summary.

use std::marker::PhantomData;

use bevy_app::{App, Plugin};
use bevy_ecs::prelude::*;
use serde::{Deserialize, Serialize};

use crate::door::DoorState;
use crate::measure::moment::Events;
use crate::measure::slope::{Measured, Slope, Sphere};
use crate::measure::{ObserveStage, due};
use crate::rest::RestDetector;
use crate::scene::outputs::Series;
use crate::writers::rows::{Rows, TakenOnce};
use siloflow_dem::outcome::Outcome;
use siloflow_dem::persist::{PersistApp as _, Problem};
use siloflow_dem::space::{Dimension, Space};
use siloflow_dem::step::{Clock, Step};
use siloflow_dem::survey::{Partner, Survey, SurveyParam};
use siloflow_dem::values::Positive;
use siloflow_files::columns::Cell::{Decimal, Scientific, Text, Whole};
use siloflow_files::columns::{Column, Columns};
use siloflow_files::growing::OutputPlace;

/// A slope at a time.
#[derive(Debug)]
pub(crate) struct SlopeRow {
    /// s.
    time: f64,
    name: String,
    measured: Option<Measured>,
}

impl SlopeRow {
    fn number(&self, of: impl Fn(&Measured) -> f64) -> f64 {
        self.measured.as_ref().map_or(f64::NAN, of)
    }
}

/// The columns.
pub(crate) const COLUMNS: &[Column<SlopeRow>] = &[
    Column::new("time_s", "s", "simulated time", |row| Decimal(row.time)),
    Column::new("slope", "", "name of the slope", |row| Text(&row.name)),
    Column::new("angle_deg", "degrees", "angle to the horizontal; `NaN` with fewer than three points", |row| {
        Decimal(row.number(|slope| slope.angle))
    }),
    Column::new("height_m", "m", "mean height of the points", |row| Decimal(row.number(|slope| slope.height))),
    Column::new("scatter_m", "m", "root-mean-square distance in height of the points from the line", |row| {
        Scientific(row.number(|slope| slope.scatter))
    }),
    Column::new("points", "", "number of points of the surface", |row| {
        Whole(row.measured.map_or(0, |slope| slope.points as u64))
    }),
];

/// The mean of a slope over the rows of its window, in the summary.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SlopeFigures {
    /// Its name.
    pub slope: String,
    /// Mean angle to the horizontal, degrees; `None` if no row has one.
    pub angle_deg: Option<f64>,
    /// Standard deviation of the rows, degrees; `None` with fewer than two.
    pub deviation_deg: Option<f64>,
    /// Number of rows with an angle.
    pub rows: u32,
    /// Mean root-mean-square distance of the points from the line, m.
    pub scatter_m: Option<f64>,
}

/// Sums over the rows of a window.
#[derive(Clone, Copy, Debug, Default, Deserialize, Serialize)]
struct Sums {
    rows: u32,
    /// Angle, degrees, and its square.
    angle: [f64; 2],
    /// m.
    scatter: f64,
}

impl Sums {
    fn add(&mut self, measured: &Measured) {
        self.rows += 1;
        self.angle[0] += measured.angle;
        self.angle[1] += measured.angle * measured.angle;
        self.scatter += measured.scatter;
    }

    fn figures(&self, name: &str) -> SlopeFigures {
        let count = f64::from(self.rows);
        let mean = self.angle[0] / count;
        let variance = (self.angle[1] - count * mean * mean) / (count - 1.0);
        SlopeFigures {
            slope: name.to_owned(),
            angle_deg: (self.rows > 0).then_some(mean),
            deviation_deg: (self.rows > 1).then(|| variance.max(0.0).sqrt()),
            rows: self.rows,
            scatter_m: (self.rows > 0).then(|| self.scatter / count),
        }
    }
}

/// Returns the figures of the slopes of a world.
#[must_use]
pub fn figures(world: &World) -> Vec<SlopeFigures> {
    let Some(file) = world.get_resource::<SlopesFile>() else { return Vec::new() };
    file.slopes.iter().zip(&file.sums).map(|(slope, sums)| sums.figures(&slope.name)).collect()
}

#[derive(Resource)]
struct SlopesFile {
    rows: Rows,
    columns: Columns<SlopeRow>,
    slopes: Vec<Slope>,
    sums: Vec<Sums>,
}

impl SlopesFile {
    fn restore(&mut self, (length, sums): (u64, Vec<Sums>)) -> Result<(), Problem> {
        if sums.len() != self.slopes.len() {
            return Err("the number of slopes differs".to_owned());
        }
        self.sums = sums;
        self.rows.restore(length)
    }
}

/// Returns the spheres of the free grains that touch something.
fn spheres_in_touch<V: Space>(survey: Survey<'_, V>) -> Vec<Sphere<V>> {
    let store = survey.store;
    let grain_of = |row: usize| match store.bodies.sphere(row) {
        Some(sphere) => store.row_of_body(sphere.body),
        None => row,
    };
    let mut touches = vec![false; store.len()];
    survey.contacts(|row, partner, _, _| {
        touches[grain_of(row)] = true;
        if let Partner::Particle(other) = partner {
            touches[grain_of(other)] = true;
        }
    });
    let rows = store.free_rows().filter(|&row| store.is_present(row) && touches[grain_of(row)]);
    rows.map(|row| Sphere { centre: store.body[row].position, radius: store.body[row].radius }).collect()
}

/// Returns the mean diameter of the grains, m; `None` without grains.
#[expect(clippy::cast_precision_loss, reason = "a number of grains")]
fn mean_diameter<V: Space>(survey: Survey<'_, V>) -> Option<f64> {
    let store = survey.store;
    let rows = store.integrated_rows();
    let count = rows.len();
    (count > 0).then(|| 2.0 * rows.map(|row| store.body[row].radius).sum::<f64>() / count as f64)
}

fn write_rows<V: Space>(
    clock: Res<Clock>,
    survey: SurveyParam<V>,
    door: Option<Res<DoorState>>,
    rest: Option<Res<RestDetector>>,
    mut file: ResMut<SlopesFile>,
    mut outcome: ResMut<Outcome>,
) {
    let time = clock.time();
    let ends = outcome.end().is_some();
    let events = Events::of(door.as_deref(), rest.as_deref());
    let spheres = spheres_in_touch(survey.survey());
    let diameter = mean_diameter(survey.survey());
    let SlopesFile { rows, columns, slopes, sums } = &mut *file;
    for (slope, sums) in slopes.iter().zip(sums) {
        let cell = slope.cell.map(Positive::get).or(diameter.map(|diameter| 2.0 * diameter));
        let measured = cell.and_then(|cell| slope.measure(spheres.iter().copied(), cell));
        let counts = match slope.from {
            Some(from) => from.after(events).is_some_and(|from| clock.has_reached(from)),
            None => ends,
        };
        if let Some(measured) = measured.filter(|_| counts) {
            sums.add(&measured);
        }
        let row = SlopeRow { time, name: slope.name.clone(), measured };
        rows.append(format_args!("{}\n", columns.cells(&row)), &mut outcome);
    }
}

/// Measures and writes slopes.
pub struct SlopesPlugin<V: Space>(TakenOnce<SlopesFile>, PhantomData<V>);

impl<V: Space> SlopesPlugin<V> {
    /// Creates the file with its header, or continues it.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn create(slopes: &[Slope], place: &OutputPlace) -> std::io::Result<Self> {
        let columns = Columns::of(V::DIMENSION == Dimension::Solid, &[COLUMNS]);
        let rows = Rows::at(place, &columns.header())?;
        let file = SlopesFile { rows, columns, slopes: slopes.to_vec(), sums: vec![Sums::default(); slopes.len()] };
        Ok(Self(TakenOnce::new(file), PhantomData))
    }
}

impl<V: Space> Plugin for SlopesPlugin<V> {
    fn build(&self, app: &mut App) {
        let Some(file) = self.0.open() else { return };
        app.persist_sound_part::<SlopesFile, _>(
            |file| Ok((file.rows.saved()?, file.sums.clone())),
            SlopesFile::restore,
        );
        app.insert_resource(file).add_systems(Step, write_rows::<V>.in_set(ObserveStage::Write).run_if(due::<Series>));
    }
}
