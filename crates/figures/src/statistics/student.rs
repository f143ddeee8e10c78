//! Student's t, from the printed table.

/// Most degrees of freedom of [`t_95`].
pub const MOST_95: usize = 15;

/// Returns the value that |t| exceeds with probability 0.05, for 1 to [`MOST_95`] degrees of freedom. A 95 % confidence interval reaches
/// this many standard errors to each side of a mean.
///
/// # Panics
/// With another number of degrees of freedom.
#[must_use]
pub fn t_95(freedom: usize) -> f64 {
    const TABLE: [f64; MOST_95] =
        [12.706, 4.303, 3.182, 2.776, 2.571, 2.447, 2.365, 2.306, 2.262, 2.228, 2.201, 2.179, 2.160, 2.145, 2.131];
    TABLE[freedom - 1]
}

/// Returns the value that |t| exceeds with probability 0.01; 0 without degrees of freedom. Above 14 of them it is an upper bound.
#[must_use]
pub fn t_99(freedom: usize) -> f64 {
    const TABLE: [f64; 14] = [63.66, 9.92, 5.84, 4.60, 4.03, 3.71, 3.50, 3.36, 3.25, 3.17, 3.11, 3.05, 3.01, 2.98];
    match freedom {
        0 => 0.0,
        1..=14 => TABLE[freedom - 1],
        // The quantile is below 2.98 here and decreases to the normal distribution's 2.58.
        15..=30 => 2.95,
        _ => 2.75,
    }
}
