//! Clogging of a small planar silo: the sizes of avalanches, and their mean against the width of the orifice.
//!
//! Sizes are tested for an exponential tail by [`avalanches`](crate::studies::validation::avalanches).
//!
//! The mean is fitted with two laws of the literature: ln n = a + b D^2, without a critical width (Janda, Zuriguel, Garcimartin, Pugnaloni and Maza,
//! EPL 84, 44002, 2008), and ln n = a - c ln(D_c - D), which diverges at a critical width D_c (Zuriguel et al. 2005, for spheres).

use crate::studies::validation::avalanches::{Avalanches, survival};
use crate::studies::validation::runs::{FinishedRun, Studies};
use crate::studies::validation::verdict::{FigureRow, Judgement, Picture, Rule};
use crate::studies::validation::{Case, file};
use siloflow_figures::diagram::{Axis, Curve, Key, Panel, colour, sheet};
use siloflow_figures::statistics::digits::short;
use siloflow_figures::statistics::fit::{BestLine, Law, best_line};
use siloflow_text::fault::Fault;

/// The case.
pub const CASE: Case = Case {
    name: "clogging",
    title: "Clogging at small orifices",
    sources: "Zuriguel et al. 2005, Phys. Rev. E 71, 051303 (cond-mat/0407761): exponential sizes, a power law with a critical size for spheres; \
              Janda et al. 2008, EPL 84, 44002: no critical size in the plane (both read in the abstract).",
    files: &[
        file!("clogging", "silo.ron"),
        file!("clogging", "short.ron"),
        file!("clogging", "full.ron"),
        file!("clogging", "full-stiff.ron"),
    ],
    short: &["short.ron"],
    full: &["full.ron", "full-stiff.ron"],
    judge,
};

/// Width of the orifice of the runs with stiffer grains, diameters.
const WIDTH_OF_STIFF: f64 = 3.0;

fn of(run: &FinishedRun) -> Avalanches {
    let width = run.value("parameters.width").unwrap_or(WIDTH_OF_STIFF);
    Avalanches::of(run, format!("D = {width} d"), width)
}

#[expect(clippy::unnecessary_wraps, reason = "other cases can fail")]
fn judge(studies: &Studies) -> Result<Judgement, Fault> {
    let mut judgement = Judgement::default();
    let all: Vec<_> = studies.first_of(&["short.ron", "full.ron"]).iter().map(of).collect();
    let mut idle = 0;
    for it in &all {
        idle += it.idle;
        judgement.rows.extend(it.rows());
    }
    let softest = all.iter().find(|it| (it.width - WIDTH_OF_STIFF).abs() < 1e-9);
    stiffness(softest, studies.runs("full-stiff.ron"), &mut judgement);
    let means: Vec<_> = all.iter().map(|it| (it.width, it.mean())).collect();
    let growth = means.windows(2).map(|two| two[1].1 / two[0].1).fold(f64::INFINITY, f64::min);
    judgement.rows.push(
        FigureRow::new("mean size of a width over that of the width before, the smallest", "", growth)
            .rule(Rule::Between(1.2, 100.0))
            .remark("sizes grow steeply with the width in all publications"),
    );
    let fits = trends(&means, &mut judgement);
    judgement.pictures.push(Picture {
        name: "",
        svg: sheet(&[survival(&all), against_width(&means, fits)], 2),
        caption: "Left: share of the avalanches with more grains than the size, over the mean size; a straight line is an exponential distribution. \
                  Right: mean size, with the fits."
            .to_owned(),
    });
    judgement.remarks.push(format!(
        "Discs with friction 0.5 in a silo 12 diameters wide. The p-value is that of a Kolmogorov-Smirnov test of the upper two thirds of the sizes, with 1000 geometric \
         samples. {idle} blows moved no grain out and are no avalanches. Published means are those of other grains and silos, so none is a rule here."
    ));
    if !studies.runs("full-stiff.ron").is_empty() {
        judgement.remarks.push(
            "Arches of soft grains break more easily: the mean size falls with the stiffness, from 2,000 m g/d in the rows of all widths, until it settles between 50,000 and 250,000 m g/d (25 and 125 \
             times). So the sizes of all widths are those of soft grains."
                .to_owned(),
        );
    }
    Ok(judgement)
}

