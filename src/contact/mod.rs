//! Contacts between grains, and between grains and walls: which pairs touch, what they do to each other, who sums it.
//!
//! Grains i and j touch when |x_ij| < R_i + R_j, with x_ij = x_i - x_j; their overlap is
//! delta = R_i + R_j - |x_ij|, their normal n = x_ij/|x_ij|, from j to i. What follows is a [`PairLaw`], made of
//! terms with a file each: a normal force ([`assignment`], [`linear`], [`hertz`]), friction ([`tangential`]), rolling
//! resistance ([`rolling`]), put together in [`composite`] with numbers for each pair of materials ([`table`]),
//! and [`centred`] for the scheme of second order.
//! [`kernel`] walks the pairs, the same for every law and every neighbour search; what a contact remembers is kept in
//! [`history`]; [`crate::survey`] shows the contacts to other systems. Walls obey the same law with a partner of no
//! curvature and infinite mass ([`crate::walls::surfaces`]).

pub mod assignment;
pub(crate) mod batch;
pub mod centred;
pub mod composite;
pub mod config;
pub mod damping;
pub(crate) mod force_accumulation;
mod forces;
pub mod geometry;
pub mod hertz;
pub mod history;
pub mod kernel;
pub(crate) mod lanes;
pub mod linear;
pub mod rolling;
pub(crate) mod root;
pub mod spring;
pub mod table;
pub mod tangential;

use std::sync::Arc;

use bevy_ecs::prelude::*;

pub use self::centred::{Centred, CentredLaw, VelocityPrediction};
pub use self::config::Contact;
pub use self::forces::{ContactForces, ContactPlugin, LargestOverlap, Law};
use crate::particle::Species;
use crate::space::{Plane, Space};

/// A touching pair as a law sees it, from the side of i.
#[derive(Clone, Copy, Debug)]
pub struct Pair<V: Space = Plane> {
    /// Unit vector from j to i.
    pub normal: V,
    /// Overlap, m, positive; a gap, negative, only for centred laws.
    pub overlap: f64,
    /// v_i - v_j of the centres, m/s.
    pub relative_velocity: V,
    /// m_i m_j/(m_i + m_j), kg; m_i against anything fixed.
    pub reduced_mass: f64,
    /// Its root; may be zero unless the law takes it ([`PairLaw::needs_mass_root`]).
    pub root: f64,
    /// R_i and R_j, m; R_j is infinite for a flat wall. May be zero unless the law demands them.
    pub radii: [f64; 2],
    /// 1/(R_i + R_j), 1/m: 0 for a flat wall. May be zero unless the law demands radii.
    pub inverse_reach: f64,
    /// Spins of i and j, rad/s; zero unless the law demands them.
    pub spins: [V::Spin; 2],
    /// Materials of i and j; the first unless the law demands them.
    pub species: [Species; 2],
    /// By how much time memory advances in this evaluation, s: the step, or 0 for a look.
    pub dt: f64,
    /// What velocities gain until the end of the step; zero unless the law demands it.
    pub ahead: VelocityPrediction<V>,
}

impl<V: Space> Pair<V> {
    /// As seen from j, without what is ahead.
    #[must_use]
    pub fn turned(&self) -> Self {
        let swapped = |[i, j]: [f64; 2]| [j, i];
        Self {
            normal: -self.normal,
            relative_velocity: -self.relative_velocity,
            radii: swapped(self.radii),
            spins: [self.spins[1], self.spins[0]],
            species: [self.species[1], self.species[0]],
            ahead: VelocityPrediction::default(),
            ..*self
        }
    }

    /// R_i R_j/(R_i + R_j), m; R_i against a flat wall.
    #[inline(always)]
    #[must_use]
    pub fn reduced_radius(&self) -> f64 {
        let [i, j] = self.radii;
        if j.is_infinite() { i } else { i * j * self.inverse_reach }
    }

    /// (v_i - v_j).n, m/s: negative while the two approach.
    #[inline(always)]
    #[must_use]
    pub fn normal_velocity(&self) -> f64 {
        self.relative_velocity.dot(self.normal)
    }

