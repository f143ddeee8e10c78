//! The silo of Dosta et al., Comput. Phys. Commun. 296, 109066 (2024), case 1: 100,000 spheres in a cylinder above a cone, two orifices, two materials.
//!
//! The rate is the slope of a straight line through the number of grains out, from 0.5 s after the opening to 3.5 s. The published rates are those of LIGGGHTS and
//! MUSEN for the published set-up, taken in the same window (`dem-bulk-dosta2024` of peclet-examples). Rates of the other three variants are taken from 0.5 to
//! 0.9 s after the opening, and so are the rates of the large orifice with which they are compared: the rate falls as the silo empties.
//!
//! Young's moduli are a hundredth of the published ones, in the runs of friction a thousandth. `short.ron` and `full-stiff.ron` show the rate against the modulus.

use crate::studies::validation::runs::{FinishedRun, Studies};
use crate::studies::validation::verdict::{FigureRow, Judgement, Picture, Rule};
use crate::studies::validation::{Case, file};
use siloflow_figures::diagram::{Axis, Curve, Panel, colour, sheet};
use siloflow_figures::statistics::points::interpolated;
use siloflow_text::fault::Fault;

/// The case.
pub const CASE: Case = Case {
    name: "dosta-silo",
    title: "Silo of Dosta et al. 2024",
    sources: "Dosta et al. 2024, Comput. Phys. Commun. 296, 109066, case 1; rates of LIGGGHTS, MUSEN and peclet from \
              `dem-bulk-dosta2024` of peclet-examples.",
    files: &[
        file!("dosta-silo", "silo.ron"),
        file!("dosta-silo", "short.ron"),
        file!("dosta-silo", "full.ron"),
        file!("dosta-silo", "full-small.ron"),
        file!("dosta-silo", "full-m2.ron"),
        file!("dosta-silo", "full-friction.ron"),
        file!("dosta-silo", "full-stiff.ron"),
    ],
    short: &["short.ron"],
    full: &["full.ron", "full-small.ron", "full-m2.ron", "full-friction.ron", "short.ron", "full-stiff.ron"],
    judge,
};

/// Rate of the large orifice with M1, grains/s.
const RATE: f64 = 24_400.0;

/// Rates with M1 from 0.5 to 0.9 s, grains/s: of the large orifice in LIGGGHTS, of the small orifice in MUSEN; LIGGGHTS was not run with it.
const EARLY_RATE: f64 = 25_177.0;
const SMALL_RATE: f64 = 7761.0;

/// Rate of the large over the small orifice with M1, of the published set-up; its window is not known.
const RATIO: f64 = 3.10;

/// Grains left at 1, 2 and 3 s in LIGGGHTS, thousands.
const LEFT: [(f64, f64); 3] = [(1.0, 76.0), (2.0, 51.3), (3.0, 27.0)];

/// A range of times, s.
#[derive(Clone, Copy)]
struct TimeWindow {
    from: f64,
    to: f64,
}

/// Windows of the rate of a full bed, of the variants, and of a bed of 30,000 grains, s after the opening.
const WINDOW: TimeWindow = TimeWindow { from: 0.5, to: 3.5 };
const VARIANT_WINDOW: TimeWindow = TimeWindow { from: 0.5, to: 0.9 };
const SHORT_WINDOW: TimeWindow = TimeWindow { from: 0.1, to: 0.4 };

/// Returns the rate of a run in a window, grains/s.
fn rate(run: &FinishedRun, TimeWindow { from, to }: TimeWindow) -> Result<f64, Fault> {
    run.rate(from, to)
}

/// Returns the points (number of the summary, rate) of some runs.
fn rates(runs: &[FinishedRun], key: &str) -> Result<Vec<(f64, f64)>, Fault> {
    let points = runs.iter().map(|run| Ok((run.number(key).unwrap_or(f64::NAN), rate(run, SHORT_WINDOW)?)));
    points.collect()
}

