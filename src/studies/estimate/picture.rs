//! Figures of an estimate: the figure against softness with the law, its band and all runs; the width of the interval against the cost.

use siloflow_figures::diagram::{Axis, Curve, Key, Panel, colour};
use siloflow_figures::statistics::extrapolation::Ladder;

use crate::studies::figures::words::words;

use super::answer::Answer;
use super::results::RunRecord;

/// Points of a curve.
const POINTS: u16 = 120;

/// The state after a round of runs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Round {
    /// Time spent so far, s.
    pub spent: f64,
    /// Half width of the interval.
    pub half: f64,
}

/// Returns the panels of the figure.
#[must_use]
pub fn panels(
    title: &str,
    figure: &str,
    ladder: &Ladder,
    answer: &Answer,
    runs: &[RunRecord],
    rounds: &[Round],
) -> [Panel; 2] {
    [against_softness(title, figure, ladder, answer, runs), against_cost(rounds)]
}

fn against_softness(title: &str, figure: &str, ladder: &Ladder, answer: &Answer, runs: &[RunRecord]) -> Panel {
    let of = |is_counted: bool| {
        let softest = ladder.softness()[answer.softest];
        let counts = move |run: &RunRecord| run.softness <= softest && run.is_of_ladder();
        let mine = runs.iter().filter(move |run| counts(run) == is_counted);
        mine.filter_map(|run| Some((run.softness, run.value?))).collect::<Vec<_>>()
    };
    let dots = |name: &str, number: usize, points: Vec<(f64, f64)>| Curve {
        name: if points.is_empty() { String::new() } else { name.to_owned() },
        colour: colour(number),
        points,
        has_dots: true,
        ..Curve::default()
    };
    let mut curves = vec![dots("runs", 1, of(true)), dots("too soft, or for comparison", 4, of(false))];
    if let Some(fit) = answer.fit {
        let last = ladder.softness()[answer.softest].max(1.0 + 1e-9).ln();
        let softness = |n| (last * f64::from(n) / f64::from(POINTS)).exp();
        let points: Vec<_> = (0..=POINTS).map(|n| (softness(n), fit.at(softness(n)))).collect();
        if ladder.softness().len() > 1 {
            curves.push(Curve {
                name: "law".to_owned(),
                colour: colour(0),
                points,
                has_line: true,
                ..Curve::default()
            });
        }
        let bar = vec![(1.0, fit.interval.low), (1.0, fit.interval.high)];
        curves.push(Curve {
            name: "interval of the value".to_owned(),
            colour: colour(2),
            points: bar,
            has_line: true,
            ..Curve::default()
        });
        curves.push(Curve { colour: colour(2), points: vec![(1.0, fit.value)], has_dots: true, ..Curve::default() });
    }
    let x = Axis::logarithmic(
        "softness: stiffness of the scene over that of the run",
        runs.iter().map(|run| run.softness).chain([1.0]),
    );
    let y = Axis::around(words(figure), curves.iter().flat_map(|curve| &curve.points).map(|point| point.1));
    Panel { curves, key: Key::Above, ..Panel::new(title.to_owned(), x, y) }
}

fn against_cost(rounds: &[Round]) -> Panel {
    let points: Vec<_> =
        rounds.iter().map(|round| (round.spent, round.half)).filter(|(x, y)| *x > 0.0 && *y > 0.0).collect();
    let x = Axis::logarithmic("time of the runs, s", points.iter().map(|point| point.0));
    let y = Axis::logarithmic("half width, in the unit of the figure", points.iter().map(|point| point.1));
    let curve = Curve { colour: colour(1), points, has_line: true, has_dots: true, ..Curve::default() };
    Panel { curves: vec![curve], ..Panel::new("error against cost", x, y) }
}
