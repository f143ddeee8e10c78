//! The packed particle store, [`ParticleStore`]: the state that the passes of a step read and write, in the order of [`Slot`]s.
//!
//! Every particle is an entity, and its components show what the store holds. During a step the store owns the numbers. Components
//! follow where a system of the schedule reads them, and what a system writes to them is taken over (`store/sync.rs`); where no
//! system uses a component, nothing is copied. The order of slots makes every sum that runs over particles, contacts first of
//! all, independent of table order, thread count and neighbour search: the determinism of a run rests on it.
//!
//! Slots go row by row through space, in large packings beam by beam (within a cell, by id), so that neighbours in space are neighbours
//! in memory; what is fixed comes last. They are dealt out anew after the phase [`Spawn`](crate::step::Phase::Spawn) when a particle
//! entered, left, was fixed or freed, or got another radius, mass, species or inertia; and every [`SORT_CHECK_INTERVAL`] steps, if more than a
//! tenth of the grains have left that order. That depends on nothing but the state.

mod accumulator;
mod component_sync;
mod declared_access;
mod deferred_kick;
mod mirror;
mod parallel_chunks;
mod plugin;
mod population;
mod predictable_conditions;
mod renumbering;
mod reorder;
mod spatial_sort;
mod sync_plan;

use bevy_ecs::prelude::*;

pub use self::accumulator::Accumulator;
pub(crate) use self::accumulator::{TOTAL, TOTAL_AND_DISSIPATIVE, kick_term};
pub(crate) use self::component_sync::{collect_from_world, plan, publish_to_world, refresh_world};
pub(crate) use self::deferred_kick::{
    AfterDeferredKick, DeferredKick, EngineBalance, EngineChecks, KickAppliedAtEnd, PendingKick, SecondKicks,
    add_second_kick, after_kicks, reads_velocities_when,
};
pub(crate) use self::mirror::MirrorSet;
pub(crate) use self::parallel_chunks::{CHUNK, ChunkedPass};
pub use self::plugin::StorePlugin;
pub(crate) use self::plugin::{DENSE, Kicked, LongestMove, SpinsDrifted, VelocitiesPredicted, clear_forces};
pub(crate) use self::predictable_conditions::register_predictable;
pub use self::renumbering::SORT_CHECK_INTERVAL;
pub(crate) use self::renumbering::{
    BeforeRenumbering, FirstRenumbering, Renumber, Renumbering, UNKNOWN_CONTACTS, has_renumbered, renumber,
    sort_check_is_due,
};
pub(crate) use self::spatial_sort::SpatialOrder;
pub(crate) use self::sync_plan::{OwnObserver, PlainCommands, Plan, ReadsMotion, ReadsPlaces};
use crate::displacement_trigger::TravelMeter;
pub use crate::particle::Slot;
use crate::particle::{GrainId, Species};
use crate::periodic::Periodic;
use crate::space::{Dimension, Linear, Plane, Solid, Space};
use crate::spin::InertiaLaw;

/// What every contact asks of a particle, side by side in memory, and in this order: they are read by fours.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct Body<V: Space = Plane> {
    /// Centre, m.
    pub position: V,
    /// v(t+dt/2) while forces are evaluated, v(t) from the end of [`Phase::Kick`](crate::step::Phase::Kick) on, or once a system
    /// looks (`store/deferred_kick.rs`), m/s.
    pub velocity: V,
    /// Radius, m.
    pub radius: f64,
    /// Inverse mass as contacts see it, 1/kg: 0 for what is fixed.
    pub inverse_mass: f64,
}

