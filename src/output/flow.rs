//! `flow.csv`: the [field of mean velocity](crate::measure::flow) of a planar scene, over the middle of its discharge.
//!
//! A sample is taken every `flow.sample` seconds while the fraction of released grains that are out is from `flow.from`
//! to `flow.to`. Grains that are out or lost and fixed particles are not counted. The rows are written at the end of
//! the run. If the discharge never reaches `flow.from`, the file has only its header.
//!
//! `COLUMNS` has the columns.
//!
//! Rows are sorted by y, then x. The window is in terms of the discharge and not of time, so that runs and models that
//! flow at different speeds are compared at equal filling.

use std::fmt::Write as _;

use bevy_app::{App, Plugin};
use bevy_ecs::prelude::*;

use crate::ledger::Ledger;
use crate::measure::flow::{Flow, FlowField, FlowMeans};
use crate::measure::{ObserveStage, due, observe_every};
use crate::writers::rows::{Rows, RowsPlace, TakenOnce};
use siloflow_dem::outcome::Outcome;
use siloflow_dem::particles::Motion;
use siloflow_dem::persist::PersistApp as _;
use siloflow_dem::space::Plane;
use siloflow_dem::step::Step;
use siloflow_files::columns::Cell::{Decimal, Scientific, Whole};
use siloflow_files::columns::{Column, Columns};

#[derive(Resource)]
struct FlowSampler {
    config: Flow,
    field: FlowField,
    file: Rows,
}

const VELOCITY: &str = "mean velocity: momentum over mass";

/// The columns.
pub(crate) const COLUMNS: &[Column<FlowMeans>] = &[
    Column::new("x_m", "m", "middle of the cell", |row| Decimal(row.x)),
    Column::new("y_m", "m", "middle of the cell", |row| Decimal(row.y)),
    Column::new("samples", "", "number of samples of the field, equal in all rows", |row| Whole(row.samples)),
    Column::new("count", "grains", "mean number of grains per sample", |row| Decimal(row.count)),
    Column::new("vx_m_per_s", "m/s", VELOCITY, |row| Scientific(row.vx)),
    Column::new("vy_m_per_s", "m/s", VELOCITY, |row| Scientific(row.vy)),
];

/// Returns the means of a field as rows. Writing to a string cannot fail.
fn rows(field: &FlowField) -> String {
    let columns = Columns::of(false, &[COLUMNS]);
    let mut text = String::new();
    for means in field.means() {
        let _ = writeln!(text, "{}", columns.cells(&means));
    }
    text
}

fn sample(
    (motion, ledger): (Motion<Plane>, Res<Ledger>),
    mut sampler: ResMut<FlowSampler>,
    mut outcome: ResMut<Outcome>,
) {
    let FlowSampler { config, field, file } = &mut *sampler;
    if config.samples_at(ledger.out().into(), ledger.released.into()) {
        for grain in motion.grains().filter(|&grain| !ledger.is_gone(motion.id(grain))) {
            let x = motion.position(grain);
            let v = motion.velocity(grain);
            field.add(x.x, x.y, motion.mass(grain), v.x, v.y);
        }
        field.end_sample();
    }
    if outcome.end().is_some() {
        file.append(format_args!("{}", rows(field)), &mut outcome);
    }
}

/// Measures and writes the field of mean velocity.
pub struct FlowPlugin {
    config: Flow,
    sampler: TakenOnce<FlowSampler>,
}

impl FlowPlugin {
    /// Creates the file with its header, or continues it.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn create(config: Flow, place: &RowsPlace) -> std::io::Result<Self> {
        let field = FlowField::new(config.cell.get());
        let file = Rows::at(place, &Columns::of(false, &[COLUMNS]).header())?;
        Ok(Self { config, sampler: TakenOnce::new(FlowSampler { config, field, file }) })
    }
}

impl Plugin for FlowPlugin {
    fn build(&self, app: &mut App) {
        let Some(sampler) = self.sampler.open() else { return };
        observe_every::<Flow>(app, self.config.sample.get());
        app.persist_sound_part::<FlowSampler, _>(
            |sampler| Ok((sampler.file.saved()?, sampler.field.clone())),
            |sampler, (length, field)| {
                sampler.field.restore(field)?;
                sampler.file.restore(length)
            },
        );
        app.insert_resource(sampler).add_systems(Step, sample.in_set(ObserveStage::Write).run_if(due::<Flow>));
    }
}
