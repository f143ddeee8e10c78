//! The file of a study: which scenes, variants and seeds it runs.

use std::collections::{BTreeMap, HashSet};
use std::fmt;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use crate::lattice_silo::door::DoorOpens;
use crate::lattice_silo::loaded::LoadedLattice;
use crate::lattice_silo::scene::LatticeScene;
use siloflow_lattice::rules::Walls;
use siloflow_text::fault::Fault;
use siloflow_text::source::Source;

/// The keys of a study file.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields, rename = "Plan")]
pub struct StudyPlan {
    /// Scene file of each silo, by the name of the silo. Paths are relative to the directory of the study file.
    pub silos: BTreeMap<String, PathBuf>,
    /// Seeds of the replicas of each variant.
    pub seeds: Vec<u64>,
    /// Variants of the parameters of the scenes.
    pub variants: Vec<Variant>,
    /// Times of the pictures in the sheets, steps after the door has opened.
    pub pictures: Vec<u64>,
}

/// Values of parameters that replace the values of the scene; `None` keeps the value of the scene.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct Variant {
    /// Stopping in collisions: the probability p.
    pub p: Option<f64>,
    /// Momentum loss in collisions: the probability q.
    pub q: Option<f64>,
    /// Wall friction: the probability b.
    pub b: Option<f64>,
    /// Internal friction: the probability k.
    pub k: Option<f64>,
    /// Gravity: the probability g.
    pub g: Option<f64>,
    /// Gravity of particles at rest: the probability h.
    pub h: Option<f64>,
    /// Effect of rough walls.
    pub walls: Option<Walls>,
}

impl Variant {
    /// The base case: all parameters of the scene are kept.
    pub const BASE: Self = Self { p: None, q: None, b: None, k: None, g: None, h: None, walls: None };

    /// Returns the names and values of the probabilities that differ from the scene.
    fn numbers(&self) -> impl Iterator<Item = (&'static str, f64)> {
        let Self { p, q, b, k, g, h, .. } = *self;
        let named = [("g", g), ("h", h), ("k", k), ("b", b), ("p", p), ("q", q)];
        named.into_iter().filter_map(|(name, value)| Some((name, value?)))
    }

    /// Returns the changes as (key path, value), in the form of `--set`.
    #[must_use]
    pub fn settings(&self) -> Vec<(String, String)> {
        let numbers = self.numbers().map(|(name, value)| (format!("method.{name}"), format!("{value:?}")));
        let walls = self.walls.map(|walls| ("method.walls".to_owned(), format!("{walls:?}")));
        numbers.chain(walls).collect()
    }
}

impl fmt::Display for Variant {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let numbers = self.numbers().map(|(name, value)| format!("{name} = {value}"));
        let walls = self.walls.map(|walls| format!("walls: {walls:?}"));
        let parts: Vec<_> = numbers.chain(walls).collect();
        f.write_str(if parts.is_empty() { "base" } else { "" })?;
        f.write_str(&parts.join(", "))
    }
}

/// A case of the study: one scene with one variant and one seed.
#[derive(Clone, Debug)]
pub struct Case {
    /// Name of the silo.
    pub silo: String,
    /// Variant of the parameters.
    pub variant: Variant,
    /// Seed of the random numbers.
    pub seed: u64,
    scene: PathBuf,
}

impl StudyPlan {
    /// Reads a study file and returns the study and its cases. Loads each silo with each variant and the first seed, so
    /// that errors in scenes are reported before the first run.
    ///
    /// # Errors
    /// If the file or a scene is not valid, or a scene has no door that opens.
    pub fn read(path: &Path) -> Result<(Self, Vec<Case>), Fault> {
        let mut source = Source::read(path)?;
        let plan: Self = source.parse(&[])?;
        let directory = path.parent().unwrap_or(Path::new(""));
        plan.check(&source, directory)?;
        let mut cases = Vec::new();
        for (silo, file) in &plan.silos {
            for &variant in &plan.variants {
                for &seed in &plan.seeds {
                    let case = Case { silo: silo.clone(), variant, seed, scene: directory.join(file) };
                    let opens = |scene: &LatticeScene| scene.door.is_some_and(|door| door.opens != DoorOpens::Never);
                    if seed == plan.seeds[0] && !opens(&case.load()?.scene) {
                        return Err(source
                            .fault("study::no_door", &format!("silos.{silo}"), "this scene has no door that opens")
                            .help("a study measures discharges: give the scene a `door`"));
                    }
                    cases.push(case);
                }
            }
        }
        Ok((plan, cases))
    }
}

impl StudyPlan {
    /// Checks the rules of a study file that do not need its scenes.
    fn check(&self, source: &Source, directory: &Path) -> Result<(), Fault> {
        let fault = |key: &str, message: &str, help: &str| Err(source.fault("study::plan", key, message).help(help));
        let are_distinct = |seeds: &[u64]| seeds.iter().collect::<HashSet<_>>().len() == seeds.len();
        if self.silos.is_empty() || self.variants.is_empty() {
            return fault("silos", "a study needs at least one silo and one variant", "for example `variants: [()]`");
        }
        if self.seeds.len() < 2 || !are_distinct(&self.seeds) {
            return fault(
                "seeds",
                "a standard error needs at least two different seeds",
                "for example `seeds: [1, 2, 3]`",
            );
        }
        if !self.pictures.is_sorted_by(|a, b| a < b) {
            return fault("pictures", "the steps must be in ascending order", "for example `pictures: [0, 100, 200]`");
        }
        for (n, variant) in self.variants.iter().enumerate() {
            if let Some((name, _)) = variant.numbers().find(|(_, value)| !(0.0..=1.0).contains(value)) {
                return fault(
                    &format!("variants[{n}].{name}"),
                    "expected a probability from 0 to 1",
                    "write for example `g: 0.95`",
                );
            }
            if self.variants[..n].contains(variant) {
                return fault(&format!("variants[{n}]"), "this variant is listed twice", "remove one of the two");
            }
        }
        for (silo, file) in &self.silos {
            let key = format!("silos.{silo}");
            if !silo.chars().all(|c| c.is_alphanumeric() || c == ' ') {
                return fault(&key, "expected a name of letters, digits and spaces", "file names contain this name");
            }
            if !directory.join(file).exists() {
                return fault(
                    &key,
                    "the scene file does not exist",
                    "give its path relative to the directory of the study file",
                );
            }
        }
        Ok(())
    }
}

impl Case {
    /// Loads the scene with the variant and the seed of the case.
    ///
    /// # Errors
    /// If the scene is not valid.
    pub fn load(&self) -> Result<LoadedLattice, Fault> {
        let mut settings = self.variant.settings();
        settings.push(("seed".to_owned(), self.seed.to_string()));
        LoadedLattice::read(&self.scene, &settings)
    }
}
