//! The packed particle store, [`ParticleStore`]: the state that the passes of a step read and write, in the order of
//! [`Slot`]s.
//!
//! Every particle is an entity, and some of its components mirror numbers of the store. During a step the store owns
//! these numbers. Before a phase whose systems read a mirrored component, the component is copied from the store. After
//! the phase, values that systems wrote are copied back (`store/component_sync.rs`). If no system uses a component,
//! nothing is copied.
//!
//! Every sum over particles, and above all over contacts, runs in the order of slots. The sums do not depend on table
//! order, thread count or neighbour search. This makes a run deterministic.
//!
//! Slots run row by row through space, and in large packings beam by beam; within a cell they are sorted by id.
//! Neighbours in space are therefore mostly neighbours in memory. Fixed particles come last.
//!
//! A grain of several spheres has a row for itself and a row for each of its spheres (`store/bodies.rs`).
//!
//! Slots are assigned anew after the phase [`Spawn`](crate::step::Phase::Spawn) in two cases, both of which depend on
//! the state alone:
//! * A particle entered, left, was fixed or freed, or got another radius, mass, species or moment of inertia.
//! * Every [`SORT_CHECK_INTERVAL`] steps, if more than a tenth of the grains have left that order.

mod access_markers;
mod accumulator;
mod adders_in_order;
mod bodies;
mod body_motion;
mod component_sync;
mod consistent;
mod declared_access;
mod deferred_kick;
mod foreign_code;
mod load_components;
mod longest_move;
mod mirror;
mod mirror_set;
mod parallel_chunks;
mod pending_kick;
mod plugin;
mod population;
mod predictable_conditions;
mod prediction;
mod renumbering;
mod reorder;
mod saved;
mod sets;
mod spatial_sort;
mod sync_plan;

use std::ops::Range;

use bevy_ecs::prelude::*;
use serde::{Deserialize, Serialize};

pub use self::access_markers::{AddsLoads, PlainCommands};
pub(crate) use self::access_markers::{OwnObserver, ReadsMotion, ReadsPlaces};
pub use self::accumulator::{Accumulator, TOTAL_AND_DISSIPATIVE};
pub(crate) use self::accumulator::{TOTAL, kick_term};
pub use self::bodies::{BodyColumns, BodySlot, SphereOfBody};
pub use self::component_sync::{collect_from_world, complete_world, plan, publish_to_world, refresh_world, uses_loads};
pub(crate) use self::deferred_kick::add_second_kick;
pub use self::deferred_kick::{
    AfterDeferredKick, DeferredKick, EngineBalance, EngineChecks, KickAppliedAtEnd, SecondKicks, after_kicks,
    apply_pending_kick, reads_velocities_when,
};
pub use self::foreign_code::path_in_siloflow;
pub(crate) use self::longest_move::LongestMove;
pub(crate) use self::mirror_set::MirrorSet;
pub use self::parallel_chunks::CHUNK;
pub(crate) use self::parallel_chunks::ChunkedPass;
pub(crate) use self::pending_kick::PendingKick;
pub use self::plugin::{StorePlugin, clear_forces};
pub use self::predictable_conditions::register_predictable;
pub use self::prediction::Prediction;
pub(crate) use self::prediction::swept_radius;
pub use self::renumbering::{AfterRenumbering, BeforeRenumbering, FirstRenumbering, Renumber, SORT_CHECK_INTERVAL};
pub(crate) use self::renumbering::{has_renumbered, sort_check_is_due};
pub use self::sets::SpinsDrifted;
pub(crate) use self::sets::{Kicked, VelocitiesPredicted};
pub(crate) use self::spatial_sort::SpatialOrder;
pub(crate) use self::sync_plan::Plan;
use crate::displacement_trigger::TravelMeter;
pub use crate::particle::Slot;
use crate::particle::{GrainId, Species};
use crate::periodic::Periodic;
use crate::space::{Dimension, Linear, Plane, Rotor, Solid, Space};
use crate::spin::InertiaLaw;

