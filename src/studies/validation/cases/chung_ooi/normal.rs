//! Tests 1 to 3 of Chung and Ooi: impacts along the normal.
//!
//! Force and overlap are those of the contact in each frame of `frames.bin`, about a hundred in a contact. The largest force of the frames is at most
//! (pi/100)^2/8 = 1e-4 below the largest one. Hertz's closed form: deepest overlap (5 m* v^2/(4 k))^(2/5), largest force k delta^1.5, with
//! k = 4/3 E* sqrt(R*).

use std::f64::consts::PI;

use super::published::{ALLOY_BY_OVERLAP, ALLOY_BY_TIME, GLASS_BY_OVERLAP, GLASS_BY_TIME};
use super::{Points, bounded, by_axis, deviation, dots, end, line};
use crate::studies::validation::runs::FinishedRun;
use crate::studies::validation::unreadable;
use crate::studies::validation::verdict::{FigureRow, Rule};
use siloflow_figures::diagram::{Axis, Panel};
use siloflow_files::frames::reader::FrameReader;
use siloflow_text::fault::Fault;

/// An elastic impact of two materials. The first has published curves.
pub(super) struct Elastic {
    test: &'static str,
    table: &'static str,
    names: [&'static str; 2],
    /// Young's modulus (Pa), Poisson's ratio, density (kg/m^3).
    materials: [[f64; 3]; 2],
    /// Radius, m.
    radius: f64,
    /// Velocity of approach, m/s.
    speed: f64,
    /// Whether both bodies are spheres; else the second is a plane a thousand times as stiff.
    is_pair: bool,
    by_overlap: &'static [(f64, f64)],
    by_time: &'static [(f64, f64)],
    /// Largest force of the second material in Kratos's data, N.
    largest_of_second: f64,
}

pub(super) const SPHERES: Elastic = Elastic {
    test: "test 1",
    table: "contacts",
    names: ["glass", "limestone"],
    materials: [[4.8e10, 0.20, 2800.0], [2.0e10, 0.25, 2500.0]],
    radius: 0.01,
    speed: 20.0,
    is_pair: true,
    by_overlap: &GLASS_BY_OVERLAP,
    by_time: &GLASS_BY_TIME,
    largest_of_second: 7108.0,
};

pub(super) const PLANE: Elastic = Elastic {
    test: "test 2",
    table: "wall_contacts",
    names: ["aluminium alloy", "magnesium alloy"],
    materials: [[7.0e10, 0.30, 2699.0], [4.0e10, 0.35, 1800.0]],
    radius: 0.1,
    speed: 0.2,
    is_pair: false,
    by_overlap: &ALLOY_BY_OVERLAP,
    by_time: &ALLOY_BY_TIME,
    largest_of_second: 7233.0,
};

impl Elastic {
    /// Returns the largest force (N) and the deepest overlap (m) of Hertz.
    fn hertz(&self, [young, poisson, density]: [f64; 3]) -> (f64, f64) {
        let mass = 4.0 / 3.0 * PI * density * self.radius.powi(3);
        let plane_strain = young / (1.0 - poisson * poisson);
        let [modulus, radius, mass] = if self.is_pair {
            [0.5 * plane_strain, 0.5 * self.radius, 0.5 * mass]
        } else {
            [plane_strain / 1.001, self.radius, mass]
        };
        let k = 4.0 / 3.0 * modulus * radius.sqrt();
        let deepest = (1.25 * mass * self.speed.powi(2) / k).powf(0.4);
        (k * deepest.powf(1.5), deepest)
    }
}

/// Time since the touch (s), overlap (m) and force (N) in each frame of a contact.
fn contact(run: &FinishedRun, elastic: &Elastic) -> Result<Vec<[f64; 3]>, Fault> {
    let path = run.files.directory.join("frames.bin");
    let unreadable = |error| unreadable(&path, &error);
    let mut rows: Vec<[f64; 3]> = Vec::new();
    for frame in FrameReader::open(&path).map_err(unreadable)? {
        let frame = frame.map_err(unreadable)?;
        let Some(table) = frame.table(elastic.table) else { continue };
        let [overlap, force] =
            ["overlap", "normal_force"].map(|column| table.floats(column).and_then(|numbers| numbers.first().copied()));
        if let (Some(overlap), Some(force)) = (overlap, force) {
            rows.push([frame.time, overlap, force]);
        }
    }
    // The speed hardly changes up to the first frame.
    let touch = rows.first().map_or(0.0, |[time, overlap, _]| time - overlap / elastic.speed);
    Ok(rows.into_iter().map(|[time, overlap, force]| [time - touch, overlap, force]).collect())
}

/// Adds the rows of test 1 or 2, and returns its panel.
pub(super) fn elastic(elastic: &Elastic, runs: &[FinishedRun], rows: &mut Vec<FigureRow>) -> Result<Panel, Fault> {
    let mut curves = Vec::new();
    for (number, (name, material)) in elastic.names.into_iter().zip(elastic.materials).enumerate() {
        let of_material = runs.iter().find(|run| run.value("parameters.material") == Some([0.0, 1.0][number]));
        let Some(run) = of_material else { continue };
        let contact = contact(run, elastic)?;
        let [largest, deepest] = [2, 1].map(|column| contact.iter().map(|row| row[column]).fold(0.0, f64::max));
        let (force, overlap) = elastic.hertz(material);
        let test = elastic.test;
        // The frames miss 1e-4 of the largest force and less of the overlap. The steps are far below that.
        rows.push(
            FigureRow::new(format!("{test}, {name}: largest force"), "N", largest)
                .published(force.round(), Rule::Within(1e-3))
                .remark("Hertz's closed form"),
        );
        rows.push(
            FigureRow::new(format!("{test}, {name}: deepest overlap"), "um", 1e6 * deepest)
                .published((1e8 * overlap).round() / 100.0, Rule::Within(1e-3))
                .remark("Hertz's closed form"),
        );
        let by_time: Points = contact.iter().map(|[time, _, force]| (1e6 * time, 1e-3 * force)).collect();
        if number == 0 {
            // Up to the deepest point; the way back is the same, because the contact is elastic.
            let mut by_overlap: Points =
                contact.iter().map(|[_, overlap, force]| (1e6 * overlap, 1e-3 * force)).collect();
            by_overlap.sort_by(|a, b| a.0.total_cmp(&b.0));
            for (against, curve, published) in
                [("overlap", &by_overlap, elastic.by_overlap), ("time", &by_time, elastic.by_time)]
            {
                let quantity =
                    format!("{test}, {name}: force against {against}, largest deviation over the largest force");
                rows.push(bounded(quantity, deviation(curve, published, false)));
            }
            curves.push(dots(&format!("{name}, published"), 0, elastic.by_time));
        } else {
            rows.push(
                FigureRow::new(format!("{test}, {name}: largest force"), "N", largest)
                    .published(elastic.largest_of_second, Rule::Within(0.05))
                    .remark("Kratos's data"),
            );
        }
        curves.push(line(name, number + 1, by_time));
    }
    let abscissae = || curves.iter().flat_map(|curve| curve.points.iter().map(|point| point.0));
    let x = Axis::around("time since the touch, us", abscissae().chain([0.0]));
    let ordinates = curves.iter().flat_map(|curve| curve.points.iter().map(|point| point.1));
    let y = Axis::around("force, kN", ordinates.chain([0.0, 15.0]));
    let title = format!("{}: elastic impact", elastic.test);
    Ok(Panel { curves, ..Panel::new(title, x, y) })
}

/// Adds the rows of test 3, and returns its panel.
pub(super) fn damped(runs: &[FinishedRun], rows: &mut Vec<FigureRow>) -> Result<Panel, Fault> {
    let mut curves = vec![dots("published: that of the law", 0, &[0.2, 0.4, 0.6, 0.8, 1.0].map(|e| (e, e)))];
    for (number, (material, name)) in [(0.0, "aluminium oxide"), (1.0, "cast iron")].into_iter().enumerate() {
        for (attraction, words) in [("Allowed", "with"), ("Forbidden", "without")] {
            let mut points = Vec::new();
            for (e, run) in by_axis(runs, material, "contact.restitution") {
                if run.values.get("contact.attraction").is_some_and(|value| value == attraction) {
                    let [v_z] = end(run, ["vz"])?;
                    points.push((e, v_z / 3.9));
                }
            }
            let published: Points = points.iter().map(|(e, _)| (*e, *e)).collect();
            let quantity =
                format!("test 3, {name}, {words} attraction: restitution from 0.2 to 1, largest relative deviation");
            let percent = if points.is_empty() { f64::NAN } else { deviation(&points, &published, true) };
            rows.push(bounded(quantity, percent));
            if words == "with" {
                curves.push(line(name, number + 1, points));
            }
        }
    }
    let [x, y] = ["restitution of the law", "measured restitution"].map(|label| Axis::linear(label, 0.0, 1.2));
    Ok(Panel { curves, ..Panel::new("test 3: damped impact", x, y) })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hertz_gives_the_numbers_of_both_tests() {
        // Tests 1 and 2: force (N) and overlap (um), in four digits.
        for (elastic, expected) in
            [(&SPHERES, [(10_700.0, 274.1), (7108.0, 368.3)]), (&PLANE, [(11_365.0, 49.74), (7230.0, 52.14)])]
        {
            for (material, (force, overlap)) in elastic.materials.into_iter().zip(expected) {
                let (found_force, found_overlap) = elastic.hertz(material);
                assert!((found_force / force - 1.0).abs() < 5e-4, "{found_force} {force}");
                assert!((1e6 * found_overlap / overlap - 1.0).abs() < 5e-4, "{found_overlap} {overlap}");
            }
        }
    }
}
