//! Where a wall sends the movers that it blocks.
//!
//! At a site with blocked directions B nothing arrives from outside in the directions opposite to B, and there are as many
//! of those as of B: any one-to-one map of B onto them lets no two particles meet in one state. Of all such maps this is the
//! one with the least sum of squared angles between where a mover goes and where a mirror along the wall would send it, and
//! 1500 square degrees more for each mover that changes between speed 1 and sqrt 3. At straight walls whose inclination is a
//! multiple of 30 degrees the lattice maps onto itself and the sum is zero: exact specular reflection. Elsewhere it is the
//! nearest that the lattice has.

use std::collections::HashMap;

use crate::lattice::velocities::{angle, directions, turned_round};

/// For each blocked direction the one that it is reflected into; 0 for others.
pub type Reflection = [u8; 13];

/// Square degrees that a change of speed costs.
const CHANGE_OF_SPEED: f64 = 1500.0;

/// Makes reflections, each only once.
#[derive(Default)]
pub struct MirrorSet(HashMap<(u16, u64), Reflection>);

impl MirrorSet {
    /// The reflection at a site with these blocked directions and a wall at this angle from the horizontal, degrees.
    pub fn reflection(&mut self, blocked: u16, tangent: f64) -> Reflection {
        *self.0.entry((blocked, tangent.to_bits())).or_insert_with(|| reflection(blocked, tangent))
    }
}

/// Square of the angle between direction `to` and the mirror image of `from`, and the cost of a change of speed.
fn cost(from: usize, to: usize, tangent: f64) -> f64 {
    let off = (angle(to) - (2.0 * tangent - angle(from))).rem_euclid(360.0);
    let off = off.min(360.0 - off);
    off * off + if (from <= 6) == (to <= 6) { 0.0 } else { CHANGE_OF_SPEED }
}

/// The cheapest assignment, by dynamic programming over the sets of directions already given away.
fn reflection(blocked: u16, tangent: f64) -> Reflection {
    let from: Vec<usize> = directions(blocked).collect();
    let to: Vec<usize> = directions(turned_round(blocked)).collect();
    // Of every set of targets, what the first movers as many as its members cost at least, and who took the last one.
    let mut best = vec![(f64::INFINITY, 0); 1 << to.len()];
    best[0].0 = 0.0;
    for set in 0..best.len() {
        let given = set.count_ones() as usize;
        for n in (0..to.len()).filter(|n| set & 1 << n == 0) {
            let total = best[set].0 + cost(from[given], to[n], tangent);
            let with = &mut best[set | 1 << n];
            // What is cheaper by rounding only is not cheaper.
            if total < with.0 - 1e-6 {
                *with = (total, n);
            }
        }
    }
    let mut reflection = [0; 13];
    let mut set = best.len() - 1;
    while set != 0 {
        let n = best[set].1;
        reflection[from[set.count_ones() as usize - 1]] = u8::try_from(to[n]).unwrap_or(0);
        set &= !(1 << n);
    }
    reflection
}

#[cfg(test)]
mod tests {
    use super::*;

    fn set(of: &[usize]) -> u16 {
        of.iter().fold(0, |set, d| set | 1 << d)
    }

    #[test]
    fn straight_walls_reflect_like_mirrors() {
        // Walls at 90, 0 and 60 degrees, all directions beyond them, and where a mirror sends each.
        let walls = [
            (90.0, vec![(2, 6), (3, 5), (7, 12), (8, 11), (9, 10)]),
            (0.0, vec![(3, 2), (4, 1), (5, 6), (9, 7), (10, 12)]),
            (60.0, vec![(2, 1), (3, 6), (4, 5), (8, 12), (9, 11)]),
        ];
        for (tangent, mirrored) in walls {
            let blocked = mirrored.iter().fold(0, |set, (from, _)| set | 1 << from);
            let reflection = MirrorSet::default().reflection(blocked, tangent);
            for (from, to) in mirrored {
                assert_eq!(usize::from(reflection[from]), to, "{from} at a wall of {tangent} degrees");
            }
        }
    }

    #[test]
    fn every_reflection_is_one_to_one_onto_the_ways_back() {
        for blocked in (0..4096u16).map(|movers| movers << 1).filter(|b| b.count_ones() <= 8) {
            let reflection = reflection(blocked, 37.0);
            let taken = directions(blocked).fold(0u16, |taken, d| taken | 1 << reflection[d]);
            assert_eq!(taken, turned_round(blocked));
        }
    }

    #[test]
    fn no_assignment_of_five_is_cheaper() {
        let (blocked, tangent) = (set(&[2, 3, 8, 9, 4]), 71.0);
        let (from, to): (Vec<_>, Vec<_>) = (directions(blocked).collect(), directions(turned_round(blocked)).collect());
        let found = reflection(blocked, tangent);
        let chosen: f64 = from.iter().map(|&d| cost(d, usize::from(found[d]), tangent)).sum();
        let mut orders = vec![vec![]];
        for _ in 0..5 {
            orders = orders
                .into_iter()
                .flat_map(|order: Vec<usize>| {
                    (0..5).filter(|n| !order.contains(n)).map(|n| [order.clone(), vec![n]].concat()).collect::<Vec<_>>()
                })
                .collect();
        }
        let cheapest = orders
            .iter()
            .map(|order| (0..5).map(|i| cost(from[i], to[order[i]], tangent)).sum::<f64>())
            .fold(f64::INFINITY, f64::min);
        assert!((chosen - cheapest).abs() < 1e-6, "{chosen} {cheapest}");
    }
}
