//! `damping tsuji` of LAMMPS: c = a(e) sqrt(k m_eff), with the polynomial a(e) of Tsuji, Tanaka and Ishida (Powder Technology 71, 239,
//! 1992). The inverse of the polynomial gives the e for any c up to 1.2728 sqrt(k m_eff).

/// Coefficient and name of the damping model with c = `factor` sqrt(k m_eff).
pub(super) fn tsuji(factor: f64) -> Option<(f64, &'static str)> {
    if factor <= 0.0 {
        return Some((0.0, "velocity"));
    }
    // The polynomial falls from 1.2728 at 0 through zero between 1 and 1.001.
    let mut low = 0.0;
    let mut high = 1.001;
    if tsuji_polynomial(low) < factor {
        return None;
    }
    for _ in 0..200 {
        let middle = 0.5 * (low + high);
        if tsuji_polynomial(middle) > factor { low = middle } else { high = middle }
    }
    Some((0.5 * (low + high), "tsuji"))
}

/// a(e) of LAMMPS.
fn tsuji_polynomial(e: f64) -> f64 {
    1.2728 - 4.2783 * e + 11.087 * e.powi(2) - 22.348 * e.powi(3) + 27.467 * e.powi(4) - 18.022 * e.powi(5)
        + 4.8218 * e.powi(6)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_inverse_of_the_polynomial_gives_the_drag_that_was_asked_for() {
        for factor in [1.2, 1.0, 0.5, 0.1, 0.01, 1e-4] {
            let (e, model) = tsuji(factor).unwrap();
            // The sum of the polynomial's terms rounds at 30 times the precision of a double.
            assert!(model == "tsuji" && (tsuji_polynomial(e) - factor).abs() < 30.0 * f64::EPSILON, "{factor}: {e}");
        }
        assert_eq!(tsuji(0.0), Some((0.0, "velocity")));
        assert_eq!(tsuji(1.3), None);
        let falls =
            (1..=1000).all(|n| tsuji_polynomial(f64::from(n) / 999.5) < tsuji_polynomial(f64::from(n - 1) / 999.5));
        assert!(falls);
    }
}
