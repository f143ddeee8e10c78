//! Work-precision figures: error against cost; the Pareto-optimal points have rings.
//!
//! One figure has a panel per case and shows the error against force evaluations per contact duration, which do not
//! depend on the machine. The other figure shows the bed and the mean of the bounces against measured nanoseconds.

use super::report::{Entry, Report, SUMMARY};
use super::work_precision::pareto;
use siloflow_figures::diagram::{Axis, Curve, Key, Panel, colour, sheet};
use siloflow_figures::statistics::mean::geometric_mean;

/// Panels per row.
const PER_ROW: usize = 4;
/// Smallest drawn error. Smaller errors are round-off and are drawn at this value.
const LEAST: f64 = 1e-13;
/// Largest drawn error. Larger errors are left out.
const MOST: f64 = 10.0;

/// Returns the errors of all cases against force evaluations, as SVG.
#[must_use]
pub fn work_precision(report: &Report) -> String {
    let mut panels = Vec::new();
    for group in report.entries.chunk_by(|a, b| a.case == b.case) {
        let evaluations = |entry: &Entry| -> Vec<(f64, f64)> {
            let point = |row: &super::report::Row| Some((row.evaluations_per_contact, row.error?));
            entry.rows.iter().filter_map(point).collect()
        };
        let curves = group.iter().map(|entry| (entry.scheme.clone(), evaluations(entry))).collect();
        panels.push(panel(report, group[0].title, "force evaluations per contact", curves));
    }
    sheet(&panels, PER_ROW)
}

/// Returns the bed's error and the mean error of the bounces against measured time, as SVG; `None` if neither was run.
#[must_use]
pub fn in_time(report: &Report) -> Option<String> {
    let mut panels = Vec::new();
    let bed: Vec<_> = report.entries.iter().filter(|entry| entry.case == "bed").collect();
    let in_time = |points: Vec<(f64, f64)>, scheme: &str| -> Vec<(f64, f64)> {
        let cost = report.schemes.iter().find(|figures| figures.scheme == scheme).and_then(|f| f.ns_per_particle_step);
        points.into_iter().filter_map(|(n, error)| Some((n * cost?, error))).collect()
    };
    if !bed.is_empty() {
        let points =
            |entry: &Entry| entry.rows.iter().filter_map(|row| Some((row.steps_per_contact, row.error?))).collect();
        let curves = bed.iter().map(|entry| (entry.scheme.clone(), in_time(points(entry), &entry.scheme)));
        panels.push(panel(report, "silo1's bed, in time", TIME, curves.collect()));
    }
    let curves = report.schemes.iter().map(|figures| {
        let scheme = &figures.scheme;
        (scheme.clone(), in_time(mean_bounce_errors(report, scheme), scheme))
    });
    let curves: Vec<_> = curves.filter(|(_, points)| !points.is_empty()).collect();
    if !curves.is_empty() {
        panels.push(panel(report, "bounces, mean of e = 0.9, 0.5, 0.2, in time", TIME, curves));
    }
    (!panels.is_empty()).then(|| sheet(&panels, PER_ROW))
}

const TIME: &str = "ns per grain and contact";

/// Returns (t_c/dt, geometric mean of the errors) over the bounces of the summary.
fn mean_bounce_errors(report: &Report, scheme: &str) -> Vec<(f64, f64)> {
    let entry = |case: &str| report.entries.iter().find(|entry| entry.case == case && entry.scheme == scheme);
    let entries: Option<Vec<_>> = SUMMARY.0.iter().map(|case| entry(case)).collect();
    let Some(entries) = entries else { return Vec::new() };
    let mean_at_rung = |n: usize| {
        let errors: Option<Vec<f64>> = entries.iter().map(|entry| entry.rows.get(n)?.error).collect();
        Some((entries[0].rows[n].steps_per_contact, geometric_mean(&errors?)?))
    };
    (0..entries[0].rows.len()).filter_map(mean_at_rung).collect()
}

fn panel(report: &Report, title: &str, label: &'static str, curves: Vec<(String, Vec<(f64, f64)>)>) -> Panel {
    let number = |scheme: &str| report.schemes.iter().position(|figures| figures.scheme == scheme).unwrap_or(0);
    let shown = |points: Vec<(f64, f64)>| -> Vec<(f64, f64)> {
        points.into_iter().filter(|point| point.1 <= MOST).map(|(n, error)| (n, error.max(LEAST))).collect()
    };
    let curves: Vec<_> = curves
        .into_iter()
        .map(|(name, points)| {
            let colour = colour(1 + number(&name));
            Curve { name, colour, points: shown(points), has_line: true, has_dots: true, ..Curve::default() }
        })
        // The legend lists only what the panel shows.
        .filter(|curve| !curve.points.is_empty())
        .collect();
    let all: Vec<_> = curves.iter().flat_map(|curve| curve.points.iter().copied()).collect();
    let rings = all.iter().zip(pareto(&all)).filter(|(_, is_on_it)| *is_on_it).map(|(point, _)| *point);
    let rings = rings.filter(|point| point.1 > LEAST).collect();
    let x = Axis::logarithmic(label, all.iter().map(|point| point.0));
    let y = Axis::logarithmic("rms error; ringed: Pareto-optimal", all.iter().map(|point| point.1));
    Panel { curves, rings, key: Key::LowerLeft, ..Panel::new(title, x, y) }
}
