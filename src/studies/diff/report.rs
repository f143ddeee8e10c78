//! The report on the first difference of two runs, as text and as JSON.

use std::fmt;

use serde::{Serialize, Serializer};

use siloflow_dem::outcome::End;
use siloflow_dem::particle::GrainId;
use siloflow_dem::space::Linear;

/// The first difference of two runs.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Divergence {
    /// Step after which the difference exists.
    pub step: u64,
    /// Simulated time after this step, s.
    pub time_s: f64,
    /// The difference.
    #[serde(flatten)]
    pub difference: Difference,
}

/// A difference of two states.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum Difference {
    /// A quantity of a particle differs.
    Particle {
        /// The particle.
        #[serde(serialize_with = "as_text")]
        particle: GrainId,
        /// The quantity.
        quantity: Quantity,
        /// Values in the first and in the second run.
        ///
        /// For [`Quantity::Presence`] the value is the position, or `None` in the run without the particle.
        values: [Option<Value>; 2],
        /// Number of particles that differ in any quantity.
        particles: usize,
    },
    /// The state of a site of a lattice gas differs.
    Site {
        /// Position of the site, m.
        place: Value,
        /// States in the first and in the second run. Bit i is set for a particle with velocity i.
        values: [u16; 2],
        /// Number of sites that differ.
        sites: usize,
    },
    /// The states are equal, but only one run has ended, or the runs ended differently.
    End {
        /// Ends of the first and of the second run; `None` if a run has not ended.
        ends: [Option<End>; 2],
    },
}

/// A quantity of a particle. The variants are in the order in which a step computes them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Quantity {
    /// Whether the particle exists.
    Presence,
    /// Radius, m.
    Radius,
    /// Mass, kg.
    Mass,
    /// Position of the centre, m.
    Position,
    /// Force, N.
    Force,
    /// Torque, N m.
    Torque,
    /// Velocity, m/s.
    Velocity,
    /// Spin, rad/s.
    Spin,
}

impl Quantity {
    /// Returns the name of the quantity.
    #[must_use]
    pub fn name(self) -> &'static str {
        self.name_and_unit().0
    }

    /// Returns the unit of the quantity.
    #[must_use]
    pub fn unit(self) -> &'static str {
        self.name_and_unit().1
    }

    fn name_and_unit(self) -> (&'static str, &'static str) {
        match self {
            Self::Presence => ("presence", "m"),
            Self::Radius => ("radius", "m"),
            Self::Mass => ("mass", "kg"),
            Self::Position => ("position", "m"),
            Self::Force => ("force", "N"),
            Self::Torque => ("torque", "N m"),
            Self::Velocity => ("velocity", "m/s"),
            Self::Spin => ("spin", "rad/s"),
        }
    }
}

/// A number or a vector. Two values are equal if all bits are equal.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Value {
    bits: [u64; 3],
    count: usize,
}

impl Value {
    /// Returns the value of a vector, a spin or a number.
    #[must_use]
    pub fn of<L: Linear>(vector: L) -> Self {
        let bits = |axis| if axis < L::COUNT { vector.component(axis).to_bits() } else { 0 };
        Self { bits: std::array::from_fn(bits), count: L::COUNT }
    }

    /// Iterates over the components.
    pub fn components(&self) -> impl Iterator<Item = f64> {
        self.bits[..self.count].iter().map(|bits| f64::from_bits(*bits))
    }
}

impl fmt::Display for Value {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        // `Debug` prints enough digits to distinguish a number from its neighbours.
        let numbers: Vec<_> = self.components().map(|number| format!("{number:?}")).collect();
        if self.count == 1 { f.write_str(&numbers[0]) } else { write!(f, "({})", numbers.join(", ")) }
    }
}

impl Serialize for Value {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_seq(self.components())
    }
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde passes a reference")]
fn as_text<S: Serializer>(particle: &GrainId, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_str(particle)
}

impl fmt::Display for Divergence {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { step, time_s, difference } = self;
        write!(f, "step {step}, t = {time_s} s: ")?;
        match difference {
            Difference::Particle { particle, quantity: Quantity::Presence, values, particles } => {
                writeln!(f, "{particle} exists in one run only (position, m)")?;
                both(f, values.map(|value| value.map_or("absent".to_owned(), |value| value.to_string())))?;
                count(f, *particles, "particle")
            }
            Difference::Particle { particle, quantity, values, particles } => {
                writeln!(f, "the {} of {particle} ({})", quantity.name(), quantity.unit())?;
                both(f, values.map(|value| value.map_or("none".to_owned(), |value| value.to_string())))?;
                count(f, *particles, "particle")
            }
            Difference::Site { place, values, sites } => {
                writeln!(
                    f,
                    "the state of the site at {place} m (a bit for each of 13 velocities, the last one first)"
                )?;
                both(f, values.map(|state| format!("{state:013b}")))?;
                count(f, *sites, "site")
            }
            Difference::End { ends } => {
                writeln!(f, "the states are the same, but the runs end differently")?;
                both(f, ends.each_ref().map(|end| describe(end.as_ref())))
            }
        }
    }
}

fn both(f: &mut fmt::Formatter<'_>, [first, second]: [String; 2]) -> fmt::Result {
    write!(f, "  first   {first}\n  second  {second}")
}

fn count(f: &mut fmt::Formatter<'_>, count: usize, noun: &str) -> fmt::Result {
    let (plural, verb) = if count == 1 { ("", "differs") } else { ("s", "differ") };
    write!(f, "\n{count} {noun}{plural} {verb} after this step")
}

fn describe(end: Option<&End>) -> String {
    match end {
        None => "goes on".to_owned(),
        Some(End::Failed(failure)) => format!("failed: {failure}"),
        Some(end) => end.word().to_owned(),
    }
}
