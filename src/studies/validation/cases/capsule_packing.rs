//! Random packings of frictionless capsules, poured under gravity: cylinders of length L and diameter D with round ends.
//!
//! Disordered jammed packings of capsules are densest at L/D = 0.45 ± 0.05, with a solid fraction of 0.721 ± 0.001 (PMC10405222, 2023, abstract, which says
//! that several earlier works agree on the form of the curve; Kyrylyuk et al. 2009 find the maximum at the same place). The rule for this fraction is 0.01, as for spheres in
//! the case `ellipsoid-packing`. Gravity may order long grains: the nematic order stands beside the fraction.
//!
//! The beds of the full form with L/D = 0.45 miss, 0.708. If the floor shakes by 0.2 mm at 50 Hz from 0.7 to 1.7 s, their fraction from 1.95 to 2.05 s is 0.712 ± 0.003
//! (`siloflow run bed.ron --seed 1` and 2, with `parameters.side=0.06`, `parameters.count=400`, `motions` and `profiles` set so).

use super::ellipsoid_packing::mean_of;
use crate::studies::validation::groups::groups_by;
use crate::studies::validation::runs::Studies;
use crate::studies::validation::verdict::{FigureRow, Judgement, Picture, Rule};
use crate::studies::validation::{Case, file};
use siloflow_figures::diagram::{Axis, Curve, Panel, colour, sheet};
use siloflow_figures::statistics::mean::Mean;
use siloflow_text::fault::Fault;

/// The case.
pub const CASE: Case = Case {
    name: "capsule-packing",
    title: "Random packings of capsules",
    sources: "Dense disordered jammed packings of hard spherocylinders, 2023, PMC10405222 (abstract): densest at L/D = 0.45 with 0.721.",
    files: &[
        file!("capsule-packing", "bed.ron"),
        file!("capsule-packing", "short.ron"),
        file!("capsule-packing", "full.ron"),
    ],
    short: &["short.ron"],
    full: &["full.ron"],
    judge,
};

/// L/D of the densest packing.
const DENSEST: f64 = 0.45;

/// Published solid fractions: of spheres and of the densest capsules.
const SPHERES: f64 = 0.64;
const LARGEST: f64 = 0.721;

/// Why poured capsules miss.
const POURED: &str = "poured, not compressed: two beds that shook for a second had 0.712 ± 0.003";

fn judge(studies: &Studies) -> Result<Judgement, Fault> {
    let mut judgement = Judgement::default();
    let mut fractions = Vec::new();
    for (long, of_shape) in groups_by(studies.first_of(&["full.ron", "short.ron"]), |run| run.value("parameters.long"))
    {
        let means = |column: &str| of_shape.iter().map(|run| mean_of(run, column)).collect::<Result<Vec<_>, _>>();
        let fraction = Mean::of(&means("packing_fraction")?);
        let row = FigureRow::of_mean(format!("L/D = {long}: solid fraction"), "", fraction);
        judgement.rows.push(match long {
            ..1e-9 => row.published(SPHERES, Rule::WithinAbsolute(0.01)).remark("random close packing of spheres"),
            it if (it - DENSEST).abs() < 1e-9 => row.published(LARGEST, Rule::WithinAbsolute(0.01)).known_miss(POURED),
            _ => row,
        });
        // A sphere has no director.
        if long > 0.0 {
            let order = Mean::of(&means("nematic_order")?);
            judgement.rows.push(FigureRow::of_mean(format!("L/D = {long}: nematic order"), "", order));
        }
        fractions.extend(fraction.map(|mean| (long, mean.value)));
    }
    let at = |long: f64| fractions.iter().find(|(it, _)| (it - long).abs() < 1e-9).map_or(f64::NAN, |it| it.1);
    let others = fractions.iter().filter(|(long, _)| (long - DENSEST).abs() > 1e-9).map(|it| it.1);
    let excess = at(DENSEST) - others.fold(f64::NAN, f64::max);
    let row = FigureRow::new(format!("solid fraction at L/D = {DENSEST} less the largest of the others"), "", excess);
    judgement.rows.push(row.rule(Rule::Between(0.0, 1.0)).remark("published: the maximum"));
    let x = Axis::around("L/D", fractions.iter().map(|point| point.0));
    let y = Axis::around("solid fraction", fractions.iter().map(|point| point.1).chain([SPHERES, LARGEST]));
    let mut panel = Panel::new("Beds of capsules without friction", x, y);
    let curve = Curve { colour: colour(1), points: fractions, has_line: true, has_dots: true, ..Curve::default() };
    panel.curves.push(curve);
    panel.rings = vec![(0.0, SPHERES), (DENSEST, LARGEST)];
    let caption = "Dots: means over seeds. Rings: published.".to_owned();
    judgement.pictures.push(Picture { name: "", svg: sheet(&[panel], 1), caption });
    judgement.remarks.push(
        "The published packings are compressed without gravity. The capsules are rows of spheres whose valleys are below 0.4 % of a diameter.".to_owned(),
    );
    Ok(judgement)
}
