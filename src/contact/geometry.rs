//! The geometry of pairs: who touches, how deep, along which normal.

use crate::columns::Columns;
use crate::contact::{Ahead, Pair};
use crate::particle::GrainId;
use crate::periodic::Metric;
use crate::space::Space;

/// The geometry of `i` and `j` if they overlap and at least one can move; with the root of the reduced mass if it is asked for.
// A pair is large: handed over in memory, and copied, each contact would wait for its own stores.
#[inline(always)]
#[must_use]
pub fn touching<V: Space>(
    metric: &impl Metric<V>,
    columns: &Columns<V>,
    i: usize,
    j: usize,
    root: bool,
) -> Option<Pair<V>> {
    let (a, b) = (&columns.body[i], &columns.body[j]);
    let separation = metric.separation(a.position, b.position);
    let reach = a.radius + b.radius;
    let squared = separation.length_squared();
    if squared < reach * reach {
        if columns.is_fixed(i) && columns.is_fixed(j) {
            return None;
        }
        let distance = squared.sqrt();
        let normal =
            if distance > 0.0 { separation * (1.0 / distance) } else { coincident(columns.id[i], columns.id[j]) };
        Some(pair(columns, i, j, normal, reach - distance, root, 0.0))
    } else {
        None
    }
}

/// The geometry of two that were in contact in the step before.
pub(super) fn parted<V: Space>(metric: &impl Metric<V>, columns: &Columns<V>, i: usize, j: usize, dt: f64) -> Pair<V> {
    let (a, b) = (&columns.body[i], &columns.body[j]);
    let separation = metric.separation(a.position, b.position);
    pair(columns, i, j, separation.unit_or_zero(), a.radius + b.radius - separation.length(), true, dt)
}

/// Two with this normal and overlap (m).
#[inline(always)]
fn pair<V: Space>(columns: &Columns<V>, i: usize, j: usize, normal: V, overlap: f64, root: bool, dt: f64) -> Pair<V> {
    let ((a, b), both) = ((&columns.body[i], &columns.body[j]), [i, j]);
    let reduced_mass = 1.0 / (a.inverse_mass + b.inverse_mass);
    Pair {
        normal,
        overlap,
        relative_velocity: a.velocity - b.velocity,
        reduced_mass,
        root: if root { reduced_mass.sqrt() } else { 0.0 },
        radii: [a.radius, b.radius],
        inverse_reach: 1.0 / (a.radius + b.radius),
        spins: both.map(|entry| columns.spin(entry)),
        species: both.map(|entry| columns.species[entry]),
        dt,
        ahead: Ahead::default(),
    }
}

/// A normal for coincident centres: fixed by the two ids, odd under their swap.
#[cold]
pub(super) fn coincident<V: Space>(i: GrainId, j: GrainId) -> V {
    let (low, high) = if i < j { (i, j) } else { (j, i) };
    let mixed = low.number().wrapping_mul(0x9E37_79B1) ^ high.number().wrapping_mul(0x85EB_CA77);
    let direction = V::direction(mixed);
    if i < j { direction } else { -direction }
}
