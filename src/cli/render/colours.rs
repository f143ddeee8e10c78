//! The colour of grains in drawings of `render`.
//!
//! The ends of a scale are those of the command line, else those of the scene if it has the same colour, else those that a behaviour
//! suggests for its column, else those of the frames that are drawn.

use super::args::ColourOption;
use super::selection::round_up;
use crate::scene::outputs::Colour;
use siloflow_dem::values::{Finite, Positive};
use siloflow_files::frames::Header;

/// The colour that is wanted: known, or with ends that the frames give.
pub(super) enum Wanted {
    Known(Colour),
    Open(String),
}

impl Wanted {
    /// Returns the name of the numbers whose range is needed.
    pub fn name(&self) -> Option<&str> {
        match self {
            Self::Known(_) => None,
            Self::Open(name) => Some(name),
        }
    }

    /// Returns the colour, for the lowest and highest number in the frames.
    pub fn colour(self, range: Option<(f64, f64)>) -> Colour {
        match self {
            Self::Known(colour) => colour,
            Self::Open(name) => {
                let (low, high) = range.unwrap_or((0.0, 1.0));
                let is_positive = matches!(&*name, "speed" | "pressure");
                let (low, high) = if is_positive { (0.0, round_up(high.max(1e-9))) } else { widened(low, high) };
                with_ends(&name, low, high)
            }
        }
    }
}

/// A scale must have a length.
fn widened(low: f64, high: f64) -> (f64, f64) {
    if low < high { (low, high) } else { (low - 0.5, low + 0.5) }
}

fn with_ends(name: &str, low: f64, high: f64) -> Colour {
    let (Ok(from), Ok(to)) = (Finite::try_from(low), Finite::try_from(high)) else { return Colour::Species };
    match (name, Positive::try_from(high)) {
        ("speed", Ok(top)) if low == 0.0 => Colour::Speed(top),
        ("pressure", Ok(top)) if low == 0.0 => Colour::Pressure(top),
        _ => Colour::Column(name.to_owned(), from, to),
    }
}

/// Returns the colour that the command line or the scene wants.
pub(super) fn wanted(option: Option<&ColourOption>, of_scene: &Colour, header: &Header) -> Wanted {
    let Some(ColourOption { name, ends }) = option else { return Wanted::Known(of_scene.clone()) };
    let is_of_scene = match of_scene {
        Colour::Species => name == "species",
        Colour::Speed(_) => name == "speed",
        Colour::Pressure(_) => name == "pressure",
        Colour::Column(column, ..) => name == column,
    };
    let suggested = header.columns.iter().find(|column| column.name == *name).and_then(|column| column.scale);
    match (ends, suggested) {
        (None, _) if is_of_scene => Wanted::Known(of_scene.clone()),
        (None, _) if name == "species" => Wanted::Known(Colour::Species),
        (Some(ends), _) => Wanted::Known(with_ends(name, ends.0, ends.1)),
        (None, Some(scale)) => Wanted::Known(with_ends(name, scale.from, scale.to)),
        (None, None) => Wanted::Open(name.clone()),
    }
}
