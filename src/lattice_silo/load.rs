//! Loads and checks a scene of the lattice gas.

use std::path::Path;

use crate::lattice_silo::door::Door;
use crate::lattice_silo::scene::{LatticeScene, Method};
use crate::lattice_silo::validity;
use crate::scene::KEYS;
use siloflow_dem::space::Vector;
use siloflow_dem::values::FiniteVector;
use siloflow_lattice::outline::Polygon;
use siloflow_lattice::rules::Rules;
use siloflow_lattice::sites::Sites;
use siloflow_text::fault::Fault;
use siloflow_text::source::Source;

/// A scene of the lattice gas that is ready to run.
#[derive(Debug)]
pub struct LoadedLattice {
    /// The keys of the scene file, with `--set` applied.
    pub scene: LatticeScene,
    /// The text of the scene file.
    pub source: Source,
    /// The parameters of the automaton, from the scene's `method`.
    pub rules: Rules,
    /// The sites of the silo with its door closed.
    pub sites: Sites,
}

impl LoadedLattice {
    /// Loads the scene at `path`. Each of `settings` (key path, value as RON) first replaces a value in its text.
    ///
    /// # Errors
    /// If the file cannot be read, is not a valid lattice-gas scene, or breaks a rule between keys.
    pub fn read(path: &Path, settings: &[(String, String)]) -> Result<Self, Fault> {
        Self::new(Source::read(path)?, settings)
    }

    /// Like [`LoadedLattice::read`], but loads the scene from a text in memory.
    ///
    /// # Errors
    /// If the text is not a valid lattice-gas scene or breaks a rule between keys.
    pub fn new(mut source: Source, settings: &[(String, String)]) -> Result<Self, Fault> {
        source.reference = KEYS;
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

    /// Creates a fault that points at the value of `key`.
    pub(super) fn fault(&self, code: &'static str, key: &str, message: impl Into<String>, help: &str) -> Fault {
        self.source.fault(code, key, message).help(help)
    }

    /// Returns the outline of the silo.
    #[must_use]
    pub fn outline(&self) -> Polygon {
        polygon(&self.scene.outline)
    }
}

/// Returns the polygon with these corners. A corner equal to the previous one is dropped, as is a last corner equal to
/// the first.
pub(super) fn polygon(corners: &[FiniteVector]) -> Polygon {
    let mut corners: Vec<Vector> = corners.iter().map(|corner| corner.padded().truncate()).collect();
    corners.dedup();
    while corners.len() > 1 && corners.first() == corners.last() {
        corners.pop();
    }
    Polygon(corners)
}
