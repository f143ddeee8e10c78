//! `flow.csv`: the [field of mean velocity](crate::measure::flow) of a planar scene, over the middle of its discharge.
//!
//! A sample is taken every `flow.sample` seconds while the fraction of released grains that are out is from `flow.from`
//! to `flow.to`. Grains that are out or lost and fixed particles are not counted. The rows are written at the end of
//! the run. If the discharge never reaches `flow.from`, the file has only its header.
//!
//! `COLUMNS` has the columns.
//!
//! A run of the lattice gas has the same file, with `sample` in steps and its own unit of velocity
//! (`output/flow/lattice.rs`).
//!
//! Rows are sorted by y, then x. The window is in terms of the discharge and not of time, so that runs and models that
//! flow at different speeds are compared at equal filling.

pub(crate) mod lattice;

use std::fmt::Write as _;
use std::marker::PhantomData;

use bevy_app::{App, Plugin};
use bevy_ecs::prelude::*;
use bevy_ecs::system::{ReadOnlySystemParam, StaticSystemParam, SystemParamItem};

use crate::ledger::Ledger;
use crate::measure::flow::{Flow, FlowField};
use crate::measure::{ObserveStage, due, observe_every};
use crate::writers::rows::{Rows, TakenOnce};
use siloflow_dem::outcome::Outcome;
use siloflow_dem::particles::Motion;
use siloflow_dem::persist::PersistApp as _;
use siloflow_dem::space::Plane;
use siloflow_dem::step::Step;
use siloflow_files::columns::Cell::{Decimal, Scientific, Whole};
use siloflow_files::columns::{Column, Columns};
use siloflow_files::flow_means::FlowMeans;
use siloflow_files::growing::OutputPlace;

/// The particles of one method, as the field of mean velocity counts them.
pub(crate) trait FlowSource: Send + Sync + 'static {
    /// The columns of the file.
    const COLUMNS: &'static [Column<FlowMeans>];
    /// Access to the particles.
    type Particles: ReadOnlySystemParam;

    /// Returns the progress of the discharge.
    fn progress(particles: &SystemParamItem<Self::Particles>) -> Progress;
    /// Adds all particles that count to the field.
    fn add_to(particles: &SystemParamItem<Self::Particles>, field: &mut FlowField);
}

/// The progress of a discharge.
pub(crate) struct Progress {
    /// Number of particles that are out.
    pub out: u64,
    /// Number of particles that entered.
    pub released: u64,
}

/// Grains as the field of mean velocity counts them, weighted by mass.
pub(crate) struct FlowOfGrains;

impl FlowSource for FlowOfGrains {
    const COLUMNS: &[Column<FlowMeans>] = COLUMNS;
    type Particles = (Motion<'static, Plane>, Res<'static, Ledger>);

    fn progress((_, ledger): &SystemParamItem<Self::Particles>) -> Progress {
        Progress { out: ledger.out().into(), released: ledger.released.into() }
    }

    fn add_to((motion, ledger): &SystemParamItem<Self::Particles>, field: &mut FlowField) {
        for grain in motion.grains().filter(|&grain| !ledger.is_gone(motion.id(grain))) {
            let x = motion.position(grain);
            let v = motion.velocity(grain);
            field.add(x.x, x.y, motion.mass(grain), v.x, v.y);
        }
    }
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
fn rows(columns: &'static [Column<FlowMeans>], field: &FlowField) -> String {
    let columns = Columns::of(false, &[columns]);
    let mut text = String::new();
    for means in field.means() {
        let _ = writeln!(text, "{}", columns.cells(&means));
    }
    text
}

#[derive(Resource)]
struct FlowSampler {
    config: Flow,
    field: FlowField,
    file: Rows,
}

fn sample<S: FlowSource>(
    particles: StaticSystemParam<S::Particles>,
    mut sampler: ResMut<FlowSampler>,
    mut outcome: ResMut<Outcome>,
) {
    let particles = particles.into_inner();
    let FlowSampler { config, field, file } = &mut *sampler;
    let Progress { out, released } = S::progress(&particles);
    if config.samples_at(out, released) {
        S::add_to(&particles, field);
        field.end_sample();
    }
    if outcome.end().is_some() {
        file.append(format_args!("{}", rows(S::COLUMNS, field)), &mut outcome);
    }
}

/// Measures and writes the field of mean velocity.
pub(crate) struct FlowPlugin<S> {
    config: Flow,
    sampler: TakenOnce<FlowSampler>,
    source: PhantomData<S>,
}

impl<S: FlowSource> FlowPlugin<S> {
    /// Creates the file with its header, or continues it.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub(crate) fn create(config: Flow, place: &OutputPlace) -> std::io::Result<Self> {
        let field = FlowField::new(config.cell.get());
        let file = Rows::at(place, &Columns::of(false, &[S::COLUMNS]).header())?;
        let sampler = TakenOnce::new(FlowSampler { config, field, file });
        Ok(Self { config, sampler, source: PhantomData })
    }
}

impl<S: FlowSource> Plugin for FlowPlugin<S> {
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
        app.insert_resource(sampler).add_systems(Step, sample::<S>.in_set(ObserveStage::Write).run_if(due::<Flow>));
    }
}
