//! Twins: a wall surface and its images beyond the sides of a periodic box.
//!
//! A grain that touches a surface near a side and passes through the side touches an image of that surface afterwards. The memory of the
//! contact passes to the image. Loads on images are loads on the wall, because images have its number.

use rustc_hash::FxHashMap;

use crate::space::Space;
use crate::walls::surface_wall::SurfaceWall;

/// For each surface with images, the indices of itself and its images, ascending.
#[derive(Clone, Debug, Default)]
pub struct Twins(FxHashMap<usize, Box<[usize]>>);

impl Twins {
    /// Finds the images: surfaces of one wall with one number within it.
    pub(super) fn of<V: Space>(all: &[SurfaceWall<V>]) -> Self {
        // Images come after all other surfaces of their wall, so that only walls whose last surface is not a new piece have some.
        let mut families: FxHashMap<(usize, u32), Vec<usize>> = FxHashMap::default();
        if all.windows(2).any(|pair| pair[0].number == pair[1].number && pair[1].piece <= pair[0].piece) {
            for (index, wall) in all.iter().enumerate() {
                families.entry((wall.number, wall.piece)).or_default().push(index);
            }
        }
        let families = families.into_values().filter(|family| family.len() > 1);
        Self(
            families
                .flat_map(|family| family.clone().into_iter().map(move |index| (index, family[..].into())))
                .collect(),
        )
    }

    /// Whether no surface has images.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Returns the other surfaces of the family of a surface, ascending.
    pub fn of_surface(&self, index: usize) -> impl Iterator<Item = usize> {
        let family = self.0.get(&index).map(|family| &family[..]).unwrap_or_default();
        family.iter().copied().filter(move |&other| other != index)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::particle::Species;
    use crate::space::Plane;
    use crate::walls::shapes::segment::Segment;
    use crate::walls::surface::Surface;

    #[test]
    fn images_are_found_by_wall_and_piece() {
        let wall = |number, piece| {
            let surface = Surface::Segment(Segment { from: Plane::ZERO, to: Plane::X });
            SurfaceWall { number, piece, ..SurfaceWall::still(surface, Species(0)) }
        };
        let found = |walls: &[(usize, u32)]| {
            let walls: Vec<_> = walls.iter().map(|&(number, piece)| wall(number, piece)).collect();
            let twins = Twins::of(&walls);
            (0..walls.len()).map(|index| twins.of_surface(index).collect::<Vec<_>>()).collect::<Vec<_>>()
        };
        assert!(Twins::of(&[wall(0, 0), wall(1, 0), wall(1, 1), wall(2, 0)]).is_empty());
        assert_eq!(
            found(&[(0, 0), (1, 0), (1, 1), (1, 1), (2, 0), (2, 0)]),
            [vec![], vec![], vec![3], vec![2], vec![5], vec![4]]
        );
    }
}
