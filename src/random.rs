//! Named random number streams. A number depends on the scene, the seed, the stream's name and a counter only, not on
//! the order of requests.
//!
//! The numbers of a stream are keyed by a counter (for example the grain's number) instead of being drawn in sequence.
//! The generator is ChaCha8, with seed and name as the key, and the counter as the stream.

use rand::rngs::ChaCha8Rng;
use rand::{Rng, SeedableRng};

use siloflow_dem::math;

/// A named stream of random numbers of the scene's seed.
#[derive(Clone, Debug)]
pub struct Stream {
    key: [u8; 32],
}

impl Stream {
    /// Returns the stream `name` of `seed`. Only the first 24 bytes of the name count.
    #[must_use]
    pub fn new(seed: u64, name: &str) -> Self {
        let mut key = [0; 32];
        key[..8].copy_from_slice(&seed.to_le_bytes());
        for (to, from) in key[8..].iter_mut().zip(name.bytes()) {
            *to = from;
        }
        Self { key }
    }

    /// Returns the generator of `counter`.
    fn generator(&self, counter: u64) -> ChaCha8Rng {
        let mut generator = ChaCha8Rng::from_seed(self.key);
        generator.set_stream(counter);
        generator
    }

    /// Returns the `N` numbers of `counter`, each uniform in 0 <= u < 1 with 53 bits.
    #[must_use]
    pub fn uniform<const N: usize>(&self, counter: u64) -> [f64; N] {
        let mut generator = self.generator(counter);
        std::array::from_fn(|_| unit(generator.next_u64()))
    }

    /// Returns the `N` numbers of `counter`, each Gaussian with mean 0 and variance 1, by the method of Box and Muller:
    /// sqrt(-2 ln(1 - u)) cos(2 pi v) (Ann. Math. Stat. 29, 610, 1958). None exceeds 8.6 in magnitude.
    #[must_use]
    pub fn gaussian<const N: usize>(&self, counter: u64) -> [f64; N] {
        let mut generator = self.generator(counter);
        std::array::from_fn(|_| {
            let [u, v] = [unit(generator.next_u64()), unit(generator.next_u64())];
            (-2.0 * math::ln(1.0 - u)).sqrt() * math::cos(std::f64::consts::TAU * v)
        })
    }
}

#[expect(clippy::cast_precision_loss, reason = "53 bits fit exactly")]
fn unit(bits: u64) -> f64 {
    (bits >> 11) as f64 * math::exp2(-53.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_depend_on_seed_name_and_counter_only() {
        let stream = Stream::new(7, "spawner.jitter");
        let [a, b] = stream.uniform(3);
        let bits = |numbers: [f64; 2]| numbers.map(f64::to_bits);
        assert_eq!(bits(stream.uniform(3)), bits([a, b]));
        for other in [
            Stream::new(8, "spawner.jitter").uniform(3),
            Stream::new(7, "spawner.radius").uniform(3),
            stream.uniform(4),
        ] {
            assert_ne!(bits(other), bits([a, b]));
        }
    }

    #[test]
    fn gaussian_numbers_have_the_moments_of_the_distribution() {
        let stream = Stream::new(1, "test");
        let n = 20_000;
        let all: Vec<[f64; 2]> = (0..n).map(|i| stream.gaussian(i)).collect();
        let mean = |f: &dyn Fn(&[f64; 2]) -> f64| all.iter().map(f).sum::<f64>() / 2e4;
        // Within five standard errors: the variances of x, x^2, x^3, x^4 and xy are 1, 2, 15, 96 and 1.
        for (moment, expected, variance) in [
            (mean(&|g| g[0]), 0.0, 1.0),
            (mean(&|g| g[1]), 0.0, 1.0),
            (mean(&|g| g[0].powi(2)), 1.0, 2.0),
            (mean(&|g| g[1].powi(3)), 0.0, 15.0),
            (mean(&|g| g[0].powi(4)), 3.0, 96.0),
            (mean(&|g| g[0] * g[1]), 0.0, 1.0),
        ] {
            assert!((moment - expected).abs() < 5.0 * f64::sqrt(variance / 2e4), "{moment} for {expected}");
        }
    }

    #[test]
    fn numbers_are_uniform() {
        let stream = Stream::new(1, "test");
        let n = 10_000;
        let mean = (0..n).map(|i| stream.uniform::<1>(i)[0]).sum::<f64>() / 1e4;
        // Five standard errors of the mean of 1e4 uniform numbers: 5/sqrt(12e4).
        assert!((mean - 0.5).abs() < 5.0 / 12e4f64.sqrt(), "{mean}");
    }
}
