//! Loads and checks a scene of the lattice gas.

use std::path::Path;

use crate::lattice_silo::door::Door;
use crate::lattice_silo::loaded::{LoadedLattice, polygon};
use crate::lattice_silo::scene::{LatticeScene, Method};
use crate::lattice_silo::validity;
use siloflow_lattice::sites::Sites;
use siloflow_text::fault::Fault;
use siloflow_text::source::Source;

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
        source.reference = include_str!("../../docs/reference/scene-file.md");
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
}
