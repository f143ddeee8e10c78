//! The discharge rate of ellipsoids of revolution against their aspect ratio, axis of revolution over width.
//!
//! Fan, Pongó, Hidalgo and Börzsönyi find a rate that is not monotonic, in experiments and simulations (PRL 133, 058201, abstract): it grows from spheres
//! to maxima at aspect ratios of about 0.6 (lentils, about 15 % more than spheres) and 1.5 (rice), and drops for 0.25 and 4, which are not run here. All
//! grains have the same volume. A rate is the slope of a straight line through the number of grains out from 0.1 s after the opening on, as in the
//! case `beverloo`.
//!
//! | figure | rule |
//! |---|---|
//! | rate of 0.6 over that of spheres | 1.15 within 0.05: "about 15 %" |
//! | rate of 1.5 over that of spheres | above 1 |
//!
//! A run that clogs has no rate.

use crate::studies::validation::groups::{groups_by, mean_rate};
use crate::studies::validation::runs::Studies;
use crate::studies::validation::verdict::{FigureRow, Judgement, Picture, Rule};
use crate::studies::validation::{Case, file};
use siloflow_figures::diagram::{Axis, Curve, Panel, colour, sheet};
use siloflow_text::fault::Fault;

/// The case.
pub const CASE: Case = Case {
    name: "ellipsoid-discharge",
    title: "Discharge of ellipsoids",
    sources: "Fan et al. 2024, Phys. Rev. Lett. 133, 058201 (arXiv 2407.21685, abstract): rate against aspect ratio, with maxima at 0.6 and 1.5.",
    files: &[
        file!("ellipsoid-discharge", "silo.ron"),
        file!("ellipsoid-discharge", "short.ron"),
        file!("ellipsoid-discharge", "full.ron"),
        file!("ellipsoid-discharge", "full-lentil.ron"),
    ],
    short: &["short.ron"],
    full: &["full-lentil.ron", "full.ron"],
    judge,
};

/// Time after the opening from which on the rate is taken, s.
const FROM: f64 = 0.1;

fn judge(studies: &Studies) -> Result<Judgement, Fault> {
    let mut judgement = Judgement::default();
    let groups = |runs| groups_by(runs, |run| run.value("parameters.aspect"));
    let lentils = groups(studies.runs("full-lentil.ron"));
    let mut rates = Vec::new();
    for (aspect, of_shape) in lentils.into_iter().chain(groups(studies.first_of(&["full.ron", "short.ron"]))) {
        let (rate, row) = mean_rate(format!("aspect {aspect}: rate"), &of_shape, FROM)?;
        judgement.rows.push(row);
        rates.extend(rate.map(|rate| (aspect, rate)));
    }
    let of = |aspect: f64| rates.iter().find(|(it, _)| (it - aspect).abs() < 1e-9).map(|(_, rate)| *rate);
    // The short form has no lentils.
    if !studies.runs("full-lentil.ron").is_empty() {
        let row = FigureRow::of_ratio("aspect 0.6: rate over that of spheres", of(0.6), of(1.0));
        let row = row.published(1.15, Rule::WithinAbsolute(0.05));
        judgement.rows.push(row.remark("published: an increase of about 15 %"));
    }
    let row = FigureRow::of_ratio("aspect 1.5: rate over that of spheres", of(1.5), of(1.0));
    judgement.rows.push(row.rule(Rule::Between(1.0, 2.0)).remark("published: a maximum"));
    let points: Vec<_> = rates.iter().map(|(aspect, rate)| (*aspect, rate.value)).collect();
    let x = Axis::logarithmic("aspect ratio", points.iter().map(|point| point.0));
    let y = Axis::around("rate, grains/s", points.iter().map(|point| point.1));
    let mut panel = Panel::new("Discharge of ellipsoids of equal volume", x, y);
    panel.curves.push(Curve { colour: colour(1), points, has_line: true, has_dots: true, ..Curve::default() });
    let caption = "Dots: means over seeds. Flat grains are left of 1, long ones right of it.".to_owned();
    judgement.pictures.push(Picture { name: "", svg: sheet(&[panel], 1), caption });
    judgement.remarks.push(
        "The orifice is 5.5 d wide and the silo 12 d, with d the diameter of the sphere of equal volume; friction is 0.5. The publication's silo and friction could \
         not be read. Long grains are rows of spheres and smooth; lentils of 13 spheres have valleys up to 3 % of d deep, which act like friction. How much they \
         lower the rate was not measured. Lentils are close to a clog at this orifice, so their rates scatter, and runs that clog do not count."
            .to_owned(),
    );
    Ok(judgement)
}
