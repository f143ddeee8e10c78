//! Pictures of a sweep: for each axis a sheet with a panel for each figure, and the table of the fit.
//!
//! Dots are means, bars reach one standard error up and down. A fit has its 95 % confidence band, by the scatter of the means about it. Up to six combinations of the other values have a curve each; more of them,
//! and the samples of a Latin hypercube, are dots of one colour. Values that are no numbers are numbered in the order of the sweep
//! file.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use crate::studies::figures::words::words;
use crate::studies::sweep::Sweep;
use crate::studies::sweep::plan::Ends;
use crate::studies::sweep::table::{PointMean, TextColumn, csv, number};
use siloflow_figures::diagram::{Axis, Curve, Key, Panel, colour, sheet};
use siloflow_figures::statistics::digits::short;
use siloflow_figures::statistics::fit::Fitted;
use siloflow_figures::statistics::fit::Parameter;

/// Most curves of a panel: the number of colours other than that of the fit.
const MOST_CURVES: usize = 6;

/// Points of the curve of a fit.
const FIT_POINTS: u16 = 200;

/// Space beside the first and the last point, as a share of the axis.
const MARGIN: f64 = 0.04;

/// Colour of the edges of the confidence band of a fit.
const BAND: &str = "#999999";

/// A fit through the means at some points.
#[derive(Clone, Debug)]
pub struct GroupFit {
    /// The other keys with their values, in words; empty if there are none.
    pub group: String,
    /// The fitted law.
    pub fitted: Fitted,
}

/// Returns the sheets: name of the key, SVG document.
#[must_use]
pub fn sheets(sweep: &Sweep, cells: &[PointMean]) -> Vec<(String, String)> {
    let of_key = |(key, name): (usize, &String)| {
        let panels: Vec<_> = (0..sweep.plan.figures.len()).map(|figure| panel(sweep, cells, key, figure)).collect();
        (name.clone(), sheet(&panels, 2))
    };
    sweep.keys.iter().enumerate().map(of_key).collect()
}

/// Whether the means of the key with this number are connected by curves: it is the key of an axis, not of a hypercube.
fn has_lines(sweep: &Sweep, key: usize) -> bool {
    key < sweep.plan.axes.len() && sweep.plan.latin_hypercube.is_none()
}

/// Returns the points with the same values of all other keys, by these values in words.
fn groups(sweep: &Sweep, key: usize) -> Vec<(String, Vec<usize>)> {
    let mut all: BTreeMap<Vec<&String>, Vec<usize>> = BTreeMap::new();
    for (number, point) in sweep.points.iter().enumerate() {
        let others = point.values.iter().enumerate().filter(|(n, _)| *n != key).map(|(_, value)| value);
        all.entry(others.collect()).or_default().push(number);
    }
    if all.len() > MOST_CURVES || !has_lines(sweep, key) {
        return vec![(String::new(), (0..sweep.points.len()).collect())];
    }
    let names: Vec<_> = sweep.keys.iter().enumerate().filter(|(n, _)| *n != key).map(|(_, name)| name).collect();
    let words = |values: &[&String]| {
        let unit = |name: &str| sweep.plan.units.get(name).map_or_else(String::new, |unit| format!(" {unit}"));
        names
            .iter()
            .zip(values)
            .map(|(name, value)| format!("{name} = {value}{}", unit(name)))
            .collect::<Vec<_>>()
            .join(", ")
    };
    let mut groups: Vec<_> = all.into_iter().map(|(values, points)| (words(&values), points)).collect();
    groups.sort_by_key(|(_, points)| points[0]);
    groups
}

