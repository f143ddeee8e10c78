//! Means over one cell of a flow field: a row of `flow.csv`. Units are those of the run: m and m/s in the grain silo.

/// Means over one cell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FlowMeans {
    /// Middle of the cell along the first axis.
    pub x: f64,
    /// Middle of the cell along the second axis, upwards.
    pub y: f64,
    /// Number of samples of the field.
    pub samples: u64,
    /// Grains per sample.
    pub count: f64,
    /// Mean velocity along the first axis.
    pub vx: f64,
    /// Mean velocity along the second axis.
    pub vy: f64,
}