/// The numbers of a particle that every contact reads, side by side in memory. The force pass loads them in groups of four,
/// in this order.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub struct Body<V: Space = Plane> {
    /// Centre, m.
    pub position: V,
    /// Velocity, m/s. Its time depends on the scheme and on the place in the step:
    /// * From the kick of a step to the drift of the next one it is v(t), at the same time as the position.
    /// * From the drift to the kick it is, in velocity Verlet, that in the middle of the step, v(t+dt/2). In the Euler schemes, which
    ///   have no kick, it is already v(t+dt).
    /// * From the drift to the kick it is, in the centred scheme, predicted for the end of the step. The one in the middle of the step is
    ///   beside it ([`ParticleStore::middle_velocity`]).
    ///
    /// A kick that is deferred (`store/deferred_kick.rs`) lets the second or third meaning last until a system reads velocities, or until
    /// the next drift, which makes that kick.
    pub velocity: V,
    /// Radius, m.
    pub radius: f64,
    /// Inverse mass as contacts see it, 1/kg: 0 for fixed particles.
    pub inverse_mass: f64,
    /// The velocity in the middle of the step, for schemes that predict velocities.
    pub middle: V::MiddleInBody,
}

/// Forces and torques on particles, summed over their contacts. Sums that the scene does not need are empty.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[serde(bound = "")]
pub struct Loads<V: Space = Plane> {
    /// Total: forces of contacts, walls and weight, N. Dissipative part: dashpots along normals and, if grains spin,
    /// across them.
    pub force: Accumulator<V>,
    /// Total: torques of all contacts, N m, if grains spin. Dissipative part: tangential dashpots.
    pub torque: Accumulator<V::Spin>,
    /// The part of the torques that dashpots of rolling resistance make, N m. Empty without rolling resistance or
    /// without the energy balance.
    pub rolling_drag: Vec<V::Spin>,
    /// Number of contacts of each particle, if the last force pass has counted them.
    pub contacts: Vec<u16>,
}

impl<V: Space> Default for Loads<V> {
    fn default() -> Self {
        Self {
            force: Accumulator::default(),
            torque: Accumulator::default(),
            rolling_drag: Vec::new(),
            contacts: Vec::new(),
        }
    }
}

/// Rotation of a particle; stored only in scenes with spin. In solid space the force pass loads these four numbers at once,
/// in this order.
#[derive(Clone, Copy, Debug, Default, Deserialize, Serialize)]
#[repr(C)]
#[serde(bound = "")]
pub struct Rotation<V: Space = Plane> {
    /// Angular velocity, rad/s, at the same time as the velocity.
    pub spin: V::Spin,
    /// 1/I, 1/(kg m^2); 0 for particles that do not spin.
    pub inverse_inertia: f64,
}

