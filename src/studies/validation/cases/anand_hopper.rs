//! The rectangular hopper of Anand, Curtis, Wassgren, Hancock and Ketterhagen, Chem. Eng. Sci. 63, 5821 (2008).
//!
//! The published curve is the one digitised in Lethe's example of the same hopper. It has the mass that has left a slab as deep as 2.5 diameters
//! (6,790 grains). The hopper with side walls is six times as deep, and its mass is divided by six.
//!
//! The rate is the slope of a straight line through the rows of `series.csv` between 10 and 60 g. The curve is compared after a shift in time, because the
//! published clock starts with the experiment: the shift is the one of least mean square.

use crate::studies::validation::runs::{FinishedRun, Studies};
use crate::studies::validation::verdict::{FigureRow, Judgement, Picture, Rule};
use crate::studies::validation::{Case, file};
use siloflow_figures::diagram::{Axis, Curve, Key, Panel, colour, sheet};
use siloflow_figures::statistics::mean::mean;
use siloflow_figures::statistics::points::{between, interpolated, slope};
use siloflow_text::fault::Fault;

/// The case.
pub const CASE: Case = Case {
    name: "anand-hopper",
    title: "Rectangular hopper of Anand et al. 2008",
    sources: "Anand et al. 2008, Chem. Eng. Sci. 63, 5821; parameters and the digitised curve from the example \
              `3d-rectangular-hopper` of Lethe.",
    files: &[
        file!("anand-hopper", "hopper.ron"),
        file!("anand-hopper", "hopper-walls.ron"),
        file!("anand-hopper", "short.ron"),
        file!("anand-hopper", "full.ron"),
        file!("anand-hopper", "full-walls.ron"),
    ],
    short: &["short.ron"],
    full: &["full.ron", "full-walls.ron"],
    judge,
};

/// Published discharge: time after the opening (s), mass (g).
const CURVE: [(f64, f64); 18] = [
    (0.078, 5.25),
    (0.142, 10.50),
    (0.206, 15.67),
    (0.267, 21.08),
    (0.333, 26.29),
    (0.399, 31.40),
    (0.461, 36.69),
    (0.524, 41.94),
    (0.586, 47.21),
    (0.652, 52.50),
    (0.717, 57.81),
    (0.783, 62.94),
    (0.850, 68.19),
    (0.928, 73.48),
    (1.014, 78.75),
    (1.139, 84.07),
    (1.466, 89.19),
    (2.244, 90.72),
];

/// Range of masses in which the rate is taken, g.
const STEADY: (f64, f64) = (10.0, 60.0);

/// Depth of the periodic hopper over that of the hopper with walls.
const SHARE_OF_DEPTH: f64 = 1.0 / 6.0;

/// A run as the case needs it.
struct Discharge {
    /// Time since the opening (s), mass (g) of a slab of 6,790 grains.
    curve: Vec<(f64, f64)>,
    rate: f64,
    /// Root of the mean square deviation from the published curve after the best shift, g.
    rms: f64,
    shift: f64,
}

impl Discharge {
    fn of(run: &FinishedRun, share: f64) -> Result<Self, Fault> {
        let grams = run.files.series.needed("out_kg")?.into_iter().map(|kg| 1e3 * kg * share);
        let times = run.discharge()?;
        let skipped = run.files.series.len() - times.len();
        let curve: Vec<_> = times.iter().map(|(time, _)| *time).zip(grams.skip(skipped)).collect();
        let steady: Vec<_> = curve.iter().copied().filter(|(_, m)| (STEADY.0..=STEADY.1).contains(m)).collect();
        let rate = slope(&steady).unwrap_or(f64::NAN);
        let (shift, rms) = best_shift(&curve);
        Ok(Self { curve, rate, rms, shift })
    }
}

/// Returns the shift of the published times of least mean square, between -0.1 and 0.3 s, and the root of that mean square.
fn best_shift(curve: &[(f64, f64)]) -> (f64, f64) {
    let rms = |shift: f64| {
        let squares =
            CURVE.iter().map(|(time, mass)| (interpolated(curve, time + shift).unwrap_or(f64::NAN) - mass).powi(2));
        (squares.sum::<f64>() / 18.0).sqrt()
    };
    let shifts = (-100..=300).map(|n| 1e-3 * f64::from(n));
    shifts
        .map(|shift| (shift, rms(shift)))
        .filter(|(_, rms)| rms.is_finite())
        .min_by(|a, b| a.1.total_cmp(&b.1))
        .unwrap_or((0.0, f64::NAN))
}

