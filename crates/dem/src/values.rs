//! Numbers whose type enforces their range: a scene with a value out of range cannot be constructed.

use std::fmt;

use serde::de::{Error as _, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize};

use crate::space::{Dimension, Solid, Space, Vector};

macro_rules! checked_number {
    ($(#[$doc:meta])* $name:ident, $expected:literal, $holds:expr) => {
        $(#[$doc])*
        #[derive(Clone, Copy, PartialEq, PartialOrd, Deserialize, Serialize)]
        #[serde(try_from = "f64", into = "f64")]
        pub struct $name(f64);

        /// Prints the number alone, so that a printed scene reads like a written one.
        impl fmt::Debug for $name {
            fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                self.0.fmt(f)
            }
        }

        impl $name {
            /// The number.
            #[must_use]
            pub fn get(self) -> f64 {
                self.0
            }
        }

        impl TryFrom<f64> for $name {
            type Error = String;

            fn try_from(value: f64) -> Result<Self, String> {
                let holds: fn(f64) -> bool = $holds;
                if value.is_finite() && holds(value) {
                    Ok(Self(value))
                } else {
                    Err(format!(concat!("expected ", $expected, ", got {}"), value))
                }
            }
        }

        impl From<$name> for f64 {
            fn from(value: $name) -> f64 {
                value.0
            }
        }
    };
}

checked_number!(
    /// A finite number greater than zero.
    Positive, "a number greater than 0", |x| x > 0.0
);
checked_number!(
    /// A finite number, zero or greater.
    NonNegative, "a number of at least 0", |x| x >= 0.0
);
checked_number!(
    /// A finite number.
    Finite, "a finite number", |_| true
);
checked_number!(
    /// A coefficient of restitution: greater than 0, at most 1.
    Restitution, "a coefficient of restitution greater than 0 and at most 1", |e| e > 0.0 && e <= 1.0
);
checked_number!(
    /// Poisson's ratio: greater than -1, at most 0.5.
    PoissonRatio, "a Poisson's ratio greater than -1 and at most 0.5", |nu| nu > -1.0 && nu <= 0.5
);
checked_number!(
    /// The error of an impact, in units of its speed: from 1e-9 to 0.1.
    ImpactError, "an error of impacts from 1e-9 to 0.1", |e| (1e-9..=0.1).contains(&e)
);
checked_number!(
    /// A share: from 0 to 1.
    Share, "a share from 0 to 1", |s| (0.0..=1.0).contains(&s)
);

impl NonNegative {
    /// Zero.
    pub(crate) const ZERO: Self = Self(0.0);
}

/// A unit of length.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
pub enum LengthUnit {
    /// 1 m.
    Metre,
    /// 0.01 m.
    Centimetre,
    /// 0.001 m.
    Millimetre,
}

impl LengthUnit {
    /// Returns the number of units per metre. Division by a whole number rounds once, so that 400 cm is exactly 4 m.
    pub(crate) fn per_metre(self) -> f64 {
        match self {
            Self::Metre => 1.0,
            Self::Centimetre => 100.0,
            Self::Millimetre => 1000.0,
        }
    }
}

/// A finite vector of two or three components, as many as the scene's `space` has.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
#[serde(try_from = "Components", into = "Components")]
pub struct FiniteVector {
    padded: Solid,
    count: usize,
}

/// A vector as a scene writes it.
#[derive(Clone, Copy, Debug, Serialize)]
#[serde(untagged)]
enum Components {
    Two(f64, f64),
    Three(f64, f64, f64),
}

impl<'de> Deserialize<'de> for Components {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(ComponentsVisitor)
    }
}

struct ComponentsVisitor;

impl<'de> Visitor<'de> for ComponentsVisitor {
    type Value = Components;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a vector (x, y), or (x, y, z) in solid space")
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut sequence: A) -> Result<Components, A::Error> {
        let missing = |count: usize| A::Error::invalid_length(count, &self);
        let x = sequence.next_element()?.ok_or_else(|| missing(0))?;
        let y = sequence.next_element()?.ok_or_else(|| missing(1))?;
        Ok(match sequence.next_element()? {
            None => Components::Two(x, y),
            Some(z) => Components::Three(x, y, z),
        })
    }
}

impl FiniteVector {
    /// The vector in the space `V`.
    #[must_use]
    pub fn get<V: Space>(self) -> V {
        debug_assert_eq!(self.count, V::COMPONENTS, "scene::rules has compared every vector with the space");
        V::narrow(self.padded)
    }

    /// The vector with three components; a missing one is 0.
    #[must_use]
    pub fn padded(self) -> Solid {
        self.padded
    }

    /// The vector of a scene in this space with these components; `None` if one of them is not finite.
    #[must_use]
    pub fn of(padded: Solid, space: Dimension) -> Option<Self> {
        padded.is_finite().then(|| Self { padded, count: space.count() })
    }

    /// Number of components given.
    #[must_use]
    pub fn count(self) -> usize {
        self.count
    }
}

impl TryFrom<Components> for FiniteVector {
    type Error = String;

    fn try_from(components: Components) -> Result<Self, String> {
        let (padded, count) = match components {
            Components::Two(x, y) => (Solid::new(x, y, 0.0), 2),
            Components::Three(x, y, z) => (Solid::new(x, y, z), 3),
        };
        if padded.is_finite() {
            Ok(Self { padded, count })
        } else {
            Err(format!("expected {count} finite numbers, got {:?}", &padded.to_array()[..count]))
        }
    }
}

impl From<FiniteVector> for Components {
    fn from(v: FiniteVector) -> Self {
        let Solid { x, y, z } = v.padded;
        if v.count == 2 { Self::Two(x, y) } else { Self::Three(x, y, z) }
    }
}

impl From<Vector> for FiniteVector {
    fn from(v: Vector) -> Self {
        Self { padded: v.extend(0.0), count: 2 }
    }
}
