//! The kernel: the sum of pair forces over the columns.
//!
//! Two loops give the same bits. On one thread each pair is evaluated once, walked i < j with both ascending, and
//! added to both: grain i has then received its partners in ascending order. On several threads every particle
//! sums its own partners in ascending order, so each pair is evaluated twice. Laws are odd under the exchange of i
//! and j to the last bit, and only touching pairs add, so the candidates that a neighbour search offers beyond those
//! leave no trace.

use rayon::prelude::*;

use crate::columns::{Body, Columns};
use crate::contact::{Pair, PairForce, PairLaw};
use crate::particle::GrainId;
use crate::space::Vector;

/// Where candidates come from.
pub trait Partners: Sync {
    /// Every particle that may touch `i`, ascending: those above `i` for a half walk, all others (`i` itself may be
    /// among them) for a full one. `scratch` is the caller's, to be used at will.
    fn of<'a>(&'a self, columns: &Columns, i: usize, scratch: &'a mut Vec<u32>) -> &'a [u32];
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

/// The candidates of `i` that overlap it, in their order, kept in `buffer`. Whether a candidate touches is hard to
/// foresee, so this loop has no branch on it: each is written, and the end moves on if it counts.
#[inline]
fn filter<'a>(bodies: &[Body], i: usize, candidates: &[u32], buffer: &'a mut Vec<u32>) -> &'a [u32] {
    let body = &bodies[i];
    if buffer.len() < candidates.len() {
        buffer.resize(candidates.len(), 0);
    }
    let mut count = 0;
    for &j in candidates {
        let other = &bodies[j as usize];
        let reach = body.radius + other.radius;
        buffer[count] = j;
        count += usize::from(body.position.distance_squared(other.position) < reach * reach);
    }
    &buffer[..count]
}

/// The geometry of `i` and `j` if they touch and at least one can move.
#[inline(always)]
#[expect(clippy::inline_always, reason = "the body of the innermost loop: a call would double its cost")]
#[must_use]
pub fn touching(columns: &Columns, i: usize, j: usize) -> Option<Pair> {
    let (a, b) = (&columns.body[i], &columns.body[j]);
    let separation = a.position - b.position;
    let reach = a.radius + b.radius;
    let squared = separation.length_squared();
    // Written so that a NaN does not touch: the finite-value check names it at the end of the step.
    if squared < reach * reach {
        let inverse_mass = a.inverse_mass + b.inverse_mass;
        if inverse_mass == 0.0 {
            return None;
        }
        let distance = squared.sqrt();
        let normal = if distance > 0.0 { separation / distance } else { coincident(columns.id[i], columns.id[j]) };
        Some(Pair {
            normal,
            overlap: reach - distance,
            relative_velocity: a.velocity - b.velocity,
            reduced_mass: 1.0 / inverse_mass,
        })
    } else {
        None
    }
}

/// A normal for coincident centres: fixed by the two ids, odd under their swap.
#[cold]
fn coincident(i: GrainId, j: GrainId) -> Vector {
    let (low, high) = if i < j { (i, j) } else { (j, i) };
    let mixed = low.number().wrapping_mul(0x9E37_79B1) ^ high.number().wrapping_mul(0x85EB_CA77);
    let direction = Vector::from_angle(f64::from(mixed));
    if i < j { direction } else { -direction }
}

/// Adds all pair forces to the loads of `columns`, each pair once.
pub fn half<L: PairLaw>(law: &L, columns: &mut Columns, partners: &impl Partners) -> OverlapRatio {
    let mut loads = std::mem::take(&mut columns.load);
    let mut largest = OverlapRatio::default();
    let (mut scratch, mut buffer) = (Vec::new(), Vec::new());
    for i in 0..columns.movable_end {
        let mut on_i = loads[i];
        for &j in filter(&columns.body, i, partners.of(columns, i, &mut scratch), &mut buffer) {
            let j = j as usize;
            if let Some(pair) = touching(columns, i, j) {
                let PairForce { elastic, drag } = law.force(&pair);
                let (sum, on_j) = (elastic + drag, &mut loads[j]);
                on_i.force += sum;
                on_i.drag += drag;
                on_j.force -= sum;
                on_j.drag -= drag;
                largest.raise(pair.overlap, columns.body[i].radius.min(columns.body[j].radius));
            }
        }
        loads[i] = on_i;
    }
    columns.load = loads;
    largest
}

/// The same sums, each particle for itself, on the threads of the current rayon pool.
pub fn full<L: PairLaw>(law: &L, columns: &mut Columns, partners: &impl Partners) -> OverlapRatio {
    const CHUNK: usize = 256;
    let mut loads = std::mem::take(&mut columns.load);
    let view = &*columns;
    let largest = loads
        .par_chunks_mut(CHUNK)
        .enumerate()
        .map_init(<(Vec<u32>, Vec<u32>)>::default, |(scratch, buffer), (chunk, loads)| {
            let mut largest = OverlapRatio::default();
            for (i, load) in (chunk * CHUNK..).zip(loads) {
                for &j in filter(&view.body, i, partners.of(view, i, scratch), buffer) {
                    let j = j as usize;
                    if i == j {
                        continue;
                    }
                    if let Some(pair) = touching(view, i, j) {
                        let PairForce { elastic, drag } = law.force(&pair);
                        load.force += elastic + drag;
                        load.drag += drag;
                        largest.raise(pair.overlap, view.body[i].radius.min(view.body[j].radius));
                    }
                }
            }
            largest
        })
        .reduce(OverlapRatio::default, |mut a, b| {
            a.merge(b);
            a
        });
    columns.load = loads;
    largest
}
