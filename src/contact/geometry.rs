//! Where a contact is made: between two particles, or between a particle and a flat wall.
//!
//! Two particles touch when |x_ij| < R_i + R_j; overlap R_i + R_j - |x_ij|, normal x_ij/|x_ij|, relative velocity v_i - v_j, reduced mass
//! 1/(1/m_i + 1/m_j). For a wall, x_j is its nearest point, R_j = 0 in the overlap and infinite in the curvature, and 1/m_j = 0; a half-space has
//! its own normal and a distance that is negative inside. Lengths come from one inverse root ([`ContactLine`]), here and in the kernel's lanes
//! (`batch/bodies.rs`): so whoever looks at a contact sees the bits that the force pass saw.

use crate::contact::root::inverse_root;
use crate::contact::{Pair, VelocityPrediction};
use crate::particle::GrainId;
use crate::space::{COINCIDENT, Linear, PARTED, Space};
use crate::store::{Body, ParticleStore};
use crate::walls::surfaces::{FlatWall, Nearest};

/// What follows from the separation of two and from their masses alone.
pub(super) struct ContactLine<V> {
    /// Unit vector from j to i.
    pub normal: V,
    /// m.
    pub distance: f64,
    /// kg.
    pub reduced_mass: f64,
}

impl<V: Space> ContactLine<V> {
    /// That of two which are this vector (m) apart, not less than [`COINCIDENT`], and whose inverse masses add up to `mobility` (1/kg): what would
    /// take a root and two divisions, from one root.
    #[inline(always)]
    pub(super) fn new(separation: V, mobility: f64) -> Self {
        let squared = separation.length_squared();
        // 1/d and 1/mobility from one root.
        let both = inverse_root(squared * (mobility * mobility));
        let inverse_distance = both * mobility;
        let distance = squared * inverse_distance;
        Self { normal: separation * inverse_distance, distance, reduced_mass: both * distance }
    }

    /// That of a particle and a wall.
    #[inline(always)]
    fn to_wall(body: &Body<V>, wall: &FlatWall<V>) -> Self {
        match wall.surface.nearest(body.position) {
            Nearest::Point(away) => Self::new(away, body.inverse_mass),
            Nearest::Half { normal, distance } => Self { normal, distance, reduced_mass: 1.0 / body.inverse_mass },
        }
    }
}

/// The contact of entries `i` and `j` if they overlap and at least one can move; with the root of the reduced mass if it is asked for.
// A pair is large: handed over in memory, and copied, each contact would wait for its own stores.
#[inline(always)]
#[must_use]
pub fn touching<V: Space>(store: &ParticleStore<V>, i: usize, j: usize, root: bool) -> Option<Pair<V>> {
    let (a, b) = (&store.body[i], &store.body[j]);
    let (separation, reach) = (store.separation(a.position, b.position), a.radius + b.radius);
    let squared = separation.length_squared();
    // Written so that a NaN does not touch.
    if squared < reach * reach && !(store.is_fixed(i) && store.is_fixed(j)) {
        Some(between(store, [i, j], separation, root, 0.0))
    } else {
        None
    }
}

/// The geometry of two particles that were in contact in the step before.
pub(super) fn parted<V: Space>(store: &ParticleStore<V>, i: usize, j: usize, dt: f64) -> Pair<V> {
    let separation = store.separation(store.body[i].position, store.body[j].position);
    between(store, [i, j], separation, true, dt)
}

/// Two particles that are this vector apart, m.
#[inline(always)]
fn between<V: Space>(store: &ParticleStore<V>, both: [usize; 2], separation: V, root: bool, dt: f64) -> Pair<V> {
    let [a, b] = both.map(|entry| &store.body[entry]);
    let separation = if separation.length_squared() < COINCIDENT {
        coincident::<V>(store.id[both[0]], store.id[both[1]]) * PARTED
    } else {
        separation
    };
    let ContactLine { normal, distance, reduced_mass } = ContactLine::new(separation, a.inverse_mass + b.inverse_mass);
    Pair {
        normal,
        overlap: a.radius + b.radius - distance,
        relative_velocity: a.velocity - b.velocity,
        reduced_mass,
        root: if root { reduced_mass.sqrt() } else { 0.0 },
        radii: [a.radius, b.radius],
        inverse_reach: 1.0 / (a.radius + b.radius),
        spins: both.map(|entry| store.spin(entry)),
        species: both.map(|entry| store.species[entry]),
        dt,
        ahead: VelocityPrediction::default(),
    }
}

/// The contact of movable entry `i` with a wall, if they touch (`PREDICTION`: within half a step).
#[inline(always)]
#[must_use]
pub fn touching_wall<const PREDICTION: bool, V: Space>(
    store: &ParticleStore<V>,
    i: usize,
    wall: &FlatWall<V>,
    root: bool,
    dt: f64,
) -> Option<Pair<V>> {
    let body = &store.body[i];
    let line = ContactLine::to_wall(body, wall);
    let window = if PREDICTION { 0.5 * dt * (body.velocity - wall.velocity).dot(line.normal).abs() } else { 0.0 };
    // Written so that a NaN does not touch.
    if !(line.distance < body.radius + window && wall.is_present) {
        return None;
    }
    let mut pair = at_wall(store, i, wall, line, root, dt);
    if PREDICTION {
        let (gain, spin) = (&store.gain[i], store.spin_gain.get(i).copied().unwrap_or_default());
        pair.ahead = VelocityPrediction {
            velocity: gain.velocity,
            spins: [spin.spin, V::Spin::ZERO],
            inverse_masses: [body.inverse_mass, 0.0],
            inverse_inertias: [spin.inverse_inertia, 0.0],
            only_contact: [gain.only_contact, 0.0],
        };
    }
    Some(pair)
}

/// The geometry of movable entry `i` and a wall that it has just left.
pub(super) fn parted_from_wall<V: Space>(store: &ParticleStore<V>, i: usize, wall: &FlatWall<V>, dt: f64) -> Pair<V> {
    at_wall(store, i, wall, ContactLine::to_wall(&store.body[i], wall), true, dt)
}

/// Movable entry `i` and a wall, which are so far apart.
#[inline(always)]
fn at_wall<V: Space>(
    store: &ParticleStore<V>,
    i: usize,
    wall: &FlatWall<V>,
    line: ContactLine<V>,
    root: bool,
    dt: f64,
) -> Pair<V> {
    let body = &store.body[i];
    let ContactLine { normal, distance, reduced_mass } = line;
    Pair {
        normal,
        overlap: body.radius - distance,
        relative_velocity: body.velocity - wall.velocity,
        reduced_mass,
        root: if root { reduced_mass.sqrt() } else { 0.0 },
        radii: [body.radius, f64::INFINITY],
        inverse_reach: 0.0,
        spins: [store.spin(i), V::Spin::ZERO],
        species: [store.species[i], wall.species],
        dt,
        ahead: VelocityPrediction::default(),
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
