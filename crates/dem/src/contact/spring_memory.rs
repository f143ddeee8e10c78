//! The memory of a law of terms ([`composite`](crate::contact::composite)): the displacements of the springs of friction, rolling and
//! twisting resistance, and the tangential stiffness.

use crate::contact::memory::{MemoryVariable, Parity};
use crate::space::{Plane, Space};

/// [`SpringMemory::spring`]. Its ends are on i and j, so that it changes its sign.
pub const SPRING: MemoryVariable = MemoryVariable::vector("spring", Parity::Odd);
/// [`SpringMemory::rolling`]. The relative spin and the normal both change their sign, so that it does not.
pub const ROLLING: MemoryVariable = MemoryVariable::vector("rolling", Parity::Even);
/// [`SpringMemory::stiffness`].
pub const STIFFNESS: MemoryVariable = MemoryVariable::number("stiffness", Parity::Even);
/// [`SpringMemory::twist`]. As for rolling, two signs change.
pub const TWIST: MemoryVariable = MemoryVariable::number("twist", Parity::Even);
/// All variables, in the order of the columns of files.
pub const ALL: &[MemoryVariable] = &[SPRING, ROLLING, STIFFNESS, TWIST];

/// The springs of one contact, seen from i. Those that the law does not have are zero.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SpringMemory<V: Space = Plane> {
    /// Displacement of the tangential spring, m.
    pub spring: V,
    /// Displacement of the rolling spring, m.
    pub rolling: V,
    /// Tangential stiffness at the last evaluation, N/m, for laws whose stiffness changes; 0 in a new contact.
    pub stiffness: f64,
    /// Displacement of the twisting spring, m.
    pub twist: f64,
}
