//! Contacts between grains, and between grains and walls: contact laws, contact history, and the kernel that sums
//! contact forces.
//!
//! Particles i and j touch when |x_ij| < R_i + R_j, with x_ij = x_i - x_j. Their overlap is delta = R_i + R_j - |x_ij|.
//! Their normal is n = x_ij/|x_ij|, from j to i.
//!
//! A contact law is a [`PairLaw`]. [`composite`] builds laws from terms: a normal force ([`linear`], [`hertz`], with
//! [`adhesion`], and [`jkr`]), friction ([`tangential`]) and rolling resistance ([`rolling`], with [`twisting`]). [`assignment`] is a law without terms. [`table`]
//! holds the parameters for each species pair. [`centred`] averages a law over a step, for the integration scheme of
//! second order.
//!
//! [`kernel`] iterates over the candidate pairs in the same way for every law and every neighbour search. [`history`]
//! keeps the memories of contacts between steps. [`crate::survey`] shows contacts to other systems. Contacts with walls
//! obey the same law, with a partner of infinite mass ([`crate::walls::surfaces`]).

pub mod adhesion;
pub mod assignment;
pub(crate) mod batch;
pub mod centred;
pub mod composite;
pub mod config;
pub mod damping;
mod facets;
pub(crate) mod force_accumulation;
mod forces;
pub mod geometry;
pub mod hertz;
pub mod history;
pub mod jkr;
pub mod kernel;
pub(crate) mod lanes;
pub mod linear;
mod lone_grains;
mod needs;
mod prediction;
pub mod rolling;
pub(crate) mod root;
pub mod selection;
pub mod spring;
mod start;
pub mod table;
pub mod tangential;
pub mod twisting;

use std::sync::Arc;

use bevy_ecs::prelude::*;

pub use self::centred::VelocityPrediction;
pub use self::config::Contact;
pub use self::forces::{ContactForces, ContactPlugin, ContactsAtStart, LargestOverlap};
pub use self::needs::MemoryParts;
use crate::particle::Species;
use crate::space::{Plane, Space};

/// A touching pair, seen from the side of i: the input of a contact law.
#[derive(Clone, Copy, Debug)]
pub struct Pair<V: Space = Plane> {
    /// Unit vector from j to i.
    pub normal: V,
    /// Overlap, m, positive. Centred laws also get gaps, as negative overlaps.
    pub overlap: f64,
    /// v_i - v_j of the centres, m/s.
    pub relative_velocity: V,
    /// m_i m_j/(m_i + m_j), kg. Against a fixed partner it is m_i.
    pub reduced_mass: f64,
    /// sqrt(reduced mass), kg^(1/2). May be zero unless [`PairLaw::needs_mass_root`] returns `true`.
    pub root: f64,
    /// R_i and R_j, m. R_j is infinite for a wall surface. May be zero unless the law requires radii.
    pub radii: [f64; 2],
    /// 1/(R_i + R_j), 1/m; for a wall surface of mean curvature H, H/(1 + R_i H). May be zero unless the law requires
    /// radii.
    pub inverse_reach: f64,
    /// Spins of i and j, rad/s; zero unless the law requires spins.
    pub spins: [V::Spin; 2],
    /// Species of i and j; both are species 0 unless the law requires species.
    pub species: [Species; 2],
    /// Time by which the law advances the memory in this evaluation, s: the step, or 0 if the evaluation must not
    /// advance it.
    pub dt: f64,
    /// Time by which the springs of the memory are ahead of the evaluation, s: half a step with [`centred`] contacts whose springs
    /// advance with predicted velocities, else 0.
    pub lead: f64,
    /// The velocities with which springs advance, if they differ from those of the pair.
    pub gathered: Option<Gathered<V>>,
    /// Velocity changes until the end of the step, for [`PairLaw::centred`]; else zero.
    pub ahead: VelocityPrediction<V>,
}

/// The times by which an evaluation treats memories, s; see [`Pair`].
#[derive(Clone, Copy, Debug, Default)]
pub struct MemoryTimes {
    /// [`Pair::dt`].
    pub dt: f64,
    /// [`Pair::lead`].
    pub lead: f64,
}

/// Velocities of a pair in the middle of the step. Springs that advance with them have exactly the stretch that positions have.
#[derive(Clone, Copy, Debug)]
pub struct Gathered<V: Space = Plane> {
    /// v_i - v_j of the centres, m/s.
    pub relative_velocity: V,
    /// Spins of i and j, rad/s.
    pub spins: [V::Spin; 2],
}

