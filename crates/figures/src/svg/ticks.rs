//! Numbers at a colour scale: its ends, and between them multiples of 1, 2 or 5 times a power of ten.

/// Returns the numbers at a scale, ascending: as many as fit if a scale has space for `letters` letters.
pub(super) fn ticks(from: f64, to: f64, letters: f64) -> Vec<f64> {
    let candidates = [5.0, 3.0, 2.0].map(|most| steps(from, to, most));
    #[expect(clippy::cast_precision_loss, reason = "a few letters")]
    let fits = |numbers: &&Vec<f64>| {
        let longest = numbers.iter().map(|&number| rounded(number).chars().count()).max().unwrap_or(0);
        (longest + 1) as f64 * (numbers.len() - 1) as f64 <= letters
    };
    candidates.iter().find(fits).cloned().unwrap_or_else(|| vec![from, to])
}

/// Returns the ends and fewer than `most` numbers between them, at least nearly the length of a step apart.
fn steps(from: f64, to: f64, most: f64) -> Vec<f64> {
    let length = to - from;
    let least = length / most;
    let apart = 0.95 * least;
    let power = 10f64.powf(least.log10().floor());
    let step = [1.0, 2.0, 5.0, 10.0].into_iter().map(|m| m * power).find(|&step| step >= 0.999 * least);
    let (Some(step), true) = (step, length.is_finite() && length > 0.0) else { return vec![from] };
    let first = (from / step).floor();
    let inner = (0..20u8).map(|number| (first + f64::from(number)) * step);
    let inner = inner.filter(|value| value - from > apart && to - value > apart);
    std::iter::once(from).chain(inner).chain([to]).collect()
}

/// Returns a number as text, without digits that come from binary rounding.
pub(super) fn rounded(value: f64) -> String {
    let size = value.abs();
    if size > 0.0 && !(1e-3..1e6).contains(&size) {
        let text = format!("{value:.4e}");
        let (digits, exponent) = text.split_once('e').unwrap_or((&text, "0"));
        let digits = if digits.contains('.') { digits.trim_end_matches('0').trim_end_matches('.') } else { digits };
        return format!("{digits}e{exponent}");
    }
    format!("{}", (value * 1e6).round() / 1e6)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scales_have_few_round_numbers_and_their_ends() {
        let texts = |from, to| ticks(from, to, 25.0).into_iter().map(rounded).collect::<Vec<_>>().join(" ");
        for ((from, to), expected) in [
            ((0.0, 1.0), "0 0.2 0.4 0.6 0.8 1"),
            ((0.0, 0.5), "0 0.1 0.2 0.3 0.4 0.5"),
            ((0.0, 0.005), "0 0.002 0.005"),
            ((0.0, 1.5), "0 0.5 1 1.5"),
            ((0.0, 0.6), "0 0.2 0.4 0.6"),
            ((0.0, 13.0), "0 5 10 13"),
            ((290.0, 310.0), "290 295 300 305 310"),
            ((-0.3, 0.1), "-0.3 -0.2 -0.1 0 0.1"),
            ((0.0, 4.0e-4), "0 1e-4 2e-4 3e-4 4e-4"),
            ((0.0, 0.0), "0"),
        ] {
            assert_eq!(texts(from, to), expected);
        }
    }

    #[test]
    fn numbers_have_no_digits_of_binary_rounding() {
        for (value, expected) in
            [(0.1 + 0.2, "0.3"), (0.0, "0"), (5.0e-4, "5e-4"), (-2.0, "-2"), (1.5e7, "1.5e7"), (2.0e-5, "2e-5")]
        {
            assert_eq!(rounded(value), expected);
        }
    }
}
