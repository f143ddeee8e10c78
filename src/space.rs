//! The space that grains live in.
//!
//! Scenes are planar: every position, velocity and force is a [`Vector`] of two components, x to the right and
//! y up, in SI units. Code elsewhere uses only dot products, lengths and sums of `Vector`s, so that another
//! dimension needs another alias here and not another copy there.

/// A vector of the plane, in SI units. Double precision: the overlaps that carry a bed are 1e-4 of its size.
pub type Vector = glam::DVec2;

/// Number of components of [`Vector`].
pub const DIMENSION: usize = 2;