impl<V: Space> Pair<V> {
    /// Returns the pair as seen from j, without the velocity prediction.
    #[must_use]
    pub fn seen_from_partner(&self) -> Self {
        let swapped = |[i, j]: [f64; 2]| [j, i];
        Self {
            normal: -self.normal,
            relative_velocity: -self.relative_velocity,
            radii: swapped(self.radii),
            spins: [self.spins[1], self.spins[0]],
            species: [self.species[1], self.species[0]],
            gathered: self.gathered.map(|Gathered { relative_velocity, spins: [i, j] }| Gathered {
                relative_velocity: -relative_velocity,
                spins: [j, i],
            }),
            ahead: VelocityPrediction::default(),
            ..*self
        }
    }

    /// Returns the pair with the velocities with which springs advance.
    #[inline(always)]
    #[must_use]
    pub fn gathering(&self) -> Self {
        match self.gathered {
            Some(Gathered { relative_velocity, spins }) => Self { relative_velocity, spins, ..*self },
            None => *self,
        }
    }

    /// Returns whether velocities are predicted for the end of the step ([`centred`]).
    #[inline(always)]
    #[must_use]
    pub fn is_predicted(&self) -> bool {
        self.lead > 0.0 || self.gathered.is_some()
    }

    /// Returns R_i R_j/(R_i + R_j), m; R_i/(1 + R_i H) against a wall surface of mean curvature H.
    #[inline(always)]
    #[must_use]
    pub fn reduced_radius(&self) -> f64 {
        let [i, j] = self.radii;
        if j.is_infinite() { i * (1.0 - i * self.inverse_reach) } else { i * j * self.inverse_reach }
    }

    /// Returns (v_i - v_j).n, m/s: negative while i and j approach.
    #[inline(always)]
    #[must_use]
    pub fn normal_velocity(&self) -> f64 {
        self.relative_velocity.dot(self.normal)
    }

    /// Returns the relative velocity of the surfaces in the tangent plane, m/s: v_ij - v_n n - (l_i w_i + l_j w_j) x n.
    /// `arms` are the distances l from the centres to the contact, m.
    #[inline(always)]
    #[must_use]
    pub fn sliding_velocity(&self, arms: [f64; 2]) -> V {
        let turning = self.spins[0] * arms[0] + self.spins[1] * arms[1];
        self.relative_velocity - self.normal * self.normal_velocity() - self.normal.turned_by(turning)
    }
}

/// The memory of one contact between steps, seen from the side of i. Seen from j, `spring` has the opposite sign.
/// `rolling` has the same sign from both sides: the relative spin and the normal both change sign.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Memory<V: Space = Plane> {
    /// Displacement of the tangential spring, m.
    pub spring: V,
    /// Displacement of the rolling spring, m.
    pub rolling: V,
    /// Displacement of the twisting spring, m. It has the same sign from both sides.
    pub twist: f64,
    /// Tangential stiffness at the last evaluation, N/m, for laws whose stiffness changes; 0 in a new contact. Laws
    /// from other crates may keep any number here: only the law reads it.
    pub stiffness: f64,
}

impl<V: Space> Memory<V> {
    /// Returns whether the memory is that of a contact that begins, or of a gap.
    #[inline]
    #[must_use]
    pub fn is_empty(&self) -> bool {
        *self == Self::default()
    }

    /// Returns the memory as seen from the other particle.
    #[must_use]
    pub fn seen_from_partner(&self) -> Self {
        Self { spring: -self.spring, ..*self }
    }
}

/// The force of the contact on i; the opposite force acts on j. The total is `smooth + turning.friction`.
#[derive(Clone, Copy, Debug, Default)]
pub struct PairForce<V: Space = Plane> {
    /// Force of the spring and damping between the centres, N.
    pub smooth: V,
    /// The damping part of `smooth`, which dissipates energy, N.
    pub drag: V,
    /// The normal force that caps friction, the one without adhesive pull, and its spring part, N. A law that computes them
    /// anyway may give them, which saves time. Otherwise they follow from the forces.
    pub load: Option<[f64; 2]>,
    /// Friction and rolling resistance.
    pub turning: Turning<V>,
}

