//! `flow.csv` of a lattice gas: the [field of mean velocity](crate::measure::flow) over the middle of its discharge.
//!
//! The file is like the `flow.csv` of grains ([`output::flow`](crate::output::flow)). The field has cells of
//! `flow.cell` m. A sample is taken every `flow.sample` steps while the share of particles that are out is from
//! `flow.from` to `flow.to`. All particles have equal weight. Velocities are in m per step: `vx_m_per_step`,
//! `vy_m_per_step`.

use std::fmt::Write as _;

use bevy_app::{App, Plugin};
use bevy_ecs::prelude::*;

use crate::measure::flow::{Flow, FlowField, FlowMeans};
use crate::measure::{ObserveStage, due, observe_every};
use crate::writers::rows::{Rows, RowsPlace, TakenOnce};
use siloflow_dem::outcome::Outcome;
use siloflow_dem::persist::PersistApp as _;
use siloflow_dem::step::Step;
use siloflow_files::columns::Cell::{Decimal, Scientific, Whole};
use siloflow_files::columns::{Column, Columns};
use siloflow_lattice::gas::Gas;
use siloflow_lattice::sites::Sites;
use siloflow_lattice::velocities::{in_bonds, momentum};

#[derive(Resource)]
struct FlowSampler {
    config: Flow,
    field: FlowField,
    file: Rows,
}

const VELOCITY: &str = "mean velocity";

/// The columns.
pub(crate) const COLUMNS: &[Column<FlowMeans>] = &[
    Column::new("x_m", "m", "middle of the cell", |row| Decimal(row.x)),
    Column::new("y_m", "m", "middle of the cell", |row| Decimal(row.y)),
    Column::new("samples", "", "number of samples of the field, equal in all rows", |row| Whole(row.samples)),
    Column::new("count", "particles", "mean number of particles per sample", |row| Decimal(row.count)),
    Column::new("vx_m_per_step", "m/step", VELOCITY, |row| Scientific(row.vx)),
    Column::new("vy_m_per_step", "m/step", VELOCITY, |row| Scientific(row.vy)),
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

fn sample((sites, gas): (Res<Sites>, Res<Gas>), mut sampler: ResMut<FlowSampler>, mut outcome: ResMut<Outcome>) {
    let FlowSampler { config, field, file } = &mut *sampler;
    if config.samples_at(gas.out(), gas.entered()) {
        for s in sites.fluid() {
            let state = gas.states()[s];
            let count = state.count_ones();
            if count > 0 {
                let x = sites.position(s);
                let (vx, vy) = in_bonds(momentum(state));
                let share = sites.spacing / f64::from(count);
                field.add_several(x.x, x.y, count, [share * vx, share * vy]);
            }
        }
        field.end_sample();
    }
    if outcome.end().is_some() {
        file.append(format_args!("{}", rows(field)), &mut outcome);
    }
}

/// Plugin that samples the field and writes `flow.csv` at the end of the run.
pub(crate) struct FlowPlugin {
    config: Flow,
    sampler: TakenOnce<FlowSampler>,
}

impl FlowPlugin {
    /// Creates the file with its header, or continues it.
    pub fn create(config: Flow, place: &RowsPlace) -> std::io::Result<Self> {
        let file = Rows::at(place, &Columns::of(false, &[COLUMNS]).header())?;
        let field = FlowField::new(config.cell.get());
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
