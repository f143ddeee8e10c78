//! Effect of the time step on the observables of a user's scene, over a ladder of steps and several seeds.
//!
//! A silo has no closed form, and its motion is chaotic: two runs that differ by a rounding error differ by a grain's
//! width one second later. The step can therefore only change statistics, and statistics have noise. Each step of the
//! ladder runs with several seeds. [`observe`] takes the observables of each run, and [`verdict`] compares their means
//! with the means at the finest step. If the seed has no effect, the scene runs once per step and every difference is
//! due to the step.

pub mod observe;
pub mod report;
pub mod verdict;

use std::num::NonZeroU32;
use std::path::Path;

use rayon::prelude::*;

use self::observe::{Observed, Rung, run};
use self::report::Study;
use crate::behaviour::Registry;
use crate::scene::check;
use crate::scene::load;
use crate::scene::loaded::{AnyScene, Loaded};
use siloflow_text::fault::Fault;

/// Steps of the ladder in units of the scene's own step, coarse to fine.
pub const FACTORS: [f64; 6] = [4.0, 2.0, 1.0, 0.5, 0.25, 0.125];
/// Steps of the short ladder in units of the scene's own step, coarse to fine.
pub const SHORT: [f64; 4] = [2.0, 1.0, 0.5, 0.25];

/// Input of a study.
pub struct Question<'a> {
    /// Path of the scene file.
    pub scene: &'a Path,
    /// Changed keys of the scene and their values.
    pub settings: &'a [(String, String)],
    /// Number of seeds; they count up from the scene's own seed.
    pub seeds: u32,
    /// Target relative error.
    pub error: f64,
    /// Whether to run the short ladder.
    pub quick: bool,
    /// Behaviours that scenes may use.
    pub registry: &'a Registry,
}

impl Question<'_> {
    /// Runs the ladder and returns the study. `report_progress` receives a line of text before each step.
    ///
    /// # Errors
    /// If the scene is invalid, or if no step of the ladder runs to its end.
    pub fn answer(&self, report_progress: &(dyn Fn(&str) + Sync)) -> Result<Study, Fault> {
        let own = self.load(None, None)?;
        let step = own.step();
        let first = own.scene.seed;
        let factors = if self.quick { &SHORT[..] } else { &FACTORS[..] };
        let mut seeds: Vec<u64> = (0..u64::from(self.seeds)).map(|n| first.wrapping_add(n)).collect();
        let mut rungs: Vec<Rung> = Vec::new();
        for &factor in factors {
            let mut rung = Rung { factor, step: step * factor, runs: Vec::new(), refusal: None };
            report_progress(&format!("step {:.3e} s, {} seeds", rung.step, seeds.len()));
            rung.refusal = self.refusal(rung.step);
            if rung.refusal.is_none() {
                rung.runs = self.run(rung.step, &seeds)?;
                // The first step that runs shows whether the seed has any effect.
                let same = rung.runs.iter().all(|run| run.state_hash == rung.runs[0].state_hash);
                if seeds.len() > 1 && same && rung.runs[0].failure.is_none() {
                    rung.runs.truncate(1);
                    seeds.truncate(1);
                }
            }
            rungs.push(rung);
        }
        if rungs.iter().all(|rung| rung.runs.iter().all(|run| run.failure.is_some())) {
            let reason = rungs.iter().find_map(|rung| rung.refusal.clone().or(rung.runs.first()?.failure.clone()));
            let message = format!("no step of the ladder can be run: {}", reason.unwrap_or_default());
            return Err(
                Fault::new("accuracy::no_rung", message).help("`siloflow check` reports the limits of the step")
            );
        }
        Ok(Study::new(&own.source.name, &rungs, self.seeds, seeds.len() > 1, self.error))
    }

    fn load(&self, step: Option<f64>, seed: Option<u64>) -> Result<Loaded, Fault> {
        let mut settings = self.settings.to_vec();
        settings.extend(step.map(|step| ("step".to_owned(), format!("Fixed({step:?})"))));
        settings.extend(seed.map(|seed| ("seed".to_owned(), seed.to_string())));
        match load::any(self.scene, &settings)? {
            AnyScene::Grains(mut loaded) => {
                // Samples would add their own error to that of the step.
                loaded.scene.energy_balance_every.get_or_insert(NonZeroU32::MIN);
                Ok(*loaded)
            }
            AnyScene::Lattice(loaded) => Err(loaded
                .source
                .fault("accuracy::lattice", "method", "the time step of a lattice gas cannot be chosen")
                .help("give a scene of grains")),
        }
    }

    /// Returns the reason why a step (s) cannot be used; `None` if it can.
    ///
    /// Either the scene check refuses the step, or the step exceeds the stability limit of a single contact.
    fn refusal(&self, step: f64) -> Option<String> {
        match self.load(Some(step), None) {
            Err(fault) => Some(fault.to_string()),
            Ok(loaded) => {
                let warnings = check::warnings(&loaded).into_iter();
                warnings.filter(|warning| warning.code == "check::unstable_step").map(|warning| warning.message).next()
            }
        }
    }

    fn run(&self, step: f64, seeds: &[u64]) -> Result<Vec<Observed>, Fault> {
        let one = |&seed: &u64| run(&self.load(Some(step), Some(seed))?, self.registry);
        // Runs in the caller's thread pool, with one run per thread at a time.
        seeds.par_iter().with_max_len(1).map(one).collect()
    }
}
