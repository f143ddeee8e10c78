//! Named random number streams. A number depends on the scene, the seed, the stream's name and a counter only, not on
//! the order of requests.
//!
//! The numbers of a stream are keyed by a counter (for example the grain's number) instead of being drawn in sequence.
//! The generator is ChaCha8, with seed and name as the key, and the counter as the stream.

use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// A named stream of random numbers of the scene's seed.
#[derive(Clone, Debug)]
pub struct Stream(ChaCha8Rng);

impl Stream {
    /// Returns the stream `name` of `seed`. Only the first 24 bytes of the name count.
    #[must_use]
    pub fn new(seed: u64, name: &str) -> Self {
        let mut key = [0; 32];
        key[..8].copy_from_slice(&seed.to_le_bytes());
        for (to, from) in key[8..].iter_mut().zip(name.bytes()) {
            *to = from;
        }
        Self(ChaCha8Rng::from_seed(key))
    }

    /// Returns the `N` numbers of `counter`, each uniform in 0 <= u < 1 with 53 bits.
    #[must_use]
    pub fn uniform<const N: usize>(&self, counter: u64) -> [f64; N] {
        let mut rng = self.0.clone();
        rng.set_stream(counter);
        rng.set_word_pos(0);
        std::array::from_fn(|_| unit(rng.next_u64()))
    }
}

#[expect(clippy::cast_precision_loss, reason = "53 bits fit exactly")]
fn unit(bits: u64) -> f64 {
    (bits >> 11) as f64 * (-53f64).exp2()
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
    fn numbers_are_uniform() {
        let stream = Stream::new(1, "test");
        let n = 10_000;
        let mean = (0..n).map(|i| stream.uniform::<1>(i)[0]).sum::<f64>() / 1e4;
        // Five standard errors of the mean of 1e4 uniform numbers: 5/sqrt(12e4).
        assert!((mean - 0.5).abs() < 5.0 / 12e4f64.sqrt(), "{mean}");
    }
}
