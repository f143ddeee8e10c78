//! The output of a contact law: force and torques of one contact.

use crate::space::{Plane, Space};

/// The force of the contact on i; the opposite force acts on j. The total is `normal + resistance.friction`.
#[derive(Clone, Copy, Debug, Default)]
pub struct PairForce<V: Space = Plane> {
    /// Normal force: spring, dashpot and pull between the centres, N. The drag of the assignment's law, which also acts along the
    /// tangent, counts here too.
    pub normal: V,
    /// The dashpot part of `normal`, which dissipates energy, N.
    pub dashpot: V,
    /// The normal force that caps friction, the one without adhesive pull, and its spring part, N. A law that computes them
    /// anyway may give them, which saves time. Otherwise they follow from the forces.
    pub load: Option<[f64; 2]>,
    /// Friction, rolling and twisting resistance.
    pub resistance: Resistance<V>,
}

/// Resistance of a contact against sliding (friction), rolling and twisting. The torque on i is `-arms[0] n x friction + rolling`. The
/// torque on j is `-arms[1] n x friction - rolling`.
#[derive(Clone, Copy, Debug, Default)]
pub struct Resistance<V: Space = Plane> {
    /// Tangential force on i, N.
    pub friction: V,
    /// The dashpot part of `friction`, N.
    pub friction_dashpot: V,
    /// Distances from the centres of i and j to the point at which `friction` acts, m.
    pub arms: [f64; 2],
    /// Torque of rolling and twisting resistance on i, N m.
    pub rolling: V::Spin,
    /// The dashpot part of `rolling`, N m.
    pub rolling_dashpot: V::Spin,
    /// Energy lost to sliding in this step, J.
    pub lost_by_sliding: f64,
    /// Energy lost to rolling beyond the cap in this step, J.
    pub lost_by_rolling: f64,
    /// Whether the friction force is at its cap.
    pub is_sliding: bool,
    /// Tangential stiffness at the previous evaluation, N/m, for laws whose stiffness changes: input of rolling resistance.
    pub stiffness_before: f64,
}

impl<V: Space> PairForce<V> {
    /// Returns a force from its spring part and its dashpot part, N, without friction.
    #[inline(always)]
    #[must_use]
    pub fn new(elastic: V, dashpot: V) -> Self {
        Self { normal: elastic + dashpot, dashpot, ..Self::default() }
    }

    /// Returns a force along the normal, without friction, from its total and the spring part of that total, N.
    #[inline(always)]
    #[must_use]
    pub fn along(normal: V, total: f64, spring: f64) -> Self {
        Self { normal: normal * total, dashpot: normal * (total - spring), ..Self::default() }
    }

    /// Returns the spring part of `normal`, N.
    #[must_use]
    pub fn elastic(&self) -> V {
        self.normal - self.dashpot
    }
}