/// Adds the mean sizes with stiffer grains, each beside the one before, from the softest grains on.
fn stiffness(softest: Option<&Avalanches>, stiff: &[FinishedRun], judgement: &mut Judgement) {
    let Some(softest) = softest else { return };
    let mut mean = softest.mean();
    let mut error = softest.error();
    for run in stiff {
        let times = 5.0 / run.value("parameters.soft").unwrap_or(f64::NAN);
        let it = of(run);
        let name = format!("D = {WIDTH_OF_STIFF} d, grains {} times as stiff: mean size", short(times));
        let row = FigureRow::new(name, "grains", it.mean())
            .error(Some(it.error()))
            .published(mean, Rule::WithinAbsolute(3.0 * it.error().hypot(error)));
        let remark =
            "the other value is that of the grains before, a fifth as stiff; the rule is three standard errors";
        judgement.rows.push(match times {
            ..10.0 => row.known_miss(format!("arches of soft grains break more easily; {remark}")),
            _ => row.remark(remark),
        });
        (mean, error) = (it.mean(), it.error());
    }
}

/// Adds the rows of both laws and returns their curves.
fn trends(means: &[(f64, f64)], judgement: &mut Judgement) -> [Vec<(f64, f64)>; 2] {
    let logarithms: Vec<_> = means.iter().map(|(width, mean)| (*width, mean.ln())).collect();
    let squares: Vec<_> = logarithms.iter().map(|(width, ln)| (width * width, *ln)).collect();
    let (Some(first), Some(last)) = (means.first(), means.last()) else { return [Vec::new(), Vec::new()] };
    let places: Vec<_> = (0..=100).map(|n| first.0 + (last.0 - first.0) * f64::from(n) / 100.0).collect();
    let mut curves = [Vec::new(), Vec::new()];
    if let Some(fit) = Law::Line.fit(&squares) {
        let row = FigureRow::new("ln(mean) = a + b (D/d)^2: b", "", fit.value("slope").unwrap_or(f64::NAN));
        judgement.rows.push(row.error(fit.parameter("slope").and_then(|slope| slope.error)));
        let share = fit.value("r_squared").unwrap_or(f64::NAN);
        judgement.rows.push(FigureRow::new("the same law: share of the variance explained", "", share));
        curves[0] = places.iter().filter_map(|x| Some((*x, fit.at(x * x)?.exp()))).collect();
    }
    // Four points for three numbers.
    if means.len() > 3 {
        let candidates = (1..=400).map(|n| last.0 + 0.01 * f64::from(n));
        if let Some(BestLine { candidate: critical, fitted: fit }) =
            best_line(&logarithms, candidates, |width, critical| (critical - width).ln())
        {
            let slope = fit.value("slope").unwrap_or(f64::NAN);
            let error = fit.parameter("slope").and_then(|slope| slope.error);
            judgement.rows.extend([
                FigureRow::new(
                    "mean = A (D_c - D)^-c: D_c/d, spheres 4.94 (Zuriguel, not read in the source)",
                    "",
                    critical,
                ),
                FigureRow::new("the same law: c, spheres 6.9 (not read in the source)", "", -slope).error(error),
                FigureRow::new(
                    "the same law: share of the variance explained",
                    "",
                    fit.value("r_squared").unwrap_or(f64::NAN),
                ),
            ]);
            curves[1] = places.iter().filter_map(|x| Some((*x, fit.at((critical - x).ln())?.exp()))).collect();
        }
    }
    curves
}

fn against_width(means: &[(f64, f64)], [squared, diverging]: [Vec<(f64, f64)>; 2]) -> Panel {
    let fitted = |name: &str, number: usize, points: Vec<(f64, f64)>| Curve {
        name: if points.is_empty() { String::new() } else { name.to_owned() },
        colour: colour(number),
        points,
        has_line: true,
        is_dashed: number == 2,
        ..Curve::default()
    };
    let dots = Curve { colour: colour(1), points: means.to_vec(), has_dots: true, ..Curve::default() };
    let curves = vec![fitted("a + b D^2", 0, squared), fitted("critical width", 2, diverging), dots];
    let x = Axis::around("width of the orifice, diameters", means.iter().map(|point| point.0));
    let y = Axis::logarithmic("mean size, grains", means.iter().map(|point| point.1));
    Panel { curves, key: Key::Above, ..Panel::new("Trend", x, y) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_laws_recover_their_numbers() {
        let mut judgement = Judgement::default();
        let of = |mean: fn(f64) -> f64| [2.5, 3.0, 3.5, 4.0, 4.5].map(|width| (width, mean(width)));
        trends(&of(|width| (0.1 + 0.4 * width * width).exp()), &mut judgement);
        trends(&of(|width| 3e4 * (5.5 - width).powf(-4.0)), &mut judgement);
        let found: Vec<_> = judgement.rows.iter().map(|row| row.found).collect();
        // The rows of each law: two of the first, three of the second.
        assert!((found[0] - 0.4).abs() < 1e-9 && (found[1] - 1.0).abs() < 1e-9, "{found:?}");
        assert!((found[7] - 5.5).abs() < 1e-9 && (found[8] - 4.0).abs() < 1e-9, "{found:?}");
    }
}