/// Friction, rolling and twisting resistance of a contact. The torque on i is `-arms[0] n x friction + rolling`. The torque on j
/// is `-arms[1] n x friction - rolling`.
#[derive(Clone, Copy, Debug, Default)]
pub struct Turning<V: Space = Plane> {
    /// Tangential force on i, N.
    pub friction: V,
    /// The dashpot part of `friction`, N.
    pub friction_drag: V,
    /// Distances from the centres of i and j to the point at which `friction` acts, m.
    pub arms: [f64; 2],
    /// Torque of rolling and twisting resistance on i, N m.
    pub rolling: V::Spin,
    /// The dashpot part of `rolling`, N m.
    pub rolling_drag: V::Spin,
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
    /// Returns a force from its spring part and its damping part, N, without friction.
    #[inline(always)]
    #[must_use]
    pub fn smooth(elastic: V, drag: V) -> Self {
        Self { smooth: elastic + drag, drag, ..Self::default() }
    }

    /// Returns a force along the normal, without friction, from its total and the spring part of that total, N.
    #[inline(always)]
    #[must_use]
    pub fn along(normal: V, total: f64, spring: f64) -> Self {
        Self { smooth: normal * total, drag: normal * (total - spring), ..Self::default() }
    }

    /// Returns the spring part of `smooth`, N.
    #[must_use]
    pub fn elastic(&self) -> V {
        self.smooth - self.drag
    }
}

/// A computation that is compiled for the type of a law. [`PairLaw::between`] calls it.
pub trait LawVisitor<V: Space> {
    /// The result.
    type Output;

    /// Computes the result with `law`.
    fn visit<L: PairLaw<V> + LawRequirements>(self, law: &L) -> Self::Output;
}

/// A contact law. Exchanging i and j reverses the normal and the relative velocity, and swaps the two entries of each
/// array in `pair`. The force must then change its sign, to the last bit.
pub trait PairLaw<V: Space = Plane>: Send + Sync + 'static {
    /// Returns the force on i and advances the memory by `pair.dt`.
    fn force(&self, pair: &Pair<V>, memory: &mut Memory<V>) -> PairForce<V>;

    /// Returns the force on i, averaged over the step centred on the evaluation, and advances the memory by `pair.dt`.
    /// `pair.overlap` may be a gap, negative, of up to the half-width of the [`Window`](centred::Window). The velocities
    /// of `pair` are those of the middle of the step.
    fn centred(&self, pair: &Pair<V>, memory: &mut Memory<V>) -> PairForce<V> {
        if pair.overlap > 0.0 { self.force(&pair.predicted(), memory) } else { PairForce::default() }
    }

    /// Returns the overlap, in half-widths of the window, from which [`PairLaw::force`] with predicted velocities replaces
    /// [`PairLaw::centred`].
    fn even_from(&self) -> f64 {
        3.0
    }

    /// Whether the law depends on the species of a pair. Asked only of a law that requires species.
    fn depends_on_species(&self) -> bool {
        true
    }

    /// Calls `visitor` with the law of contacts between these species: with the law itself if it is the same for all species.
    #[inline]
    fn between<W: LawVisitor<V>>(&self, _species: [Species; 2], visitor: W) -> W::Output
    where
        Self: LawRequirements + Sized,
    {
        visitor.visit(self)
    }

    /// Returns the energy stored in a contact, J.
    fn elastic_energy(&self, pair: &Pair<V>, memory: &Memory<V>) -> f64;

    /// Returns the energies lost with the tangential and the rolling spring of a contact that has ended in this step,
    /// J. Not called for a contact whose memory is empty. The overlap of `pair` is negative. The lost energy is
    /// k S/2 . (S + v dt): the stored energy, and the energy k S/2 . v dt that the spring takes from the motion in the last
    /// step ([`spring`]).
    fn on_contact_end(&self, _pair: &Pair<V>, _memory: &Memory<V>) -> [f64; 2] {
        [0.0, 0.0]
    }

    /// Returns the range of a contact beyond touch, m: a contact with this memory exists while its overlap is greater than
    /// minus the range. A contact that does not exist has no range.
    fn range(&self, _pair: &Pair<V>, _memory: &Memory<V>) -> f64 {
        0.0
    }

    /// Returns the range of a contact beyond touch at a reduced radius (m), for estimates and searches, m.
    fn range_at(&self, _reduced_radius: f64) -> f64 {
        0.0
    }

    /// Returns the energy that the normal force loses where a contact beyond touch breaks, J. `pair` is that of the end of
    /// the step.
    fn lost_at_break(&self, _pair: &Pair<V>, _memory: &Memory<V>) -> f64 {
        0.0
    }

    /// Returns the adhesive pull in the normal force, N. Friction is capped with the normal force without it.
    fn pull(&self, _pair: &Pair<V>) -> f64 {
        0.0
    }

    /// Whether the law reads [`Pair::root`]. Computing the root takes time.
    fn needs_mass_root(&self) -> bool {
        false
    }

    /// Returns the largest friction coefficient, for views and pictures; 0 without friction.
    fn friction(&self, _pair: &Pair<V>) -> f64 {
        0.0
    }

    /// Returns the normal stiffness at the deepest point of a bounce, N/m. Estimates of time step and overlap use it.
    fn stiffness(&self, bounce: &Bounce) -> f64;

    /// Returns the normal drag coefficient c at the deepest point of a bounce, N s/m, for estimates.
    fn damping(&self, bounce: &Bounce) -> f64;

    /// Returns the largest overlap of an undamped bounce, m.
    fn deepest(&self, bounce: &Bounce) -> f64 {
        bounce.speed / self.frequency(bounce)
    }

    /// Returns the contact duration, s, for estimates; infinite if the contact never ends.
    fn contact_duration(&self, bounce: &Bounce) -> f64;

    /// Returns the restitution of a head-on bounce, for reports.
    fn restitution(&self, bounce: &Bounce) -> f64;

    /// Returns stiffness (N/m) and drag coefficient (N s/m) of the four modes in which a contact can oscillate: along
    /// the normal, along the tangent, in rolling, in twisting. The effective masses of the last three depend on the pair and are not
    /// included.
    fn modes(&self, bounce: &Bounce) -> [[f64; 2]; 4] {
        [[self.stiffness(bounce), self.damping(bounce)], [0.0; 2], [0.0; 2], [0.0; 2]]
    }

    /// Returns w0 = sqrt(k/m_eff), 1/s.
    fn frequency(&self, bounce: &Bounce) -> f64 {
        (self.stiffness(bounce) / bounce.reduced_mass).sqrt()
    }

    /// Returns zeta = c/(2 sqrt(k m_eff)).
    fn damping_ratio(&self, bounce: &Bounce) -> f64 {
        self.damping(bounce) / (2.0 * (self.stiffness(bounce) * bounce.reduced_mass).sqrt())
    }
}

