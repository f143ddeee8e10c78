//! Links of wall discs: the lines between neighbouring discs through which no grain fits.
//!
//! Discs a and b, a before b in the scene, are *tight* if d(a, b) < r_a + r_b + 2 s, with the smallest radius s of a grain. They are linked if they are tight, and
//! no third disc c that is tight with a is nearer to both than they are to each other: d(a, c) < d(a, b) and d(c, b) < d(a, b). For equal radii this is the
//! relative neighbourhood graph (Toussaint, Pattern Recognition 12, 261, 1980). Discs at one place count as one, with the largest of their
//! radii: a line without length parts nothing.
//!
//! All pairs may be tight, so pairs are not listed. From each disc the search goes outwards through a tree ([`BoxTree`]). A disc c that was found closes every
//! branch whose discs are all nearer to c than to a. Few candidates remain, and for each the tree is asked for a disc between. The time is
//! about n log n.

use std::ops::ControlFlow;

use rustc_hash::FxHashMap;

use crate::space::Vector;
use crate::walls::box_tree::{Bounds, BoxTree};
use crate::walls::link::Link;
use crate::walls::silo_file::Disc;

/// Most discs that close branches. More of them cost more than they close: at most six neighbours are nearest in their direction, but equal distances add
/// to them.
const MOST_BLOCKERS: usize = 24;

/// Margin of comparisons that skip a branch, above the rounding of distances. Within it discs are compared one by one.
const MARGIN: f64 = 1e-9;

/// Links neighbouring wall discs between which no grain of radius `smallest` (m) fits, ordered by their first and then by their second disc.
pub(super) fn disc_links(discs: &[Disc], smallest: f64) -> Vec<Link> {
    let search = Search::new(discs, smallest);
    let mut links = Vec::new();
    for a in 0..search.discs.len() {
        let mut partners = search.candidates(a);
        partners.retain(|&b| b > a && !search.is_bridged(a, b));
        partners.sort_unstable();
        links.extend(partners.iter().map(|&b| Link { from: search.discs[a].centre, to: search.discs[b].centre }));
    }
    links
}

struct Search {
    /// Discs at different places, in the order of the scene.
    discs: Vec<Disc>,
    smallest: f64,
    /// By x, y and radius.
    tree: BoxTree<3>,
}

impl Search {
    fn new(all: &[Disc], smallest: f64) -> Self {
        let mut places: FxHashMap<[u64; 2], usize> = FxHashMap::default();
        let mut discs: Vec<Disc> = Vec::new();
        for disc in all {
            let place = (disc.centre + Vector::ZERO).to_array().map(f64::to_bits);
            let known = *places.entry(place).or_insert(discs.len());
            match discs.get_mut(known) {
                Some(same) => same.radius = same.radius.max(disc.radius),
                None => discs.push(*disc),
            }
        }
        let boxes: Vec<_> = discs.iter().map(|disc| [[disc.centre.x, disc.centre.y, disc.radius]; 2]).collect();
        Self { tree: BoxTree::new(&boxes), discs, smallest }
    }

    fn distance(&self, a: usize, b: usize) -> f64 {
        self.discs[a].centre.distance(self.discs[b].centre)
    }

    fn is_tight(&self, a: usize, b: usize) -> bool {
        self.distance(a, b) < self.discs[a].radius + self.discs[b].radius + 2.0 * self.smallest
    }

    /// Whether a disc at this distance from `a` may be tight with it, if its radius is at most that of the bounds.
    fn may_be_tight(&self, a: usize, distance: f64, bounds: &Bounds<3>) -> bool {
        let reach = self.discs[a].radius + bounds[1][2] + 2.0 * self.smallest;
        distance <= reach * (1.0 + MARGIN)
    }

    /// Returns the discs that are tight with `a`, but for some that have a disc between.
    fn candidates(&self, a: usize) -> Vec<usize> {
        let centre = self.discs[a].centre;
        let enters = |found: &Vec<(usize, f64)>, bounds: &Bounds<3>| {
            let nearest = distance_of(bounds, centre);
            let closes = |&(c, apart): &(usize, f64)| {
                nearest > apart * (1.0 + MARGIN) && is_beyond(bounds, centre, self.discs[c].centre)
            };
            self.may_be_tight(a, nearest, bounds) && !found.iter().take(MOST_BLOCKERS).any(closes)
        };
        let visit = |found: &mut Vec<(usize, f64)>, b: usize| {
            let apart = self.distance(a, b);
            let blocks = |&(c, its): &(usize, f64)| its < apart && self.distance(c, b) < apart;
            if b != a && self.is_tight(a, b) && !found.iter().take(MOST_BLOCKERS).any(blocks) {
                if found.len() < MOST_BLOCKERS {
                    found.retain(|&(c, its)| !(apart < its && self.distance(b, c) < its));
                }
                found.push((b, apart));
            }
            ControlFlow::Continue(())
        };
        // With their distances from `a`.
        let mut found: Vec<(usize, f64)> = Vec::new();
        let _ = self.tree.search_with(&mut found, |bounds| distance_of(bounds, centre), enters, visit);
        found.into_iter().map(|(b, _)| b).collect()
    }

