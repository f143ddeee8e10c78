//! The keys of a scene of grains that say which pictures and rows a run leaves.

use serde::{Deserialize, Serialize};

use crate::values::{FiniteVector, Positive};

/// The scene's `pictures`.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct Pictures {
    /// Time between pictures, s.
    pub interval: Positive,
    /// Width, px.
    pub width: Positive,
    /// What colours the grains.
    pub colour: Colour,
    /// Whether PNGs are written beside the SVGs.
    pub png: bool,
    /// Contact forces as bonds; a bond as wide as the smallest radius stands for this force, N. Default none.
    pub network: Option<Positive>,
    /// The view, lower left and upper right corner, m, of solid space in x and z; by default, all walls and grains of
    /// the start.
    pub view: Option<(FiniteVector, FiniteVector)>,
}

/// What colours the grains.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize, Serialize)]
pub enum Colour {
    /// The species: the sizes of a mixture.
    #[default]
    Species,
    /// The speed, from 0 to this, m/s.
    Speed(Positive),
    /// The pressure, from 0 to this, N/m, in solid space N/m^2.
    Pressure(Positive),
}

impl Default for Pictures {
    fn default() -> Self {
        let positive = |number: f64| Positive::try_from(number).expect("positive");
        Self {
            interval: positive(1.0),
            width: positive(600.0),
            colour: Colour::Species,
            png: false,
            network: None,
            view: None,
        }
    }
}

/// The scene's `series`.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Series {
    /// Time between rows, s.
    pub interval: Positive,
}

impl Default for Series {
    fn default() -> Self {
        Self { interval: Positive::try_from(0.05).expect("positive") }
    }
}
