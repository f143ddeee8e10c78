//! Header, legend and key of a picture. They name what the picture contains and nothing else.

use std::collections::BTreeSet;

use super::bonds::{self, Bonds};
use super::grains::Grains;
use super::shades;
use super::style::{Colouring, Style};
use glam::{DVec2, DVec3};
use siloflow_figures::colour::Rgb;
use siloflow_figures::svg::Legend;
use siloflow_files::frames::{Frame, Header};

pub(super) fn header(header: &Header, frame: &Frame, style: &Style) -> Vec<String> {
    let title = if header.title.is_empty() { &header.scene } else { &header.title };
    let [_, inside, out, lost] = frame.counts;
    let time = frame.time;
    let decimals = style.decimals;
    vec![title.clone(), format!("t = {time:.decimals$} s"), format!("inside {inside}, out {out}, lost {lost} grains")]
}

pub(super) fn legend(header: &Header, frame: &Frame, style: &Style, grains: &Grains) -> Legend {
    let map = shades::map(header, style);
    let scale = |from: f64, to: f64, title: String| Legend::Scale { from, to, title, map };
    match &style.colour {
        Colouring::Species => {
            let present: BTreeSet<usize> = grains.species().map(usize::from).collect();
            let named = header.species.iter().enumerate().filter(|(number, _)| present.contains(number));
            Legend::Classes(named.map(|(_, class)| class.clone()).collect())
        }
        Colouring::Speed(top) => scale(0.0, *top, "speed, m/s".to_owned()),
        Colouring::Pressure(top) => {
            scale(0.0, *top, if header.dimension == 2 { "pressure, N/m" } else { "pressure, N/m²" }.to_owned())
        }
        Colouring::Column { name, from, to } => {
            let column = frame.table("grains").and_then(|grains| grains.column(name));
            let unit = column.map(|column| column.unit.as_str()).filter(|unit| !unit.is_empty());
            let registered = header.columns.iter().find(|column| column.name == *name);
            let name = registered.map_or_else(|| name.replace('_', " "), |column| column.label.clone());
            scale(*from, *to, unit.map_or(name.clone(), |unit| format!("{name}, {unit}")))
        }
    }
}

/// Returns the number of rows of the legend in any picture of the run.
pub(super) fn rows(header: &Header, style: &Style) -> usize {
    if style.colour == Colouring::Species { header.species.len() } else { 0 }
}

pub(super) fn key(style: &Style, bonds: &Bonds) -> Vec<(f64, Rgb, String)> {
    let widest = style.network.unwrap_or(0.0);
    // A product such as 0.1 * 0.002 has digits of rounding.
    let weakest = bonds::WEAKEST * widest;
    let weakest: f64 = format!("{weakest:.5e}").parse().unwrap_or(weakest);
    let force = format!("force {weakest} to {widest} N");
    let words = [force.clone(), "sliding".to_owned()];
    let entries = bonds.kinds.into_iter().zip(bonds::COLOURS).zip(words);
    let mut key: Vec<_> = entries
        .filter(|((is_there, _), _)| *is_there)
        .map(|((_, colour), words)| (style.smallest_radius, colour, words))
        .collect();
    // If all contacts slide, the only entry says how wide the bonds are.
    if let ([false, true], [only]) = (bonds.kinds, &mut key[..]) {
        only.2 = format!("sliding, {force}");
    }
    key
}

pub(super) fn axes(style: &Style) -> Vec<(&'static str, DVec2)> {
    [("x", DVec3::X), ("y", DVec3::Y), ("z", DVec3::Z)].map(|(name, axis)| (name, style.camera.on_paper(axis))).to_vec()
}
