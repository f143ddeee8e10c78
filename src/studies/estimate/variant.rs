//! The kinds of runs of an estimate: the stiffness, and one further change of the scene.

/// A change beside that of the stiffness.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Change {
    /// None.
    Nothing,
    /// Half of the step.
    HalfStep,
    /// A larger silo.
    Larger,
    /// None, also no growth: a run that measures overlaps and has no other use.
    Overlaps,
}

/// The kind of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Variant {
    /// Its rung.
    pub rung: usize,
    /// Its change.
    pub change: Change,
}
