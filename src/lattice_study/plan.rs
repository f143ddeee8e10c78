//! What a study runs: its file.

use std::collections::{BTreeMap, HashSet};
use std::fmt;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use crate::fault::Fault;
use crate::lattice::door::DoorOpens;
use crate::lattice::load::LoadedLattice;
use crate::lattice::rules::Walls;
use crate::lattice::scene::LatticeScene;
use crate::source::Source;

/// A study, as its file says it.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Plan {
    /// Scenes by the name of the silo; their paths count from the study's directory.
    pub silos: BTreeMap<String, PathBuf>,
    /// Seeds of the replicas of each variant.
    pub seeds: Vec<u64>,
    /// Changes to the parameters of the scenes.
    pub variants: Vec<Variant>,
    /// Steps after the door has opened at which the sheets of pictures look.
    pub pictures: Vec<u64>,
}

/// Parameters that differ from the scene's.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct Variant {
    /// Collision: stopping.
    pub p: Option<f64>,
    /// Collision: loss of momentum.
    pub q: Option<f64>,
    /// Wall friction.
    pub b: Option<f64>,
    /// Internal friction.
    pub k: Option<f64>,
    /// Gravity.
    pub g: Option<f64>,
    /// Gravity of particles at rest.
    pub h: Option<f64>,
    /// What rough walls do.
    pub walls: Option<Walls>,
}

impl Variant {
    /// The scene's own parameters.
    pub const BASE: Self = Self { p: None, q: None, b: None, k: None, g: None, h: None, walls: None };

    fn numbers(&self) -> impl Iterator<Item = (&'static str, f64)> {
        let Self { p, q, b, k, g, h, .. } = *self;
        let named = [("g", g), ("h", h), ("k", k), ("b", b), ("p", p), ("q", q)];
        named.into_iter().filter_map(|(name, value)| Some((name, value?)))
    }

    /// The changes, as `--set` takes them.
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

/// One scene with one variant and one seed.
#[derive(Clone, Debug)]
pub struct Case {
    /// The silo's name.
    pub silo: String,
    /// The variant.
    pub variant: Variant,
    /// The seed.
    pub seed: u64,
    scene: PathBuf,
}

impl Plan {
    /// Reads a study and loads each of its cases once, so that what is wrong is told before anything runs.
    ///
    /// # Errors
    /// If the file or a scene is not what it should be.
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

impl Plan {
    /// Checks what can be told without the scenes.
    fn check(&self, source: &Source, directory: &Path) -> Result<(), Fault> {
        let fault = |key: &str, message: &str, help: &str| Err(source.fault("study::plan", key, message).help(help));
        let are_distinct = |seeds: &[u64]| seeds.iter().collect::<HashSet<_>>().len() == seeds.len();
        if self.silos.is_empty() || self.variants.is_empty() {
            return fault("silos", "a study needs a silo and a variant", "for example `variants: [()]`");
        }
        if self.seeds.len() < 2 || !are_distinct(&self.seeds) {
            return fault(
                "seeds",
                "a standard error needs two seeds or more, each once",
                "for example `seeds: [1, 2, 3]`",
            );
        }
        if !self.pictures.is_sorted_by(|a, b| a < b) {
            return fault("pictures", "the steps of pictures must ascend", "for example `pictures: [0, 100, 200]`");
        }
        for (n, variant) in self.variants.iter().enumerate() {
            if let Some((name, _)) = variant.numbers().find(|(_, value)| !(0.0..=1.0).contains(value)) {
                return fault(&format!("variants[{n}].{name}"), "expected a probability from 0 to 1", "as `g: 0.95`");
            }
            if self.variants[..n].contains(variant) {
                return fault(&format!("variants[{n}]"), "this variant stands here twice", "remove one of the two");
            }
        }
        for (silo, file) in &self.silos {
            let key = format!("silos.{silo}");
            if !silo.chars().all(|c| c.is_alphanumeric() || c == ' ') {
                return fault(&key, "expected a name of letters, digits and spaces", "files are named after it");
            }
            if !directory.join(file).exists() {
                return fault(&key, "there is no such scene", "its path counts from the directory of the study");
            }
        }
        Ok(())
    }
}

impl Case {
    /// Loads the scene.
    ///
    /// # Errors
    /// If it is not what it should be.
    pub fn load(&self) -> Result<LoadedLattice, Fault> {
        let mut settings = self.variant.settings();
        settings.push(("seed".to_owned(), self.seed.to_string()));
        LoadedLattice::read(&self.scene, &settings)
    }
}
