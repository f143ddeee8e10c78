//! Occupied places: finds out whether a disc or sphere overlaps any of many others, in a time that does not grow with their number.
//!
//! Places are sorted into cubic cells that are as wide as the largest pair of grains. Particles much larger than the grains to be placed
//! are compared one by one. In a periodic box the nearest images count.

use rustc_hash::FxHashMap;

use siloflow_dem::periodic::PeriodicSides;
use siloflow_dem::space::Solid;

/// A particle that is compared one by one is larger than the largest new grain by more than this factor.
const LARGE: f64 = 4.0;

/// Occupied places: centres and radii, m.
pub struct Occupied {
    /// Sides of a cell, m: at least the largest distance at which a new grain touches a particle of a cell.
    cell: Solid,
    cells: FxHashMap<[i64; 3], Vec<(Solid, f64)>>,
    large: Vec<(Solid, f64)>,
    largest_new: f64,
    /// The lengths of the periodic sides, m; 0 for open axes.
    periods: Solid,
}

impl Occupied {
    /// Returns places for new grains of radii up to `largest_new` (m), none of them occupied.
    #[must_use]
    pub fn new(largest_new: f64, periodic: &PeriodicSides) -> Self {
        let periods = periodic.axes().map(|side| side.map_or(0.0, |(low, high)| high - low));
        let reach = (1.0 + LARGE) * largest_new;
        // A whole number of cells in a periodic side.
        let side = |length: f64| if length > 0.0 { length / (length / reach).floor().max(1.0) } else { reach };
        Self {
            cell: Solid::from(periods.map(side)),
            cells: FxHashMap::default(),
            large: Vec::new(),
            largest_new,
            periods: Solid::from(periods),
        }
    }

    /// Occupies the place of a particle.
    pub fn add(&mut self, centre: Solid, radius: f64) {
        if radius > LARGE * self.largest_new {
            self.large.push((centre, radius));
        } else {
            let cell = self.cell_at(centre, [0; 3]);
            self.cells.entry(cell).or_default().push((centre, radius));
        }
    }

    /// Whether a new grain overlaps no particle.
    #[must_use]
    pub fn is_free(&self, centre: Solid, radius: f64) -> bool {
        let is_clear = |&(other, size): &(Solid, f64)| self.shortest(centre - other).length() >= radius + size;
        let offsets = (0..27).map(|n| [n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1]);
        let mut around = offsets.filter_map(|offset| self.cells.get(&self.cell_at(centre, offset)));
        self.large.iter().all(is_clear) && around.all(|cell| cell.iter().all(is_clear))
    }

    /// The cell of a place, or one beside it. Cells of images are the same.
    fn cell_at(&self, x: Solid, offset: [i64; 3]) -> [i64; 3] {
        std::array::from_fn(|axis| {
            let side = self.cell[axis];
            let period = self.periods[axis];
            #[expect(clippy::cast_possible_truncation, reason = "far places share a cell")]
            let number = ((x[axis] / side).floor() as i64).saturating_add(offset[axis]);
            #[expect(
                clippy::cast_possible_truncation,
                reason = "a side has fewer cells than a number can count, or they share one"
            )]
            let count = (period / side).round() as i64;
            if count > 0 { number.rem_euclid(count) } else { number }
        })
    }

    /// The shortest separation between images.
    fn shortest(&self, s: Solid) -> Solid {
        let shorten = |s: f64, length: f64| if length > 0.0 { s - length * (s / length).round() } else { s };
        Solid::new(shorten(s.x, self.periods.x), shorten(s.y, self.periods.y), shorten(s.z, self.periods.z))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Stream;
    use siloflow_text::source::parse;

    #[test]
    fn cells_find_what_a_comparison_with_all_finds() {
        let random = Stream::new(1, "occupied");
        for sides in ["()", "(x: (0.0, 1.03), z: (-0.2, 0.81))"] {
            let sides: PeriodicSides = parse::parse("a.ron", sides).unwrap();
            let mut occupied = Occupied::new(0.05, &sides);
            let mut all = Vec::new();
            let mut counts = [0; 2];
            for n in 0..600 {
                let [x, y, z, r] = random.uniform(n);
                // A few are large, and may overlap others.
                let is_large = n % 200 == 100;
                let radius = if is_large { 0.23 } else { 0.01 + 0.04 * r };
                let centre = Solid::new(1.4 * x - 0.2, 1.0 * y, 1.4 * z - 0.4);
                let is_free = all.iter().all(|&(other, size): &(Solid, f64)| {
                    let images = (-1..=1).flat_map(|i| (-1..=1).map(move |k| (f64::from(i), f64::from(k))));
                    let images = images.map(|(i, k)| Solid::new(i, 0.0, k) * occupied.periods);
                    images.map(|image| (centre - other + image).length()).fold(f64::INFINITY, f64::min) >= radius + size
                });
                assert!(is_large || occupied.is_free(centre, radius) == is_free, "{n}: {centre} {radius}");
                counts[usize::from(is_free)] += 1;
                if is_free || is_large {
                    occupied.add(centre, radius);
                    all.push((centre, radius));
                }
            }
            assert!(counts.into_iter().all(|count| count > 30) && occupied.large.len() == 3, "{counts:?}");
        }
    }
}