fn judge(studies: &Studies) -> Result<Judgement, Fault> {
    let mut judgement = Judgement::default();
    let mut curves = vec![Curve {
        name: "published".to_owned(),
        colour: colour(0),
        points: CURVE.to_vec(),
        has_dots: true,
        ..Curve::default()
    }];
    let periodic = studies.first_of(&["short.ron", "full.ron"]);
    let with =
        |mu_r: f64| periodic.iter().filter(move |run| run.value("parameters.mu_r") == Some(mu_r)).collect::<Vec<_>>();
    let groups = [
        ("periodic", with(0.09), 1.0, Some(0.12), None),
        ("periodic, without rolling resistance", with(0.0), 1.0, None, None),
        ("side walls", studies.runs("full-walls.ron").iter().collect(), SHARE_OF_DEPTH, Some(0.05), Some(1.5)),
    ];
    for (number, (name, runs, share, bound, most)) in (1..).zip(groups) {
        if runs.is_empty() {
            continue;
        }
        let all = runs.iter().map(|run| Discharge::of(run, share)).collect::<Result<Vec<_>, _>>()?;
        let mean = |of: fn(&Discharge) -> f64| mean(all.iter().map(of));
        let rate = FigureRow::of_mean(format!("{name}: rate between 10 and 60 g"), "g/s", mean(|it| it.rate));
        judgement.rows.push(rate.published(82.3, bound.map_or(Rule::Reported, Rule::Within)));
        let rms = FigureRow::of_mean(format!("{name}: rms of the curve after one shift"), "g", mean(|it| it.rms));
        judgement.rows.push(rms.rule(most.map_or(Rule::Reported, |most| Rule::Between(0.0, most))));
        let last = |it: &Discharge| it.curve.last().map_or(f64::NAN, |(_, grams)| 99.9 - grams);
        judgement.rows.push(
            FigureRow::of_mean(format!("{name}: mass that stays"), "g", mean(last)).published(9.2, Rule::Reported),
        );
        let first = &all[0];
        let shifted: Vec<_> = first.curve.iter().map(|(time, grams)| (time - first.shift, *grams)).collect();
        let points = between(&shifted, 0.0, 2.5);
        curves.push(Curve {
            name: name.to_owned(),
            colour: colour(number),
            points,
            has_line: true,
            ..Curve::default()
        });
    }
    let axes = [Axis::linear("time, s (shifted to fit)", 0.0, 2.5), Axis::linear("mass out, g", 0.0, 100.0)];
    let [x, y] = axes;
    let svg = sheet(&[Panel { curves, key: Key::Above, ..Panel::new("Discharge", x, y) }], 1);
    let caption = "Mass that has left a slab of 6,790 grains. Curves are those of the first seed.".to_owned();
    judgement.pictures.push(Picture { name: "", svg, caption });
    judgement.remarks.push(
        "Rolling resistance is that of Lethe's example: a constant torque of 0.09 R* F_n. Lethe finds 85.1 g/s with side walls and 91.7 g/s in the \
         periodic hopper."
            .to_owned(),
    );
    Ok(judgement)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_shifted_curve_is_found_at_its_shift() {
        let shifted: Vec<_> = CURVE.iter().map(|(time, mass)| (time + 0.05, *mass)).chain([(9.0, 90.72)]).collect();
        let (shift, rms) = best_shift(&[vec![(-1.0, 0.0)], shifted].concat());
        // The grid of shifts holds 0.05 to rounding.
        assert!((shift - 0.05).abs() < 1e-9 && rms < 1e-9, "{shift} {rms}");
    }

    #[test]
    fn the_published_rate_is_the_slope_of_the_published_curve() {
        let steady: Vec<_> = CURVE.into_iter().filter(|(_, mass)| (STEADY.0..=STEADY.1).contains(mass)).collect();
        assert!((slope(&steady).unwrap() - 82.3).abs() < 0.05);
    }
}