/// A head-on bounce, for estimates. Stiffness and damping of nonlinear laws depend on size and speed.
#[derive(Clone, Copy, Debug)]
pub struct Bounce {
    /// m_i m_j/(m_i + m_j), kg.
    pub reduced_mass: f64,
    /// R_i R_j/(R_i + R_j), m.
    pub reduced_radius: f64,
    /// Speed of approach, m/s.
    pub speed: f64,
}

/// Law requirements: the data that a law needs from the kernel. The kernel does not compute other data.
pub trait LawRequirements {
    /// Spins and torques.
    const SPIN: bool = false;
    /// Species of both particles.
    const SPECIES: bool = false;
    /// [`Pair::radii`]. Required by default; a law that does not read radii sets it to `false`.
    const RADII: bool = true;
    /// [`Memory::spring`].
    const SPRING: bool = false;
    /// [`Memory::rolling`].
    const ROLLING: bool = false;
    /// [`Memory::twist`]. Only together with [`Self::ROLLING`].
    const TWISTING: bool = false;
    /// [`Memory::stiffness`]: the tangential stiffness, or a number of the law's own.
    const STIFFNESS: bool = false;
    /// Whether the normal force has an adhesive pull, [`PairLaw::pull`].
    const PULLS: bool = false;
    /// Whether contacts may exist beyond touch, [`PairLaw::range`]. A contact then exists if its [`Memory::stiffness`] is not
    /// zero, so that the law needs [`Self::STIFFNESS`].
    const REACHES: bool = false;
    /// Whether the kernel needs radius and mass of each particle, not only the sums for the pair.
    const INDIVIDUAL_BODIES: bool = Self::RADII || Self::SPIN;
    /// Whether contacts have a memory.
    const MEMORY: bool = Self::SPRING || Self::ROLLING || Self::STIFFNESS;
}

/// The contact law of the scene as a trait object, for code that is not performance-critical: surveys, estimates,
/// reports.
#[derive(Resource, Clone)]
pub struct AnyLaw<V: Space = Plane>(pub Arc<dyn PairLaw<V>>);

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::space::Vector;

    /// Returns two equal grains of radius 4 cm that touch along x, at rest.
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
            lead: 0.0,
            gathered: None,
            ahead: VelocityPrediction::default(),
        }
    }
}
