//! The input of a force pass.

use crate::contact::batch_law::BatchLaw;
use crate::contact::needs::Needs;
use crate::instruction_set::InstructionSet;
use crate::neighbours::list::{Candidate, PairList};
use crate::space::Space;
use crate::walls::surface_wall::SurfaceWall;
use crate::walls::twins::Twins;

/// The input of a force pass besides the particle store.
pub struct ForcePass<'a, V: Space> {
    /// The contact law.
    pub law: &'a dyn BatchLaw<V>,
    /// The requirements of the law.
    pub needs: Needs,
    /// Candidate pairs. With velocity prediction, pairs with a lone particle are marked.
    pub list: &'a PairList,
    /// The wall surfaces.
    pub walls: &'a [SurfaceWall<V>],
    /// Their images beyond periodic sides.
    pub twins: &'a Twins,
    /// Pairs of a particle and a wall that may touch, ascending.
    pub near: &'a [Candidate],
    /// Time by which memories advance, s.
    pub dt: f64,
    /// Whether this is the first pass of a run, whose forces act in half a step only.
    pub starts: bool,
    /// Whether this pass counts contacts.
    pub counts: bool,
    /// Acceleration of gravity, m/s^2.
    pub gravity: V,
    /// Instruction set of the lane loops.
    pub instructions: InstructionSet,
}