/// Returns the place of each point along the key with this number, and the axis.
fn places(sweep: &Sweep, key: usize) -> (Vec<f64>, Axis) {
    let name = sweep.plan.label(&sweep.keys[key]);
    let texts: Vec<&str> = sweep.points.iter().map(|point| point.values[key].as_str()).collect();
    let numbers: Option<Vec<f64>> = texts.iter().map(|text| text.parse().ok()).collect();
    if let Some(numbers) = numbers {
        let axis = Axis::around(name, numbers.iter().copied()).with_margins(MARGIN);
        return (numbers, axis);
    }
    let mut distinct: Vec<&str> = Vec::new();
    for &text in &texts {
        if !distinct.contains(&text) {
            distinct.push(text);
        }
    }
    #[expect(clippy::cast_precision_loss, reason = "a small number")]
    let place = |text: &&str| distinct.iter().position(|other| other == text).map_or(0.0, |n| (n + 1) as f64);
    let legend: Vec<_> = (1..).zip(&distinct).map(|(n, text)| format!("{n}: {text}")).collect();
    let numbers: Vec<f64> = texts.iter().map(place).collect();
    let mut ticks = numbers.clone();
    ticks.sort_by(f64::total_cmp);
    ticks.dedup();
    let to = ticks.last().map_or(1.5, |last| last + 0.5);
    let label = format!("{name} ({})", legend.join(", "));
    (numbers, Axis { ticks, ..Axis::linear(label, 0.5, to) })
}

/// Returns the fit of each group that has one. It is a fit of the sweep's figure against its key.
#[must_use]
pub fn fits(sweep: &Sweep, cells: &[PointMean]) -> Vec<GroupFit> {
    let Some(plan) = &sweep.plan.fit else { return Vec::new() };
    let key = sweep.keys.iter().position(|key| *key == plan.against);
    let figure = sweep.plan.figures.iter().position(|figure| *figure == plan.figure);
    let (Some(key), Some(figure)) = (key, figure) else { return Vec::new() };
    let place = places(sweep, key).0;
    let fit = |(group, points): (String, Vec<usize>)| {
        let means = cells.iter().filter(|cell| cell.figure == figure && points.contains(&cell.point));
        let means: Vec<_> = means.filter_map(|cell| Some((place[cell.point], cell.mean?))).collect();
        Some(GroupFit { group, fitted: plan.law.fit(&means)? })
    };
    groups(sweep, key).into_iter().filter_map(fit).collect()
}

/// A row of `fit.csv`.
struct FitRow<'a> {
    group: &'a str,
    parameter: &'a Parameter,
}

/// Returns `fit.csv`; `None` without a fit.
#[must_use]
pub fn fit_table(fits: &[GroupFit]) -> Option<Vec<u8>> {
    let mut rows = Vec::new();
    for GroupFit { group, fitted } in fits {
        rows.extend(fitted.parameters.iter().map(|parameter| FitRow { group, parameter }));
    }
    let columns = [
        TextColumn::new("group", |row: &FitRow| row.group.to_owned()),
        TextColumn::new("parameter", |row: &FitRow| row.parameter.name.to_owned()),
        TextColumn::new("value", |row: &FitRow| row.parameter.value.to_string()),
        TextColumn::new("standard_error", |row: &FitRow| number(row.parameter.error)),
    ];
    (!fits.is_empty()).then(|| csv(&columns, &rows))
}

/// Returns a fit in words, for example `12.3 (x - 0.045)^1.5; k = 1.62 ± 0.05`.
#[must_use]
pub fn fit_in_words(fit: &GroupFit) -> String {
    let mut words = fit.fitted.in_words();
    for it in &fit.fitted.parameters {
        let error = it.error.map_or_else(String::new, |error| format!(" ± {}", short(error)));
        // Writing to a string cannot fail.
        let _ = write!(words, "; {} = {}{error}", it.name, short(it.value));
    }
    if fit.group.is_empty() { words } else { format!("{}: {words}", fit.group) }
}

