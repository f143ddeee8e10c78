//! The scene file of the lattice gas: its keys. Lengths are in m, times in steps of the automaton.

use std::collections::BTreeMap;

use ron::value::RawValue;
use serde::{Deserialize, Serialize};

use crate::lattice_silo::door::Door;
use crate::lattice_silo::enter::{Fill, Pour, Thrown};
use crate::lattice_silo::pictures::Pictures;
use crate::lattice_silo::rest::Rest;
use crate::lattice_silo::series::Series;
use crate::measure::flow::Flow;
use siloflow_dem::persist::{CheckpointConfig, default_checkpoint};
use siloflow_dem::values::FiniteVector;
use siloflow_lattice::rules::Rules;

/// The simulation method of a scene.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize, Serialize)]
pub enum Method {
    /// Discrete elements: a [scene of grains](crate::scene::Scene).
    #[default]
    Grains,
    /// The cellular automaton: a [scene of the lattice gas](LatticeScene).
    LatticeGas(Rules),
}

/// The keys of a lattice-gas scene file.
#[derive(Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct LatticeScene {
    /// Title in the pictures.
    #[serde(default)]
    pub title: String,
    /// Seed of all random numbers.
    #[serde(default)]
    pub seed: u64,
    /// Named values for [expressions](siloflow_text::source::parameters), of any unit.
    #[serde(default)]
    pub parameters: BTreeMap<String, f64>,
    /// The method `LatticeGas` and its parameters.
    pub method: Method,
    /// Corners of the silo, in order along the boundary, m. The highest part of the outline is the lid.
    pub outline: Vec<FiniteVector>,
    /// Corners of each obstacle in the silo, in order along its boundary, m.
    #[serde(default)]
    pub inserts: Vec<Vec<FiniteVector>>,
    /// The door in the outline.
    pub door: Option<Door>,
    /// Random fill of the silo at the start.
    pub fill: Option<Fill>,
    /// Particles poured in at the top.
    pub pour: Option<Pour>,
    /// Single particles at the start.
    #[serde(default)]
    pub particles: Vec<Thrown>,
    /// The rest detector.
    pub rest: Option<Rest>,
    /// Last step of the run.
    pub until: u64,
    /// Number of steps after the door has opened at which the run ends.
    pub discharge: Option<u64>,
    /// The field of mean velocity over the middle of the discharge, in `flow.csv`.
    pub flow: Option<Flow>,
    /// The rows of `series.csv`. Default: interval 10.
    #[serde(default)]
    pub series: Series,
    /// Checkpoints; `None` writes no checkpoints.
    #[serde(default = "default_checkpoint")]
    pub checkpoint: Option<CheckpointConfig>,
    /// The pictures; `None` writes no pictures.
    #[serde(default = "default_pictures")]
    pub pictures: Option<Pictures>,
    /// Behaviours registered by the program that runs the scene, by name, each with its own keys.
    #[serde(default)]
    pub behaviours: BTreeMap<String, Box<RawValue>>,
}

#[expect(clippy::unnecessary_wraps, reason = "the default of a field of this type")]
fn default_pictures() -> Option<Pictures> {
    Some(Pictures::default())
}
