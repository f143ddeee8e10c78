//! Contacts between discs: which pairs touch, what they do to each other, and who sums it.
//!
//! Discs i and j touch when |x_ij| < R_i + R_j, with x_ij = x_i - x_j; their overlap is
//! delta = R_i + R_j - |x_ij|, their normal n = x_ij/|x_ij|, from j to i. What force follows is a [`PairLaw`], one
//! file a law; [`kernel`] walks the pairs, the same for every law and every neighbour search. Walls obey the same
//! law with a partner of no curvature and infinite mass ([`crate::walls::surfaces`]).

pub mod assignment;
pub mod damping;
mod forces;
pub mod kernel;
pub mod linear;
pub mod survey;

use std::sync::Arc;

use bevy_ecs::prelude::*;
use serde::{Deserialize, Serialize};

pub use self::forces::{ContactForces, ContactPlugin, LargestOverlap, Law};
use crate::scene::values::{NonNegative, Positive};
use crate::space::Vector;

/// The scene's `contact`: which law holds between grains, and between grains and walls.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub enum Contact {
    /// The assignment's law, [`assignment::Assignment`].
    Assignment {
        /// Spring stiffness k, N/m.
        k: Positive,
        /// Drag b on the full relative velocity, N s/m.
        b: NonNegative,
    },
    /// The linear spring-dashpot along the normal, [`linear::LinearNormal`].
    Linear {
        /// Spring stiffness k_n, N/m.
        k: Positive,
        /// Damping of the normal velocity.
        damping: damping::Damping,
        /// Whether the normal force may pull.
        #[serde(default)]
        attraction: damping::Attraction,
    },
}

/// A touching pair as a law sees it, from the side of i.
#[derive(Clone, Copy, Debug)]
pub struct Pair {
    /// Unit vector from j to i.
    pub normal: Vector,
    /// Overlap, m, positive.
    pub overlap: f64,
    /// v_i - v_j, m/s.
    pub relative_velocity: Vector,
    /// m_i m_j/(m_i + m_j), kg; m_i against anything fixed.
    pub reduced_mass: f64,
}

/// The force on i; on j acts its opposite. The total is `elastic + drag`.
#[derive(Clone, Copy, Debug)]
pub struct PairForce {
    /// What [`PairLaw::elastic_energy`] is the potential of, N.
    pub elastic: Vector,
    /// The rest, which dissipates, N.
    pub drag: Vector,
}

/// A contact law without memory. Odd under the exchange of i and j to the last bit: `force` may use `pair.normal`
/// and `pair.relative_velocity` only in ways that change sign with both.
pub trait PairLaw: Send + Sync + 'static {
    /// The force on i.
    fn force(&self, pair: &Pair) -> PairForce;

    /// Energy stored in an overlap (m), J.
    fn elastic_energy(&self, overlap: f64) -> f64;

    /// Normal stiffness, N/m, for estimates of time step and overlap.
    fn stiffness(&self) -> f64;

    /// Normal drag coefficient c for a reduced mass (kg), N s/m, for estimates.
    fn damping(&self, reduced_mass: f64) -> f64;

    /// Duration of a contact, s, for estimates; infinite if it never ends.
    fn contact_duration(&self, reduced_mass: f64) -> f64;

    /// Restitution of a head-on bounce, for reports.
    fn restitution(&self, reduced_mass: f64) -> f64;

    /// w0 = sqrt(k/m_eff), 1/s.
    fn frequency(&self, reduced_mass: f64) -> f64 {
        (self.stiffness() / reduced_mass).sqrt()
    }

    /// zeta = c/(2 sqrt(k m_eff)).
    fn damping_ratio(&self, reduced_mass: f64) -> f64 {
        self.damping(reduced_mass) / (2.0 * (self.stiffness() * reduced_mass).sqrt())
    }
}

/// The law of the scene for passes that are not hot: surveys, estimates, reports.
#[derive(Resource, Clone)]
pub struct AnyLaw(pub Arc<dyn PairLaw>);

impl Contact {
    /// The law, for passes that are not hot.
    #[must_use]
    pub fn law(&self) -> Arc<dyn PairLaw> {
        match *self {
            Self::Assignment { k, b } => Arc::new(assignment::Assignment::new(k, b)),
            Self::Linear { k, damping, attraction } => Arc::new(linear::LinearNormal::new(k, damping, attraction)),
        }
    }
}
