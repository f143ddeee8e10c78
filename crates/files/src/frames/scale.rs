//! Colours that a behaviour suggests for a column of grains. They stand in the header of `frames.bin`.

use serde::{Deserialize, Serialize};

/// Suggestion how a column of grains is coloured.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
pub struct Scale {
    /// Value with the first colour of the palette.
    pub from: f64,
    /// Value with its last colour.
    pub to: f64,
    /// The palette.
    pub palette: Palette,
}

/// A colour map for numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
pub enum Palette {
    /// From dark blue to yellow, for magnitudes.
    Viridis,
    /// From blue over white to red, for differences from the middle of the scale.
    BlueRed,
}
