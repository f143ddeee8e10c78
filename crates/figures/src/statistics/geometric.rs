//! The test of sizes k = 0, 1, ... against a geometric distribution, the discrete form of the exponential one.
//!
//! The distance is that of Kolmogorov and Smirnov to the geometric distribution of the same mean. Its chance is found from 1000 geometric samples of the same
//! number, each compared with the distribution of its own mean (Lilliefors, J. Am. Stat. Assoc. 64, 387, 1969, with discrete sizes).

/// Samples of the null hypothesis.
const SAMPLES: u32 = 1000;

/// Returns the number of some sizes.
#[must_use]
pub fn count(values: &[u32]) -> f64 {
    u32::try_from(values.len()).map_or(f64::INFINITY, f64::from)
}

/// Returns the mean of some sizes.
#[must_use]
pub fn mean(values: &[u32]) -> f64 {
    values.iter().map(|size| f64::from(*size)).sum::<f64>() / count(values)
}

/// Returns the ratio of moments of the excesses k: the mean of (k + 1)^2 over the square of the mean of k + 1.
#[must_use]
pub fn ratio_of_moments(excess: &[u32]) -> f64 {
    let m = mean(excess) + 1.0;
    excess.iter().map(|k| (f64::from(*k) + 1.0).powi(2)).sum::<f64>() / count(excess) / (m * m)
}

/// Returns the largest difference between the distribution of the excesses and the geometric one of the same mean.
fn distance(excess: &mut [u32]) -> f64 {
    excess.sort_unstable();
    let m = mean(excess);
    // The chance of an excess of at least one.
    let q = m / (1.0 + m);
    let mut largest = 0.0_f64;
    let mut below = 0.0;
    for group in excess.chunk_by(|a, b| a == b) {
        let k = f64::from(group[0]);
        // Just below a value of the sample, and at it.
        largest = largest.max((1.0 - q.powf(k) - below / count(excess)).abs());
        below += count(group);
        largest = largest.max((1.0 - q.powf(k + 1.0) - below / count(excess)).abs());
    }
    largest
}

/// The result of the test of the excesses against a geometric distribution.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Test {
    /// Chance of a larger distance of a geometric sample.
    pub p_value: f64,
    /// Standard deviation of the ratio of moments under the geometric distribution.
    pub spread: f64,
}

/// Returns `number` sizes k with the chance q^k of at least k, from uniform numbers.
fn geometric(uniform: &mut impl FnMut() -> [f64; 32], number: usize, q: f64) -> Vec<u32> {
    let mut sizes = Vec::with_capacity(number);
    while sizes.len() < number {
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a size of an avalanche")]
        sizes.extend(uniform().map(|u| ((1.0 - u).ln() / q.ln()) as u32));
    }
    sizes.truncate(number);
    sizes
}

/// Tests excesses against the geometric distribution of their mean. Each call of `uniform` returns new random numbers, uniform in 0 <= u < 1.
#[must_use]
pub fn test(excess: &[u32], mut uniform: impl FnMut() -> [f64; 32]) -> Test {
    let q = mean(excess) / (1.0 + mean(excess));
    let found = distance(&mut excess.to_vec());
    let mut larger = 0u32;
    let mut sum = 0.0;
    let mut squares = 0.0;
    for _ in 0..SAMPLES {
        let mut sample = geometric(&mut uniform, excess.len(), q);
        let ratio = ratio_of_moments(&sample);
        sum += ratio;
        squares += ratio * ratio;
        larger += u32::from(distance(&mut sample) >= found);
    }
    let n = f64::from(SAMPLES);
    Test { p_value: f64::from(larger) / n, spread: (squares / n - (sum / n).powi(2)).max(0.0).sqrt() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::statistics::noise::Noise;

    /// Returns `n` sizes by a function of a uniform number.
    fn sizes(n: u64, of: impl Fn(f64) -> f64) -> Vec<u32> {
        let mut noise = Noise::new(3);
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a size of an avalanche")]
        let sizes = (0..n).map(|_| of(noise.uniform()) as u32).collect();
        sizes
    }

    /// Returns a source of blocks of uniform numbers.
    fn blocks(seed: u64) -> impl FnMut() -> [f64; 32] {
        let mut noise = Noise::new(seed);
        move || std::array::from_fn(|_| noise.uniform())
    }

    #[test]
    fn exponential_sizes_pass_and_others_miss() {
        let exponential = test(&sizes(200, |u| -40.0 * (1.0 - u).ln()), blocks(1));
        assert!(exponential.p_value > 0.01, "{}", exponential.p_value);
        // Uniform sizes, and a power law of heavy tail.
        for it in [sizes(200, |u| 80.0 * u), sizes(200, |u| 10.0 * (1.0 - u).powf(-0.7) - 10.0)] {
            assert!(test(&it, blocks(1)).p_value < 0.01);
        }
    }

    #[test]
    fn the_chance_of_geometric_samples_is_uniform() {
        let mut uniform = blocks(5);
        let below = (0..24).filter(|_| test(&geometric(&mut uniform, 32, 0.9), blocks(1)).p_value < 0.5);
        // 12 of 24 with a standard deviation of 2.4: the bounds are four of them.
        assert!((3..=21).contains(&below.count()));
    }

    #[test]
    fn moments_of_a_geometric_distribution_are_those_of_the_textbook() {
        let it = sizes(20_000, |u| -10.0 * (1.0 - u).ln());
        // The standard deviation of the ratio is about sqrt(20/n) = 0.03.
        assert!((ratio_of_moments(&it) - (2.0 - 1.0 / (mean(&it) + 1.0))).abs() < 0.1);
    }
}
