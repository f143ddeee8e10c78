//! Numbers as text with a number of significant digits.

/// Returns a number with four significant digits.
#[must_use]
pub fn short(x: f64) -> String {
    digits(x, 4)
}

/// Returns a number with this many significant digits, at least one. Digits before the point are all kept.
#[must_use]
pub fn digits(x: f64, count: u8) -> String {
    let size = if x == 0.0 || !x.is_finite() { 0.0 } else { x.abs().log10().floor() };
    if !(-4.0..6.0).contains(&size) {
        return format!("{x:.*e}", usize::from(count.saturating_sub(1)));
    }
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped")]
    let decimals = (f64::from(count) - 1.0 - size).clamp(0.0, 8.0) as usize;
    format!("{x:.decimals$}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_their_digits() {
        assert_eq!([0.0, 12.3456, -0.012_346, 1.0e7].map(short), ["0.000", "12.35", "-0.01235", "1.000e7"]);
        assert_eq!([0.0312, 12.6, 3.14e-7].map(|x| digits(x, 2)), ["0.031", "13", "3.1e-7"]);
    }
}
