//! Read-only system parameters over the particle store, for systems that read all particles, or run in every step.
//!
//! [`Particles`] and [`Motion`] read the store of the force loop directly, in the order of its rows. Nothing is copied
//! for them, unlike for a query of `Position` or `Velocity`. A row belongs to the same particle until a renumbering,
//! after [`Phase::Spawn`](crate::step::Phase::Spawn) of a later step. Particles that have entered since have no row
//! yet. All numbers are SI.
//!
//! ```
//! use siloflow::prelude::*;
//!
//! fn highest(particles: Particles) {
//!     let tops = particles.grains().map(|row| particles.position(row).y + particles.radius(row));
//!     let top = tops.fold(f64::NEG_INFINITY, f64::max); // m
//!     # let _ = top;
//! }
//! ```

use std::ops::Deref;

use bevy_ecs::prelude::*;
use bevy_ecs::system::SystemParam;

use crate::displacement_trigger::TravelMeter;
use crate::particle::{GrainId, Species};
use crate::periodic::Periodic;
use crate::space::{Plane, Space};
use crate::store::{ParticleStore, ReadsMotion, ReadsPlaces};

/// Positions, properties and forces of all particles.
#[derive(SystemParam)]
pub struct Particles<'w, V: Space = Plane> {
    store: Res<'w, ParticleStore<V>>,
    _reads: Res<'w, ReadsPlaces>,
}

impl<V: Space> Particles<'_, V> {
    /// Number of rows.
    #[must_use]
    #[inline]
    pub fn len(&self) -> usize {
        self.store.len()
    }

    /// Whether there are no rows.
    #[must_use]
    #[inline]
    pub fn is_empty(&self) -> bool {
        self.store.is_empty()
    }

    /// The rows of free particles that are present.
    #[inline]
    pub fn grains(&self) -> impl Iterator<Item = usize> {
        self.store.integrated_rows().filter(|&row| self.is_present(row))
    }

    /// The rows of all particles: grains, each once, and fixed particles.
    #[inline]
    pub fn all(&self) -> impl Iterator<Item = usize> {
        (0..self.len()).filter(|&row| self.is_present(row) && self.store.is_whole(row))
    }

    /// The rows of all spheres (discs): particles that are one sphere, and the spheres of shaped grains.
    #[inline]
    pub fn spheres(&self) -> impl Iterator<Item = usize> {
        self.store.contact_rows().filter(|&row| self.is_present(row))
    }

    /// Whether the particle of a row still exists. A particle that left keeps its row until the next renumbering.
    #[must_use]
    #[inline]
    pub fn is_present(&self, row: usize) -> bool {
        self.store.is_present(row)
    }

    /// Whether the particle is fixed: forces do not move it.
    #[must_use]
    #[inline]
    pub fn is_fixed(&self, row: usize) -> bool {
        self.store.is_fixed(row)
    }

    /// The entity of the particle.
    #[must_use]
    #[inline]
    pub fn entity(&self, row: usize) -> Entity {
        self.store.entity[row]
    }

    /// The id of the particle.
    #[must_use]
    #[inline]
    pub fn id(&self, row: usize) -> GrainId {
        self.store.id[row]
    }

    /// The centre, m.
    #[must_use]
    #[inline]
    pub fn position(&self, row: usize) -> V {
        self.store.body[row].position
    }

    /// The radius, m.
    #[must_use]
    #[inline]
    pub fn radius(&self, row: usize) -> f64 {
        self.store.body[row].radius
    }

    /// The mass, kg; 0 for particles without mass.
    #[must_use]
    #[inline]
    pub fn mass(&self, row: usize) -> f64 {
        self.store.mass[row]
    }

    /// The species.
    #[must_use]
    #[inline]
    pub fn species(&self, row: usize) -> Species {
        self.store.species[row]
    }

    /// The sum of the forces on the particle, N, at the last evaluation.
    #[must_use]
    #[inline]
    pub fn force(&self, row: usize) -> V {
        self.store.loads.force.of(row)
    }

    /// The vector from `b` to `a`, m: in a periodic scene, the shortest one.
    #[must_use]
    #[inline]
    pub fn separation(&self, a: V, b: V) -> V {
        self.store.separation(a, b)
    }

    /// The periodic sides of the scene, if it has any.
    #[must_use]
    #[inline]
    pub fn periodic(&self) -> Option<&Periodic<V>> {
        self.store.periodic.as_ref()
    }

    /// The distance that particles can have moved, for systems that need not run in every step.
    #[must_use]
    #[inline]
    pub fn travel_meter(&self) -> TravelMeter {
        self.store.travel_meter()
    }
}

/// Like [`Particles`], with velocities and spins.
#[derive(SystemParam)]
pub struct Motion<'w, V: Space = Plane> {
    particles: Particles<'w, V>,
    _reads: Res<'w, ReadsMotion>,
}

impl<'w, V: Space> Deref for Motion<'w, V> {
    type Target = Particles<'w, V>;

    fn deref(&self) -> &Self::Target {
        &self.particles
    }
}

impl<V: Space> Motion<'_, V> {
    /// The particle store.
    #[must_use]
    #[inline]
    pub fn store(&self) -> &ParticleStore<V> {
        &self.particles.store
    }

    /// The velocity, m/s: v(t+dt/2) from [`Phase::Drift`](crate::step::Phase::Drift) to
    /// [`Phase::Forces`](crate::step::Phase::Forces), elsewhere v(t).
    #[must_use]
    #[inline]
    pub fn velocity(&self, row: usize) -> V {
        self.store().body[row].velocity
    }

    /// The spin, rad/s; zero where nothing spins.
    #[must_use]
    #[inline]
    pub fn spin(&self, row: usize) -> V::Spin {
        self.store().spin(row)
    }

    /// The kinetic energy of translation and rotation, J.
    #[must_use]
    #[inline]
    pub fn kinetic_energy(&self, row: usize) -> f64 {
        self.store().kinetic_energy(row) + self.store().rotational_energy(row)
    }
}
