//! Flat walls: half-planes and segments, under the same contact law as between grains.
//!
//! The partner has no curvature, no velocity and infinite mass: overlap delta = R - d with d the distance from the
//! centre to the wall, normal from the wall to the centre, reduced mass that of the grain. A half-plane is solid
//! behind its normal however deep a grain is in it; a segment is thin and acts on both sides. Forces are summed in
//! the scene's order, after those of all particles.

use std::sync::Arc;

use bevy_app::{App, Plugin};
use bevy_ecs::prelude::*;
use serde::{Deserialize, Serialize};

use crate::columns::Columns;
use crate::contact::{LargestOverlap, Law, Pair, PairLaw};
use crate::scene::values::{FiniteVector, Positive};
use crate::space::Vector;
use crate::step::{ForceStage, Step};

/// One of the scene's `walls`.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub enum Wall {
    /// Everything behind a line is solid.
    HalfPlane {
        /// A point of the line, m.
        point: FiniteVector,
        /// The direction from the solid into the free half, of any length but zero.
        normal: FiniteVector,
    },
    /// A thin wall between two points.
    Segment {
        /// One end, m.
        from: FiniteVector,
        /// The other end, m.
        to: FiniteVector,
    },
    /// A fixed disc: a wall grain like those of a silo file.
    Disc {
        /// Centre, m.
        centre: FiniteVector,
        /// Radius, m.
        radius: Positive,
    },
}

/// A flat wall.
#[derive(Clone, Copy, Debug)]
pub enum Surface {
    /// Solid behind `normal`, a unit vector.
    HalfPlane {
        /// A point of the surface, m.
        point: Vector,
        /// Unit normal into the free half.
        normal: Vector,
    },
    /// Thin, between two points, m.
    Segment {
        /// One end, m.
        from: Vector,
        /// The other end, m.
        to: Vector,
    },
}

impl Wall {
    /// The flat wall, unless it is a disc.
    #[must_use]
    pub fn surface(&self) -> Option<Surface> {
        match self {
            Self::HalfPlane { point, normal } => {
                Some(Surface::HalfPlane { point: point.get(), normal: normal.get().normalize_or_zero() })
            }
            Self::Segment { from, to } => Some(Surface::Segment { from: from.get(), to: to.get() }),
            Self::Disc { .. } => None,
        }
    }
}

impl Surface {
    /// Distance of a point from the wall, m (negative inside a half-plane), and the unit vector towards the point.
    #[inline]
    #[must_use]
    pub fn distance(&self, x: Vector) -> (f64, Vector) {
        match *self {
            Self::HalfPlane { point, normal } => ((x - point).dot(normal), normal),
            Self::Segment { from, to } => {
                let along = to - from;
                let share = ((x - from).dot(along) / along.length_squared()).clamp(0.0, 1.0);
                let away = x - (from + share * along);
                let distance = away.length();
                // A centre exactly on the segment is pushed to its left.
                let normal = if distance > 0.0 { away / distance } else { along.perp().normalize_or_zero() };
                (distance, normal)
            }
        }
    }
}

/// The flat walls of the scene, in its order.
#[derive(Resource, Clone, Debug, Default)]
pub struct Surfaces(pub Vec<Surface>);

/// The contact of movable entry `i` with a wall, if they touch.
#[inline]
#[must_use]
pub fn touching(columns: &Columns, i: usize, wall: &Surface) -> Option<Pair> {
    let (distance, normal) = wall.distance(columns.body[i].position);
    let overlap = columns.body[i].radius - distance;
    (overlap > 0.0).then(|| Pair {
        normal,
        overlap,
        relative_velocity: columns.body[i].velocity,
        reduced_mass: 1.0 / columns.body[i].inverse_mass,
    })
}

fn wall_forces<L: PairLaw>(
    law: Res<Law<L>>,
    walls: Res<Surfaces>,
    mut columns: ResMut<Columns>,
    mut largest: ResMut<LargestOverlap>,
) {
    for i in 0..columns.movable_end {
        if columns.is_fixed(i) {
            continue;
        }
        for wall in &walls.0 {
            if let Some(pair) = touching(&columns, i, wall) {
                let on_i = law.0.force(&pair);
                columns.load[i].force += on_i.elastic + on_i.drag;
                columns.load[i].drag += on_i.drag;
                largest.0.raise(pair.overlap, columns.body[i].radius);
            }
        }
    }
}

/// Flat walls under the law `law`.
pub struct SurfacesPlugin<L: PairLaw>(pub Arc<L>);

impl<L: PairLaw> Plugin for SurfacesPlugin<L> {
    fn build(&self, app: &mut App) {
        app.add_systems(Step, wall_forces::<L>.in_set(ForceStage::Walls));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_segment_is_round_at_its_ends_and_two_sided() {
        let wall = Surface::Segment { from: Vector::ZERO, to: Vector::new(2.0, 0.0) };
        assert_eq!(wall.distance(Vector::new(1.0, -0.5)), (0.5, Vector::NEG_Y));
        assert_eq!(wall.distance(Vector::new(5.0, 4.0)), (5.0, Vector::new(0.6, 0.8)));
        assert_eq!(wall.distance(Vector::new(1.0, 0.0)), (0.0, Vector::Y));
    }

    #[test]
    fn a_half_plane_measures_depth() {
        let wall = Surface::HalfPlane { point: Vector::new(0.0, 1.0), normal: Vector::Y };
        assert_eq!(wall.distance(Vector::new(7.0, 0.25)), (-0.75, Vector::Y));
    }
}
