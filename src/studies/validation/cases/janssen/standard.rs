//! Pressures of filling in a slender round silo after EN 1991-4, for wheat. Not a design check: no load case, no factor, no patch load.
//!
//! p(z) = gamma K z_0 (1 - exp(-z/z_0)) with z_0 = R/(2 K mu). The standard gives a mean and a factor of conversion for each property of the solid. Pressures
//! on the wall are largest with the upper K and the lower mu, and smallest with the lower K and the upper mu. They are divided here by gamma R, so
//! that beds of other densities stand beside them.

/// Lateral pressure ratio of wheat, and its factor.
const RATIO: (f64, f64) = (0.54, 1.11);

/// Friction of wheat on a wall of type D3, and its factor.
const FRICTION: (f64, f64) = (0.57, 1.16);

/// Returns the smallest and the largest pressure over gamma R at a depth over R.
pub(super) fn wheat(depth: f64) -> (f64, f64) {
    let pressure = |k: f64, mu: f64| {
        let z_0 = 1.0 / (2.0 * k * mu);
        k * z_0 * (1.0 - (-depth / z_0).exp())
    };
    let (k, by) = RATIO;
    let (mu, factor) = FRICTION;
    (pressure(k / by, mu * factor), pressure(k * by, mu / factor))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pressures_are_hydrostatic_at_the_top_and_saturate() {
        let (low, high) = wheat(1e-6);
        // K times the depth, to first order.
        assert!((low / 1e-6 - 0.54 / 1.11).abs() < 1e-5 && (high / 1e-6 - 0.54 * 1.11).abs() < 1e-5);
        let (low, high) = wheat(100.0);
        // gamma R/(2 mu).
        assert!((low - 0.5 / (0.57 * 1.16)).abs() < 1e-9 && (high - 0.5 / 0.57 * 1.16).abs() < 1e-9);
    }
}
