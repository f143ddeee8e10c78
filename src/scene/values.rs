//! Numbers that carry their own range: a scene with a value outside cannot be built.

use serde::{Deserialize, Serialize};

use crate::space::{DIMENSION, Vector};

macro_rules! checked_number {
    ($(#[$doc:meta])* $name:ident, $expected:literal, $holds:expr) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq, PartialOrd, Deserialize, Serialize)]
        #[serde(try_from = "f64", into = "f64")]
        pub struct $name(f64);

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
    /// A share: from 0 to 1.
    Share, "a share from 0 to 1", |s| (0.0..=1.0).contains(&s)
);

/// A finite vector.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
#[serde(try_from = "(f64, f64)", into = "(f64, f64)")]
pub struct FiniteVector(Vector);

impl FiniteVector {
    /// The vector.
    #[must_use]
    pub fn get(self) -> Vector {
        self.0
    }
}

impl TryFrom<(f64, f64)> for FiniteVector {
    type Error = String;

    fn try_from((x, y): (f64, f64)) -> Result<Self, String> {
        let v = Vector::new(x, y);
        if v.is_finite() { Ok(Self(v)) } else { Err(format!("expected {DIMENSION} finite numbers, got ({x}, {y})")) }
    }
}

impl From<FiniteVector> for (f64, f64) {
    fn from(v: FiniteVector) -> Self {
        (v.0.x, v.0.y)
    }
}
