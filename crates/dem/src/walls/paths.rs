//! Paths of grains: the lines or faces that they must not cross, and the way out.
//!
//! In the plane, the lines are an [`Enclosure`](crate::walls::enclosure::Enclosure) of wall grains and wall surfaces. In solid
//! space the faces are [`SolidEnclosure`] alone, and the way out is the place of a door.

use crate::space::{Solid, Space};
use crate::walls::surfaces::Surfaces;

/// Line or face that a path crosses.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Crossing<V> {
    /// A way out: the line between the flanks of a door of wall grains, or a surface of a door, with the number of the door.
    Orifice(u16),
    /// A wall line between two points, m.
    Wall {
        /// One end.
        from: V,
        /// The other end.
        to: V,
    },
    /// A wall surface.
    Surface,
}

/// Bounds of the region of the grains.
pub trait Paths<V: Space>: Send + Sync {
    /// Returns the line or face that the straight path crosses first.
    fn crossing(&self, from: V, to: V) -> Option<Crossing<V>>;

    /// Returns the side of the bounding box of the walls through which a grain has left, in words.
    fn beyond(&self, before: V, here: V) -> Option<&'static str>;
}

/// The wall surfaces that enclose the grains of a scene of solid space: all but those that a motion moves, with doors at their shut places.
#[derive(Clone, Debug)]
pub struct SolidEnclosure(pub Surfaces<Solid>);

impl Paths<Solid> for SolidEnclosure {
    fn crossing(&self, from: Solid, to: Solid) -> Option<Crossing<Solid>> {
        let mut first: Option<(f64, Crossing<Solid>)> = None;
        for index in self.0.on_path(from, to).iter() {
            let wall = &self.0.all[index];
            if let Some(share) = wall.surface.crossing(from, to)
                && first.is_none_or(|(earliest, _)| share < earliest)
            {
                first = Some((share, wall.door.map_or(Crossing::Surface, Crossing::Orifice)));
            }
        }
        first.map(|(_, crossing)| crossing)
    }

    /// Always `None`: gaps between wall surfaces are legal, and the cull line catches grains that fall through.
    fn beyond(&self, _: Solid, _: Solid) -> Option<&'static str> {
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::particle::Species;
    use crate::walls::shapes::half_plane::HalfPlane;
    use crate::walls::shapes::panel::Panel;
    use crate::walls::surface::Surface;
    use crate::walls::surface_wall::SurfaceWall;

    fn wall(surface: Surface<Solid>, is_door: bool) -> SurfaceWall<Solid> {
        SurfaceWall { door: is_door.then_some(3), ..SurfaceWall::still(surface, Species(0)) }
    }

    #[test]
    fn the_way_out_is_where_the_door_was() {
        let panel =
            |x: f64| Surface::Panel(Panel { corner: Solid::new(x, 0.0, 0.0), along: Solid::X, across: Solid::Y });
        let floor = Surface::HalfPlane(HalfPlane { point: Solid::new(0.0, 0.0, -1.0), normal: Solid::Z });
        let walls = [wall(panel(0.0), false), wall(panel(1.0), true), wall(floor, false)];
        let walls = SolidEnclosure(Surfaces::new(walls.to_vec(), 0.0));
        let down = |x: f64, to: f64| walls.crossing(Solid::new(x, 0.5, 0.1), Solid::new(x, 0.5, to));
        assert_eq!(down(1.5, -0.1), Some(Crossing::Orifice(3)));
        assert_eq!(down(0.5, -0.1), Some(Crossing::Surface));
        assert_eq!(down(2.5, -0.1), None);
        assert_eq!(down(2.5, -1.1), Some(Crossing::Surface));
        assert_eq!(walls.crossing(Solid::new(1.5, 0.5, -0.1), Solid::new(1.5, 0.5, 0.1)), Some(Crossing::Orifice(3)));
    }
}
