//! Totals over all grains at one time: energies, largest speed and overlap, coordination number.
//!
//! Kinetic energy uses full-step velocities. Gravitational energy is -m g.x, zero at the origin. The coordination
//! number is the mean number of contacts of a grain, with grains and walls. Sums run in ascending order of slots.

use bevy_ecs::prelude::*;
use serde::Serialize;

use siloflow_dem::gravity::Gravity;
use siloflow_dem::space::{Dimension, Plane, Solid, Space};
use siloflow_dem::survey::{Partner, Survey};

/// Results of the measurement, SI.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub struct Totals {
    /// Number of free grains in the world.
    pub grains: usize,
    /// Kinetic energy of translation, J.
    pub kinetic: f64,
    /// Kinetic energy of rotation, J.
    pub rotational: f64,
    /// Gravitational energy, J.
    pub potential: f64,
    /// Elastic energy of contacts, J.
    pub elastic: f64,
    /// Largest speed, m/s.
    pub largest_speed: f64,
    /// Largest ratio of overlap to the smaller radius of a pair.
    pub largest_overlap_ratio: f64,
    /// Mean overlap of contacts between grains, over the mean radius of the pair; 0 without such contacts.
    pub mean_overlap_ratio: f64,
    /// Coordination number.
    pub coordination: f64,
}

impl Totals {
    /// Measures the state of `survey`; `gravity` in m/s^2.
    #[must_use]
    pub fn measure<V: Space>(survey: &Survey<V>, gravity: V) -> Self {
        let store = survey.store;
        let mut totals = Self::default();
        for i in store.integrated_rows() {
            totals.grains += 1;
            totals.kinetic += store.kinetic_energy(i);
            totals.rotational += store.rotational_energy(i);
            totals.potential -= store.mass[i] * gravity.dot(store.body[i].position);
            totals.largest_speed = totals.largest_speed.max(store.body[i].velocity.length());
        }
        let mut largest = 0.0f64;
        let mut ends = 0u32;
        let mut overlaps = 0.0;
        let mut pairs = 0u32;
        survey.contacts(|i, partner, pair, memory| {
            totals.elastic += survey.law.elastic_energy(pair, memory);
            let (radius, other_is_grain) = match partner {
                Partner::Particle(j) => (store.body[i].radius.min(store.body[j].radius), !store.is_fixed(j)),
                Partner::Wall(_) => (store.body[i].radius, false),
            };
            largest = largest.max(pair.overlap / radius);
            if let Partner::Particle(j) = partner
                && !store.is_fixed(i)
                && other_is_grain
            {
                overlaps += 2.0 * pair.overlap / (store.body[i].radius + store.body[j].radius);
                pairs += 1;
            }
            ends += u32::from(!store.is_fixed(i)) + u32::from(other_is_grain);
        });
        totals.largest_overlap_ratio = largest;
        totals.mean_overlap_ratio = overlaps / f64::from(pairs.max(1));
        #[expect(clippy::cast_precision_loss, reason = "fewer than 2^32 grains")]
        let grains = totals.grains.max(1) as f64;
        totals.coordination = f64::from(ends) / grains;
        totals
    }

    /// Returns the sum of kinetic, rotational, gravitational and elastic energy, J.
    #[must_use]
    pub fn energy(&self) -> f64 {
        self.kinetic + self.rotational + self.potential + self.elastic
    }
}

/// Measures the totals of a world at any time.
#[must_use]
pub fn of_world(world: &World) -> Totals {
    fn of<V: Space>(world: &World) -> Totals {
        Totals::measure(&Survey::<V>::of_world(world), world.resource::<Gravity<V>>().0)
    }
    match Dimension::of_world(world) {
        Dimension::Plane => of::<Plane>(world),
        Dimension::Solid => of::<Solid>(world),
    }
}