    /// Relative velocity of the surfaces in the tangent plane, m/s, with these arms (m) from the centres to the contact:
    /// v_ij - v_n n - (l_i w_i + l_j w_j) x n.
    #[inline(always)]
    #[must_use]
    pub fn sliding_velocity(&self, arms: [f64; 2]) -> V {
        let turning = self.spins[0] * arms[0] + self.spins[1] * arms[1];
        self.relative_velocity - self.normal * self.normal_velocity() - self.normal.turned_by(turning)
    }
}

/// What a contact remembers from step to step, from the side of i. Seen from j, `spring` has the
/// other sign; `rolling` has the same, because relative spin and normal both change theirs.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Memory<V: Space = Plane> {
    /// Displacement of the tangential spring, m.
    pub spring: V,
    /// Displacement of the rolling spring, m.
    pub rolling: V,
    /// Tangential stiffness at the last evaluation, N/m, for laws whose stiffness changes; 0 in a new contact. A law of one's own may keep
    /// any number here: nobody but the law reads it.
    pub stiffness: f64,
}

impl<V: Space> Memory<V> {
    /// As seen from the other one.
    #[must_use]
    pub fn turned(&self) -> Self {
        Self { spring: -self.spring, ..*self }
    }
}

/// What the pair does to i; on j acts the opposite force. The total is `smooth + friction`.
#[derive(Clone, Copy, Debug, Default)]
pub struct PairForce<V: Space = Plane> {
    /// Spring and damping between the centres, N.
    pub smooth: V,
    /// The part of it that damping makes, which dissipates, N.
    pub drag: V,
    /// What spinning laws add.
    pub turning: Turning<V>,
}

/// What friction and rolling resistance do to i. The torques are `-arms[0] n x friction + rolling` on i and
/// `-arms[1] n x friction - rolling` on j.
#[derive(Clone, Copy, Debug, Default)]
pub struct Turning<V: Space = Plane> {
    /// Tangential force, N.
    pub friction: V,
    /// The part of it that a dashpot makes, N.
    pub friction_drag: V,
    /// Distances from the centres of i and j to where it acts, m.
    pub arms: [f64; 2],
    /// Torque of rolling resistance, N m.
    pub rolling: V::Spin,
    /// The part of it that a dashpot makes, N m.
    pub rolling_drag: V::Spin,
    /// What sliding took in this step, J.
    pub lost_by_sliding: f64,
    /// What rolling beyond the cap took in this step, J.
    pub lost_by_rolling: f64,
    /// Whether the friction force is at its cap.
    pub is_sliding: bool,
}

impl<V: Space> PairForce<V> {
    /// Spring and damping, and no friction, N.
    #[inline(always)]
    #[must_use]
    pub fn smooth(elastic: V, drag: V) -> Self {
        Self { smooth: elastic + drag, drag, turning: Turning::default() }
    }

    /// The same along the normal: a total of which the spring makes a part, N.
    #[inline(always)]
    #[must_use]
    pub fn along(normal: V, total: f64, spring: f64) -> Self {
        Self { smooth: normal * total, drag: normal * (total - spring), turning: Turning::default() }
    }

    /// What the spring does, N.
    #[must_use]
    pub fn elastic(&self) -> V {
        self.smooth - self.drag
    }
}

