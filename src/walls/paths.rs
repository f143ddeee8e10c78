//! Paths of grains: the lines or faces that they must not cross, and the way out.
//!
//! In the plane, the lines are an [`Outline`](crate::walls::outline::Outline) of wall grains and flat walls. In solid
//! space the faces are [`FlatWalls`] alone, and the way out is the place of a door panel.

use crate::space::{Solid, Space};
use crate::walls::surfaces::{FlatWall, Surface};

/// Line or face that a path crosses.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Crossing<V> {
    /// The way out: the line between the flanks of the door, or a panel of the door.
    Orifice,
    /// A wall line between two points, m.
    Wall {
        /// One end.
        from: V,
        /// The other end.
        to: V,
    },
    /// A half-plane or a panel.
    FlatWall,
}

/// Bounds of the region of the grains.
pub trait Paths<V: Space>: Send + Sync {
    /// Returns the line or face that the straight path crosses first.
    fn crossing(&self, from: V, to: V) -> Option<Crossing<V>>;

    /// Returns the side of the walls' bounding box through which a grain has left, in words.
    fn beyond(&self, before: V, here: V) -> Option<&'static str>;
}

/// The flat walls of a solid scene.
#[derive(Clone, Debug)]
pub struct FlatWalls(pub Vec<FlatWall<Solid>>);

/// Returns where a path passes from the free side of a half-space into it, as a share of the path (0 to 1).
pub(super) fn enters<V: Space>(surface: &Surface<V>, from: V, to: V) -> Option<f64> {
    let (before, after) = (surface.distance(from), surface.distance(to));
    (before >= 0.0 && after < 0.0).then(|| before / (before - after))
}

/// Returns where a path passes through a panel, as a share of the path (0 to 1).
fn pierces(corner: Solid, along: Solid, across: Solid, from: Solid, to: Solid) -> Option<f64> {
    let normal = along.cross(across);
    let (before, after) = ((from - corner).dot(normal), (to - corner).dot(normal));
    if (before < 0.0) == (after < 0.0) {
        return None;
    }
    let share = before / (before - after);
    let at = from + (to - from) * share - corner;
    let inside = |edge: Solid| (0.0..=1.0).contains(&(at.dot(edge) / edge.length_squared()));
    (inside(along) && inside(across)).then_some(share)
}

impl Paths<Solid> for FlatWalls {
    fn crossing(&self, from: Solid, to: Solid) -> Option<Crossing<Solid>> {
        let crossed = self.0.iter().filter_map(|wall| {
            let (share, crossing) = match wall.surface {
                Surface::HalfPlane { .. } => (enters(&wall.surface, from, to)?, Crossing::FlatWall),
                Surface::Panel { corner, along, across } => {
                    let crossing = if wall.is_door { Crossing::Orifice } else { Crossing::FlatWall };
                    (pierces(corner, along, across, from, to)?, crossing)
                }
                Surface::Segment { .. } => return None,
            };
            Some((share, crossing))
        });
        crossed.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, crossing)| crossing)
    }

    /// Always `None`: gaps between flat walls are legal, and the cull line catches grains that fall through.
    fn beyond(&self, _: Solid, _: Solid) -> Option<&'static str> {
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::particle::Species;
    use crate::walls::surfaces::WallLoad;

    fn wall(surface: Surface<Solid>, is_door: bool) -> FlatWall<Solid> {
        let (species, load) = (Species(0), WallLoad::default());
        FlatWall { surface, velocity: Solid::ZERO, species, is_door, is_present: true, load }
    }

    #[test]
    fn the_way_out_is_where_the_door_was() {
        let panel = |x: f64| Surface::Panel { corner: Solid::new(x, 0.0, 0.0), along: Solid::X, across: Solid::Y };
        let floor = Surface::HalfPlane { point: Solid::new(0.0, 0.0, -1.0), normal: Solid::Z };
        let walls = FlatWalls(vec![wall(panel(0.0), false), wall(panel(1.0), true), wall(floor, false)]);
        let down = |x: f64, to: f64| walls.crossing(Solid::new(x, 0.5, 0.1), Solid::new(x, 0.5, to));
        assert_eq!(down(1.5, -0.1), Some(Crossing::Orifice));
        assert_eq!(down(0.5, -0.1), Some(Crossing::FlatWall));
        assert_eq!(down(2.5, -0.1), None);
        assert_eq!(down(2.5, -1.1), Some(Crossing::FlatWall));
        assert_eq!(walls.crossing(Solid::new(1.5, 0.5, -0.1), Solid::new(1.5, 0.5, 0.1)), Some(Crossing::Orifice));
    }
}
