//! Avalanches of a silo that clogs again and again: their sizes, whether these are exponential, and their mean.
//!
//! A flow whose grains clog the orifice with a constant chance p each has sizes n with the geometric distribution p (1 - p)^n, the discrete form of the exponential
//! one (Zuriguel, Garcimartin, Maza, Pugnaloni and Pastor, Phys. Rev. E 71, 051303, 2005). It holds for the tail: the first grains after a blow
//! fall in another state than those of a steady flow. So the excesses k = 0, 1, ... of the sizes over their lower third are tested:
//!
//! | figure | definition | a geometric distribution has |
//! |---|---|---|
//! | ratio of moments | mean of (k + 1)^2 over the squared mean of k + 1 | 2 - 1/M, with M the mean of k + 1 |
//! | p-value | chance of a larger distance of a geometric sample ([`geometric`](siloflow_figures::statistics::geometric)) | a uniform value |

use crate::random::Stream;
use crate::studies::validation::runs::FinishedRun;
use crate::studies::validation::verdict::{FigureRow, Rule};
use siloflow_figures::diagram::{Axis, Curve, Key, Panel, colour};
use siloflow_figures::statistics::geometric::{count, mean, ratio_of_moments, test};

/// Smallest chance at which sizes count as exponential: one in a hundred cases is wrong.
const SMALLEST_CHANCE: f64 = 0.01;

/// The avalanches of a run.
#[derive(Clone, Debug)]
pub struct Avalanches {
    /// Name in rows and figures.
    pub name: String,
    /// Width of the orifice, diameters.
    pub width: f64,
    /// Grains of each avalanche.
    pub sizes: Vec<u32>,
    /// Blows after which no grain left.
    pub idle: usize,
}

impl Avalanches {
    /// Returns the avalanches of a run without the first, which begins with the bed at rest.
    #[must_use]
    pub fn of(run: &FinishedRun, name: String, width: f64) -> Self {
        let all = run.files.summary["avalanches"].as_array().map_or(&[][..], |all| all);
        let grains = all.iter().skip(1).filter_map(|one| u32::try_from(one["grains"].as_u64()?).ok());
        let (idle, sizes): (Vec<u32>, Vec<u32>) = grains.partition(|grains| *grains == 0);
        Self { name, width, sizes, idle: idle.len() }
    }

    /// Returns the mean size.
    #[must_use]
    pub fn mean(&self) -> f64 {
        mean(&self.sizes)
    }

    /// Returns the standard error of the mean.
    #[must_use]
    pub fn error(&self) -> f64 {
        let n = count(&self.sizes);
        let m = self.mean();
        let squares: f64 = self.sizes.iter().map(|size| (f64::from(*size) - m).powi(2)).sum();
        (squares / (n - 1.0) / n).sqrt()
    }

    /// Returns the excesses of the upper two thirds over the largest size of the lower third.
    fn tail(&self) -> Vec<u32> {
        let mut sorted = self.sizes.clone();
        sorted.sort_unstable();
        let Some(&start) = sorted.get(sorted.len() / 3) else { return Vec::new() };
        sorted.into_iter().filter_map(|size| size.checked_sub(start + 1)).collect()
    }

    /// Returns the rows of the mean and of the test.
    #[must_use]
    pub fn rows(&self) -> [FigureRow; 3] {
        let tail = self.tail();
        let stream = Stream::new(1, "geometric");
        let mut counter = 0;
        let test = test(&tail, || {
            counter += 1;
            stream.uniform(counter - 1)
        });
        let name = &self.name;
        let m = mean(&tail) + 1.0;
        [
            FigureRow::new(format!("{name}: mean size of {} avalanches", self.sizes.len()), "grains", self.mean())
                .error(Some(self.error())),
            FigureRow::new(format!("{name}: p-value of an exponential tail"), "", test.p_value)
                .rule(Rule::Between(SMALLEST_CHANCE, 1.0)),
            FigureRow::new(format!("{name}: ratio of moments of the tail"), "", ratio_of_moments(&tail))
                .error(Some(test.spread))
                .published(2.0 - 1.0 / m, Rule::WithinAbsolute(3.0 * test.spread))
                .remark("the other value is that of an exponential distribution; the rule is three standard errors"),
        ]
    }
}

/// Returns the shares of larger avalanches.
#[must_use]
pub fn survival(all: &[Avalanches]) -> Panel {
    let curve = |(number, it): (usize, &Avalanches)| {
        let mut sorted = it.sizes.clone();
        sorted.sort_unstable();
        let n = count(&sorted);
        let larger = (0..sorted.len()).map(|k| 1.0 - count(&sorted[..=k]) / n);
        let points = sorted
            .iter()
            .map(|size| f64::from(*size) / it.mean())
            .zip(larger)
            .filter(|(_, share)| *share > 0.0)
            .collect();
        Curve { name: it.name.clone(), colour: colour(number + 1), points, has_line: true, ..Curve::default() }
    };
    let mut curves: Vec<_> = all.iter().enumerate().map(curve).collect();
    let points = (0..=60).map(|n| 0.1 * f64::from(n)).map(|x| (x, f64::exp(-x))).filter(|(_, y)| *y > 2e-3).collect();
    curves.push(Curve {
        name: "exp(-x)".to_owned(),
        colour: colour(0),
        points,
        has_line: true,
        is_dashed: true,
        ..Curve::default()
    });
    let y = Axis::logarithmic("share of larger avalanches", [2e-3, 1.0]);
    Panel { curves, key: Key::LowerLeft, ..Panel::new("Sizes", Axis::linear("size / mean", 0.0, 6.0), y) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::studies::validation::verdict::Verdict;

    /// Returns 200 avalanches by a function of a uniform number.
    fn avalanches(of: impl Fn(f64) -> f64) -> Avalanches {
        let stream = Stream::new(3, "sizes");
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a size of an avalanche")]
        let sizes = (0..200).map(|counter| of(stream.uniform::<1>(counter)[0]) as u32 + 1).collect();
        Avalanches { name: String::new(), width: 3.0, sizes, idle: 0 }
    }

    #[test]
    fn exponential_sizes_pass_and_uniform_ones_miss() {
        let misses =
            |of: fn(f64) -> f64| avalanches(of).rows().iter().filter(|row| row.verdict() == Verdict::Miss).count();
        // Only the smallest third does not follow the law.
        assert_eq!(misses(|u| 5.0 + -40.0 * (1.0 - u).ln()), 0);
        // Chance and ratio of moments.
        assert_eq!(misses(|u| 80.0 * u), 2);
    }
}