/// A contact law. Odd under the exchange of i and j to the last bit: what is a vector may be made from `pair` only
/// in ways that change sign with the normal, the relative velocity and the exchange of the two entries of the lists.
pub trait PairLaw<V: Space = Plane>: Send + Sync + 'static {
    /// The force on i; advances the memory by `pair.dt`.
    fn force(&self, pair: &Pair<V>, memory: &mut Memory<V>) -> PairForce<V>;

    /// Energy stored in a contact, J.
    fn elastic_energy(&self, pair: &Pair<V>, memory: &Memory<V>) -> f64;

    /// What is lost with the tangential and with the rolling spring of a contact that has ended in this step, J; the
    /// overlap of `pair` is negative. A spring takes k S/2 . v dt before it is gone ([`spring`]): k S/2 . (S + v dt).
    fn on_contact_end(&self, _pair: &Pair<V>, _memory: &Memory<V>) -> [f64; 2] {
        [0.0, 0.0]
    }

    /// Whether it takes [`Pair::root`], which takes time.
    fn needs_mass_root(&self) -> bool {
        false
    }

    /// Largest friction coefficient, for views and pictures; 0 without friction.
    fn friction(&self, _pair: &Pair<V>) -> f64 {
        0.0
    }

    /// Normal stiffness, N/m, at the deepest point of such a bounce, for estimates of time step and overlap.
    fn stiffness(&self, bounce: &Bounce) -> f64;

    /// Normal drag coefficient c there, N s/m, for estimates.
    fn damping(&self, bounce: &Bounce) -> f64;

    /// Largest overlap of an undamped bounce, m.
    fn deepest(&self, bounce: &Bounce) -> f64 {
        bounce.speed / self.frequency(bounce)
    }

    /// Duration of a contact, s, for estimates; infinite if it never ends.
    fn contact_duration(&self, bounce: &Bounce) -> f64;

    /// Restitution of a head-on bounce, for reports.
    fn restitution(&self, bounce: &Bounce) -> f64;

    /// Stiffness (N/m) and drag coefficient (N s/m) of each way in which a contact can swing: along the normal, along the
    /// tangent, in rolling. How much faster than along the normal a force moves the last two is the pair's affair.
    fn modes(&self, bounce: &Bounce) -> [[f64; 2]; 3] {
        [[self.stiffness(bounce), self.damping(bounce)], [0.0; 2], [0.0; 2]]
    }

    /// w0 = sqrt(k/m_eff), 1/s.
    fn frequency(&self, bounce: &Bounce) -> f64 {
        (self.stiffness(bounce) / bounce.reduced_mass).sqrt()
    }

    /// zeta = c/(2 sqrt(k m_eff)).
    fn damping_ratio(&self, bounce: &Bounce) -> f64 {
        self.damping(bounce) / (2.0 * (self.stiffness(bounce) * bounce.reduced_mass).sqrt())
    }
}

/// A head-on bounce, for estimates: laws that are not linear depend on size and speed.
#[derive(Clone, Copy, Debug)]
pub struct Bounce {
    /// m_i m_j/(m_i + m_j), kg.
    pub reduced_mass: f64,
    /// R_i R_j/(R_i + R_j), m.
    pub reduced_radius: f64,
    /// Speed of approach, m/s.
    pub speed: f64,
}

/// What a law demands of the kernel that is compiled for it; what it does not demand, no scene with it pays for.
pub trait LawRequirements {
    /// Spins, and the torques that come with them.
    const SPIN: bool = false;
    /// Materials by species.
    const SPECIES: bool = false;
    /// [`Pair::radii`]. Who does without them says so.
    const RADII: bool = true;
    /// [`Memory::spring`].
    const SPRING: bool = false;
    /// [`Memory::rolling`].
    const ROLLING: bool = false;
    /// [`Memory::stiffness`]: the tangential stiffness, or a number of the law's own.
    const STIFFNESS: bool = false;
    /// Velocities predicted for the end of the step, and pairs that touch within half a step: [`centred`].
    const PREDICTION: bool = false;
    /// Whether it counts which of the two has which radius or mass.
    const NUMBERS: bool = Self::RADII || Self::SPIN || Self::PREDICTION;
    /// Any memory.
    const MEMORY: bool = Self::SPRING || Self::ROLLING || Self::STIFFNESS;
}

/// The law of the scene for passes that are not hot: surveys, estimates, reports.
#[derive(Resource, Clone)]
pub struct AnyLaw<V: Space = Plane>(pub Arc<dyn PairLaw<V>>);

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::space::Vector;

    /// Two equal grains of 4 cm that touch along x, at rest.
    pub(crate) fn pair() -> Pair {
        Pair {
            normal: Vector::X,
            overlap: 1e-3,
            relative_velocity: Vector::ZERO,
            reduced_mass: 0.1,
            root: 0.1f64.sqrt(),
            radii: [0.04, 0.04],
            inverse_reach: 1.0 / 0.08,
            spins: [0.0, 0.0],
            species: [Species(0); 2],
            dt: 1e-4,
            ahead: VelocityPrediction::default(),
        }
    }
}
