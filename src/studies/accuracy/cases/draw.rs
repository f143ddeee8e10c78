//! Pseudo-random numbers of the test cases.

/// Returns the next pseudo-random number in [0, 1) and advances `state`.
///
/// The sequence is the same on every machine: the upper 53 bits of a 64-bit linear congruential generator with Knuth's
/// constants.
pub(super) fn draw(state: &mut u64) -> f64 {
    *state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
    #[expect(clippy::cast_precision_loss, reason = "53 bits")]
    let fraction = (*state >> 11) as f64 / (1u64 << 53) as f64;
    fraction
}
