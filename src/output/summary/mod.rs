//! `summary.json`: the results of a run in a stable format for scripts. A summary has keys that all runs share ([`Head`],
//! [`FileRecord`]), and between them the results of one method: of grains ([`grains`]) or of the lattice gas
//! ([`output::summary::lattice`](crate::output::summary::lattice)).
//!
//! `format` increases when a key changes its meaning or is removed; adding keys does not change it.

pub mod grains;
pub mod lattice;

use std::collections::BTreeMap;

use bevy_ecs::prelude::*;
use serde::Serialize;

use crate::writers::SUMMARY_FORMAT;
use siloflow_dem::outcome::End;
use siloflow_dem::step::Clock;
use siloflow_files::hashes::SummaryFiles;
use siloflow_files::run_files::Damage;
use siloflow_text::source::Source;

/// Content of `summary.json`.
#[derive(Debug, Serialize)]
pub struct Summary<R> {
    /// The first keys.
    #[serde(flatten)]
    pub head: Head,
    /// The results of the method.
    #[serde(flatten)]
    pub results: R,
    /// The last keys.
    #[serde(flatten)]
    pub written: FileRecord,
}

/// The results of one method.
pub trait Results: Serialize {
    /// The value of the key `method`, which is absent for grains.
    const METHOD: Option<&'static str>;

    /// Number of grains that left in another way than through the orifice.
    fn lost(&self) -> u32;
}

/// The keys at the start of a summary.
#[derive(Debug, Serialize)]
pub struct Head {
    /// Version of the format, [`SUMMARY_FORMAT`].
    pub format: u32,
    /// Name of the scene.
    pub scene: String,
    /// Values of the scene's parameters. The key is absent if the scene has none.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub parameters: BTreeMap<String, f64>,
    /// `LatticeGas`; the key is absent for a run of grains.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub method: Option<&'static str>,
    /// `empty`, `at_rest`, `end_of_flow`, `clogged`, `out_reached` or `time_reached` if the run succeeded; `interrupted` by a signal;
    /// `grains_lost` or `failed` if not.
    pub status: &'static str,
    /// Reason of a failure.
    pub failure: Option<String>,
    /// Number of completed steps.
    pub steps: u64,
}

/// The keys at the end of a summary.
#[derive(Debug, Default, Serialize)]
pub struct FileRecord {
    /// Damaged files without which the run was continued. The key is absent without any.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub damaged: Vec<Damage>,
    /// The files of the run; `null` unless `siloflow run` wrote the summary.
    pub files: Option<SummaryFiles>,
}

/// Counts and times that the caller of the simulation measures.
#[derive(Debug, Clone, Copy, Default)]
pub struct Cost {
    /// Wall-clock time of the steps, s.
    pub wall_s: f64,
    /// Number of updates: sum over all steps of the number of free grains, or of sites of the lattice gas.
    pub updates: u64,
}

impl Cost {
    /// Returns the number of updates per second of wall-clock time, 1/s.
    #[must_use]
    #[expect(clippy::cast_precision_loss, reason = "a rounded result suffices")]
    pub fn updates_per_s(&self) -> f64 {
        self.updates as f64 / self.wall_s.max(f64::MIN_POSITIVE)
    }
}

impl<R: Results> Summary<R> {
    /// Returns the summary of a run that ended with `end`.
    pub(crate) fn new(
        world: &World,
        source: &Source,
        parameters: &BTreeMap<String, f64>,
        end: &End,
        results: R,
    ) -> Self {
        let failure = match end {
            End::Failed(failure) => Some(failure.to_string()),
            _ => None,
        };
        let is_over = failure.is_none() && *end != End::Interrupted;
        let head = Head {
            format: SUMMARY_FORMAT,
            scene: source.name.clone(),
            parameters: parameters.clone(),
            method: R::METHOD,
            status: if results.lost() > 0 && is_over { "grains_lost" } else { end.word() },
            failure,
            steps: world.resource::<Clock>().steps,
        };
        Self { head, results, written: FileRecord::default() }
    }

    /// Returns whether the run succeeded: it did not fail and lost no grain.
    #[must_use]
    pub fn is_done(&self) -> bool {
        self.head.failure.is_none() && self.results.lost() == 0
    }

    /// Records a failure that happened after the last step.
    pub(crate) fn fail(&mut self, reason: String) {
        self.head.status = "failed";
        self.head.failure.get_or_insert(reason);
    }
}
