//! The kernel: the sum of pair forces over the columns.
//!
//! Two loops give the same bits. On one thread each pair is evaluated once, walked i < j with both ascending, and
//! added to both: grain i has then received its partners in ascending order. On several threads every particle
//! sums its own partners in ascending order, so each pair is evaluated twice. Laws are odd under the exchange of i
//! and j to the last bit, and only touching pairs add, so the candidates that a neighbour search offers beyond those
//! leave no trace. What a law does not demand ([`Demands`]) is not compiled.

use rayon::prelude::*;

use crate::columns::{Columns, Load, Turn};
use crate::contact::geometry::{filter, touching};
use crate::contact::history::{Book, CHUNK, History, Recall};
use crate::contact::sums::{Ended, book_losses, total, turn};
use crate::contact::{Demands, Memory, Pair, PairForce, PairLaw};
use crate::periodic::Metric;
use crate::space::Space;

/// Where candidates come from.
pub trait Partners<V: Space>: Sync {
    /// Every particle that may touch `i`, ascending: those above `i` for a half walk, all others (`i` itself may be
    /// among them) for a full one. `scratch` is the caller's, to be used at will.
    fn of<'a>(&'a self, columns: &Columns<V>, i: usize, scratch: &'a mut Vec<u32>) -> &'a [u32];
}

/// The largest overlap of a pass, over the smaller radius of its pair.
#[derive(Clone, Copy, Debug)]
pub struct OverlapRatio {
    overlap: f64,
    radius: f64,
}

impl Default for OverlapRatio {
    fn default() -> Self {
        Self { overlap: 0.0, radius: 1.0 }
    }
}

impl OverlapRatio {
    /// Takes an overlap (m) into account; cross-multiplied, to save the division.
    #[inline]
    pub fn raise(&mut self, overlap: f64, radius: f64) {
        if overlap * self.radius > self.overlap * radius {
            *self = Self { overlap, radius };
        }
    }

    /// Takes another pass into account.
    pub fn merge(&mut self, other: Self) {
        self.raise(other.overlap, other.radius);
    }

    /// Overlap over radius.
    #[must_use]
    pub fn get(self) -> f64 {
        self.overlap / self.radius
    }
}

/// What a pass needs besides the columns.
pub struct Pass<'a, V: Space, L, M> {
    /// The contact law.
    pub law: &'a L,
    /// How separations are measured.
    pub metric: M,
    /// Where candidates come from.
    pub partners: &'a dyn Partners<V>,
    /// By how much memories advance, s.
    pub dt: f64,
}

