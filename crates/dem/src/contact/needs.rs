//! Law requirements as values, and the classes of laws for which the loops of the force pass are compiled.
//!
//! The loops of the pass around the law depend on the torques that contacts exert, and are compiled for three classes of laws:
//! [`NoTorques`], [`FrictionTorques`] and [`RollingTorques`]. The remaining requirements are values ([`Needs`]), which the pass looks up
//! once for a batch.

use crate::contact::law::{LawRequirements, memory_layout};
use crate::contact::memory::MemoryLayout;
use crate::space::Space;

/// The numbers of the two bodies of a pair that the force pass loads.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BodyNumbers {
    /// The sums of radii and of inverse masses.
    Sums,
    /// Radius and mass of each body.
    Each,
    /// Radius and mass of each body; the law reads radii.
    EachWithRadii,
}

/// The torques that contacts exert.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TorqueClass {
    /// None.
    None,
    /// Torques of friction.
    Friction,
    /// Torques of friction, and of rolling or twisting resistance.
    Rolling,
}

/// [`LawRequirements`] as values.
#[derive(Clone, Copy, Debug)]
pub struct Needs {
    /// The torques that contacts exert.
    pub torques: TorqueClass,
    /// Layout of the memory; `None` if contacts have none.
    pub memory: Option<MemoryLayout>,
    /// Numbers of the bodies.
    pub bodies: BodyNumbers,
    /// Whether the law depends on the species of a pair.
    pub species: bool,
    /// Whether contacts may exist beyond touch.
    pub reaches: bool,
}

impl Needs {
    /// Returns the requirements of the law `L`. `depends_on_species` states whether it depends on the species of a pair, if it requires
    /// them.
    #[must_use]
    pub fn of<L: LawRequirements, V: Space>(depends_on_species: bool) -> Self {
        Self {
            torques: match (L::SPIN, L::ROLLING) {
                (false, _) => TorqueClass::None,
                (true, false) => TorqueClass::Friction,
                (true, true) => TorqueClass::Rolling,
            },
            memory: if L::REMEMBERS { Some(const { memory_layout::<L, V>() }) } else { None },
            bodies: match (L::RADII, L::INDIVIDUAL_BODIES) {
                (true, _) => BodyNumbers::EachWithRadii,
                (false, true) => BodyNumbers::Each,
                (false, false) => BodyNumbers::Sums,
            },
            species: L::SPECIES && depends_on_species,
            reaches: L::REACHES,
        }
    }
}

/// The requirements of any law of [`TorqueClass::None`].
pub(crate) struct NoTorques;

impl LawRequirements for NoTorques {
    const SPECIES: bool = true;
}

/// The requirements of any law of [`TorqueClass::Friction`].
pub(crate) struct FrictionTorques;

impl LawRequirements for FrictionTorques {
    const SPIN: bool = true;
    const SPECIES: bool = true;
}

/// The requirements of any law of [`TorqueClass::Rolling`].
pub(crate) struct RollingTorques;

impl LawRequirements for RollingTorques {
    const SPIN: bool = true;
    const SPECIES: bool = true;
    const ROLLING: bool = true;
}
