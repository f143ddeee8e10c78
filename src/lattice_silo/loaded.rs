//! A scene of the lattice gas that has been loaded and checked.

use crate::lattice_silo::scene::LatticeScene;
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
    /// Creates a fault that points at the value of `key`.
    pub(super) fn fault(&self, code: &'static str, key: &str, message: impl Into<String>, help: &str) -> Fault {
        self.source.fault(code, key, message).help(help)
    }

    /// Returns the outline of the silo.
    #[must_use]
    pub fn outline(&self) -> Polygon {
        polygon(&self.scene.outline)
    }

    /// Returns the corners (m) of the view of the pictures: the outline with a margin.
    pub(crate) fn view(&self) -> (Vector, Vector) {
        let (low, high) = self.outline().bounds();
        let margin = Vector::splat(0.04 * (high - low).max_element());
        (low - margin, high + margin)
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
