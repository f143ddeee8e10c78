//! Index of wall surfaces by place, so that a grain pays only for the surfaces near it.
//!
//! A grid of cells lists the surfaces whose bounds meet each cell. A cell is twice as wide as the largest grain. Surfaces
//! without bounds, and those that meet very many cells, are candidates everywhere. A scene with few surfaces has no grid.

use std::ops::Range;

use rustc_hash::FxHashMap;

use crate::neighbours::cells::floor;
use crate::space::Space;
use crate::walls::surface_wall::SurfaceWall;

/// Most surfaces without a grid.
const FEW: usize = 32;

/// Most cells that list one surface.
const MOST_CELLS: i64 = 512;

/// Candidate surfaces by place.
#[derive(Clone, Debug, Default)]
pub(crate) struct SurfaceIndex {
    /// Side of a cell, m; `None` if all surfaces are candidates everywhere.
    side: Option<f64>,
    by_cell: FxHashMap<[i64; 3], Vec<u32>>,
    everywhere: Vec<u32>,
}

/// Surfaces that may be near a place: all, or some.
pub struct Candidates {
    all: Range<usize>,
    found: Vec<u32>,
}

impl Candidates {
    /// Returns all of `count` surfaces.
    pub(crate) fn all(count: usize) -> Self {
        Self { all: 0..count, found: Vec::new() }
    }

    /// Iterates over the numbers of the surfaces, ascending.
    pub fn iter(&self) -> impl Iterator<Item = usize> + Clone {
        self.all.clone().chain(self.found.iter().map(|&number| number as usize))
    }
}

impl SurfaceIndex {
    /// Makes the index for grains of radius up to `largest`, m.
    pub(crate) fn new<V: Space>(walls: &[SurfaceWall<V>], largest: f64) -> Self {
        let numbers = 0..u32::try_from(walls.len()).expect("fewer than 2^32 surfaces");
        let side = 4.0 * largest;
        if walls.len() <= FEW || side <= 0.0 {
            return Self { side: None, by_cell: FxHashMap::default(), everywhere: numbers.collect() };
        }
        let mut index = Self { side: Some(side), ..Self::default() };
        for (number, wall) in numbers.zip(walls) {
            match wall.surface.bounds().map(|[low, high]| cells(side, low, high)) {
                Some(cells) if count(cells) <= MOST_CELLS => {
                    each_cell(cells, |cell| index.by_cell.entry(cell).or_default().push(number));
                }
                _ => index.everywhere.push(number),
            }
        }
        index
    }

    /// Returns the surfaces that are candidates everywhere, ascending.
    pub(crate) fn everywhere(&self) -> &[u32] {
        &self.everywhere
    }

    /// Whether there is a grid.
    pub(crate) fn has_grid(&self) -> bool {
        self.side.is_some()
    }

    /// Returns the candidates in a box among `count` surfaces. It allocates only if there is a grid.
    pub(crate) fn candidates<V: Space>(&self, bounds: [V; 2], count: usize) -> Candidates {
        if self.side.is_none() {
            return Candidates::all(count);
        }
        let mut found = Vec::new();
        self.find(bounds, &mut found);
        Candidates { all: 0..0, found }
    }

    /// Sets `found` to the candidates in a box, ascending.
    pub(crate) fn find<V: Space>(&self, [low, high]: [V; 2], found: &mut Vec<u32>) {
        found.clear();
        found.extend(&self.everywhere);
        if let Some(side) = self.side {
            let own = found.len();
            let range @ [lowest, highest] = cells(side, low, high);
            // A grain may come from so far that its way meets more cells than the grid has.
            if usize::try_from(count(range)).is_ok_and(|cells| cells <= self.by_cell.len()) {
                each_cell(range, |cell| found.extend(self.by_cell.get(&cell).into_iter().flatten()));
            } else {
                let is_met = |cell: &[i64; 3]| (0..3).all(|axis| (lowest[axis]..=highest[axis]).contains(&cell[axis]));
                found.extend(self.by_cell.iter().filter(|(cell, _)| is_met(cell)).flat_map(|(_, walls)| walls));
            }
            if found.len() > own {
                found.sort_unstable();
                found.dedup();
            }
        }
    }
}

/// Returns the lowest and the highest cell that a box meets.
fn cells<V: Space>(side: f64, low: V, high: V) -> [[i64; 3]; 2] {
    [low, high].map(|corner| {
        let mut cell = [0; 3];
        for (axis, number) in cell.iter_mut().enumerate().take(V::COMPONENTS) {
            *number = floor(corner.axis(axis) / side);
        }
        cell
    })
}

fn count([low, high]: [[i64; 3]; 2]) -> i64 {
    let spans = (0..3).map(|axis| high[axis].saturating_sub(low[axis]).saturating_add(1));
    spans.fold(1, i64::saturating_mul)
}

fn each_cell([low, high]: [[i64; 3]; 2], mut visit: impl FnMut([i64; 3])) {
    for x in low[0]..=high[0] {
        for y in low[1]..=high[1] {
            for z in low[2]..=high[2] {
                visit([x, y, z]);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::particle::Species;
    use crate::space::Solid;
    use crate::walls::shapes::half_plane::HalfPlane;
    use crate::walls::shapes::triangle::Triangle;
    use crate::walls::surface::Surface;

    proptest! {
        #[test]
        fn every_surface_within_reach_is_found(
            corners in prop::collection::vec(((-1.0..1.0, -1.0..1.0, -1.0..1.0), 0.001..0.9), 40..80),
            x in (-1.2..1.2, -1.2..1.2, -1.2..1.2),
            reach in prop_oneof![0.01..0.2, 1.0..1e300],
        ) {
            let wall = |((x, y, z), size): ((f64, f64, f64), f64)| {
                let a = Solid::new(x, y, z);
                let corners = [a, a + Solid::new(size, 0.3 * size, 0.0), a + Solid::new(0.0, size, -size)];
                SurfaceWall::still(Surface::Triangle(Triangle(corners)), Species(0))
            };
            let mut walls: Vec<_> = corners.into_iter().map(wall).collect();
            let floor = HalfPlane { point: Solid::ZERO, normal: Solid::Z };
            walls.push(SurfaceWall::still(Surface::HalfPlane(floor), Species(0)));
            let index = SurfaceIndex::new(&walls, 0.02);
            let x = Solid::new(x.0, x.1, x.2);
            let mut found = Vec::new();
            index.find([x - Solid::splat(reach), x + Solid::splat(reach)], &mut found);
            prop_assert!(found.is_sorted_by(|a, b| a < b));
            for (number, wall) in (0u32..).zip(&walls) {
                prop_assert!(wall.surface.distance(x) > reach || found.contains(&number));
            }
        }
    }
}
