//! Avalanches of round grains and of grains with a shape in the same silo, for the cases `rice-clogging` and `ellipses-hopper`.
//!
//! Each run has rows for its mean size and for the exponential tail ([`avalanches`](crate::studies::validation::avalanches)). Where both kinds of grains have the same
//! width of the orifice, their means n_r (round) and n_s (shaped) are compared by (ln n_r - ln n_s)/e, with e^2 = (e_r/n_r)^2 + (e_s/n_s)^2
//! from the standard errors of both means. Above three the shaped grains clog earlier, and chance is not the reason.

use crate::studies::validation::avalanches::{Avalanches, survival};
use crate::studies::validation::runs::FinishedRun;
use crate::studies::validation::verdict::{FigureRow, Judgement, Picture};
use siloflow_figures::diagram::{Axis, Curve, Key, Panel, colour, sheet};

/// Returns the avalanches of runs of one kind of grain.
pub(super) fn of<'a>(kind: &str, runs: impl IntoIterator<Item = &'a FinishedRun>) -> Vec<Avalanches> {
    let one = |run: &FinishedRun| {
        let width = run.number("parameters.width").unwrap_or(f64::NAN);
        Avalanches::of(run, format!("{kind}, D = {width} d"), width)
    };
    runs.into_iter().map(one).collect()
}

/// The avalanches of two kinds of grains.
pub(super) struct TwoShapes {
    pub(super) round: Vec<Avalanches>,
    pub(super) shaped: Vec<Avalanches>,
    /// Names of the kinds, the round one first.
    pub(super) names: [&'static str; 2],
}

impl TwoShapes {
    /// Adds the rows of each run and of the comparisons, and the figure. `rule` completes the row of a comparison.
    pub(super) fn judge(&self, judgement: &mut Judgement, rule: impl Fn(FigureRow) -> FigureRow) {
        let all: Vec<_> = self.round.iter().chain(&self.shaped).cloned().collect();
        judgement.rows.extend(all.iter().flat_map(Avalanches::rows));
        let [name, of_shaped] = self.names;
        for shaped in &self.shaped {
            let Some(round) = self.round.iter().find(|it| (it.width - shaped.width).abs() < 1e-9) else { continue };
            let width = shaped.width;
            let [a, b] = [round, shaped].map(|it| it.error() / it.mean());
            let ratio = shaped.mean() / round.mean();
            let row = FigureRow::new(format!("D = {width} d: mean size of {of_shaped} over that of {name}"), "", ratio);
            judgement.rows.push(row.error(Some(ratio * a.hypot(b))));
            let quantity = format!("D = {width} d: by how many standard errors {of_shaped} clog earlier than {name}");
            judgement.rows.push(rule(FigureRow::new(quantity, "", -ratio.ln() / a.hypot(b))));
        }
        let caption = "Left: share of the avalanches with more grains than the size, over the mean size; a straight line is an exponential distribution. \
                       Right: mean sizes."
            .to_owned();
        let svg = sheet(&[survival(&all), self.means()], 2);
        judgement.pictures.push(Picture { name: "", svg, caption });
        let idle: usize = all.iter().map(|it| it.idle).sum();
        judgement.remarks.push(format!(
            "d is the diameter of the sphere of equal volume, in the plane of the disc of equal area. The p-value is that of a Kolmogorov-Smirnov test of the upper two \
             thirds of the sizes, with 1000 geometric samples. {idle} blows moved no grain out and are no avalanches."
        ));
    }

    /// Returns the panel of the mean sizes against the width.
    fn means(&self) -> Panel {
        let curve = |number: usize, all: &[Avalanches]| Curve {
            name: self.names[number].to_owned(),
            colour: colour(number + 1),
            points: all.iter().map(|it| (it.width, it.mean())).collect(),
            has_line: true,
            has_dots: true,
            ..Curve::default()
        };
        let curves = vec![curve(0, &self.round), curve(1, &self.shaped)];
        let places: Vec<_> = curves.iter().flat_map(|curve| curve.points.iter().copied()).collect();
        let x = Axis::around("width of the orifice, d", places.iter().map(|place| place.0));
        let y = Axis::logarithmic("mean size, grains", places.iter().map(|place| place.1));
        Panel { curves, key: Key::Above, ..Panel::new("Trend", x, y) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Stream;
    use crate::studies::validation::verdict::{Rule, Verdict};

    /// Returns 100 exponential sizes about a mean.
    fn avalanches(seed: u64, mean: f64) -> Vec<Avalanches> {
        let stream = Stream::new(seed, "sizes");
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a size of an avalanche")]
        let size = |counter| (-mean * (1.0 - stream.uniform::<1>(counter)[0]).ln()) as u32 + 1;
        vec![Avalanches { name: String::new(), width: 3.0, sizes: (0..100).map(size).collect(), idle: 0 }]
    }

    #[test]
    fn a_third_of_the_mean_passes_and_another_draw_of_the_same_mean_misses() {
        for (mean, expected) in [(10.0, Verdict::Pass), (30.0, Verdict::Miss)] {
            let two = TwoShapes { round: avalanches(1, 30.0), shaped: avalanches(2, mean), names: ["a", "b"] };
            let mut judgement = Judgement::default();
            two.judge(&mut judgement, |row| row.rule(Rule::Between(3.0, 1e3)));
            let last = judgement.rows.last().unwrap();
            assert_eq!(last.verdict(), expected, "{last:?}");
        }
    }
}
