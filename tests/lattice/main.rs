//! The lattice gas against a reference that implements the rules literally, conserved quantities, exact means, and the
//! claims of the study.

#![allow(
    clippy::cast_possible_truncation,
    clippy::cast_possible_wrap,
    clippy::cast_precision_loss,
    clippy::cast_sign_loss,
    clippy::float_cmp,
    clippy::missing_panics_doc,
    clippy::must_use_candidate,
    clippy::unwrap_used,
    clippy::similar_names,
    missing_docs,
    reason = "tests count in small numbers and compare exact values"
)]

mod conservation;
mod gates;
mod reference;
mod same_as_reference;
mod symmetry;
mod thrown;

use std::num::NonZeroUsize;
use std::path::Path;

use siloflow::lattice::gas::Gas;
use siloflow::lattice::sites::Sites;
use siloflow::lattice_silo::loaded::LoadedLattice;
use siloflow::prelude::*;

/// Loads a scene of `scenes/` with settings.
pub fn load(name: &str, settings: &[(&str, &str)]) -> LoadedLattice {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes").join(name);
    let settings: Vec<_> = settings.iter().map(|(key, value)| ((*key).to_owned(), (*value).to_owned())).collect();
    LoadedLattice::read(&path, &settings).unwrap_or_else(|fault| panic!("{name}: {fault}"))
}

/// Builds a simulation of a loaded scene.
pub fn simulation(loaded: &LoadedLattice, threads: usize) -> Simulation {
    Simulation::of_lattice(loaded, &Registry::default(), NonZeroUsize::new(threads).unwrap()).unwrap()
}

/// Returns sites and gas of a simulation.
pub fn parts(simulation: &Simulation) -> (&Sites, &Gas) {
    (simulation.world().resource(), simulation.world().resource())
}

/// Returns a silo of about 900 sites with a slanted wall on one side, an insert, and a wide outlet that opens at step
/// `opens`. `keys` are further keys of the scene.
pub fn small_silo(rules: &str, opens: u64, keys: &str) -> LoadedLattice {
    let text = format!(
        "(method: LatticeGas(spacing: 1.0, {rules}), seed: 11, until: 1000000, {keys}
          outline: [(0.0, 0.0), (20.0, 0.0), (26.0, 14.0), (26.0, 36.0), (0.0, 36.0)],
          inserts: [[(8.0, 14.0), (13.0, 9.0), (15.0, 15.0)]],
          door: (from: (6.0, 0.0), to: (15.0, 0.0), opens: At({opens})))"
    );
    let source = siloflow::text::source::Source::new("small.ron", "small", Path::new(""), text);
    LoadedLattice::new(source, &[]).unwrap_or_else(|fault| panic!("{fault}"))
}
