//! Loads on free walls: constant, or straight lines between times.

use serde::{Deserialize, Serialize};

use crate::values::Finite;

/// The load on a free wall: a force along the direction, N, or for a hinge a torque, N m.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(untagged)]
pub enum Load {
    /// The same at all times, N or N m.
    Constant(Finite),
    /// Pairs of a time and a load, s and N or N m. Between two rows the load follows a straight line, before the first and after the last one it is theirs.
    Table(Vec<(Finite, Finite)>),
}

impl Load {
    /// The load at a time, s.
    #[must_use]
    pub fn at(&self, time: f64) -> f64 {
        let rows = match self {
            Self::Constant(load) => return load.get(),
            Self::Table(rows) => rows,
        };
        let next = rows.partition_point(|row| row.0.get() <= time);
        match (next.checked_sub(1).and_then(|last| rows.get(last)), rows.get(next)) {
            (Some(last), Some(next)) => {
                let share = (time - last.0.get()) / (next.0.get() - last.0.get());
                last.1.get() + share * (next.1.get() - last.1.get())
            }
            (Some(end), None) | (None, Some(end)) => end.1.get(),
            (None, None) => 0.0,
        }
    }

    /// The largest absolute load.
    #[must_use]
    pub fn largest(&self) -> f64 {
        match self {
            Self::Constant(load) => load.get().abs(),
            Self::Table(rows) => rows.iter().map(|row| row.1.get().abs()).fold(0.0, f64::max),
        }
    }

    /// Whether there is a row, and times ascend.
    #[must_use]
    pub fn is_ordered(&self) -> bool {
        match self {
            Self::Constant(_) => true,
            Self::Table(rows) => !rows.is_empty() && rows.windows(2).all(|pair| pair[0].0.get() < pair[1].0.get()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_table_is_joined_by_straight_lines() {
        let load: Load = ron::from_str("[(1.0, -100.0), (2.0, -300.0), (2.5, 0.0)]").unwrap();
        let expected =
            [(0.0, -100.0), (1.0, -100.0), (1.25, -150.0), (2.0, -300.0), (2.25, -150.0), (2.5, 0.0), (9.0, 0.0)];
        for (time, force) in expected {
            assert!((load.at(time) - force).abs() < 1e-12, "{time}: {}", load.at(time));
        }
        assert!(load.is_ordered() && load.largest().to_bits() == 300.0_f64.to_bits());
        let constant: Load = ron::from_str("-5").unwrap();
        assert!(constant.at(3.0).to_bits() == (-5.0_f64).to_bits() && constant.is_ordered());
        for wrong in ["[]", "[(1.0, 2.0), (1.0, 3.0)]", "[(2.0, 2.0), (1.0, 3.0)]"] {
            assert!(!ron::from_str::<Load>(wrong).unwrap().is_ordered(), "{wrong}");
        }
    }
}