/// The packed state, one entry per particle, in the order of slots. SI units.
#[derive(Resource)]
pub struct ParticleStore<V: Space = Plane> {
    /// Particle ids.
    pub id: Vec<GrainId>,
    /// The entity of each particle; [`Entity::PLACEHOLDER`] if the particle has left since the last renumbering.
    pub entity: Vec<Entity>,
    /// The slot of each particle before the last renumbering; the default slot if it had none.
    pub former: Vec<Slot>,
    /// Slots of particles that were fixed or freed, or got another radius, at the last renumbering; in ascending order.
    pub(crate) altered: Vec<Slot>,
    /// The scene's rule for moments of inertia; `None` if grains do not spin.
    pub inertia: Option<InertiaLaw>,
    /// Rows of particles that have left since the last renumbering.
    pub(crate) vacated: Vec<usize>,
    /// Mirrored components that are older than the store.
    pub(crate) stale: MirrorSet,
    /// Potential energy gained in this step's drift by particles that crossed a periodic side, J.
    pub lifted: f64,
    /// Whether a system or a command has written a velocity, a spin, a force or a torque that is not finite.
    pub is_suspect: bool,
    /// The numbers that every contact reads.
    pub body: Vec<Body<V>>,
    /// Masses, kg; 0 for particles without mass.
    pub mass: Vec<f64>,
    /// Species.
    pub species: Vec<Species>,
    /// Sums of forces and torques.
    pub loads: Loads<V>,
    /// Rotations; empty if nothing spins.
    pub rotation: Vec<Rotation<V>>,
    /// The prediction of velocities.
    pub prediction: Prediction<V>,
    /// Duration of the second kick, s: half a step if a kick with this step's forces is still to come, else 0.
    pub(crate) half_step: f64,
    /// Forces that systems have added in this step, N; empty if no system adds one.
    pub added: Vec<V>,
    /// Power of the added forces at the end of the step, W.
    pub added_power: Option<f64>,
    /// The periodic sides of the scene, if it has any.
    pub periodic: Option<Periodic<V>>,
    /// Whether a separate pass after the drift wraps particles into the periodic box. The pass records the energy
    /// that wrapping adds.
    pub(crate) wraps_after_drift: bool,
    /// r_min/(r_min + r_max): for any pair, the smaller radius is at least this share of the sum of both radii.
    pub smallest_share: f64,
    /// Number of free rows: they have the first slots. All others are fixed.
    pub free_end: usize,
    /// The bodies of several spheres, and the rows of their spheres.
    pub bodies: BodyColumns<V>,
    /// Number of renumberings so far. Code that caches slots compares it to detect a renumbering.
    pub generation: u64,
    /// Sum over the steps of the longest move of any particle in a step, m: an upper bound of the distance that any
    /// particle has moved. NaN once a position is NaN.
    pub travel: f64,
    /// Whether the last force pass has summed dissipation for the energy balance.
    pub tracks_energy: bool,
    /// Sum over all free particles that the kick has formed, component by component, chunk by chunk in the order of
    /// slots. After a force pass that sums dissipation it is the power of the drag, W. Otherwise it is the sum of velocities,
    /// m/s, which shows whether any is not finite.
    pub kick_sum: Option<V>,
    /// Like `kick_sum`, of rotation: the power of tangential dashpots, W, or the sum of spins, rad/s.
    pub spin_kick_sum: Option<V::Spin>,
    /// The spatial order of slots.
    pub(crate) order: SpatialOrder,
}

impl<V: Space> Default for ParticleStore<V> {
    fn default() -> Self {
        Self {
            id: Vec::new(),
            entity: Vec::new(),
            former: Vec::new(),
            altered: Vec::new(),
            inertia: None,
            vacated: Vec::new(),
            stale: MirrorSet::NONE,
            lifted: 0.0,
            is_suspect: false,
            half_step: 0.0,
            added: Vec::new(),
            added_power: None,
            body: Vec::new(),
            mass: Vec::new(),
            species: Vec::new(),
            loads: Loads::default(),
            rotation: Vec::new(),
            prediction: Prediction::default(),
            periodic: None,
            wraps_after_drift: false,
            smallest_share: 0.0,
            free_end: 0,
            bodies: BodyColumns::default(),
            generation: 0,
            travel: 0.0,
            tracks_energy: false,
            kick_sum: None,
            spin_kick_sum: None,
            order: SpatialOrder::default(),
        }
    }
}

impl<V: Space> ParticleStore<V> {
    /// Number of particles.
    #[must_use]
    #[inline]
    pub fn len(&self) -> usize {
        self.id.len()
    }

