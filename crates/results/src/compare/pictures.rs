//! The pictures of a comparison: fields side by side, discharge curves, disagreement against cost.

use crate::compare::Run;
use crate::compare::field::{Cell, Field};
use crate::compare::report::{FieldFigures, Report, Row};
use glam::DVec2;
use siloflow_figures::colour::{WALL, viridis};
use siloflow_figures::diagram::{Axis, Curve, colour, figure};
use siloflow_figures::svg::{Legend, Picture};

/// Returns the pictures of a comparison as pairs of name and SVG document. Fields and cost are drawn for the runs with a field.
#[must_use]
pub fn all(runs: &[Run], report: &Report) -> Vec<(&'static str, String)> {
    let panels: Vec<_> = runs.iter().zip(&report.rows).filter_map(|(run, row)| Panel::of(run, row)).collect();
    let mut pictures = vec![("discharge", discharge(runs, report))];
    if let Some(fields) = fields(&panels, report.looks) {
        pictures.extend([("fields", fields), ("cost", cost(report))]);
    }
    pictures
}

/// A run with a field, and its comparison.
struct Panel<'a> {
    run: &'a Run,
    field: &'a Field,
    figures: &'a FieldFigures,
}

impl<'a> Panel<'a> {
    fn of(run: &'a Run, row: &'a Row) -> Option<Self> {
        Some(Self { run, field: run.field.as_ref()?, figures: row.field.as_ref()? })
    }
}

/// Width of a run's panel, px.
const PANEL: f64 = 320.0;

/// Draws the vertical velocity over its mean for every run, with equal length scale and equal colour scale; `None` without a run.
fn fields(panels: &[Panel], looks: f64) -> Option<String> {
    let side = panels.first()?.field.side;
    let corner = |[row, column]: [i64; 2]| side * DVec2::new(to_f64(column), to_f64(row));
    let (low, high) = bounds(panels, looks, side);
    let step = DVec2::new(1.15 * (high.x - low.x), 0.0);
    let all = f64::from(u32::try_from(panels.len()).unwrap_or(1)) * step;
    // The names above have a size in proportion to the total width.
    let margin = 0.07 * (high.x - low.x);
    let above = DVec2::new(0.0, 0.08 * all.x);
    let top = top(panels, looks);
    let mut picture = Picture {
        low: low - DVec2::splat(margin),
        high: DVec2::new(low.x - margin + all.x, high.y) + above,
        // Header and legend are side by side, so the width is at least two panels.
        width: (PANEL * all.x / step.x).max(2.0 * PANEL),
        header: vec![format!("cells of {side} m; yellow: {top} and more")],
        legend: Legend::Scale { from: 0.0, to: top, title: "downward speed/its mean".to_owned(), map: viridis },
        ..Picture::default()
    };
    let mut offset = DVec2::ZERO;
    // Names alternate between two heights, because they may be wider than their panels.
    let rows = [0.2, 0.65].into_iter().cycle();
    for (Panel { run, field, figures }, height) in panels.iter().zip(rows) {
        let square = |(key, cell): ([i64; 2], Cell)| {
            let low = corner(key) + offset;
            (viridis(cell.down / figures.mean_speed / top), vec![(low, low + DVec2::splat(side))])
        };
        picture.cells.extend(field.seen(looks).map(square));
        picture.lines.extend(run.outline.lines.iter().map(|&(from, to)| (from + offset, to + offset, WALL)));
        picture.discs.extend(run.outline.discs.iter().map(|disc| (disc.centre + offset, disc.radius, WALL)));
        let name = DVec2::new(0.5 * (low.x + high.x), high.y) + height * above + offset;
        picture.labels.push((name, run.name.clone()));
        offset += step;
    }
    Some(picture.to_svg())
}

/// Returns the lower left and upper right corner of the box around all cells and wall grains, m.
fn bounds(panels: &[Panel], looks: f64, side: f64) -> (DVec2, DVec2) {
    let cells = panels.iter().flat_map(|panel| panel.field.seen(looks)).map(|([row, column], _)| {
        let corner = side * DVec2::new(to_f64(column), to_f64(row));
        (corner, corner + DVec2::splat(side))
    });
    let discs = panels.iter().flat_map(|panel| &panel.run.outline.discs);
    let discs = discs.map(|disc| (disc.centre - DVec2::splat(disc.radius), disc.centre + DVec2::splat(disc.radius)));
    cells.chain(discs).reduce(|a, b| (a.0.min(b.0), a.1.max(b.1))).unwrap_or((DVec2::ZERO, DVec2::ONE))
}

#[expect(clippy::cast_precision_loss, reason = "cells are far below 2^53")]
fn to_f64(number: i64) -> f64 {
    number as f64
}