fn judge(studies: &Studies) -> Result<Judgement, Fault> {
    let mut judgement = Judgement::default();
    let mut panels = Vec::new();
    if let [run] = studies.runs("full.ron") {
        judgement.rows.push(
            FigureRow::new("large orifice, M1: rate from 0.5 to 3.5 s", "grains/s", rate(run, WINDOW)?)
                .published(RATE, Rule::Within(0.05)),
        );
        let left: Vec<_> = run.discharge()?.into_iter().map(|(time, out)| (time, 100.0 - 1e-3 * out)).collect();
        for (time, published) in LEFT {
            let found = interpolated(&left, time).unwrap_or(f64::NAN);
            judgement.rows.push(
                FigureRow::new(format!("large orifice, M1: left at {time} s"), "thousand grains", found)
                    .published(published, Rule::Reported),
            );
        }
        panels.push(discharge_panel(left));
    }
    variants(studies, &mut judgement)?;
    let mut soft = rates(studies.runs("short.ron"), "parameters.soft")?;
    soft.extend(rates(studies.runs("full-stiff.ron"), "parameters.soft")?);
    let friction = rates(studies.runs("full-friction.ron"), "parameters.friction")?;
    for (share, found) in &soft {
        let row = FigureRow::new(
            format!("30,000 grains, {share} of the published moduli: rate from 0.1 to 0.4 s"),
            "grains/s",
            *found,
        );
        judgement.rows.push(row.published(RATE, if *share < 0.005 { Rule::Reported } else { Rule::Within(0.05) }));
    }
    if let (Some(first), Some(last)) = (friction.first(), friction.last()) {
        let row = FigureRow::new(
            format!("30,000 grains: rate at friction {} over rate at {}", first.0, last.0),
            "",
            first.1 / last.1,
        );
        // A rate that does not depend on friction would be an error of the program.
        judgement.rows.push(row.rule(Rule::Between(1.05, 10.0)));
        panels.push(panel("Friction", Axis::linear("friction, grains and wall", 0.0, 1.0), friction));
    }
    let axis = Axis::logarithmic("share of the published Young's moduli", soft.iter().map(|point| point.0));
    panels.push(panel("Stiffness", axis, soft));
    let caption = if panels.len() == 1 {
        "Rate of the large orifice against the stiffness."
    } else {
        "Left to right: grains left after the opening, with LIGGGHTS as dots; rates against friction; rates against stiffness."
    };
    let caption = caption.to_owned();
    let columns = panels.len();
    judgement.pictures.push(Picture { name: "", svg: sheet(&panels, columns), caption });
    judgement.remarks.push(
        "Walls, materials and laws are the published ones. The bed is made here: grains begin on a lattice and settle. The published bed is a file of positions. \
         The runs of the full bed have a hundredth of the published Young's moduli, those of friction have a thousandth."
            .to_owned(),
    );
    Ok(judgement)
}

/// Adds the rates of both orifices and materials, and the ratios of the orifices.
fn variants(studies: &Studies, judgement: &mut Judgement) -> Result<(), Fault> {
    let ([large], [small]) = (studies.runs("full.ron"), studies.runs("full-small.ron")) else { return Ok(()) };
    let of_m2 = |orifice: f64| {
        let mut runs = studies.runs("full-m2.ron").iter();
        runs.find(|run| run.value("parameters.orifice") == Some(orifice))
    };
    let (Some(large_m2), Some(small_m2)) = (of_m2(0.03), of_m2(0.02)) else { return Ok(()) };
    for (material, large, small) in [("M1", large, small), ("M2", large_m2, small_m2)] {
        let [large, small] = [rate(large, VARIANT_WINDOW)?, rate(small, VARIANT_WINDOW)?];
        let mut rows = [
            FigureRow::new(format!("large orifice, {material}: rate from 0.5 to 0.9 s"), "grains/s", large),
            FigureRow::new(format!("small orifice, {material}: rate from 0.5 to 0.9 s"), "grains/s", small),
            FigureRow::new(format!("{material}: rate of the large over the small orifice"), "", large / small),
        ];
        if material == "M1" {
            let [large, small, ratio] = rows;
            rows = [
                large.published(EARLY_RATE, Rule::Within(0.05)).remark("LIGGGHTS; MUSEN has 24625"),
                small.published(SMALL_RATE, Rule::Within(0.05)).remark("MUSEN"),
                ratio.published(RATIO, Rule::WithinAbsolute(0.1)).remark("In this window MUSEN has 3.17"),
            ];
        }
        judgement.rows.extend(rows);
    }
    Ok(())
}

fn discharge_panel(left: Vec<(f64, f64)>) -> Panel {
    let curves = vec![
        Curve { name: "siloflow".to_owned(), colour: colour(1), points: left, has_line: true, ..Curve::default() },
        Curve {
            name: "LIGGGHTS".to_owned(),
            colour: colour(0),
            points: LEFT.to_vec(),
            has_dots: true,
            ..Curve::default()
        },
    ];
    let [x, y] = [("time after the opening, s", 4.0), ("grains left, thousands", 100.0)]
        .map(|(label, to)| Axis::linear(label, 0.0, to));
    Panel { curves, key: siloflow_figures::diagram::Key::LowerLeft, ..Panel::new("Large orifice, M1", x, y) }
}

/// Returns a panel of rates.
fn panel(title: &str, x: Axis, points: Vec<(f64, f64)>) -> Panel {
    let thousands: Vec<_> = points.into_iter().map(|(x, rate)| (x, 1e-3 * rate)).collect();
    let y = Axis::around("rate, thousand grains/s", thousands.iter().map(|point| point.1).chain([0.0]));
    let curves =
        vec![Curve { colour: colour(1), points: thousands, has_line: true, has_dots: true, ..Curve::default() }];
    Panel { curves, ..Panel::new(title, x, y) }
}
