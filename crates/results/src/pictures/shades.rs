//! Colours of grains by a number: the place of each grain on the scale, and the colour map.

use siloflow_figures::colour::{self, Rgb};
use siloflow_files::frames::scale::Palette;
use siloflow_files::frames::{Frame, Header};

use super::style::{Colouring, Style, speeds};

/// Returns the colour map: that which a behaviour suggests for its column, or viridis.
pub(super) fn map(header: &Header, style: &Style) -> fn(f64) -> Rgb {
    let Colouring::Column { name, .. } = &style.colour else { return colour::viridis };
    let registered = header.columns.iter().find(|column| column.name == *name).and_then(|column| column.scale);
    match registered.map(|scale| scale.palette) {
        Some(Palette::BlueRed) => colour::blue_red,
        _ => colour::viridis,
    }
}

/// Returns the place of each grain on the colour scale, from 0 to 1; nothing if species give the colours.
pub(super) fn of(header: &Header, frame: &Frame, style: &Style) -> Vec<f64> {
    let Some(table) = frame.table("grains") else { return Vec::new() };
    let ((from, to), values) = match &style.colour {
        Colouring::Species => return Vec::new(),
        Colouring::Speed(top) => ((0.0, *top), speeds(header, frame)),
        Colouring::Pressure(top) => ((0.0, *top), table.numbers("pressure").unwrap_or_default()),
        Colouring::Column { name, from, to } => ((*from, *to), table.numbers(name).unwrap_or_default()),
    };
    values.into_iter().map(|value| (value - from) / (to - from)).collect()
}
