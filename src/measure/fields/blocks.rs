//! Sums over samples, in blocks of time, and the standard error that follows from them.
//!
//! Successive samples are correlated, so their spread says little about the error of their mean. The samples are therefore added up in
//! blocks of equal numbers of samples. At most [`MOST_BLOCKS`] blocks are kept: when all are full, neighbours are joined, and blocks
//! are twice as long from then on. The means of long blocks are independent.
//!
//! The standard error of a quantity that is a function of the sums, such as momentum over mass, is that of the jackknife: with
//! the value q_k without block k, and n blocks, error^2 = (n - 1)/n sum (q_k - mean q)^2. For a sum itself it is the
//! standard error of the mean of the blocks. (Flyvbjerg and Petersen, J. Chem. Phys. 91, 461 (1989); Efron, Ann. Stat. 7, 1 (1979).)
//!
//! Limits: it is sound if samples that are a block apart are independent, which the caller can judge by the length of a block. With n
//! blocks the error itself is known to a share 1/sqrt(2 (n - 1)), at most 0.27. Samples after the last full block
//! count in the mean, not in the error.

use serde::{Deserialize, Serialize};

/// Most blocks that are kept.
pub const MOST_BLOCKS: usize = 16;

/// Fewest blocks that give an error.
pub const FEWEST_BLOCKS: usize = 8;

/// Sums of many quantities over blocks of samples.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub struct Blocks {
    /// Full blocks.
    full: Vec<Vec<f64>>,
    /// The block that is being filled.
    present: Vec<f64>,
    /// Number of samples in it.
    filled: u64,
    /// Number of samples in a full block.
    block: u64,
}

impl Blocks {
    /// Makes `len` sums without samples.
    #[must_use]
    pub fn new(len: usize) -> Self {
        Self { full: Vec::new(), present: vec![0.0; len], filled: 0, block: 1 }
    }

    /// Number of sums.
    #[must_use]
    pub fn len(&self) -> usize {
        self.present.len()
    }