/// What acts on particles: sums over their contacts. What a scene does not ask for is empty.
#[derive(Clone, Debug)]
pub struct Loads<V: Space = Plane> {
    /// Forces of contacts, walls and weight together, N; of dashpots along normals and, where grains spin, across them.
    pub force: Accumulator<V>,
    /// Torques of all contacts, N m, where grains spin; of tangential dashpots.
    pub torque: Accumulator<V::Spin>,
    /// The part of the torques that dashpots of rolling resistance make, N m, where there is any and books of energy are kept.
    pub rolling_drag: Vec<V::Spin>,
    /// How many contacts each has had in this force pass; where the scheme looks ahead.
    pub contacts: Vec<u32>,
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

/// How a particle spins: only in scenes with spin. In this order: in solid space they are read by fours.
#[derive(Clone, Copy, Debug, Default)]
#[repr(C)]
pub struct Rotation<V: Space = Plane> {
    /// Angular velocity, rad/s, at the times of velocities.
    pub spin: V::Spin,
    /// 1/I, 1/(kg m^2); 0 for what does not spin.
    pub inverse_inertia: f64,
}

/// How forces change a velocity.
#[derive(Clone, Copy, Debug, Default)]
pub struct VelocityGain<V: Space = Plane> {
    /// What it gains in half a step by the forces of its beginning, m/s.
    pub velocity: V,
    /// 1 for what had at most one contact then, else 0.
    pub only_contact: f64,
}

/// How torques change a spin.
#[derive(Clone, Copy, Debug, Default)]
pub struct SpinGain<V: Space = Plane> {
    /// What it gains in half a step by the torques of its beginning, rad/s.
    pub spin: V::Spin,
    /// 1/I, 1/(kg m^2); 0 for what is fixed.
    pub inverse_inertia: f64,
}

/// The packed state, one entry a particle, in the order of slots. SI units.
#[derive(Resource)]
pub struct ParticleStore<V: Space = Plane> {
    /// Names.
    pub id: Vec<GrainId>,
    /// The entity of each; [`Entity::PLACEHOLDER`] if it has left since slots were dealt out.
    pub entity: Vec<Entity>,
    /// The slot that each had before slots were dealt out anew; that of nobody if it had none.
    pub(crate) former: Vec<Slot>,
    /// Who had another radius in that one, or was fixed and is free, or the reverse; in ascending order.
    pub(crate) altered: Vec<Slot>,
    /// What moments of inertia follow from, where grains spin.
    pub(crate) inertia: Option<InertiaLaw>,
    /// The rows of particles that have left since slots were dealt out.
    pub(crate) vacated: Vec<usize>,
    /// The components that do not show what the store holds.
    pub(crate) stale: MirrorSet,
    /// Potential energy that periodic sides have given to particles in this step's drift, J.
    pub(crate) lifted: f64,
    /// Whether a system or a command has written a velocity, a spin, a force or a torque that is not finite.
    pub(crate) is_suspect: bool,
    /// What every contact asks for.
    pub body: Vec<Body<V>>,
    /// Masses, kg; 0 for what has none.
    pub mass: Vec<f64>,
    /// Kinds.
    pub species: Vec<Species>,
    /// What acts on them.
    pub loads: Loads<V>,
    /// Spins; empty where nothing spins.
    pub rotation: Vec<Rotation<V>>,
    /// What velocities gain by the forces of the step's beginning; empty unless the scheme looks ahead.
    pub gain: Vec<VelocityGain<V>>,
    /// The same of spins.
    pub spin_gain: Vec<SpinGain<V>>,
    /// For how long velocities are still to be kicked by the forces of a step when these are known, s: half a step, or 0.
    pub(crate) half_step: f64,
    /// The forces that systems have added in this step, N; empty where none does.
    pub(crate) added: Vec<V>,
    /// Their power at the end of the step, W.
    pub(crate) added_power: Option<f64>,
    /// For how long the scheme looks ahead, s: half a step, or 0.
    pub lookahead: f64,
    /// The largest gap that two can close in that time, m.
    pub margin: f64,
    /// The sides through which the scene repeats itself, if it does.
    pub periodic: Option<Periodic<V>>,
    /// Whether a pass of its own, not the drift, sets back particles that have gone through them, for it books what that lifts.
    pub(crate) sets_back_later: bool,
    /// At least this share of the sum of the radii of any two is the smaller one.
    pub smallest_share: f64,
    /// How many are not fixed: they come first.
    pub movable_end: usize,
    /// Counts the renumberings; whoever caches indices compares it.
    pub generation: u64,
    /// The sum over the steps of the longest move of any particle in a step, m: how far anyone can have gone. Not a number
    /// once somebody's position is not.
    pub travel: f64,
    /// Whether books of energy are kept.
    pub tracks_energy: bool,
    /// What the kick has summed in passing over all that is not fixed, component by component, by strides in the order of slots:
    /// the power of the drag, W, where books of energy are kept, else velocities, m/s, so that it shows if one is not a number.
    pub(crate) kick_sum: Option<V>,
    /// The same of the torques of tangential dashpots, or of spins.
    pub(crate) spin_kick_sum: Option<V::Spin>,
    /// What the order of slots goes by.
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
            gain: Vec::new(),
            spin_gain: Vec::new(),
            lookahead: 0.0,
            margin: 0.0,
            periodic: None,
            sets_back_later: false,
            smallest_share: 0.0,
            movable_end: 0,
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

    /// Whether there is no particle.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.id.is_empty()
    }

    /// Whether entry `i` is not moved by forces.
    #[must_use]
    #[inline]
    pub fn is_fixed(&self, i: usize) -> bool {
        i >= self.movable_end
    }

    /// The entries in ascending order of id.
    #[must_use]
    pub fn by_id(&self) -> Vec<usize> {
        let mut entries: Vec<_> = (0..self.len()).collect();
        entries.sort_unstable_by_key(|&i| self.id[i]);
        entries
    }

    /// How far particles can have moved.
    #[inline]
    pub(crate) fn travel_meter(&self) -> TravelMeter {
        TravelMeter { generation: self.generation, travel: self.travel }
    }

    /// The vector from `b` to `a`, m: in a periodic scene the shortest one.
    #[inline]
    #[must_use]
    pub fn separation(&self, a: V, b: V) -> V {
        self.periodic.map_or(a - b, |periodic| periodic.shortest(a - b))
    }

    /// Kinetic energy of translation of entry `i`, J; nothing for what is fixed.
    #[must_use]
    #[inline]
    pub fn kinetic_energy(&self, i: usize) -> f64 {
        if self.is_fixed(i) { 0.0 } else { 0.5 * self.mass[i] * self.body[i].velocity.length_squared() }
    }

    /// The spin of entry `i`, rad/s; zero where nothing spins.
    #[must_use]
    #[inline]
    pub fn spin(&self, i: usize) -> V::Spin {
        self.rotation.get(i).map_or(V::Spin::ZERO, |rotation| rotation.spin)
    }

    /// Kinetic energy of rotation of entry `i`, J; nothing for what is fixed or does not spin.
    #[must_use]
    #[inline]
    pub fn rotational_energy(&self, i: usize) -> f64 {
        match self.rotation.get(i) {
            Some(&Rotation { spin, inverse_inertia }) if inverse_inertia > 0.0 && !self.is_fixed(i) => {
                0.5 * spin.length_squared() / inverse_inertia
            }
            _ => 0.0,
        }
    }
}

impl Dimension {
    /// That of a world: for what does not know the type of its space. A [`Behaviour`](crate::behaviour::Behaviour) asks it in `build`, with
    /// `app.world()`. The lattice gas lives in the plane.
    #[must_use]
    pub fn of_world(world: &World) -> Self {
        if world.contains_resource::<ParticleStore<Solid>>() { Self::Solid } else { Self::Plane }
    }
}
