//! Random packings of frictionless ellipsoids of revolution, poured under gravity.
//!
//! Donev et al. pack spheres at random to a solid fraction of 0.64, and ellipsoids with an aspect ratio close to that of M&M's candies to 0.68 to 0.71 (Science
//! 303, 990, abstract). The fraction of a bed is the mean over the middle of its height and the last tenth of a second, from `profiles.csv`; the
//! volume of a grain is that of the union of its spheres. The nematic order beside it says whether gravity has aligned the grains.
//!
//! Grains of several spheres are not smooth: valleys between spheres act like friction. They are flatter with more spheres: in beds of 250 flat grains
//! 19 spheres gave 0.676, and 31 spheres 0.686.

use crate::studies::validation::groups::groups_by;
use crate::studies::validation::runs::{FinishedRun, Studies};
use crate::studies::validation::verdict::{FigureRow, Judgement, Picture, Rule};
use crate::studies::validation::{Case, file};
use siloflow_figures::diagram::{Axis, Curve, Panel, colour, sheet};
use siloflow_figures::statistics::mean::Mean;
use siloflow_text::fault::Fault;

/// The case.
pub const CASE: Case = Case {
    name: "ellipsoid-packing",
    title: "Random packings of ellipsoids",
    sources: "Donev et al. 2004, Science 303, 990 (abstract): random packings of spheres and of ellipsoids like M&M's candies.",
    files: &[
        file!("ellipsoid-packing", "bed.ron"),
        file!("ellipsoid-packing", "short.ron"),
        file!("ellipsoid-packing", "full.ron"),
        file!("ellipsoid-packing", "full-long.ron"),
    ],
    short: &["short.ron"],
    full: &["full.ron", "full-long.ron"],
    judge,
};

/// Aspect ratio of the candies: 0.693 cm over 1.34 cm.
const CANDY: f64 = 0.517;

/// Published solid fractions: of spheres, and the range of those of candies.
const SPHERES: f64 = 0.64;
const CANDIES: [f64; 2] = [0.68, 0.71];

/// Returns the mean of a column of the profile.
pub(super) fn mean_of(run: &FinishedRun, column: &str) -> Result<f64, Fault> {
    let numbers = run.table("profiles.csv")?.needed(column)?;
    Ok(Mean::of(&numbers).map_or(f64::NAN, |mean| mean.value))
}

fn judge(studies: &Studies) -> Result<Judgement, Fault> {
    let mut judgement = Judgement::default();
    let runs = studies.first_of(&["full.ron", "short.ron"]);
    let mut curve = Vec::new();
    let groups = |runs| groups_by(runs, |run| run.value("parameters.thick"));
    for (thick, of_shape) in groups(runs).into_iter().chain(groups(studies.runs("full-long.ron"))) {
        let means = |column: &str| of_shape.iter().map(|run| mean_of(run, column)).collect::<Result<Vec<_>, _>>();
        let fraction = Mean::of(&means("packing_fraction")?);
        let row = FigureRow::of_mean(format!("aspect {thick}: solid fraction"), "", fraction);
        let row = if (thick - 1.0).abs() < 1e-9 {
            row.published(SPHERES, Rule::WithinAbsolute(0.01)).remark("random close packing of spheres")
        } else if (thick - CANDY).abs() < 1e-9 {
            row.rule(Rule::Between(CANDIES[0], CANDIES[1])).remark("published: 0.68 to 0.71")
        } else {
            row
        };
        judgement.rows.push(row);
        // A sphere has no director.
        if (thick - 1.0).abs() > 1e-9 {
            let order = Mean::of(&means("nematic_order")?);
            judgement.rows.push(FigureRow::of_mean(format!("aspect {thick}: nematic order"), "", order));
        }
        curve.extend(fraction.map(|mean| (thick, mean.value)));
    }
    let x = Axis::around("axis of revolution over width", curve.iter().map(|point| point.0));
    let y = Axis::around("solid fraction", curve.iter().map(|point| point.1).chain([SPHERES, CANDIES[1]]));
    let mut panel = Panel::new("Beds of ellipsoids without friction", x, y);
    panel.curves.push(Curve { colour: colour(1), points: curve, has_line: true, has_dots: true, ..Curve::default() });
    panel.rings = vec![(1.0, SPHERES), (CANDY, CANDIES[0]), (CANDY, CANDIES[1])];
    let caption =
        "Dots: means over seeds. Flat grains are left of 1, long ones right of it. Rings: published; two are the ends of a range."
            .to_owned();
    judgement.pictures.push(Picture { name: "", svg: sheet(&[panel], 1), caption });
    judgement.remarks.push(
        "Donev et al. compress without gravity; here grains are poured, and gravity orders flat ones. Flat ellipsoids are rigid bodies of 31 spheres, long ones rows of eleven. In beds of 250 candies, 19 spheres \
         with deeper valleys gave a fraction of 0.676.".to_owned(),
    );
    Ok(judgement)
}
