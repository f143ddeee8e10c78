//! Marks of candidates: a list marks its pairs that contain one of some chosen particles.
//!
//! The choice changes a little now and then. After such a change only the rows near the changed particles are visited.

use std::ops::Range;

use crate::neighbours::candidate::Candidate;

/// State of the marks of a list.
#[derive(Debug, Default)]
pub(super) struct Marks {
    /// When pairs were last marked.
    marked_at: Versions,
    /// The largest difference of the slots of a candidate.
    span: usize,
}

/// Numbers of changes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Versions {
    /// Changes of the list.
    list: u64,
    /// Changes of the choice.
    choice: u64,
}

/// The particles whose pairs are marked.
#[derive(Clone, Copy, Debug)]
pub struct Chosen<'a> {
    /// For each particle: 1 if its pairs are marked, else 0.
    pub particles: &'a [u8],
    /// The particles that the last change of the choice has changed, ascending.
    pub changed: &'a [usize],
    /// Number of changes of the choice.
    pub version: u64,
}

impl Marks {
    /// Marks the pairs that contain a chosen particle, and no others. `version` is that of the list with these `pairs`.
    pub(super) fn mark(&mut self, version: u64, pairs: &mut [Candidate], chosen: Chosen<'_>) {
        let now = Versions { list: version, choice: chosen.version };
        let before = std::mem::replace(&mut self.marked_at, now);
        if before == now {
            return;
        }
        if before == (Versions { choice: now.choice.wrapping_sub(1), ..now }) {
            mark_near(pairs, self.span, chosen);
        } else {
            self.span = pairs.iter().map(|pair| pair.row() - pair.partner()).max().unwrap_or(0);
            mark_all(pairs, chosen);
        }
    }
}

/// Marks anew the pairs, ascending, that may contain one of the changed particles.
fn mark_near(pairs: &mut [Candidate], span: usize, chosen: Chosen<'_>) {
    let mut changed = chosen.changed.iter().peekable();
    while let Some(&particle) = changed.next() {
        let mut end = particle + span + 1;
        while let Some(&next) = changed.next_if(|&&next| next <= end) {
            end = next + span + 1;
        }
        let range = rows(pairs, particle..end);
        mark_all(&mut pairs[range], chosen);
    }
}

/// Returns the places of the pairs, ascending, of a range of rows.
fn rows(pairs: &[Candidate], rows: Range<usize>) -> Range<usize> {
    let start = pairs.partition_point(|pair| pair.row() < rows.start);
    start..start + pairs[start..].partition_point(|pair| pair.row() < rows.end)
}

fn mark_all(pairs: &mut [Candidate], Chosen { particles, .. }: Chosen<'_>) {
    for pair in pairs {
        let [i, j] = pair.slots();
        *pair = pair.with_mark(particles[i] | particles[j]);
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::neighbours::list::PairList;

    proptest! {
        /// After changes of few or many particles, and after a renewal of the list, the pairs of chosen particles are marked.
        #[test]
        fn pairs_of_chosen_particles_are_marked(
            pairs in prop::collection::btree_set((0u32..300, 1u32..9), 0..900),
            changes in prop::collection::vec((prop::collection::btree_set(0usize..308, 0..40), any::<bool>()), 1..6),
        ) {
            let mut all: Vec<_> = pairs.iter().map(|&(i, apart)| Candidate::of_slots(i, i + apart)).collect();
            all.sort_unstable();
            let mut list = PairList::default();
            list.fill(all.iter().copied(), 308);
            list.assign_tasks(308, 3, 64);
            let mut particles = vec![0; 308];
            for (version, (changed, renews)) in (1..).zip(changes) {
                let changed: Vec<_> = changed.into_iter().collect();
                for &particle in &changed {
                    particles[particle] ^= 1;
                }
                if renews {
                    let former = list.pairs().to_vec();
                    list.fill(former.into_iter(), 308);
                    prop_assert_eq!(list.pairs(), &all[..]);
                    list.assign_tasks(308, 2, 64);
                }
                list.mark(Chosen { particles: &particles, changed: &changed, version });
                let chosen = |pair: &&Candidate| pair.slots().iter().any(|&slot| particles[slot] > 0);
                let expected: Vec<_> = all.iter().filter(chosen).map(|pair| pair.slots()).collect();
                let marked = list.pairs().iter().filter(|pair| pair.mark() > 0).map(|pair| pair.slots());
                prop_assert_eq!(marked.collect::<Vec<_>>(), expected);
            }
        }
    }
}
