//! Comparisons of vectors and corners that several rules need.

use siloflow_dem::space::Solid;
use siloflow_dem::values::FiniteVector;

/// Whether a vector is zero, or its square under- or overflows.
pub(super) fn has_no_direction(v: Solid) -> bool {
    !v.length_squared().is_normal()
}

/// Whether the angle of two vectors differs from a right angle by more than rounding.
pub(super) fn is_oblique(a: Solid, b: Solid) -> bool {
    a.dot(b).abs() > 1e-9 * a.length() * b.length()
}

/// Whether the first corner is below the second along every axis.
pub(super) fn is_box(low: FiniteVector, high: FiniteVector) -> bool {
    (0..low.count()).all(|axis| low.padded()[axis] < high.padded()[axis])
}
