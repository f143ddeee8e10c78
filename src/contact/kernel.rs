//! The kernel: the sum of pair forces over the columns.
//!
//! Two loops give the same bits. On one thread each pair is evaluated once, walked i < j with both ascending, and
//! added to both: grain i has then received its partners in ascending order. On several threads every particle
//! sums its own partners in ascending order, so each pair is evaluated twice. Laws are odd under the exchange of i
//! and j to the last bit, and only touching pairs add, so the candidates that a neighbour search offers beyond those
//! leave no trace. What a law does not demand ([`Demands`]) is not compiled.

use rayon::prelude::*;

use crate::columns::{Body, Columns, Load, Turn};
use crate::contact::history::{Book, CHUNK, History, Recall};
use crate::contact::{Demands, Memory, Pair, PairForce, PairLaw};
use crate::particle::{GrainId, Species};
use crate::periodic::Metric;
use crate::space::{Linear, Space};

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

/// The candidates of `i` that overlap it, in their order, kept in `buffer`. Whether a candidate touches is hard to
/// foresee, so this loop has no branch on it: each is written, and the end moves on if it counts.
#[inline]
fn filter<'a, V: Space>(
    metric: &impl Metric<V>,
    bodies: &[Body<V>],
    i: usize,
    candidates: &[u32],
    buffer: &'a mut Vec<u32>,
) -> &'a [u32] {
    let body = &bodies[i];
    if buffer.len() < candidates.len() {
        buffer.resize(candidates.len(), 0);
    }
    let mut count = 0;
    for &j in candidates {
        let other = &bodies[j as usize];
        let reach = body.radius + other.radius;
        buffer[count] = j;
        let squared = metric.separation(body.position, other.position).length_squared();
        count += usize::from(squared < reach * reach);
    }
    &buffer[..count]
}

/// The geometry of `i` and `j` if they touch and at least one can move; spins and species are left out.
#[inline(always)]
#[expect(clippy::inline_always, reason = "the body of the innermost loop: a call would double its cost")]
#[must_use]
pub fn touching<V: Space>(
    metric: &impl Metric<V>,
    columns: &Columns<V>,
    i: usize,
    j: usize,
    dt: f64,
) -> Option<Pair<V>> {
    let (a, b) = (&columns.body[i], &columns.body[j]);
    let separation = metric.separation(a.position, b.position);
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
            radii: [a.radius, b.radius],
            spins: [V::Spin::ZERO; 2],
            species: [Species(0); 2],
            dt,
        })
    } else {
        None
    }
}

/// The geometry of two that were in contact in the step before.
fn parted<V: Space>(metric: &impl Metric<V>, columns: &Columns<V>, i: usize, j: usize, dt: f64) -> Pair<V> {
    let (a, b) = (&columns.body[i], &columns.body[j]);
    let separation = metric.separation(a.position, b.position);
    let spin = |i: usize| columns.spin.get(i).copied().unwrap_or_default();
    Pair {
        normal: separation.unit_or_zero(),
        overlap: a.radius + b.radius - separation.length(),
        relative_velocity: a.velocity - b.velocity,
        reduced_mass: 1.0 / (a.inverse_mass + b.inverse_mass),
        radii: [a.radius, b.radius],
        spins: [spin(i), spin(j)],
        species: [columns.species[i], columns.species[j]],
        dt,
    }
}

/// A normal for coincident centres: fixed by the two ids, odd under their swap.
#[cold]
fn coincident<V: Space>(i: GrainId, j: GrainId) -> V {
    let (low, high) = if i < j { (i, j) } else { (j, i) };
    let mixed = low.number().wrapping_mul(0x9E37_79B1) ^ high.number().wrapping_mul(0x85EB_CA77);
    let direction = V::direction(mixed);
    if i < j { direction } else { -direction }
}

/// What a pass needs besides the columns.
pub struct Pass<'a, L, M> {
    /// The contact law.
    pub law: &'a L,
    /// How separations are measured.
    pub metric: M,
    /// By how much memories advance, s.
    pub dt: f64,
}

