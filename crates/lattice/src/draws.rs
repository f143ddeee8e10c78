//! Random numbers of the lattice, keyed by site and step. They do not depend on the order of the sites or on the number
//! of threads.
//!
//! The decisions of site s in step t, for purpose f and sub-step j, use their own stream of words:
//!
//! ```text
//! mix = the finaliser of splitmix64 (Steele, Lea, Flood, OOPSLA 2014)
//! key = mix(seed ^ s 0xD1B54A32D192ED03 ^ (mix(8 t + f) + j 0x632BE59BD9B4E019))
//! word(i) = mix(key + (i + 1) 0x9E3779B97F4A7C15)
//! ```
//!
//! The words are the output of splitmix64 started at `key`. A draw is the lower or upper half of a word, 32 bits. An
//! event with probability c happens if the draw is less than c 2^32. Probabilities 0 and 1 are exact. Others are
//! rounded to multiples of 2^-32.

/// Purpose of a stream of random numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Purpose {
    /// Entering particles: filling and pouring.
    Enter = 0,
    /// Number of particles of a site that stop in a collision.
    Stop = 1,
    /// Neighbours that take the surplus stopped particles of a site.
    Scatter = 2,
    /// Outgoing state of a collision.
    Collide = 3,
    /// Particles at rest that move down.
    Trickle = 4,
    /// Random reflection at walls.
    Reflect = 5,
    /// Particles that stop at a rough wall.
    StopAtWall = 6,
    /// Neighbours that take the particles stopped by a wall.
    ScatterAtWall = 7,
}

/// The streams of all sites for one step, purpose and sub-step.
#[derive(Clone, Copy, Debug)]
pub struct Streams(u64);

/// The stream of one site: the key of its words.
#[derive(Clone, Copy, Debug)]
pub struct Draws(u64);

#[inline]
const fn mix(mut z: u64) -> u64 {
    z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    z ^ (z >> 31)
}

impl Streams {
    /// Returns the streams for a purpose in step `t`. Different `sub_step`s give different streams within the step.
    #[must_use]
    pub fn new(seed: u64, t: u64, purpose: Purpose, sub_step: u64) -> Self {
        let moment = mix(t.wrapping_mul(8).wrapping_add(purpose as u64));
        Self(seed ^ moment.wrapping_add(sub_step.wrapping_mul(0x632B_E59B_D9B4_E019)))
    }

    /// Returns the stream of a site.
    #[inline]
    #[must_use]
    pub fn of(self, site: usize) -> Draws {
        Draws(mix(self.0 ^ (site as u64).wrapping_mul(0xD1B5_4A32_D192_ED03)))
    }
}

impl Draws {
    /// Returns word `i` of the stream, counted from 0.
    #[inline]
    #[must_use]
    pub fn word(self, i: u64) -> u64 {
        mix(self.0.wrapping_add((i + 1).wrapping_mul(0x9E37_79B9_7F4A_7C15)))
    }

    /// Returns the upper half of word `i`.
    #[inline]
    #[must_use]
    pub fn high(self, i: u64) -> u32 {
        high(self.word(i))
    }
}

/// Returns the upper half of a word.
#[inline]
#[must_use]
pub fn high(word: u64) -> u32 {
    (word >> 32) as u32
}

/// Returns the lower half of a word.
#[inline]
#[must_use]
#[expect(clippy::cast_possible_truncation, reason = "keeps the lower half")]
pub fn low(word: u64) -> u32 {
    word as u32
}

/// Returns a random integer from 0 to `n` - 1 for the draw `draw`.
#[inline]
#[must_use]
pub fn below(draw: u32, n: u32) -> u32 {
    high(u64::from(draw) * u64::from(n))
}

/// A probability, as a multiple of 2^-32.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Chance(u64);

impl Chance {
    /// Converts a probability, clamped to 0..=1.
    #[must_use]
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "from 0 to 2^32")]
    pub fn of(probability: f64) -> Self {
        Self((probability.clamp(0.0, 1.0) * 2f64.powi(32)).round() as u64)
    }

    /// Whether the event happens for the draw `draw`.
    #[inline]
    #[must_use]
    pub fn happens(self, draw: u32) -> bool {
        u64::from(draw) < self.0
    }
}

