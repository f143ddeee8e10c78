//! `series.csv` of a lattice gas: one row every `series.interval` steps, and one at the end. `COLUMNS` has the columns; further ones are
//! those that behaviours [register](crate::measure::outputs).
//!
//! All particles are counted for each row. The run fails if the count differs from entered minus out.

use bevy_app::{App, Plugin};
use bevy_ecs::prelude::*;
use serde::{Deserialize, Serialize};
use std::num::NonZeroU32;

use crate::measure::outputs::{self, SeriesValues};
use crate::measure::{ObserveStage, due, observe_every};
use crate::writers::rows::{Rows, TakenOnce};
use siloflow_dem::outcome::{Failure, Outcome};
use siloflow_dem::persist::PersistApp as _;
use siloflow_dem::space::Vector;
use siloflow_dem::step::{Clock, Step};
use siloflow_files::columns::Cell::{Decimal, Scientific, Whole};
use siloflow_files::columns::{Column, Columns};
use siloflow_files::growing::OutputPlace;
use siloflow_lattice::gas::Gas;
use siloflow_lattice::sites::Sites;
use siloflow_lattice::velocities::{in_bonds, momentum};

/// The scene's key `series`.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Series {
    /// Steps between rows.
    pub interval: NonZeroU32,
}

impl Default for Series {
    fn default() -> Self {
        Self { interval: NonZeroU32::new(10).expect("positive") }
    }
}

/// Mean values over all particles inside.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Means {
    /// Number of particles, counted from the states.
    pub count: u64,
    /// Mean position, m; zero if there are no particles.
    pub centre: Vector,
    /// Mean velocity, m per step.
    pub velocity: Vector,
    /// Share of the particles that are at rest.
    pub at_rest: f64,
}

/// Computes the mean values over all particles inside.
#[must_use]
#[expect(clippy::cast_precision_loss, reason = "fewer than 2^53 particles")]
pub fn means(sites: &Sites, gas: &Gas) -> Means {
    let mut count = 0u64;
    let mut resting = 0u64;
    let mut moment = Vector::ZERO;
    let mut sum = (0i64, 0i64);
    for s in sites.fluid() {
        let state = gas.states()[s];
        let here = state.count_ones();
        if here > 0 {
            count += u64::from(here);
            resting += u64::from(state & 1);
            moment += f64::from(here) * sites.position(s);
            let (x, y) = momentum(state);
            sum = (sum.0 + i64::from(x), sum.1 + i64::from(y));
        }
    }
    if count == 0 {
        return Means::default();
    }
    let (vx, vy) = in_bonds((1, 1));
    let n = count as f64;
    let velocity = sites.spacing * Vector::new(vx * sum.0 as f64, vy * sum.1 as f64) / n;
    Means { count, centre: moment / n, velocity, at_rest: resting as f64 / n }
}

/// A row of the file.
#[derive(Debug)]
pub(crate) struct SeriesRow {
    step: u64,
    entered: u64,
    out: u64,
    /// Particles per step.
    outflow: f64,
    means: Means,
}

const CENTRE: &str = "mean position of all particles inside; the path, if there is one particle";
const VELOCITY: &str = "mean velocity of all particles inside";

/// The columns of the file.
pub(crate) const COLUMNS: &[Column<SeriesRow>] = &[
    Column::new("step", "", "step of the automaton", |row| Whole(row.step)),
    Column::new("entered", "particles", "particles that have entered", |row| Whole(row.entered)),
    Column::new("inside", "particles", "particles inside, counted for each row", |row| Whole(row.means.count)),
    Column::new("out", "particles", "particles that have left", |row| Whole(row.out)),
    Column::new(
        "outflow_per_step",
        "1/step",
        "particles out since the previous row, over the steps since then",
        |row| Decimal(row.outflow),
    ),
    Column::new("x_m", "m", CENTRE, |row| Decimal(row.means.centre.x)),
    Column::new("y_m", "m", CENTRE, |row| Decimal(row.means.centre.y)),
    Column::new("vx_m_per_step", "m/step", VELOCITY, |row| Scientific(row.means.velocity.x)),
    Column::new("vy_m_per_step", "m/step", VELOCITY, |row| Scientific(row.means.velocity.y)),
    Column::new("at_rest", "", "share of the particles inside that are at rest", |row| Decimal(row.means.at_rest)),
];

/// Returns the names of siloflow's own columns.
pub(crate) fn header() -> String {
    Columns::of(false, &[COLUMNS]).header()
}

#[derive(Resource)]
struct SeriesFile {
    rows: Rows,
    columns: Columns<SeriesRow>,
    last: Option<(u64, u64)>,
}

fn write_row(
    clock: Res<Clock>,
    (sites, gas, registered): (Res<Sites>, Res<Gas>, Option<Res<SeriesValues>>),
    mut series: ResMut<SeriesFile>,
    mut outcome: ResMut<Outcome>,
) {
    let step = clock.steps;
    let out = gas.out();
    let now = means(&sites, &gas);
    if now.count != gas.inside() {
        outcome.fail(Failure::Miscounted { step, expected: gas.inside(), counted: now.count });
    }
    #[expect(clippy::cast_precision_loss, reason = "fewer than 2^53 particles and steps")]
    let outflow = match series.last.replace((step, out)) {
        Some((before, out_before)) if step > before => out.saturating_sub(out_before) as f64 / (step - before) as f64,
        _ => 0.0,
    };
    let row = SeriesRow { step, entered: gas.entered(), out, outflow, means: now };
    let registered = outputs::cells(registered);
    let SeriesFile { rows, columns, .. } = &mut *series;
    rows.append(format_args!("{}{registered}\n", columns.cells(&row)), &mut outcome);
}

/// Plugin that writes `series.csv`.
pub(crate) struct SeriesPlugin {
    config: Series,
    file: TakenOnce<SeriesFile>,
}

impl SeriesPlugin {
    /// Creates the file with its header, or continues it. The world has the columns that behaviours have registered.
    pub fn create(config: Series, world: &World, place: &OutputPlace) -> std::io::Result<Self> {
        let columns = Columns::of(false, &[COLUMNS]);
        let header = columns.header() + &outputs::names(world);
        let file = SeriesFile { rows: Rows::at(place, &header)?, columns, last: None };
        Ok(Self { config, file: TakenOnce::new(file) })
    }
}

impl Plugin for SeriesPlugin {
    fn build(&self, app: &mut App) {
        let Some(file) = self.file.open() else { return };
        observe_every::<Series>(app, f64::from(self.config.interval.get()));
        outputs::compute_series(app, due::<Series>);
        app.persist_sound_part::<SeriesFile, _>(
            |series| Ok((series.rows.saved()?, series.last)),
            |series, (length, last)| {
                series.last = last;
                series.rows.restore(length)
            },
        );
        app.insert_resource(file).add_systems(Step, write_row.in_set(ObserveStage::Write).run_if(due::<Series>));
    }
}