impl<L: Demands, M> Pass<'_, L, M> {
    /// The pair and the force on `i`, if it touches `j`.
    #[inline(always)]
    #[expect(clippy::inline_always, reason = "the body of the innermost loop: a call would double its cost")]
    fn meet<V: Space>(
        &self,
        columns: &Columns<V>,
        i: usize,
        j: usize,
        recall: &mut Option<Recall<V>>,
        ended: &mut Ended,
    ) -> Option<(Pair<V>, PairForce<V>, Memory<V>)>
    where
        L: PairLaw<V>,
        M: Metric<V>,
    {
        let mut pair = touching(&self.metric, columns, i, j, self.dt)?;
        if L::SPIN {
            pair.spins = [columns.spin[i], columns.spin[j]];
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
    pub fn half<V: Space>(
        &self,
        columns: &mut Columns<V>,
        partners: &dyn Partners<V>,
        book: &mut Book<V>,
    ) -> OverlapRatio
    where
        L: PairLaw<V>,
        M: Metric<V>,
    {
        let (mut loads, mut turns) = (std::mem::take(&mut columns.load), std::mem::take(&mut columns.turn));
        let (before, pages) = book.turn();
        let mut largest = OverlapRatio::default();
        let (mut scratch, mut buffer) = (Vec::new(), Vec::new());
        for i in 0..columns.movable_end {
            let mut on_i = loads[i];
            let mut turn_i = if L::SPIN { turns[i] } else { Turn::default() };
            let mut recall = L::MEMORY.then(|| Recall::new(before, i));
            let mut ended = Ended::default();
            let candidates = partners.of(columns, i, &mut scratch);
            for &partner in filter(&self.metric, &columns.body, i, candidates, &mut buffer) {
                let j = partner as usize;
                if let Some((pair, force, memory)) = self.meet(columns, i, j, &mut recall, &mut ended) {
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
        (columns.load, columns.turn) = (loads, turns);
        largest
    }

    /// The same sums, each particle for itself, on the threads of the current rayon pool.
    pub fn full<V: Space>(
        &self,
        columns: &mut Columns<V>,
        partners: &dyn Partners<V>,
        history: &mut History<V>,
    ) -> OverlapRatio
    where
        L: PairLaw<V>,
        M: Metric<V>,
    {
        let (mut loads, mut turns) = (std::mem::take(&mut columns.load), std::mem::take(&mut columns.turn));
        let view = &*columns;
        let mut turn_chunks = turns.chunks_mut(CHUNK);
        let mut books = history.pairs.iter_mut();
        let shares: Vec<Share<V>> = (0..)
            .step_by(CHUNK)
            .zip(loads.chunks_mut(CHUNK))
            .map(|(first, loads)| Share {
                first,
                loads,
                turns: turn_chunks.next().unwrap_or_default(),
                book: if L::MEMORY { books.next() } else { None },
            })
            .collect();
        let largest = share_out(shares, &|share, buffers| self.full_share(view, partners, share, buffers));
        (columns.load, columns.turn) = (loads, turns);
        largest
    }

    fn full_share<V: Space>(
        &self,
        view: &Columns<V>,
        partners: &dyn Partners<V>,
        share: Share<V>,
        (scratch, buffer): &mut Buffers,
    ) -> OverlapRatio
    where
        L: PairLaw<V>,
        M: Metric<V>,
    {
        let mut largest = OverlapRatio::default();
        let mut pages = share.book.map(Book::turn);
        for (row, load) in share.loads.iter_mut().enumerate() {
            let i = share.first + row;
            let mut recall = pages.as_ref().map(|(before, _)| Recall::new(before, row));
            let mut ended = Ended::default();
            let candidates = partners.of(view, i, scratch);
            for &partner in filter(&self.metric, &view.body, i, candidates, buffer) {
                let j = partner as usize;
                if i == j {
                    continue;
                }
                if let Some((pair, force, memory)) = self.meet(view, i, j, &mut recall, &mut ended) {
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
    book: Option<&'a mut Book<V>>,
}

/// What the springs of contacts that ended held, J: it is lost to friction and rolling resistance.
#[derive(Default)]
pub(crate) struct Ended {
    sliding: f64,
    rolling: f64,
}

impl Ended {
    /// Adds a contact of entry `i`; that with a lower entry is booked there.
    #[cold]
    fn add<V: Space, L: PairLaw<V> + Demands, M: Metric<V>>(
        &mut self,
        pass: &Pass<L, M>,
        columns: &Columns<V>,
        i: usize,
        partner: u32,
        memory: &Memory<V>,
    ) {
        let j = partner as usize;
        if i < j {
            self.add_pair(pass.law, &parted(&pass.metric, columns, i, j, pass.dt), memory);
        }
    }

    /// Adds a contact whose two have parted.
    pub(crate) fn add_pair<V: Space, L: PairLaw<V>>(&mut self, law: &L, pair: &Pair<V>, memory: &Memory<V>) {
        let [sliding, rolling] = law.forget(pair, memory);
        self.sliding += sliding;
        self.rolling += rolling;
    }

    /// Whether there was one.
    pub(crate) fn is_any(&self) -> bool {
        self.sliding != 0.0 || self.rolling != 0.0
    }

    pub(crate) fn book<V: Space>(&self, turn: &mut Turn<V>) {
        turn.lost_by_sliding += self.sliding;
        turn.lost_by_rolling += self.rolling;
    }
}

/// The whole force on i.
#[inline]
pub(crate) fn total<L: Demands, V: Space>(force: &PairForce<V>) -> V {
    let smooth = force.elastic + force.drag;
    if L::SPIN { smooth + force.turning.friction } else { smooth }
}

/// Adds the torques of a contact on its first (`side` 0) or second member.
#[inline]
pub(crate) fn turn<L: Demands, V: Space>(turn: &mut Turn<V>, pair: &Pair<V>, force: &PairForce<V>, side: usize) {
    let friction = &force.turning;
    let arm = pair.normal * -friction.arms[side];
    turn.torque += arm.cross(friction.friction);
    turn.friction_drag_torque += arm.cross(friction.friction_drag);
    if side == 0 {
        turn.friction_drag += friction.friction_drag;
    } else {
        turn.friction_drag -= friction.friction_drag;
    }
    if L::ROLLING {
        let (rolling, drag) = if side == 0 {
            (friction.rolling, friction.rolling_drag)
        } else {
            (-friction.rolling, -friction.rolling_drag)
        };
        turn.torque += rolling;
        turn.rolling_drag_torque += drag;
    }
}

/// Books what sliding took at one of the two.
#[inline]
pub(crate) fn book_losses<L: Demands, V: Space>(turn: &mut Turn<V>, force: &PairForce<V>) {
    turn.lost_by_sliding += force.turning.lost_by_sliding;
    if L::ROLLING {
        turn.lost_by_rolling += force.turning.lost_by_rolling;
    }
}