/// A geometric distribution: n is the largest integer with r < a^n for r uniform in 0..1, so that P(n >= j) = a^j.
#[derive(Clone, Copy, Debug)]
pub struct Geometric([Chance; 14]);

impl Geometric {
    /// Creates the distribution with base `a`, from 0 to 1.
    #[must_use]
    pub fn new(a: f64) -> Self {
        let mut power = 1.0;
        Self(std::array::from_fn(|_| {
            let chance = Chance::of(power);
            power *= a;
            chance
        }))
    }

    /// Returns n, limited to `cap`, for the draw `draw`; `cap` is from 2 to 13.
    #[inline]
    #[must_use]
    pub fn draw(&self, draw: u32, cap: u8) -> u8 {
        debug_assert!(cap >= 2, "a collision has at least two particles");
        // Two comparisons cost less than one unpredictable branch. Larger n are rare.
        let n = u8::from(self.0[1].happens(draw)) + u8::from(self.0[2].happens(draw));
        if self.0[3].happens(draw) { self.draw_at_least_three(draw, cap) } else { n }
    }

    /// Returns n if it is at least 3 without the cap.
    #[cold]
    fn draw_at_least_three(&self, draw: u32, cap: u8) -> u8 {
        (0..cap).find(|&n| !self.0[usize::from(n) + 1].happens(draw)).unwrap_or(cap)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn streams_are_splitmix64() {
        // The first outputs of splitmix64 from 0 (Vigna's reference, as in rand_xoshiro's tests).
        let draws = Draws(0);
        assert_eq!(
            [0, 1, 2].map(|i| draws.word(i)),
            [0xE220_A839_7B1D_CDAF, 0x6E78_9E6A_A1B9_65F4, 0x06C4_5D18_8009_454F]
        );
    }

    #[test]
    fn streams_differ_by_seed_site_step_purpose_and_sub_step() {
        let first_word = |seed, t, purpose, sub, site| Streams::new(seed, t, purpose, sub).of(site).word(0);
        let all = [
            first_word(1, 1, Purpose::Stop, 0, 1),
            first_word(2, 1, Purpose::Stop, 0, 1),
            first_word(1, 2, Purpose::Stop, 0, 1),
            first_word(1, 1, Purpose::Scatter, 0, 1),
            first_word(1, 1, Purpose::Stop, 1, 1),
            first_word(1, 1, Purpose::Stop, 0, 2),
        ];
        for (i, a) in all.iter().enumerate() {
            assert!(all[..i].iter().all(|b| b != a));
        }
    }

    #[test]
    fn probabilities_zero_and_one_are_exact() {
        assert!(!Chance::of(0.0).happens(0));
        assert!(Chance::of(1.0).happens(u32::MAX));
        assert_eq!([0.0, 1.0].map(|a| Geometric::new(a).draw(u32::MAX / 2, 5)), [0, 5]);
        assert_eq!([2, 3, 13].map(|cap| Geometric::new(1.0).draw(0, cap)), [2, 3, 13]);
    }

    #[test]
    fn the_geometric_distribution_has_its_tail_probabilities() {
        let law = Geometric::new(0.4);
        let streams = Streams::new(5, 1, Purpose::Stop, 0);
        let n = 100_000;
        let mut at_least = [0u32; 5];
        for site in 0..n {
            let drawn = usize::from(law.draw(streams.of(site).high(0), 4));
            (0..=drawn).for_each(|j| at_least[j] += 1);
        }
        for (j, &count) in (0..).zip(&at_least) {
            let p = 0.4f64.powi(j);
            // Five standard errors of a binomial share.
            let allowed = 5.0 * (p * (1.0 - p) / 1e5).sqrt();
            assert!((f64::from(count) / 1e5 - p).abs() <= allowed, "{j}: {count}");
        }
    }
}
