//! Rods and spheres in a silo whose base turns.
//!
//! To et al. let pegs of 20 mm by 6 and 8 mm flow through a circular orifice in a base that turns: turning lowers their rate by more than half in
//! the continuous flow, whatever its speed; spheres flow otherwise (Phys. Rev. E 103, 062905, abstract, arXiv 2106.13640). Simulations of Pongó,
//! Börzsönyi and Hidalgo have up to 70 % (arXiv 2210.14115, abstract). Here d is the diameter of the sphere of equal volume.
//!
//! | figure | rule |
//! |---|---|
//! | rate of rods on a turning base over that on one at rest | 0.3 to 0.5: "more than 50 %", "up to 70 %"; missed |
//! | the same ratio of spheres | reported |
//!
//! A rate is the slope of a straight line through the number of grains out, once rods near the base are in line with its motion. In the first second a turning base changes little.

use crate::studies::validation::groups::{groups_by, mean_rate};
use crate::studies::validation::runs::{FinishedRun, Studies};
use crate::studies::validation::verdict::{FigureRow, Judgement, Picture, Rule};
use crate::studies::validation::{Case, file};
use siloflow_figures::diagram::{Axis, Curve, Panel, colour, sheet};
use siloflow_text::fault::Fault;

/// The case.
pub const CASE: Case = Case {
    name: "turning-base",
    title: "Rods above a turning base",
    sources: "To et al. 2021, Phys. Rev. E 103, 062905 (arXiv 2106.13640, abstract), and Pongó et al. (arXiv 2210.14115, abstract): turning the base lowers the rate of rods by more than half.",
    files: &[
        file!("turning-base", "silo.ron"),
        file!("turning-base", "short.ron"),
        file!("turning-base", "full.ron"),
        file!("turning-base", "full-still.ron"),
        file!("turning-base", "full-spheres.ron"),
    ],
    short: &["short.ron"],
    full: &["full.ron", "full-still.ron", "full-spheres.ron"],
    judge,
};

/// Why the rods miss.
const SMALLER: &str = "turning slows rods down, and not spheres; in six silos by less than published";

/// Time after the opening from which on the rate is taken, s: one and a half turns at 3 rad/s.
const FROM: f64 = 3.0;

fn judge(studies: &Studies) -> Result<Judgement, Fault> {
    let mut judgement = Judgement::default();
    let mut panels = Vec::new();
    for (name, sweeps) in
        [("rods", &["full.ron", "full-still.ron", "short.ron"][..]), ("spheres", &["full-spheres.ron"])]
    {
        let runs: Vec<_> = sweeps.iter().flat_map(|sweep| studies.runs(sweep)).collect();
        if runs.is_empty() {
            continue;
        }
        let mut rates = Vec::new();
        for (turn, of_speed) in groups_by(runs.iter().copied(), |run| run.value("parameters.turn")) {
            let (rate, row) = mean_rate(format!("{name}, base at {turn} rad/s: rate"), &of_speed, FROM)?;
            judgement.rows.push(row);
            rates.extend(rate.map(|rate| (turn, rate)));
        }
        let still = rates.iter().find(|(turn, _)| *turn <= 0.0).map(|(_, rate)| *rate);
        for (turn, rate) in rates.iter().filter(|(turn, _)| *turn > 0.0) {
            let row =
                FigureRow::of_ratio(format!("{name}: rate at {turn} rad/s over that at rest"), Some(*rate), still);
            let row = if name == "rods" { row.rule(Rule::Between(0.3, 0.5)).known_miss(SMALLER) } else { row };
            judgement.rows.push(row);
        }
        panels.push(panel(name, &runs)?);
    }
    let caption = format!(
        "Grains that have left, without those of the first {FROM} s after the opening. Each line is a run: blue with the base at rest, orange with a turning base."
    );
    judgement.pictures.push(Picture { name: "", svg: sheet(&panels, 2), caption });
    judgement.remarks.push(
        "The silo is 14 d wide and the orifice 6.5 d, friction is 0.5 and the base is smooth; those of the publications could not be read. Rods are capsules of five \
         spheres, the pegs have flat ends. Rates of rods above a base at rest differ from run to run, because their flow stops and starts. The abstract also \
         has a rate that grows exponentially with the orifice below D = 3 d, between clogs that the base breaks. This smooth base does \
         not break them: in silos of 8 d rods leave for some seconds only, up to D = 4 d (trials of 30 November 2026). So this rate was not compared."
            .to_owned(),
    );
    Ok(judgement)
}

/// Draws the curves of all runs.
fn panel(name: &str, runs: &[&FinishedRun]) -> Result<Panel, Fault> {
    let mut curves = Vec::new();
    for run in runs {
        let curve: Vec<_> = run.discharge()?.into_iter().filter(|(time, _)| *time >= FROM).collect();
        let begin = curve.first().map_or(0.0, |point| point.1);
        let points = curve.into_iter().map(|(time, out)| (time, out - begin)).collect();
        let turns = run.value("parameters.turn").is_some_and(|turn| turn > 0.0);
        curves.push(Curve { colour: colour(usize::from(turns) + 1), points, has_line: true, ..Curve::default() });
    }
    let all = || curves.iter().flat_map(|curve| &curve.points);
    let x = Axis::around("time since the opening, s", all().map(|point| point.0));
    let y = Axis::around("grains out", all().map(|point| point.1));
    Ok(Panel { curves, ..Panel::new(name, x, y) })
}
