//! The geometry of pairs: who touches, how deep, along which normal.

use crate::columns::{Body, Columns};
use crate::contact::Pair;
use crate::contact::centred::{Ahead, Window};
use crate::particle::{GrainId, Species};
use crate::periodic::Metric;
use crate::space::{Linear, Space};

/// The candidates of `i` that overlap it or are at most `margin` (m) away, in their order, kept in `buffer`. Whether a candidate touches is hard to
/// foresee, so this loop has no branch on it: each is written, and the end moves on if it counts.
#[inline]
pub(super) fn filter<'a, V: Space>(
    metric: &impl Metric<V>,
    bodies: &[Body<V>],
    i: usize,
    margin: f64,
    candidates: &[u32],
    buffer: &'a mut Vec<u32>,
) -> &'a [u32] {
    let body = &bodies[i];
    let extent = body.radius + margin;
    if buffer.len() < candidates.len() {
        buffer.resize(candidates.len(), 0);
    }
    let mut count = 0;
    for &j in candidates {
        let other = &bodies[j as usize];
        let reach = extent + other.radius;
        buffer[count] = j;
        let squared = metric.separation(body.position, other.position).length_squared();
        count += usize::from(squared < reach * reach);
    }
    &buffer[..count]
}

/// The geometry of `i` and `j` if they touch (`AHEAD`: within half a step) and at least one can move; spins and species
/// are left out.
#[inline(always)]
#[expect(clippy::inline_always, reason = "the body of the innermost loop: a call would double its cost")]
#[must_use]
pub fn touching<const AHEAD: bool, V: Space>(
    metric: &impl Metric<V>,
    columns: &Columns<V>,
    i: usize,
    j: usize,
    dt: f64,
) -> Option<Pair<V>> {
    let (a, b) = (&columns.body[i], &columns.body[j]);
    let separation = metric.separation(a.position, b.position);
    let reach = a.radius + b.radius;
    let farthest = if AHEAD { reach + columns.margin } else { reach };
    let squared = separation.length_squared();
    // Written so that a NaN does not touch: the finite-value check names it at the end of the step.
    if squared < farthest * farthest {
        let inverse_mass = a.inverse_mass + b.inverse_mass;
        if inverse_mass == 0.0 {
            return None;
        }
        let distance = squared.sqrt();
        let normal = if distance > 0.0 { separation / distance } else { coincident(columns.id[i], columns.id[j]) };
        let pair = Pair {
            normal,
            overlap: reach - distance,
            relative_velocity: a.velocity - b.velocity,
            reduced_mass: 1.0 / inverse_mass,
            radii: [a.radius, b.radius],
            spins: [V::Spin::ZERO; 2],
            species: [Species(0); 2],
            dt,
            ahead: Ahead::default(),
        };
        if AHEAD {
            // Candidates are as near as the fastest of all grains asks for; this pair has a speed of its own.
            let (gain_i, gain_j) = (&columns.gain[i], &columns.gain[j]);
            let ahead = Ahead {
                velocity: gain_i.velocity - gain_j.velocity,
                inverse_masses: [a.inverse_mass, b.inverse_mass],
                lone: [gain_i.lone, gain_j.lone],
                ..Ahead::default()
            };
            Window::of(&pair).touches(pair.overlap).then_some(Pair { ahead, ..pair })
        } else {
            Some(pair)
        }
    } else {
        None
    }
}

/// The geometry of two that were in contact in the step before.
pub(super) fn parted<V: Space>(metric: &impl Metric<V>, columns: &Columns<V>, i: usize, j: usize, dt: f64) -> Pair<V> {
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
        ahead: Ahead::default(),
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
