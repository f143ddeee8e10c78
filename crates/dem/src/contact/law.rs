//! Contact laws: the trait that every law implements, the data that a law needs, and a head-on bounce for estimates.

use crate::contact::memory::{Memory, MemoryLayout, MemoryVariable};
use crate::contact::pair::Pair;
use crate::contact::pair_force::PairForce;
use crate::particle::Species;
use crate::space::{Plane, Space};

/// A computation that is compiled for the type of a law. [`PairLaw::between`] runs it.
pub trait LawComputation<V: Space> {
    /// The result.
    type Output;

    /// Computes the result with `law`.
    fn run<L: PairLaw<V> + LawRequirements>(self, law: &L) -> Self::Output;
}

/// A contact law. Exchanging i and j reverses the normal and the relative velocity, swaps the two entries of each
/// array in `pair`, and changes the sign of the odd variables of the memory. The force must then change its sign, to the last bit.
pub trait PairLaw<V: Space = Plane>: Send + Sync + 'static {
    /// Returns the force on i and advances the memory by `pair.dt`. The contact exists: the bodies overlap, or the law reaches
    /// beyond touch and the contact is within its range.
    fn force(&self, pair: &Pair<V>, memory: &mut Memory) -> PairForce<V>;

    /// Returns the force on i, averaged over the step centred on the evaluation, and advances the memory by `pair.dt`.
    /// `pair.overlap` may be a gap, negative, of up to the half-width of the [`Window`](crate::contact::centred::window::Window), beyond the
    /// range of the law. The velocities of `pair` are those of the middle of the step.
    fn centred(&self, pair: &Pair<V>, memory: &mut Memory) -> PairForce<V> {
        if pair.overlap + self.range_of(pair, memory) > 0.0 {
            self.force(&pair.predicted(), memory)
        } else {
            PairForce::default()
        }
    }

    /// Returns the smallest overlap, in half-widths of the window, at which a contact cannot open or close within the step. The
    /// scheme `Centred` takes [`PairLaw::force`] with predicted velocities from this overlap on, and [`PairLaw::centred`] below it.
    fn overlap_without_events(&self) -> f64 {
        3.0
    }

    /// Whether the law depends on the species of a pair. Asked only of a law that requires species.
    fn depends_on_species(&self) -> bool {
        true
    }

    /// Runs a computation with the law of contacts between these species: with the law itself if it is the same for all species.
    #[inline]
    fn between<C: LawComputation<V>>(&self, _species: [Species; 2], computation: C) -> C::Output
    where
        Self: LawRequirements + Sized,
    {
        computation.run(self)
    }

    /// Returns the energy stored in a contact, J.
    fn elastic_energy(&self, pair: &Pair<V>, memory: &Memory) -> f64;

    /// Returns the energies lost with the tangential and the rolling spring of a contact that has ended in this step,
    /// J. Not called for a contact whose memory is empty. The overlap of `pair` is negative. The lost energy is
    /// k S/2 . (S + v dt): the stored energy, and the energy k S/2 . v dt that the spring takes from the motion in the last
    /// step ([`spring`](crate::contact::spring)).
    fn on_contact_end(&self, _pair: &Pair<V>, _memory: &Memory) -> [f64; 2] {
        [0.0, 0.0]
    }

    /// Returns the range of a contact beyond touch, m: a contact that begins at touch exists while its overlap is greater than
    /// minus the range. Asked only of a law that reaches beyond touch.
    #[inline(always)]
    fn range(&self, pair: &Pair<V>) -> f64 {
        self.largest_range(pair.reduced_radius())
    }

    /// Returns the largest range of a contact beyond touch at a reduced radius (m) between any two species, m. The search for neighbours
    /// reaches as far.
    fn largest_range(&self, _reduced_radius: f64) -> f64 {
        0.0
    }

    /// Returns the range of a contact with this memory, m: 0 if it has not existed before.
    #[inline(always)]
    fn range_of(&self, pair: &Pair<V>, memory: &Memory) -> f64 {
        if memory.exists { self.range(pair) } else { 0.0 }
    }

    /// Returns the energy that the normal force loses where a contact beyond touch breaks, J. `pair` is that of the end of
    /// the step.
    fn lost_at_break(&self, _pair: &Pair<V>) -> f64 {
        0.0
    }

    /// Returns the adhesive pull in the normal force, N. Friction is capped with the normal force without it.
    fn pull(&self, _pair: &Pair<V>) -> f64 {
        0.0
    }

    /// Whether the law reads [`Pair::mass_root`]. Computing the root takes time.
    fn needs_mass_root(&self) -> bool {
        false
    }

    /// Returns the largest friction coefficient, for views and pictures; 0 without friction.
    fn friction(&self, _pair: &Pair<V>) -> f64 {
        0.0
    }

    /// Returns the normal stiffness at the deepest point of a bounce, N/m. Estimates of time step and overlap use it.
    fn stiffness(&self, bounce: &Bounce) -> f64;

    /// Returns the normal dashpot coefficient c at the deepest point of a bounce, N s/m, for estimates.
    fn damping(&self, bounce: &Bounce) -> f64;

    /// Returns the largest overlap of an undamped bounce, m.
    fn deepest(&self, bounce: &Bounce) -> f64 {
        bounce.speed / self.frequency(bounce)
    }

    /// Returns the contact duration, s, for estimates; infinite if the contact never ends.
    fn contact_duration(&self, bounce: &Bounce) -> f64;

    /// Returns the restitution of a head-on bounce, for reports.
    fn restitution(&self, bounce: &Bounce) -> f64;

    /// Returns stiffness (N/m) and dashpot coefficient (N s/m) of the four modes in which a contact can oscillate: along
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

/// Law requirements: the data that a law needs from the force pass. The pass does not compute other data.
pub trait LawRequirements {
    /// Spins and torques.
    const SPIN: bool = false;
    /// Torques of rolling or twisting resistance, [`Resistance::rolling`](crate::contact::pair_force::Resistance::rolling). Only
    /// together with [`Self::SPIN`].
    const ROLLING: bool = false;
    /// Species of both particles.
    const SPECIES: bool = false;
    /// [`Pair::radii`]. Required by default; a law that does not read radii sets it to `false`.
    const RADII: bool = true;
    /// The variables that the law remembers of a contact: the numbers of [`Memory::numbers`], in this order.
    const MEMORY: &'static [MemoryVariable] = &[];
    /// Whether the normal force has an adhesive pull, [`PairLaw::pull`].
    const PULLS: bool = false;
    /// Whether contacts may exist beyond touch, [`PairLaw::range`].
    const REACHES: bool = false;
    /// Whether the force pass needs radius and mass of each particle, not only the sums for the pair.
    const INDIVIDUAL_BODIES: bool = Self::RADII || Self::SPIN;
    /// Whether contacts have a memory.
    const REMEMBERS: bool = Self::REACHES || has_kept(Self::MEMORY);
}

/// Returns whether a law keeps any of these variables.
const fn has_kept(variables: &[MemoryVariable]) -> bool {
    let mut next = 0;
    while next < variables.len() {
        if variables[next].is_kept {
            return true;
        }
        next += 1;
    }
    false
}

/// Returns the layout of the memories of the law `L`.
#[must_use]
pub const fn memory_layout<L: LawRequirements, V: Space>() -> MemoryLayout {
    MemoryLayout::new::<V>(L::MEMORY, L::REACHES)
}