impl<V: Space, L: PairLaw<V> + Demands, M: Metric<V>> Pass<'_, V, L, M> {
    /// How far apart two may be for the law to look at them, m.
    fn margin(columns: &Columns<V>) -> f64 {
        if L::AHEAD { columns.margin } else { 0.0 }
    }

    #[inline(always)]
    #[expect(clippy::inline_always, reason = "the body of the innermost loop: a call would double its cost")]
    fn touching(&self, columns: &Columns<V>, i: usize, j: usize) -> Option<Pair<V>> {
        if L::AHEAD {
            touching::<true, V>(&self.metric, columns, i, j, self.dt)
        } else {
            touching::<false, V>(&self.metric, columns, i, j, self.dt)
        }
    }

    /// The pair and the force on `i`, if it touches `j`.
    #[inline(always)]
    #[expect(clippy::inline_always, reason = "the body of the innermost loop: a call would double its cost")]
    fn meet(
        &self,
        columns: &Columns<V>,
        i: usize,
        j: usize,
        recall: &mut Option<Recall<V>>,
        ended: &mut Ended,
    ) -> Option<(Pair<V>, PairForce<V>, Memory<V>)> {
        let mut pair = self.touching(columns, i, j)?;
        if L::SPIN {
            pair.spins = [columns.spin[i], columns.spin[j]];
            if L::AHEAD {
                let [gain_i, gain_j] = [columns.spin_gain[i], columns.spin_gain[j]];
                pair.ahead.spins = [gain_i.spin, gain_j.spin];
                pair.ahead.inverse_inertias = [gain_i.inverse_inertia, gain_j.inverse_inertia];
            }
        }
        if L::SPECIES {
            pair.species = [columns.species[i], columns.species[j]];
        }
        #[expect(clippy::cast_possible_truncation, reason = "fewer than 2^32 particles")]
        let mut memory = match recall {
            Some(recall) if L::MEMORY => {
                recall.of::<L>(j as u32, |partner, memory| ended.add(self, columns, i, partner, memory))
            }
            _ => Memory::default(),
        };
        let force = self.law.force(&pair, &mut memory);
        Some((pair, force, memory))
    }

    /// Adds all pair forces to the loads of `columns`, each pair once.
    pub fn half(&self, columns: &mut Columns<V>, book: &mut Book<V>) -> OverlapRatio {
        let (mut loads, mut turns) = (std::mem::take(&mut columns.load), std::mem::take(&mut columns.turn));
        let mut contacts = std::mem::take(&mut columns.contacts);
        let (before, pages) = book.turn();
        let mut largest = OverlapRatio::default();
        let (mut scratch, mut buffer) = (Vec::new(), Vec::new());
        let margin = Self::margin(columns);
        for i in 0..columns.movable_end {
            let mut on_i = loads[i];
            let mut turn_i = if L::SPIN { turns[i] } else { Turn::default() };
            let mut recall = L::MEMORY.then(|| Recall::new(before, i));
            let mut ended = Ended::default();
            let candidates = self.partners.of(columns, i, &mut scratch);
            for &partner in filter(&self.metric, &columns.body, i, margin, candidates, &mut buffer) {
                let j = partner as usize;
                if let Some((pair, force, memory)) = self.meet(columns, i, j, &mut recall, &mut ended) {
                    if L::AHEAD {
                        contacts[i] += 1;
                        contacts[j] += 1;
                    }
                    let (sum, on_j) = (total::<L, V>(&force), &mut loads[j]);
                    on_i.force += sum;
                    on_i.drag += force.drag;
                    on_j.force -= sum;
                    on_j.drag -= force.drag;
                    if L::SPIN {
                        turn::<L, V>(&mut turn_i, &pair, &force, 0);
                        turn::<L, V>(&mut turns[j], &pair, &force, 1);
                        book_losses::<L, V>(&mut turn_i, &force);
                    }
                    if L::MEMORY {
                        pages.push::<L>(partner, &memory);
                    }
                    largest.raise(pair.overlap, pair.radii[0].min(pair.radii[1]));
                }
            }
            loads[i] = on_i;
            if let Some(recall) = &mut recall {
                recall.finish::<L>(|partner, memory| ended.add(self, columns, i, partner, memory));
                pages.end_row();
            }
            if L::SPIN {
                turns[i] = turn_i;
                ended.book(&mut turns[i]);
            }
        }
        (columns.load, columns.turn, columns.contacts) = (loads, turns, contacts);
        largest
    }

    /// The same sums, each particle for itself, on the threads of the current rayon pool.
    pub fn full(&self, columns: &mut Columns<V>, history: &mut History<V>) -> OverlapRatio {
        let (mut loads, mut turns) = (std::mem::take(&mut columns.load), std::mem::take(&mut columns.turn));
        let mut contacts = std::mem::take(&mut columns.contacts);
        let view = &*columns;
        let mut turn_chunks = turns.chunks_mut(CHUNK);
        let mut contact_chunks = contacts.chunks_mut(CHUNK);
        let mut books = history.pairs.iter_mut();
        let shares: Vec<Share<V>> = (0..)
            .step_by(CHUNK)
            .zip(loads.chunks_mut(CHUNK))
            .map(|(first, loads)| Share {
                first,
                loads,
                turns: turn_chunks.next().unwrap_or_default(),
                contacts: contact_chunks.next().unwrap_or_default(),
                book: if L::MEMORY { books.next() } else { None },
            })
            .collect();
        let largest = share_out(shares, &|share, buffers| self.full_share(view, share, buffers));
        (columns.load, columns.turn, columns.contacts) = (loads, turns, contacts);
        largest
    }

    fn full_share(&self, view: &Columns<V>, share: Share<V>, (scratch, buffer): &mut Buffers) -> OverlapRatio {
        let mut largest = OverlapRatio::default();
        let margin = Self::margin(view);
        let mut pages = share.book.map(Book::turn);
        for (row, load) in share.loads.iter_mut().enumerate() {
            let i = share.first + row;
            let mut recall = pages.as_ref().map(|(before, _)| Recall::new(before, row));
            let mut ended = Ended::default();
            let candidates = self.partners.of(view, i, scratch);
            for &partner in filter(&self.metric, &view.body, i, margin, candidates, buffer) {
                let j = partner as usize;
                if i == j {
                    continue;
                }
                if let Some((pair, force, memory)) = self.meet(view, i, j, &mut recall, &mut ended) {
                    if L::AHEAD {
                        share.contacts[row] += 1;
                    }
                    load.force += total::<L, V>(&force);
                    load.drag += force.drag;
                    if L::SPIN {
                        turn::<L, V>(&mut share.turns[row], &pair, &force, 0);
                        if i < j {
                            book_losses::<L, V>(&mut share.turns[row], &force);
                        }
                    }
                    if let Some((_, pages)) = &mut pages {
                        pages.push::<L>(partner, &memory);
                    }
                    largest.raise(pair.overlap, pair.radii[0].min(pair.radii[1]));
                }
            }
            if let Some((_, pages)) = &mut pages {
                if let Some(recall) = &mut recall {
                    recall.finish::<L>(|partner, memory| ended.add(self, view, i, partner, memory));
                }
                pages.end_row();
            }
            if L::SPIN {
                ended.book(&mut share.turns[row]);
            }
        }
        largest
    }
}

/// Does the work of all shares on the threads of the pool. Behind one pointer, so that it is compiled once a space and
/// not once a law.
fn share_out<V: Space>(
    shares: Vec<Share<V>>,
    work: &(dyn Fn(Share<V>, &mut Buffers) -> OverlapRatio + Sync),
) -> OverlapRatio {
    shares.into_par_iter().map_init(Buffers::default, |buffers, share| work(share, buffers)).reduce(
        OverlapRatio::default,
        |mut a, b| {
            a.merge(b);
            a
        },
    )
}

/// Candidates of a particle, and those that it touches.
type Buffers = (Vec<u32>, Vec<u32>);

/// The rows that one thread sums at a time.
struct Share<'a, V: Space> {
    first: usize,
    loads: &'a mut [Load<V>],
    turns: &'a mut [Turn<V>],
    contacts: &'a mut [u32],
    book: Option<&'a mut Book<V>>,
}
