//! Law requirements as values, and the classes of the contact pass.
//!
//! The contact pass calls the law once for a batch of contacts. So only the loop over the lanes of a batch is compiled for each law
//! ([`BatchLaw`]). The other loops of a pass depend on the loads that contacts exert, and are compiled for three classes of laws: [`Forces`],
//! [`Torques`] and [`RollingTorques`]. The remaining requirements are values ([`Needs`]), which the pass looks up once for a batch.

use crate::contact::batch::{Batch, Call, EventStep};
use crate::contact::{LawRequirements, LawVisitor, MemoryTimes, PairLaw};
use crate::particle::Species;
use crate::space::Space;
use crate::store::{TOTAL, TOTAL_AND_DISSIPATIVE};

/// The components of a [`Memory`](crate::contact::Memory) that a law requires.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[expect(clippy::struct_excessive_bools, reason = "one for each component")]
pub struct MemoryParts {
    /// [`LawRequirements::SPRING`].
    pub spring: bool,
    /// [`LawRequirements::ROLLING`].
    pub rolling: bool,
    /// [`LawRequirements::TWISTING`].
    pub twist: bool,
    /// [`LawRequirements::STIFFNESS`].
    pub stiffness: bool,
}

impl MemoryParts {
    /// Returns the components that the law `L` requires.
    #[must_use]
    pub const fn of<L: LawRequirements>() -> Self {
        Self { spring: L::SPRING, rolling: L::ROLLING, twist: L::TWISTING, stiffness: L::STIFFNESS }
    }
}

/// The numbers of the two bodies of a pair that the kernel loads.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BodyNumbers {
    /// The sums of radii and of inverse masses.
    Sums,
    /// Radius and mass of each body.
    Each,
    /// Radius and mass of each body; the law reads radii.
    EachWithRadii,
}

/// The loads that contacts exert.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Class {
    /// Forces.
    Forces,
    /// Forces, and torques of friction.
    Torques,
    /// Forces, torques of friction, and torques of rolling resistance.
    RollingTorques,
}

/// [`LawRequirements`] as values.
#[derive(Clone, Copy, Debug)]
pub struct Needs {
    /// The loads that contacts exert.
    pub class: Class,
    /// Components of the memory; `None` if contacts have none.
    pub memory: Option<MemoryParts>,
    /// Numbers of the bodies.
    pub bodies: BodyNumbers,
    /// Whether the law depends on the species of a pair.
    pub species: bool,
    /// Whether contacts may exist beyond touch.
    pub reaches: bool,
}

/// A law as the contact pass calls it.
pub trait BatchLaw<V: Space>: PairLaw<V> {
    /// Returns the requirements of the law.
    fn needs(&self) -> Needs;

    /// Evaluates the law for all contacts of a batch, with the numbers that only the energy balance needs if `tracks_energy`. Returns
    /// what [`Batch::evaluate`] returns.
    fn evaluate(&self, batch: &mut Batch<V>, call: &Call, tracks_energy: bool) -> (u64, u64);

    /// Evaluates the law anew for the contacts near an event, `near` (bits of lanes).
    fn evaluate_events(&self, batch: &mut Batch<V>, times: MemoryTimes, step: &EventStep<V>, near: u64);
}

impl<V: Space, L: PairLaw<V> + LawRequirements> BatchLaw<V> for L {
    fn needs(&self) -> Needs {
        Needs {
            class: match (L::SPIN, L::ROLLING) {
                (false, _) => Class::Forces,
                (true, false) => Class::Torques,
                (true, true) => Class::RollingTorques,
            },
            memory: L::MEMORY.then_some(MemoryParts::of::<L>()),
            bodies: match (L::RADII, L::INDIVIDUAL_BODIES) {
                (true, _) => BodyNumbers::EachWithRadii,
                (false, true) => BodyNumbers::Each,
                (false, false) => BodyNumbers::Sums,
            },
            species: L::SPECIES && self.depends_on_species(),
            reaches: L::REACHES,
        }
    }

    fn evaluate(&self, batch: &mut Batch<V>, call: &Call, tracks_energy: bool) -> (u64, u64) {
        if tracks_energy {
            batch.evaluate::<L, TOTAL_AND_DISSIPATIVE>(self, call)
        } else {
            batch.evaluate::<L, TOTAL>(self, call)
        }
    }

    fn evaluate_events(&self, batch: &mut Batch<V>, times: MemoryTimes, step: &EventStep<V>, near: u64) {
        let events = Events { batch, times, step, near };
        if L::SPECIES && self.depends_on_species() {
            events.visit(self);
        } else {
            self.between([Species(0); 2], events);
        }
    }
}

/// Arguments of [`Batch::evaluate_events`].
struct Events<'a, V: Space> {
    batch: &'a mut Batch<V>,
    times: MemoryTimes,
    step: &'a EventStep<'a, V>,
    near: u64,
}

impl<V: Space> LawVisitor<V> for Events<'_, V> {
    type Output = ();

    fn visit<L: PairLaw<V> + LawRequirements>(self, law: &L) {
        self.batch.evaluate_events(law, self.times, self.step, self.near);
    }
}

/// The requirements of any law of [`Class::Forces`].
pub(crate) struct Forces;

impl LawRequirements for Forces {
    const SPECIES: bool = true;
}

/// The requirements of any law of [`Class::Torques`].
pub(crate) struct Torques;

impl LawRequirements for Torques {
    const SPIN: bool = true;
    const SPECIES: bool = true;
}

/// The requirements of any law of [`Class::RollingTorques`].
pub(crate) struct RollingTorques;

impl LawRequirements for RollingTorques {
    const SPIN: bool = true;
    const SPECIES: bool = true;
    const ROLLING: bool = true;
}
