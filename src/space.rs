//! The space that grains live in.
//!
//! Scenes are planar: every position, velocity and force is a [`Vector`] of two components, x to the right and
//! y up, in SI units. Code elsewhere uses only dot products, lengths and sums of `Vector`s, so that another
//! dimension needs another alias here and not another copy there.

/// A vector of the plane, in SI units. Double precision: the overlaps that carry a bed are 1e-4 of its size.
pub type Vector = glam::DVec2;

/// Number of components of [`Vector`].
pub const DIMENSION: usize = 2;

/// The names of the components, in the order in which files list them.
pub const AXES: [&str; DIMENSION] = ["x", "y"];

/// `+0.0` for `-0.0`, anything else as it is: two states that compare equal then have the same bits.
#[must_use]
pub fn plain_zero(v: Vector) -> Vector {
    v + Vector::ZERO
}
