//! The points of a sweep: all combinations of the values of its axes, each with all samples of its Latin hypercube.
//!
//! A Latin hypercube of n samples cuts the range of each key into n equal parts. Each part of each key holds one sample, at a random
//! place, and the parts of different keys are combined at random (McKay, Beckman and Conover, Technometrics 21, 239, 1979).
//!
//! Numbers are rounded to twelve significant digits, so that the number in the table is the number of the scene.

use crate::random::Stream;
use crate::studies::sweep::plan::{Axis, Ends, Interval, LatinHypercube, Spacing, SweepPlan};

/// A point: a value of each key.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Point {
    /// The values, as RON, in the order of the keys of the sweep.
    pub values: Vec<String>,
}

/// Returns all points. The values of the last axis change fastest, and samples change before values.
#[must_use]
pub fn points(plan: &SweepPlan) -> Vec<Point> {
    let mut rows = vec![Vec::new()];
    let samples = plan.latin_hypercube.as_ref().map(samples);
    let columns = plan.axes.iter().map(|axis| values(axis).into_iter().map(|value| vec![value]).collect());
    for parts in columns.chain(samples) {
        let parts: Vec<Vec<String>> = parts;
        let combine =
            |row: Vec<String>| parts.iter().map(move |part| [row.as_slice(), part].concat()).collect::<Vec<_>>();
        rows = rows.into_iter().flat_map(combine).collect();
    }
    rows.into_iter().map(|values| Point { values }).collect()
}

/// Returns the values of an axis.
fn values(axis: &Axis) -> Vec<String> {
    match axis {
        Axis::Values { values, .. } => values.iter().map(|value| value.trim().get_ron().to_owned()).collect(),
        Axis::Range { from, to, count, spacing, .. } => {
            let last = real(count - 1);
            (0..*count).map(|n| between(Ends { low: *from, high: *to }, real(n) / last, *spacing)).collect()
        }
    }
}

/// Returns the samples of a Latin hypercube: a value of each key.
fn samples(cube: &LatinHypercube) -> Vec<Vec<String>> {
    let columns: Vec<_> = (0u64..).zip(&cube.keys).map(|(key, interval)| column(cube, key, interval)).collect();
    (0..cube.samples).map(|sample| columns.iter().map(|column| column[sample].clone()).collect()).collect()
}

/// Returns the values of the key with this number, in the order of the samples.
fn column(cube: &LatinHypercube, key: u64, interval: &Interval) -> Vec<String> {
    let stream = Stream::new(cube.seed, "sweep.latin_hypercube");
    let draws = |sample: usize| stream.uniform::<2>(key << 32 | sample as u64);
    // A random order of the parts, by the method of Fisher and Yates.
    let mut parts: Vec<usize> = (0..cube.samples).collect();
    for last in (1..cube.samples).rev() {
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "below the number of samples")]
        let other = (draws(last)[0] * real(last + 1)) as usize;
        parts.swap(last, other.min(last));
    }
    let place = |(sample, part): (usize, &usize)| (real(*part) + draws(sample)[1]) / real(cube.samples);
    let range = Ends { low: interval.low, high: interval.high };
    parts.iter().enumerate().map(|row| between(range, place(row), interval.spacing)).collect()
}

/// Returns the number at a share of the way between two others, as text.
fn between(Ends { low, high }: Ends, share: f64, spacing: Spacing) -> String {
    let number = match spacing {
        Spacing::Linear => low * (1.0 - share) + high * share,
        Spacing::Log => (low.ln() * (1.0 - share) + high.ln() * share).exp(),
    };
    let rounded: f64 = format!("{number:.11e}").parse().unwrap_or(number);
    format!("{rounded}")
}

#[expect(clippy::cast_precision_loss, reason = "fewer than 2^53 samples")]
fn real(count: usize) -> f64 {
    count as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    fn interval(low: f64, high: f64, spacing: Spacing) -> Interval {
        Interval { key: "k".to_owned(), low, high, spacing }
    }

    #[test]
    fn each_part_of_each_range_holds_one_sample() {
        let keys = vec![interval(-1.0, 3.0, Spacing::Linear), interval(1e-3, 1e3, Spacing::Log)];
        for (seed, samples) in [(1, 1), (2, 7), (3, 40)] {
            let cube = LatinHypercube { samples, seed, keys: keys.clone() };
            let rows = super::samples(&cube);
            let share = |key: usize, row: &Vec<String>| {
                let x: f64 = row[key].parse().unwrap();
                if key == 0 { (x + 1.0) / 4.0 } else { (x.ln() - 1e-3f64.ln()) / 1e6f64.ln() }
            };
            for key in 0..2 {
                #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a small index")]
                let mut parts: Vec<_> = rows.iter().map(|row| (share(key, row) * real(samples)) as usize).collect();
                assert_eq!(rows.len(), samples);
                parts.sort_unstable();
                assert_eq!(parts, (0..samples).collect::<Vec<_>>(), "seed {seed}, key {key}");
            }
            assert_eq!(rows, super::samples(&cube));
        }
    }

    #[test]
    fn keys_are_combined_at_random_and_another_seed_gives_other_samples() {
        let keys = vec![interval(0.0, 1.0, Spacing::Linear); 2];
        let cube = |seed| LatinHypercube { samples: 50, seed, keys: keys.clone() };
        let numbers = |seed| -> Vec<Vec<f64>> {
            super::samples(&cube(seed)).iter().map(|row| row.iter().map(|x| x.parse().unwrap()).collect()).collect()
        };
        assert_ne!(numbers(1), numbers(2));
        // The correlation of 50 independent pairs has the standard deviation 1/sqrt(49); the bound is 4 of them.
        let covariance: f64 = numbers(1).iter().map(|row| (row[0] - 0.5) * (row[1] - 0.5)).sum::<f64>() / 50.0;
        assert!((12.0 * covariance).abs() < 4.0 / 7.0, "{covariance}");
    }

    #[test]
    fn ranges_begin_and_end_at_their_ends_and_have_short_numbers() {
        let axis = |from, to, count, spacing| Axis::Range { key: "k".to_owned(), from, to, count, spacing };
        assert_eq!(
            values(&axis(0.1, 0.8, 8, Spacing::Linear)),
            ["0.1", "0.2", "0.3", "0.4", "0.5", "0.6", "0.7", "0.8"]
        );
        assert_eq!(values(&axis(0.01, 100.0, 5, Spacing::Log)), ["0.01", "0.1", "1", "10", "100"]);
    }

    #[test]
    fn points_are_all_combinations_in_the_order_of_the_file() {
        let plan: SweepPlan = siloflow_text::source::parse::parse(
            "s.ron",
            r#"(scene: "a.ron", seeds: 2, figures: ["steps"], axes: [
                Values(key: "a", values: [Fixed(0.1), "x"]), Range(key: "b", from: 1, to: 2, count: 2)])"#,
        )
        .unwrap();
        let all: Vec<_> = points(&plan).into_iter().map(|point| point.values.join(" ")).collect();
        assert_eq!(all, ["Fixed(0.1) 1", "Fixed(0.1) 2", "\"x\" 1", "\"x\" 2"]);
        assert_eq!(plan.seeds.list(), [1, 2]);
    }
}
