//! The particles of a lattice gas in `flow.csv`, the [field of mean velocity](crate::output::flow) over the middle of its discharge.
//!
//! The field has cells of `flow.cell` m. A sample is taken every `flow.sample` steps while the share of particles that are out is from
//! `flow.from` to `flow.to`. All particles have equal weight. Velocities are in m per step: `vx_m_per_step`,
//! `vy_m_per_step`.

use bevy_ecs::prelude::*;
use bevy_ecs::system::SystemParamItem;

use crate::measure::flow::FlowField;
use crate::output::flow::{FlowSource, Progress};
use siloflow_files::columns::Cell::{Decimal, Scientific, Whole};
use siloflow_files::columns::Column;
use siloflow_files::flow_means::FlowMeans;
use siloflow_lattice::gas::Gas;
use siloflow_lattice::sites::Sites;
use siloflow_lattice::velocities::{in_bonds, momentum};

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

/// The particles of the gas as the field of mean velocity counts them.
pub(crate) struct FlowOfLattice;

impl FlowSource for FlowOfLattice {
    const COLUMNS: &[Column<FlowMeans>] = COLUMNS;
    type Particles = (Res<'static, Sites>, Res<'static, Gas>);

    fn progress((_, gas): &SystemParamItem<Self::Particles>) -> Progress {
        Progress { out: gas.out(), released: gas.entered() }
    }

    fn add_to((sites, gas): &SystemParamItem<Self::Particles>, field: &mut FlowField) {
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
    }
}
