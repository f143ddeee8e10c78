//! Moves the spheres of free bodies after the drift.
//!
//! A sphere at b in the body is at X + R b and moves with V + w x R b. In the middle of a step it moves with its displacement over dt, so that
//! springs follow the positions. The arm R b comes from the orientation: a sphere wraps at a periodic side by itself.
//!
//! The pass goes over spheres, on all threads. Each reads its body, which is near in memory because both are in the order of space.

use crate::integrate::recorded_velocity::Swept;
use crate::space::{Linear, Rotor, Space};
use crate::store::{BodyColumns, ChunkedPass, LongestMove, ParticleStore};

/// Moves the spheres of free bodies after a drift of `dt`, s.
pub(super) fn scatter<V: Space>(dt: f64, chunked: &ChunkedPass, store: &mut ParticleStore<V>) {
    let predicts = store.predicts();
    let longest = if predicts && store.prediction.sweeps {
        let mut swept = std::mem::take(&mut store.prediction.swept);
        let longest = scatter_by(dt, &mut swept, chunked, store);
        store.prediction.swept = swept;
        longest
    } else {
        // Values without size: the vector allocates nothing.
        let mut swept = vec![(); store.body.len()];
        scatter_by(dt, &mut swept, chunked, store)
    };
    // The drift has counted the moves of all centres. The longest move of all particles counts; NaN stays.
    let beyond = longest - store.bodies.drifted;
    store.travel += if beyond <= 0.0 { 0.0 } else { beyond };
    if predicts {
        store.widen_margin(longest);
    }
}

/// Moves the spheres and writes their swept radii. Returns the longest move, m.
fn scatter_by<V: Space, W: Swept>(
    dt: f64,
    swept: &mut [W],
    chunked: &ChunkedPass,
    store: &mut ParticleStore<V>,
) -> f64 {
    let predicts = store.predicts();
    let range = store.prediction.range;
    let end = store.free_end;
    let count = store.body.len();
    let ParticleStore { bodies, body, rotation, prediction, periodic, .. } = store;
    // Without prediction nobody reads these two.
    prediction.middle.resize(count, V::MiddleBesideBody::default());
    prediction.middle_spin.resize(count, V::Spin::ZERO);
    let periodic = *periodic;
    let BodyColumns { rotor, arm, in_body, spheres, first_sphere, .. } = bodies;
    let rotor = &rotor[..];
    let first = *first_sphere;
    let spheres = &spheres[..end - first];
    let (carrier, body) = split(body, first);
    let (carrier_rotation, rotation) = split(rotation, first);
    let (carrier_middle, middle) = split(&mut prediction.middle, first);
    let (carrier_spin, middle_spin) = split(&mut prediction.middle_spin, first);
    let size = end - first;
    let places = ((&in_body[..size], &mut arm[..size]), &mut body[..size]);
    let middles = (&mut middle[..size], &mut middle_spin[..size]);
    let per_time = 1.0 / dt;
    let longest = chunked.in_chunks(
        spheres,
        (places, ((&mut rotation[..size], &mut swept[first..end]), middles)),
        #[inline(always)]
        move |of, (((in_body, arm), sphere), ((rotation, swept), (middle, middle_spin))), longest: &mut LongestMove| {
            let b = of.body.index();
            let centre = &carrier[b];
            let spin = carrier_rotation[b].spin;
            let turned = rotor[b].turn(*in_body);
            let before = std::mem::replace(arm, turned);
            let velocity = if predicts { V::middle(&centre.middle, &carrier_middle[b]) } else { centre.velocity };
            let moved = velocity * dt + (turned - before);
            let squared = longest.raise(moved);
            sphere.position = centre.position + turned;
            if let Some(periodic) = periodic {
                periodic.wrap(&mut sphere.position);
            }
            rotation.spin = spin;
            // In the middle of the step.
            let velocity = moved * per_time;
            if predicts {
                sphere.velocity = centre.velocity + turned.turned_by(spin);
                V::set_middle(velocity, &mut sphere.middle, middle);
                *middle_spin = carrier_spin[b];
                *swept = W::of(sphere.radius, squared, range);
            } else {
                sphere.velocity = velocity;
            }
        },
    );
    longest.into_iter().fold(LongestMove::default(), LongestMove::or).length()
}

/// Returns the entries before `first`, to be read, and those from it on.
fn split<T>(column: &mut [T], first: usize) -> (&[T], &mut [T]) {
    let (before, from) = column.split_at_mut(first);
    (before, from)
}
