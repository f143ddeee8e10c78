//! A scene of the lattice gas: the keys of its file. Lengths are in m, times in steps of the automaton.

use std::collections::BTreeMap;

use ron::value::RawValue;
use serde::{Deserialize, Serialize};

use crate::lattice::door::Door;
use crate::lattice::enter::{Fill, Pour, Thrown};
use crate::lattice::pictures::Pictures;
use crate::lattice::rest::Rest;
use crate::lattice::rules::Rules;
use crate::lattice::series::Series;
use crate::measure::flow::Flow;
use crate::values::FiniteVector;

/// What a scene is simulated by.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize, Serialize)]
pub enum Method {
    /// Discrete elements: the keys of [`Scene`](crate::scene::Scene).
    #[default]
    Grains,
    /// The cellular automaton: the keys of [`LatticeScene`].
    LatticeGas(Rules),
}

/// A scene of the lattice gas, as its file says it.
#[derive(Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct LatticeScene {
    /// Shown in pictures.
    #[serde(default)]
    pub title: String,
    /// Seed of all random numbers.
    #[serde(default)]
    pub seed: u64,
    /// The lattice gas and its parameters.
    pub method: Method,
    /// Corners of the silo, in turn, m. Its highest points are the lid.
    pub outline: Vec<FiniteVector>,
    /// Corners of what stands in it, m.
    #[serde(default)]
    pub inserts: Vec<Vec<FiniteVector>>,
    /// The outlet.
    pub door: Option<Door>,
    /// Fills the silo at once.
    pub fill: Option<Fill>,
    /// Pours particles in at the top.
    pub pour: Option<Pour>,
    /// Single particles of the start.
    #[serde(default)]
    pub particles: Vec<Thrown>,
    /// Detects rest.
    pub rest: Option<Rest>,
    /// When the run ends at the latest, steps.
    pub until: u64,
    /// When it ends after the outlet has opened, steps.
    pub discharge: Option<u64>,
    /// A field of mean velocity over the middle of the discharge, in `flow.csv`.
    pub flow: Option<Flow>,
    /// The rows of `series.csv`.
    #[serde(default)]
    pub series: Series,
    /// The snapshots; `None` for none.
    #[serde(default = "default_pictures")]
    pub pictures: Option<Pictures>,
    /// Behaviours that a program registered, each with its own keys.
    #[serde(default)]
    pub behaviours: BTreeMap<String, Box<RawValue>>,
}

#[expect(clippy::unnecessary_wraps, reason = "the default of a field of this type")]
fn default_pictures() -> Option<Pictures> {
    Some(Pictures::default())
}