/// Returns the panel of a figure against the key with this number.
fn panel(sweep: &Sweep, cells: &[PointMean], key: usize, figure: usize) -> Panel {
    let (place, axis) = places(sweep, key);
    let groups = groups(sweep, key);
    let name = &sweep.plan.figures[figure];
    let is_fitted = sweep.plan.fit.as_ref().is_some_and(|fit| fit.figure == *name && fit.against == sweep.keys[key]);
    let fits = if is_fitted { fits(sweep, cells) } else { Vec::new() };
    let ends = |points: &[usize]| {
        points.iter().fold(Ends { low: f64::INFINITY, high: f64::NEG_INFINITY }, |Ends { low, high }, &n| Ends {
            low: low.min(place[n]),
            high: high.max(place[n]),
        })
    };
    let mut curves = Vec::new();
    let mut bands = Vec::new();
    for (number, (group, points)) in groups.iter().enumerate() {
        let mine = || cells.iter().filter(|cell| cell.figure == figure && points.contains(&cell.point));
        let mut means: Vec<_> = mine().filter_map(|cell| Some((place[cell.point], cell.mean?))).collect();
        means.sort_by(|a, b| a.0.total_cmp(&b.0));
        let bars = mine().filter_map(|cell| Some((place[cell.point], cell.mean?, cell.error?)));
        let bars = bars.flat_map(|(x, mean, error)| [(x, mean - error), (x, mean + error), (x, f64::NAN)]).collect();
        // The first colour is black, which is that of the fit of a single curve.
        let colour = colour(number + 1);
        let fit = fits.iter().find(|fit| fit.group == *group);
        let has_line = fit.is_none() && has_lines(sweep, key) && groups.len() <= MOST_CURVES;
        curves.push(Curve { name: group.clone(), colour, points: means, has_line, has_dots: true, is_dashed: false });
        curves.push(Curve { colour, points: bars, has_line: true, ..Curve::default() });
        let colour = if groups.len() > 1 { colour } else { "#222222" };
        if let Some(fit) = fit {
            let ends = start_of(fit, ends(points), axis.from);
            curves.push(law_curve(fit, &ends, colour));
            bands.extend(band_curves(fit, &ends));
        }
    }
    // A band of few points is wide, and must not squeeze the means.
    let y = Axis::around(words(name), curves.iter().flat_map(|curve| &curve.points).map(|point| point.1));
    for point in bands.iter_mut().flat_map(|band| &mut band.points) {
        if !(y.from..=y.to).contains(&point.1) {
            point.1 = f64::NAN;
        }
    }
    // Below the means and the law.
    bands.extend(curves);
    Panel { curves: bands, key: Key::Above, ..Panel::new(sweep.name.clone(), axis, y) }
}

/// Returns the ends of the curve of a fit: those of the means, or the place where its law begins, if the axis, which begins at `first`, has it.
fn start_of(fit: &GroupFit, Ends { low, high }: Ends, first: f64) -> Ends {
    Ends { low: fit.fitted.start().filter(|start| (first..low).contains(start)).unwrap_or(low), high }
}

/// Returns the places of the points of a fit.
fn places_between(&Ends { low, high }: &Ends) -> impl Iterator<Item = f64> {
    (0..=FIT_POINTS).map(move |n| low + (high - low) * f64::from(n) / f64::from(FIT_POINTS))
}

/// Returns the curve of a fit.
fn law_curve(fit: &GroupFit, ends: &Ends, colour: &'static str) -> Curve {
    let points = places_between(ends).filter_map(|x| Some((x, fit.fitted.at(x)?))).collect();
    Curve { name: fit.fitted.in_words(), colour, points, has_line: true, has_dots: false, is_dashed: true }
}

/// Returns the lower and the upper edge of the confidence band of a fit; nothing without one.
fn band_curves(fit: &GroupFit, ends: &Ends) -> Vec<Curve> {
    let edges: Vec<_> = places_between(ends).filter_map(|x| Some((x, fit.fitted.band(x)?))).collect();
    if edges.is_empty() {
        return Vec::new();
    }
    let edge = |name: &str, number: usize| Curve {
        name: name.to_owned(),
        colour: BAND,
        points: edges.iter().map(|(x, band)| (*x, band[number])).collect(),
        has_line: true,
        ..Curve::default()
    };
    vec![edge("95 % of the law", 0), edge("", 1)]
}