    /// Whether the store has no particle.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.id.is_empty()
    }

    /// Sets whether the next force pass sums dissipation for the energy balance. Afterwards all loads are meaningless until
    /// that pass has set them.
    pub fn track_energy(&mut self, tracks_energy: bool) {
        if tracks_energy == self.tracks_energy {
            return;
        }
        self.tracks_energy = tracks_energy;
        self.loads.force.change_layout(tracks_energy);
        self.loads.torque.change_layout(tracks_energy);
        self.loads.rolling_drag.clear();
    }

    /// Whether the particle in slot `i` is fixed: forces do not act on it. Two fixed particles make no contact.
    #[must_use]
    #[inline]
    pub fn is_fixed(&self, i: usize) -> bool {
        i >= self.free_end
    }

    /// The rows of free spheres, on which contacts act: grains that are one sphere, and spheres of bodies. Searches and sums over contacts
    /// use these rows.
    #[must_use]
    #[inline]
    pub fn free_rows(&self) -> Range<usize> {
        self.bodies.free..self.free_end
    }

    /// The rows of all spheres, free and fixed. The other rows are centres of bodies.
    #[must_use]
    #[inline]
    pub fn contact_rows(&self) -> Range<usize> {
        if self.bodies.is_empty() { 0..self.len() } else { self.bodies.free..self.bodies.contact_end }
    }

    /// The rows of fixed spheres: fixed particles that are one sphere, and spheres of fixed bodies.
    #[must_use]
    #[inline]
    pub fn fixed_rows(&self) -> Range<usize> {
        self.free_end..self.contact_rows().end
    }

    /// The rows that the integrator moves, each by its own force and torque. Kicks and drifts use these rows, and so do sums and
    /// counts over grains, because each such row is one grain with its mass and its energy of motion. Free bodies come first.
    #[must_use]
    #[inline]
    pub fn integrated_rows(&self) -> Range<usize> {
        if self.bodies.is_empty() { 0..self.free_end } else { 0..self.bodies.first_sphere }
    }

    /// The rows of all spheres, in ascending order of particle id, then of the number in the shape.
    #[must_use]
    pub fn by_id(&self) -> Vec<usize> {
        let mut entries: Vec<_> = self.contact_rows().collect();
        let number = |i: usize| self.bodies.sphere(i).map_or(0, |sphere| sphere.number);
        entries.sort_unstable_by_key(|&i| (self.id[i], number(i)));
        entries
    }

    /// The distance that particles can have moved.
    #[inline]
    pub(crate) fn travel_meter(&self) -> TravelMeter {
        TravelMeter { generation: self.generation, travel: self.travel }
    }

    /// The vector from `b` to `a`, m: in a periodic scene, the shortest one.
    #[inline]
    #[must_use]
    pub fn separation(&self, a: V, b: V) -> V {
        self.periodic.map_or(a - b, |periodic| periodic.shortest(a - b))
    }

    /// Kinetic energy of translation of the particle in slot `i`, J; zero for a row that is not integrated.
    #[must_use]
    #[inline]
    pub fn kinetic_energy(&self, i: usize) -> f64 {
        if self.integrated_rows().contains(&i) {
            0.5 * self.mass[i] * self.body[i].velocity.length_squared()
        } else {
            0.0
        }
    }

    /// Whether grains of this run spin, also before there is a grain.
    #[must_use]
    pub fn has_spins(&self) -> bool {
        self.inertia.is_some()
    }

    /// Spin of the particle in slot `i`, rad/s; zero if nothing spins.
    #[must_use]
    #[inline]
    pub fn spin(&self, i: usize) -> V::Spin {
        self.rotation.get(i).map_or(V::Spin::ZERO, |rotation| rotation.spin)
    }

    /// Kinetic energy of rotation of the particle in slot `i`, J; zero for a row that is not integrated or does
    /// not spin.
    #[must_use]
    #[inline]
    pub fn rotational_energy(&self, i: usize) -> f64 {
        if i < self.bodies.free {
            let momentum = self.bodies.rotor[i].momentum(self.spin(i), self.bodies.inverse_inertia[i]);
            return 0.5 * momentum.dot(self.spin(i));
        }
        match self.rotation.get(i) {
            Some(&Rotation { spin, inverse_inertia })
                if inverse_inertia > 0.0 && self.integrated_rows().contains(&i) =>
            {
                0.5 * spin.length_squared() / inverse_inertia
            }
            _ => 0.0,
        }
    }
}

impl Dimension {
    /// The dimension of a world, for code that is not generic over the space. A
    /// behaviour from another crate calls it in `build`, with `app.world()`. The dimension of the lattice
    /// gas is the plane.
    #[must_use]
    pub fn of_world(world: &World) -> Self {
        if world.contains_resource::<ParticleStore<Solid>>() { Self::Solid } else { Self::Plane }
    }
}
