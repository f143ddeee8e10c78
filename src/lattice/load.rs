//! A scene of the lattice gas, loaded and checked.

use std::path::Path;

use crate::fault::Fault;
use crate::lattice::door::Door;
use crate::lattice::outline::Polygon;
use crate::lattice::rules::Rules;
use crate::lattice::scene::{LatticeScene, Method};
use crate::lattice::sites::Sites;
use crate::lattice::validity;
use crate::source::Source;
use crate::space::Vector;
use crate::values::FiniteVector;

/// A scene of the lattice gas that is ready to run.
#[derive(Debug)]
pub struct LoadedLattice {
    /// What the file says, with `--set` applied.
    pub scene: LatticeScene,
    /// Its text.
    pub source: Source,
    /// The rules.
    pub rules: Rules,
    /// The sites of the silo, its door closed.
    pub sites: Sites,
}

impl LoadedLattice {
    /// Loads the scene at `path`, each of `settings` (key path, value as RON) applied to its text first.
    ///
    /// # Errors
    /// If the file cannot be read, is not what it should be, or a rule is broken.
    pub fn read(path: &Path, settings: &[(String, String)]) -> Result<Self, Fault> {
        Self::new(Source::read(path)?, settings)
    }

    /// The same for a text.
    ///
    /// # Errors
    /// As [`LoadedLattice::read`].
    pub fn new(mut source: Source, settings: &[(String, String)]) -> Result<Self, Fault> {
        let scene: LatticeScene = source.parse(settings)?;
        let Method::LatticeGas(rules) = scene.method else {
            return Err(source
                .fault("scene::method", "method", "this is not a scene of the lattice gas")
                .help("write `method: LatticeGas(...)`"));
        };
        validity::shapes(&scene, &rules, &source)?;
        let inserts: Vec<_> = scene.inserts.iter().map(|corners| polygon(corners)).collect();
        let sites = Sites::new(&polygon(&scene.outline), &inserts, scene.door.map(Door::ends), rules.spacing.get());
        let loaded = Self { scene, source, rules, sites };
        validity::check(&loaded)?;
        Ok(loaded)
    }

    /// A fault that points at the value of `key`.
    pub(super) fn fault(&self, code: &'static str, key: &str, message: impl Into<String>, help: &str) -> Fault {
        self.source.fault(code, key, message).help(help)
    }

    /// The silo.
    #[must_use]
    pub fn outline(&self) -> Polygon {
        polygon(&self.scene.outline)
    }
}

/// The polygon of some corners; one that repeats the one before it, or the first at the end, is no corner of its own.
pub(super) fn polygon(corners: &[FiniteVector]) -> Polygon {
    let mut corners: Vec<Vector> = corners.iter().map(|corner| corner.padded().truncate()).collect();
    corners.dedup();
    while corners.len() > 1 && corners.first() == corners.last() {
        corners.pop();
    }
    Polygon(corners)
}