/// Returns the upper end of the colour scale: a round number above the relative speed of 95 % of the reference's
/// grains.
fn top(panels: &[Panel], looks: f64) -> f64 {
    let Some(Panel { field, figures, .. }) = panels.first() else { return 1.0 };
    let mut cells: Vec<_> = field.seen(looks).map(|(_, cell)| (cell.down, cell.count)).collect();
    cells.sort_by(|a, b| a.0.total_cmp(&b.0));
    let all: f64 = cells.iter().map(|cell| cell.1).sum();
    let mut below = 0.0;
    let most = cells.iter().find(|cell| {
        below += cell.1;
        below >= 0.95 * all
    });
    let most = most.map_or(1.0, |cell| cell.0 / figures.mean_speed).max(1e-9);
    let power = 10f64.powf(most.log10().floor());
    [1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 7.0].into_iter().map(|m| m * power).find(|&end| end >= most).unwrap_or(10.0 * power)
}

fn discharge(runs: &[Run], report: &Report) -> String {
    let curves: Vec<_> = runs
        .iter()
        .zip(&report.rows)
        .enumerate()
        .map(|(number, (run, row))| Curve {
            name: format!("{}: unit {:.4} {}", run.name, row.unit_time, row.time_unit),
            colour: colour(number),
            points: run.discharge.in_units(row.unit_time).points().to_vec(),
            has_line: true,
            ..Curve::default()
        })
        .collect();
    let last = curves.iter().filter_map(|curve| curve.points.last()).map(|point| point.0).fold(1.0, f64::max);
    let title = format!("Discharge; unit of time: until {} is out", (1000.0 * report.unit_share).round() / 1000.0);
    let x = Axis::linear("time since the door opened, in units of the run's own", 0.0, last);
    figure(&[(&title, x, Axis::linear("fraction of the grains that are out", 0.0, 1.0), curves)])
}

/// Smallest cost (s) and disagreement of the cost figure. Zero has no logarithm and is drawn at this value.
const LEAST: f64 = 1e-6;

fn cost(report: &Report) -> String {
    // The colour of a run is that of its discharge curve.
    let others = || {
        let rows = report.rows.iter().enumerate().skip(1);
        rows.filter_map(|(number, row)| Some((number, row, row.field.as_ref()?.field_rms)))
    };
    let point = |row: &Row, rms: f64| (row.wall_s.max(LEAST), rms.max(LEAST));
    let curves = others().map(|(number, row, rms)| Curve {
        name: row.run.clone(),
        colour: colour(number),
        points: vec![point(row, rms)],
        has_dots: true,
        ..Curve::default()
    });
    let x = Axis::logarithmic("cost: wall-clock time of the steps, s", others().map(|(_, row, rms)| point(row, rms).0));
    let y =
        Axis::logarithmic("disagreement of the field, mean speeds", others().map(|(_, row, rms)| point(row, rms).1));
    let reference = report.rows.first();
    let title = reference.map_or_else(String::new, |row| format!("Against {}, {:.1} s", row.run, row.wall_s));
    figure(&[(&title, x, y, curves.collect())])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compare::{compare, tests::run};
    use siloflow_figures::png;

    #[test]
    fn every_picture_shows_every_run_and_is_valid() {
        let runs = [
            run("first", 1.0, |x, _| 1.0 + x),
            run("second", 2.0, |x, _| 1.0 + x * x),
            run("third", 2.0, |x, _| 1.0 + x),
        ];
        let report = compare(&runs[0], &runs[1..], 1.0).unwrap();
        for (name, svg) in all(&runs, &report) {
            assert!(png::encode(&svg).is_ok() && svg.contains("first") && svg.contains("third"), "{name}: {svg}");
            assert!(!svg.contains("NaN") && !svg.contains("inf"), "{name}: {svg}");
        }
        // There are 16 cells per run. Each run except the reference has a dot and a dot in the legend.
        let pictures = all(&runs, &report);
        let [_, (_, fields), (_, cost)] = &pictures[..] else { panic!("{} pictures", pictures.len()) };
        assert_eq!(fields.matches('Z').count(), 16 * 3);
        assert_eq!(cost.matches("<circle").count(), 4);
    }

    #[test]
    fn runs_without_a_field_are_in_the_discharge_alone() {
        let without = |name: &str| Run { field: None, ..run(name, 1.0, |_, _| 1.0) };
        let mixed = [run("first", 1.0, |x, _| 1.0 + x), without("second")];
        let report = compare(&mixed[0], &mixed[1..], 1.0).unwrap();
        let names = |pictures: &[(&'static str, String)], text: &str| {
            pictures.iter().filter(|(_, svg)| svg.contains(text)).map(|(name, _)| *name).collect::<Vec<_>>()
        };
        assert_eq!(names(&all(&mixed, &report), "second"), ["discharge"]);
        let neither = [without("first"), without("second")];
        let report = compare(&neither[0], &neither[1..], 1.0).unwrap();
        assert_eq!(names(&all(&neither, &report), "<svg"), ["discharge"]);
    }

    #[test]
    fn colour_scale_ends_at_a_round_number_above_most_grains() {
        let runs = [run("a", 1.0, |x, _| if x < 0.5 { 1.0 } else { 3.0 })];
        let report = compare(&runs[0], &[], 1.0).unwrap();
        // The mean is 2.5, so the largest relative speed is 3/2.5 = 1.2.
        let panels = [Panel::of(&runs[0], &report.rows[0]).unwrap()];
        assert!((top(&panels, 1.0) - 1.5).abs() < 1e-15);
    }
}