    /// Whether there are no sums.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.present.is_empty()
    }

    /// Whether restored blocks are such of `len` sums.
    #[must_use]
    pub fn fit(&self, len: usize) -> bool {
        let has_lengths = self.present.len() == len && self.full.iter().all(|block| block.len() == len);
        has_lengths && self.full.len() < MOST_BLOCKS && self.block.is_power_of_two() && self.filled < self.block
    }

    /// The sums of the present sample, and of earlier samples of its block.
    pub fn present(&mut self) -> &mut [f64] {
        &mut self.present
    }

    /// Ends a sample.
    pub fn end_sample(&mut self) {
        self.filled += 1;
        if self.filled < self.block {
            return;
        }
        let empty = vec![0.0; self.present.len()];
        self.full.push(std::mem::replace(&mut self.present, empty));
        self.filled = 0;
        if self.full.len() == MOST_BLOCKS {
            let mut all = std::mem::take(&mut self.full).into_iter();
            while let (Some(mut first), Some(second)) = (all.next(), all.next()) {
                first.iter_mut().zip(second).for_each(|(sum, more)| *sum += more);
                self.full.push(first);
            }
            self.block *= 2;
        }
    }

    /// Number of samples.
    #[must_use]
    pub fn samples(&self) -> u64 {
        self.full.len() as u64 * self.block + self.filled
    }

    /// Number of samples in a full block.
    #[must_use]
    pub fn block(&self) -> u64 {
        self.block
    }

    /// Returns `estimate` of the mean sums in `range`, each quantity with its standard error. The error is `None` below
    /// [`FEWEST_BLOCKS`] full blocks, and where a value without some block is no number.
    #[must_use]
    #[expect(clippy::cast_precision_loss, reason = "numbers of samples and blocks")]
    pub fn estimate(
        &self,
        range: std::ops::Range<usize>,
        estimate: impl Fn(&[f64]) -> Vec<f64>,
    ) -> Vec<(f64, Option<f64>)> {
        let mut full = vec![0.0; range.len()];
        for block in &self.full {
            full.iter_mut().zip(&block[range.clone()]).for_each(|(sum, more)| *sum += more);
        }
        let samples = self.samples().max(1) as f64;
        let all = full.iter().zip(&self.present[range.clone()]).map(|(full, present)| (full + present) / samples);
        let means = estimate(&all.collect::<Vec<_>>());
        let blocks = self.full.len();
        if blocks < FEWEST_BLOCKS {
            return means.into_iter().map(|mean| (mean, None)).collect();
        }
        let others = (self.block * (blocks as u64 - 1)) as f64;
        let without = self.full.iter().map(|block| {
            let rest = full.iter().zip(&block[range.clone()]).map(|(full, of_block)| (full - of_block) / others);
            estimate(&rest.collect::<Vec<_>>())
        });
        let without: Vec<_> = without.collect();
        let n = blocks as f64;
        let error = |quantity: usize| {
            let mean = without.iter().map(|values| values[quantity]).sum::<f64>() / n;
            let squares = without.iter().map(|values| (values[quantity] - mean).powi(2)).sum::<f64>();
            Some(((n - 1.0) / n * squares).sqrt()).filter(|error| error.is_finite())
        };
        means.into_iter().enumerate().map(|(quantity, mean)| (mean, error(quantity))).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Stream;

    #[test]
    fn the_error_covers_the_spread_of_means_of_correlated_samples() {
        // x' = a x + noise has a correlation time of 1/(1 - a) = 20 samples. The mean of N of them has, over many
        // repetitions, the variance s^2/N/(1 - a)^2 for noise of variance s^2 and N far above 20.
        let a = 0.95;
        let samples = 4000u32;
        let repetitions = 200u32;
        let mut squares = 0.0;
        let mut estimated = 0.0;
        for repetition in 0..repetitions {
            let random = Stream::new(repetition.into(), "blocks");
            let mut blocks = Blocks::new(2);
            let mut x = 0.0;
            for sample in 0..samples {
                let [noise] = random.uniform::<1>(sample.into());
                x = a * x + noise - 0.5;
                blocks.present()[0] += x;
                blocks.present()[1] += 1.0;
                blocks.end_sample();
            }
            assert_eq!((blocks.samples(), blocks.block()), (samples.into(), 256));
            let [(mean, error)] = blocks.estimate(0..2, |sums| vec![sums[0] / sums[1]])[..] else { panic!() };
            squares += mean * mean / f64::from(repetitions);
            estimated += error.unwrap().powi(2) / f64::from(repetitions);
        }
        let expected = 1.0 / 12.0 / f64::from(samples) / (1.0 - a).powi(2);
        // A variance from 200 repetitions is known to sqrt(2/200) = 10 %: three of these. Each jackknife has 14
        // degrees of freedom; the mean of 200 is known to 3 %; blocks of 256 underestimate by about 20/256 = 8 %.
        assert!((squares / expected - 1.0).abs() < 0.3, "{squares} {expected}");
        assert!((estimated / expected - 1.0).abs() < 0.2, "{estimated} {expected}");
    }

    #[test]
    fn few_blocks_have_no_error_and_the_mean_has_all_samples() {
        let mut blocks = Blocks::new(1);
        for sample in 0..7u8 {
            blocks.present()[0] += f64::from(sample);
            blocks.end_sample();
        }
        assert_eq!(blocks.estimate(0..1, <[f64]>::to_vec), [(3.0, None)]);
        for sample in 7..35u8 {
            blocks.present()[0] += f64::from(sample);
            blocks.end_sample();
        }
        // 35 samples are eight blocks of four and three more.
        let [(mean, Some(error))] = blocks.estimate(0..1, <[f64]>::to_vec)[..] else { panic!() };
        // Means of the blocks are 1.5, 5.5, ..., 29.5: variance 16 (8^2 - 1)/12 8/7 = 96.
        assert!((mean - 17.0).abs() < 1e-14 && (error - (96.0f64 / 8.0).sqrt()).abs() < 1e-12, "{mean} {error}");
        assert_eq!((blocks.samples(), blocks.block()), (35, 4));
    }
}