    /// Whether a disc that is tight with `a` is nearer to both discs than they are to each other.
    fn is_bridged(&self, a: usize, b: usize) -> bool {
        let apart = self.distance(a, b);
        let ends = [a, b].map(|end| self.discs[end].centre);
        let farther = |bounds: &Bounds<3>| ends.map(|end| distance_of(bounds, end)).into_iter().fold(0.0, f64::max);
        let enters = |(): &(), bounds: &Bounds<3>| {
            let may_be_between = farther(bounds) <= apart * (1.0 + MARGIN);
            may_be_between && self.may_be_tight(a, distance_of(bounds, ends[0]), bounds)
        };
        let visit = |(): &mut (), c: usize| {
            let is_between =
                c != a && c != b && self.is_tight(a, c) && self.distance(a, c) < apart && self.distance(c, b) < apart;
            if is_between { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        };
        self.tree.search_with(&mut (), farther, enters, visit).is_break()
    }
}

/// Returns the least distance of a place from discs with these bounds.
fn distance_of([low, high]: &Bounds<3>, x: Vector) -> f64 {
    let [low, high] = [low, high].map(|corner| Vector::new(corner[0], corner[1]));
    x.distance(x.clamp(low, high))
}

/// Whether all places with these bounds are nearer to `c` than to `a`, by more than the rounding of distances.
fn is_beyond([low, high]: &Bounds<3>, a: Vector, c: Vector) -> bool {
    // |x - a|^2 - |x - c|^2 is linear in x, and least at one corner.
    let way = c - a;
    let corner = |axis: usize, of_a: f64| if way[axis] > 0.0 { low[axis] - of_a } else { high[axis] - of_a };
    let nearest = Vector::new(corner(0, a.x), corner(1, a.y));
    let lead = 2.0 * nearest.dot(way) - way.length_squared();
    let [low, high] = [low, high].map(|corner| Vector::new(corner[0], corner[1]) - a);
    let farthest = low.abs().max(high.abs());
    lead > MARGIN * (farthest.length_squared() + way.length_squared())
}

#[cfg(test)]
mod tests {
    use std::time::{Duration, Instant};

    use proptest::prelude::*;

    use super::*;

    /// The definition, pair by pair.
    fn plain(discs: &[Disc], smallest: f64) -> Vec<Link> {
        let distance = |a: usize, b: usize| discs[a].centre.distance(discs[b].centre);
        let tight = |a: usize, b: usize| distance(a, b) < discs[a].radius + discs[b].radius + 2.0 * smallest;
        let mut links = Vec::new();
        for a in 0..discs.len() {
            for b in (a + 1..discs.len()).filter(|&b| tight(a, b)) {
                let between = |&c: &usize| {
                    c != a
                        && c != b
                        && tight(a, c)
                        && distance(a, c) < distance(a, b)
                        && distance(c, b) < distance(a, b)
                };
                if !(0..discs.len()).any(|c| between(&c)) {
                    links.push(Link { from: discs[a].centre, to: discs[b].centre });
                }
            }
        }
        links
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(400))]
        #[test]
        fn links_are_those_of_the_definition(
            places in prop::collection::vec((0..40i32, 0..40i32, 1..9i32), 1..70),
            // From a lattice with many equal distances to places without any.
            fraction in prop::sample::select(vec![0.0, 1e-13, 0.37]),
            radius in prop::sample::select(vec![0.1, 0.5, 3.0, 100.0]),
            smallest in prop::sample::select(vec![0.0, 0.2, 2.0]),
        ) {
            let mut discs: Vec<Disc> = Vec::new();
            for (n, (x, y, r)) in (0u32..).zip(places) {
                let off = fraction * (7.3 * f64::from(n)).sin();
                let centre = Vector::new(f64::from(x) + off, f64::from(y) - off * off);
                if discs.iter().all(|disc| disc.centre != centre) {
                    discs.push(Disc { centre, radius: radius * f64::from(r) });
                }
            }
            prop_assert_eq!(disc_links(&discs, smallest), plain(&discs, smallest));
        }
    }

    #[test]
    fn discs_at_one_place_are_one() {
        let disc = |x: f64, radius: f64| Disc { centre: Vector::new(x, 0.0), radius };
        let discs = [disc(0.0, 0.1), disc(0.0, 0.2), disc(-0.0, 0.1), disc(0.3, 0.1), disc(0.3, 0.1)];
        let link = Link { from: Vector::ZERO, to: Vector::new(0.3, 0.0) };
        assert_eq!(disc_links(&discs, 0.01), [link]);
        assert_eq!(disc_links(&discs[2..], 0.01), []);
    }

    /// Pair by pair, each of these takes minutes.
    #[test]
    fn many_discs_that_all_overlap_take_little_time() {
        let n = 20_000u32;
        let at = |place: &dyn Fn(f64) -> Vector| {
            (0..n).map(|k| Disc { centre: place(f64::from(k)), radius: 10.0 }).collect::<Vec<_>>()
        };
        let shapes = [
            at(&|_| Vector::ZERO),
            at(&|k| Vector::new(k / f64::from(n), 0.0)),
            at(&|k| Vector::from_angle(k)),
            at(&|k| (k / f64::from(n)).sqrt() * Vector::from_angle(2.4 * k)),
            at(&|k| Vector::new((k / 141.0).floor(), k % 141.0) / 141.0),
        ];
        for (number, discs) in shapes.iter().enumerate() {
            let start = Instant::now();
            let links = disc_links(discs, 0.01).len();
            assert!(start.elapsed() < Duration::from_secs(20), "{number}: {:?}", start.elapsed());
            // A chain has n - 1 links; a lattice has about two for each disc.
            assert!(links < 3 * n as usize, "{number}: {links}");
        }
    }
}
