//! The keys `hole` and `patch` of walls: a circle or a rectangle that cuts a wall.

use serde::{Deserialize, Serialize};

use crate::space::Space;
use crate::values::{FiniteVector, Positive};
use crate::walls::shapes::prism::Prism;
use crate::walls::shapes::whole::Whole;

/// The outline of a hole or patch. It cuts the wall that it meets when it moves along its normal.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub enum Cut {
    /// A circle.
    Circle {
        /// Centre, m.
        centre: FiniteVector,
        /// Radius, m.
        radius: Positive,
        /// Direction of its normal, of any non-zero length. Default: the normal of the wall at its point nearest to the centre, or its
        /// axis if the centre is on it.
        #[serde(default)]
        normal: Option<FiniteVector>,
    },
    /// A rectangle.
    Rectangle {
        /// Centre, m.
        centre: FiniteVector,
        /// Edge vector, m.
        along: FiniteVector,
        /// Other edge vector, m, at right angles to `along`.
        across: FiniteVector,
    },
}

impl Cut {
    /// Returns the prism that cuts a surface. `vector` converts the vectors of the scene.
    pub(in crate::walls) fn prism<V: Space>(&self, whole: &Whole<V>, vector: impl Fn(FiniteVector) -> V) -> Prism<V> {
        match *self {
            Self::Circle { centre, radius, normal } => {
                let centre = vector(centre);
                let of_wall = || whole.outwards(centre);
                Prism::circle(centre, normal.map_or_else(of_wall, vector), radius.get())
            }
            Self::Rectangle { centre, along, across } => {
                Prism::rectangle(vector(centre), vector(along), vector(across))
            }
        }
    }

    /// Returns the smaller width, m.
    #[must_use]
    pub fn width(&self) -> f64 {
        match self {
            Self::Circle { radius, .. } => 2.0 * radius.get(),
            Self::Rectangle { along, across, .. } => along.padded().length().min(across.padded().length()),
        }
    }

    /// Returns the vectors of the cut with their keys.
    pub(super) fn vectors(&self) -> Vec<(&'static str, FiniteVector)> {
        match *self {
            Self::Circle { centre, normal, .. } => [("centre", Some(centre)), ("normal", normal)]
                .into_iter()
                .filter_map(|(key, v)| Some((key, v?)))
                .collect(),
            Self::Rectangle { centre, along, across } => vec![("centre", centre), ("along", along), ("across", across)],
        }
    }
}
