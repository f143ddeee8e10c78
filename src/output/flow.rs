//! `flow.csv`: the [field of mean velocity](crate::measure::flow) of a planar scene, over the middle of its discharge.
//!
//! A sample is taken every `flow.sample` seconds while the share of all released grains that are out is from `flow.from` to
//! `flow.to`. Grains that are out or lost do not count, fixed ones neither. The file is written at the end of the run; a
//! run whose discharge never gets to `flow.from` leaves a header alone.
//!
//! | column | unit | meaning |
//! |---|---|---|
//! | `x_m`, `y_m` | m | middle of the cell |
//! | `samples` | | of the field: the same in all rows |
//! | `count` | | grains a sample |
//! | `vx_m_per_s`, `vy_m_per_s` | m/s | mean velocity: momentum over mass |
//!
//! Rows are ordered by y, then x. Why a window of the discharge and not of time: runs, and models, that flow at different
//! speeds are then compared at the same filling.

use std::fmt::Write as _;
use std::path::Path;

use bevy_app::{App, Plugin};
use bevy_ecs::prelude::*;
use serde::{Deserialize, Serialize};

use crate::columns::Columns;
use crate::ledger::Ledger;
use crate::measure::flow::{FlowField, FlowMeans};
use crate::measure::{ObserveStage, due, observe_every};
use crate::outcome::Outcome;
use crate::output::rows::{Parcel, Rows};
use crate::scene::values::{Positive, Share};
use crate::space::Plane;
use crate::step::Step;

/// The scene's `flow`.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Flow {
    /// Side of the square cells, m.
    pub cell: Positive,
    /// Share of the released grains that are out when sampling begins. Default 0.05.
    #[serde(default = "default_from")]
    pub from: Share,
    /// And when it ends. Default 0.4.
    #[serde(default = "default_to")]
    pub to: Share,
    /// Time between samples, s; of a lattice gas a whole number of steps.
    pub sample: Positive,
}

fn default_from() -> Share {
    Share::try_from(0.05).expect("a share")
}

fn default_to() -> Share {
    Share::try_from(0.4).expect("a share")
}

impl Flow {
    /// Whether a sample is wanted when `out` of `released` grains are out.
    #[must_use]
    #[expect(clippy::cast_precision_loss, reason = "fewer than 2^53 grains")]
    pub fn samples_at(&self, out: u64, released: u64) -> bool {
        let share = out as f64 / released.max(1) as f64;
        (self.from.get()..=self.to.get()).contains(&share)
    }
}

#[derive(Resource)]
struct FlowSampler {
    config: Flow,
    field: FlowField,
    file: Rows,
}

const HEADER: &str = "x_m,y_m,samples,count,vx_m_per_s,vy_m_per_s";

fn sample(
    (columns, ledger): (Res<Columns<Plane>>, Res<Ledger>),
    mut sampler: ResMut<FlowSampler>,
    mut outcome: ResMut<Outcome>,
) {
    let FlowSampler { config, field, file } = &mut *sampler;
    if config.samples_at(ledger.out().into(), ledger.released.into()) {
        let grains = (0..columns.movable_end).filter(|&i| !columns.is_fixed(i));
        for i in grains.filter(|&i| !ledger.is_gone(columns.id[i])) {
            let (x, v) = (columns.body[i].position, columns.body[i].velocity);
            field.add(x.x, x.y, columns.mass[i], v.x, v.y);
        }
        field.end_sample();
    }
    if outcome.end().is_some() {
        file.append(format_args!("{}", rows(field)), &mut outcome);
    }
}

/// The means of a field as rows of the file. Writing to a string cannot fail.
pub(crate) fn rows(field: &FlowField) -> String {
    field.means().iter().fold(String::new(), |mut text, cell| {
        let FlowMeans { x, y, samples, count, vx, vy } = cell;
        let _ = writeln!(text, "{x:.9},{y:.9},{samples},{count:.6},{vx:e},{vy:e}");
        text
    })
}

/// Takes the field.
pub struct FlowPlugin {
    config: Flow,
    sampler: Parcel<FlowSampler>,
}

impl FlowPlugin {
    /// Creates the file at `path` with its header.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn create(config: Flow, path: &Path) -> std::io::Result<Self> {
        let (field, file) = (FlowField::new(config.cell.get()), Rows::create(path, HEADER)?);
        Ok(Self { config, sampler: Parcel::new(FlowSampler { config, field, file }) })
    }
}

impl Plugin for FlowPlugin {
    fn build(&self, app: &mut App) {
        let Some(sampler) = self.sampler.open() else { return };
        observe_every::<Flow>(app, self.config.sample.get());
        app.insert_resource(sampler).add_systems(Step, sample.in_set(ObserveStage::Write).run_if(due::<Flow>));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_window_holds_both_its_ends_and_no_grain_at_all() {
        let flow: Flow = ron::from_str("(cell: 0.1, from: 0.25, to: 0.5, sample: 0.1)").unwrap();
        assert!([(1, 4), (3, 8), (2, 4)].iter().all(|&(out, released)| flow.samples_at(out, released)));
        assert!(![(0, 0), (0, 4), (3, 4)].iter().any(|&(out, released)| flow.samples_at(out, released)));
    }
}
