//! Reflection: the directions into which a wall reflects the movers that it blocks.
//!
//! Let B be the blocked directions of a site. No mover arrives in the directions opposite to B, and B has as many
//! directions as its opposites. A one-to-one map from B onto its opposites therefore never puts two particles into one
//! state. Of all these maps, the reflection is the one with the smallest total cost. The cost of a mover is the square
//! of the angle between its new direction and its exact specular reflection about the wall. A mover that changes
//! between speed 1 and sqrt 3 costs 1500 square degrees more.
//!
//! The lattice maps onto itself at straight walls with an inclination that is a multiple of 30 degrees. The cost is
//! then zero and the reflection exactly specular. Elsewhere the map is the best approximation that the lattice allows.

use std::collections::HashMap;

use crate::velocities::{angle, directions, turned_round};

/// The reflected direction of each blocked direction; 0 for directions that are not blocked.
pub type Reflection = [u8; 13];

/// Cost of a change of speed, square degrees.
const CHANGE_OF_SPEED: f64 = 1500.0;

/// The reflections computed so far, by blocked directions and wall angle.
#[derive(Default)]
pub struct Reflections(HashMap<(u16, u64), Reflection>);

impl Reflections {
    /// Returns the reflection at a site with the blocked directions `blocked` (a state), near a wall at the angle
    /// `tangent` to the horizontal, degrees.
    pub fn reflection(&mut self, blocked: u16, tangent: f64) -> Reflection {
        *self.0.entry((blocked, tangent.to_bits())).or_insert_with(|| reflection(blocked, tangent))
    }
}

/// Returns the cost of reflecting `from` into `to`, square degrees: the squared angle between `to` and the specular
/// reflection of `from`, plus the cost of a change of speed.
fn cost(from: usize, to: usize, tangent: f64) -> f64 {
    let off = (angle(to) - (2.0 * tangent - angle(from))).rem_euclid(360.0);
    let off = off.min(360.0 - off);
    off * off + if (from <= 6) == (to <= 6) { 0.0 } else { CHANGE_OF_SPEED }
}

/// Returns the cheapest one-to-one map, by dynamic programming over the sets of targets that are already assigned.
fn reflection(blocked: u16, tangent: f64) -> Reflection {
    let from: Vec<usize> = directions(blocked).collect();
    let to: Vec<usize> = directions(turned_round(blocked)).collect();
    // For each set of n targets: the least cost of assigning them to the first n movers, and the target of the last
    // one.
    let mut best = vec![(f64::INFINITY, 0); 1 << to.len()];
    best[0].0 = 0.0;
    for set in 0..best.len() {
        let assigned = set.count_ones() as usize;
        for n in (0..to.len()).filter(|n| set & 1 << n == 0) {
            let total = best[set].0 + cost(from[assigned], to[n], tangent);
            let with = &mut best[set | 1 << n];
            // The margin ignores differences that are only rounding errors.
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
    fn straight_walls_reflect_specularly() {
        // For walls at 90, 0 and 60 degrees: each blocked direction and its specular reflection.
        let walls = [
            (90.0, vec![(2, 6), (3, 5), (7, 12), (8, 11), (9, 10)]),
            (0.0, vec![(3, 2), (4, 1), (5, 6), (9, 7), (10, 12)]),
            (60.0, vec![(2, 1), (3, 6), (4, 5), (8, 12), (9, 11)]),
        ];
        for (tangent, mirrored) in walls {
            let blocked = mirrored.iter().fold(0, |set, (from, _)| set | 1 << from);
            let reflection = Reflections::default().reflection(blocked, tangent);
            for (from, to) in mirrored {
                assert_eq!(usize::from(reflection[from]), to, "{from} at a wall of {tangent} degrees");
            }
        }
    }

    #[test]
    fn every_reflection_maps_one_to_one_onto_the_opposite_directions() {
        for blocked in (0..4096u16).map(|movers| movers << 1).filter(|b| b.count_ones() <= 8) {
            let reflection = reflection(blocked, 37.0);
            let taken = directions(blocked).fold(0u16, |taken, d| taken | 1 << reflection[d]);
            assert_eq!(taken, turned_round(blocked));
        }
    }

    #[test]
    fn no_permutation_of_five_targets_is_cheaper() {
        let blocked = set(&[2, 3, 8, 9, 4]);
        let tangent = 71.0;
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
