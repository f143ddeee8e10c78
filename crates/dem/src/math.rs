//! Elementary functions with the same bits on every machine: those of the crate `libm`. The methods of `f64` call the mathematical library
//! of the platform. Its last bits differ between C libraries, and from those of WebAssembly.
//!
//! Code whose numbers enter a run uses these functions; `clippy.toml` names the methods that it does not use. Roots and rounding follow IEEE 754
//! everywhere, and powers with a whole exponent one algorithm, so they stay methods.

pub use libm::{acos, asin, atan, atan2, cbrt, cos, exp, exp2, hypot, log as ln, log2, log10, pow, sin, sincos};

use glam::DVec2;

/// Returns the unit vector at this angle to the x axis.
#[must_use]
pub fn direction(angle: f64) -> DVec2 {
    let (sine, cosine) = sincos(angle);
    DVec2::new(cosine, sine)
}
