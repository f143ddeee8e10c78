//! The columns: what the force pass reads and writes, packed in ascending order of [`GrainId`].
//!
//! Components are the live state and keep whatever order the ECS gives them; a behaviour may add components, which
//! moves rows between tables. So a step copies positions and velocities into these columns, works here, and copies
//! the forces back. The order by id makes every sum that runs over particles, contacts first of all, independent of
//! table order, thread count and neighbour search: it *is* the order that the determinism of a run rests on.
//!
//! A particle's place is its [`Slot`]. Slots are dealt out anew at the end of [`Phase::Spawn`] when a particle was
//! added, removed, fixed or freed, or a radius or mass changed. Until then a particle that vanished in the middle
//! of a step keeps a ghost in its slot, and one that appeared has none.

use std::marker::PhantomData;

use bevy_app::{App, Plugin};
use bevy_ecs::lifecycle::HookContext;
use bevy_ecs::prelude::*;
use bevy_ecs::world::DeferredWorld;

use crate::particle::{Fixed, Force, GrainId, Mass, Position, Radius, Species, Velocity};
use crate::periodic::Periodic;
use crate::space::{Dimension, Linear, Plane, Solid, Space};
use crate::step::{ForceStage, Phase, Step};

/// Index of a particle in the [`Columns`].
#[derive(Component, Clone, Copy, Debug, PartialEq, Eq)]
pub struct Slot(u32);

impl Default for Slot {
    /// No place yet.
    fn default() -> Self {
        Self(u32::MAX)
    }
}

impl Slot {
    /// The index, out of range as long as the particle has no place.
    #[must_use]
    pub fn index(self) -> usize {
        self.0 as usize
    }
}

/// Why contiguous iteration cannot fail: every component of a particle's columns is stored in tables.
pub(crate) const DENSE: &str = "table components are contiguous";

/// What a contact needs to know of a particle, side by side because it is read at random.
#[derive(Clone, Copy, Debug)]
pub struct Body<V: Space = Plane> {
    /// Centre, m.
    pub position: V,
    /// v(t+dt/2) while forces are evaluated, v(t) from the end of [`Phase::Kick`] on, m/s.
    pub velocity: V,
    /// Radius, m.
    pub radius: f64,
    /// Inverse mass as contacts see it, 1/kg: 0 for what is fixed.
    pub inverse_mass: f64,
}

impl<V: Space> Body<V> {
    /// Whether no force moves it.
    #[must_use]
    pub fn is_fixed(&self) -> bool {
        self.inverse_mass == 0.0
    }
}

/// The force on a particle.
#[derive(Clone, Copy, Debug, Default)]
pub struct Load<V: Space = Plane> {
    /// Of contacts, walls and weight together, N.
    pub force: V,
    /// The part of it that the normal damping makes, N.
    pub drag: V,
}

/// What turns a particle, and what friction takes: only in scenes with spin.
#[derive(Clone, Copy, Debug, Default)]
pub struct Turn<V: Space = Plane> {
    /// The torque of all contacts, N m.
    pub torque: V::Spin,
    /// The part of the force that the tangential dashpots make, N.
    pub friction_drag: V,
    /// The part of the torque that they make, N m.
    pub friction_drag_torque: V::Spin,
    /// The part of the torque that the dashpots of rolling resistance make, N m.
    pub rolling_drag_torque: V::Spin,
    /// What sliding took in this step at the contacts that are booked here, J.
    pub lost_by_sliding: f64,
    /// What rolling beyond its cap took, J.
    pub lost_by_rolling: f64,
}

/// How forces change a velocity.
#[derive(Clone, Copy, Debug, Default)]
pub struct Gain<V: Space = Plane> {
    /// What it gains in half a step by the forces of its beginning, m/s.
    pub velocity: V,
    /// 1 for what had at most one contact then, else 0.
    pub lone: f64,
}

/// How torques change a spin.
#[derive(Clone, Copy, Debug, Default)]
pub struct SpinGain<V: Space = Plane> {
    /// What it gains in half a step by the torques of its beginning, rad/s.
    pub spin: V::Spin,
    /// 1/I, 1/(kg m^2); 0 for what is fixed.
    pub inverse_inertia: f64,
}

/// The packed state, one entry a particle, in ascending order of id. SI units.
#[derive(Resource)]
pub struct Columns<V: Space = Plane> {
    /// Names, ascending.
    pub id: Vec<GrainId>,
    /// Whose entry this is.
    pub entity: Vec<Entity>,
    /// Positions, velocities, radii, inverse masses.
    pub body: Vec<Body<V>>,
    /// Masses, kg; 0 for what has none.
    pub mass: Vec<f64>,
    /// Kinds.
    pub species: Vec<Species>,
    /// Forces.
    pub load: Vec<Load<V>>,
    /// Spins, rad/s, at the times of velocities; empty where nothing spins.
    pub spin: Vec<V::Spin>,
    /// Moments of inertia, kg m^2; empty where nothing spins.
    pub inertia: Vec<f64>,
    /// Torques and what belongs to them; empty where nothing spins.
    pub turn: Vec<Turn<V>>,
    /// What velocities gain by the forces of the step's beginning; empty unless the scheme looks ahead.
    pub gain: Vec<Gain<V>>,
    /// How many contacts each has had in this force pass; empty unless the scheme looks ahead.
    pub contacts: Vec<u32>,
    /// The same of spins.
    pub spin_gain: Vec<SpinGain<V>>,
    /// For how long the scheme looks ahead, s: half a step, or 0.
    pub lookahead: f64,
    /// The largest gap that two can close in that time, m.
    pub margin: f64,
    /// The sides through which the scene repeats itself, if it does.
    pub periodic: Option<Periodic<V>>,
    /// One past the last entry that is not fixed.
    pub movable_end: usize,
    /// Counts the renumberings; whoever caches indices compares it.
    pub generation: u64,
}

impl<V: Space> Default for Columns<V> {
    fn default() -> Self {
        Self {
            id: Vec::new(),
            entity: Vec::new(),
            body: Vec::new(),
            mass: Vec::new(),
            species: Vec::new(),
            load: Vec::new(),
            spin: Vec::new(),
            inertia: Vec::new(),
            turn: Vec::new(),
            gain: Vec::new(),
            contacts: Vec::new(),
            spin_gain: Vec::new(),
            lookahead: 0.0,
            margin: 0.0,
            periodic: None,
            movable_end: 0,
            generation: 0,
        }
    }
}

impl<V: Space> Columns<V> {
    /// Number of particles.
    #[must_use]
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
    pub fn is_fixed(&self, i: usize) -> bool {
        self.body[i].is_fixed()
    }

    /// The vector from `b` to `a`, m: in a periodic scene the shortest one.
    #[inline]
    #[must_use]
    pub fn separation(&self, a: V, b: V) -> V {
        self.periodic.map_or(a - b, |periodic| periodic.shortest(a - b))
    }

    /// Kinetic energy of translation of entry `i`, J; nothing for what is fixed.
    #[must_use]
    pub fn kinetic_energy(&self, i: usize) -> f64 {
        if self.is_fixed(i) { 0.0 } else { 0.5 * self.mass[i] * self.body[i].velocity.length_squared() }
    }

    /// Kinetic energy of rotation of entry `i`, J; nothing for what is fixed or does not spin.
    #[must_use]
    pub fn rotational_energy(&self, i: usize) -> f64 {
        match self.spin.get(i) {
            Some(spin) if !self.is_fixed(i) => 0.5 * self.inertia[i] * spin.length_squared(),
            _ => 0.0,
        }
    }

    fn refill<'a>(&mut self, particles: impl Iterator<Item = ParticleItem<'a, V>>) {
        let mut rows: Vec<_> = particles.collect();
        rows.sort_unstable_by_key(|row| *row.1);
        let inverse = |mass: Option<&Mass>, fixed: bool| mass.map_or(0.0, |m| if fixed { 0.0 } else { 1.0 / m.0 });
        self.id = rows.iter().map(|row| *row.1).collect();
        self.entity = rows.iter().map(|row| row.0).collect();
        self.body = rows
            .iter()
            .map(|&(_, _, x, v, radius, mass, _, fixed)| Body {
                position: x.0,
                velocity: v.0,
                radius: radius.0,
                inverse_mass: inverse(mass, fixed),
            })
            .collect();
        self.mass = rows.iter().map(|row| row.5.map_or(0.0, |mass| mass.0)).collect();
        self.species = rows.iter().map(|row| row.6.copied().unwrap_or_default()).collect();
        self.load = vec![Load::default(); rows.len()];
        self.contacts.clear();
        self.movable_end = self.body.iter().rposition(|body| !body.is_fixed()).map_or(0, |last| last + 1);
        self.generation += 1;
    }
}

impl Dimension {
    /// That of a world: for what does not know the type of its space.
    #[must_use]
    pub fn of_world(world: &World) -> Self {
        if world.contains_resource::<Columns<Solid>>() { Self::Solid } else { Self::Plane }
    }
}

type ParticleData<V> = (
    Entity,
    &'static GrainId,
    &'static Position<V>,
    &'static Velocity<V>,
    &'static Radius,
    Option<&'static Mass>,
    Option<&'static Species>,
    Has<Fixed>,
);

type ParticleItem<'a, V> =
    (Entity, &'a GrainId, &'a Position<V>, &'a Velocity<V>, &'a Radius, Option<&'a Mass>, Option<&'a Species>, bool);

/// Whether particles were added, removed, fixed or freed since slots were dealt out.
#[derive(Resource, Default)]
pub struct PopulationChanged(bool);

/// Component hook: the population changed.
pub(crate) fn population_changed(mut world: DeferredWorld, _: HookContext) {
    if let Some(mut changed) = world.get_resource_mut::<PopulationChanged>() {
        changed.0 = true;
    }
}

/// Run condition: slots will be dealt out anew in this step.
#[must_use]
pub fn renumbering_due(
    changed: Res<PopulationChanged>,
    radii: Query<(), Changed<Radius>>,
    masses: Query<(), Changed<Mass>>,
) -> bool {
    changed.0 || !radii.is_empty() || !masses.is_empty()
}

pub(crate) fn renumber<V: Space>(
    mut columns: ResMut<Columns<V>>,
    mut changed: ResMut<PopulationChanged>,
    particles: Query<ParticleData<V>>,
    mut slots: Query<&mut Slot>,
) {
    columns.refill(particles.iter());
    for (slot, &entity) in (0..).zip(&columns.entity) {
        if let Ok(mut place) = slots.get_mut(entity) {
            place.0 = slot;
        }
    }
    changed.0 = false;
}

pub(crate) fn gather<V: Space>(mut columns: ResMut<Columns<V>>, particles: Query<(&Slot, &Position<V>, &Velocity<V>)>) {
    for (slots, xs, vs) in particles.contiguous_iter().expect(DENSE) {
        for (slot, (x, v)) in slots.iter().zip(xs.iter().zip(vs.iter())) {
            if let Some(body) = columns.body.get_mut(slot.index()) {
                body.position = x.0;
                body.velocity = v.0;
            }
        }
    }
}

pub(crate) fn gather_velocities<V: Space>(mut columns: ResMut<Columns<V>>, particles: Query<(&Slot, &Velocity<V>)>) {
    for (slots, vs) in particles.contiguous_iter().expect(DENSE) {
        for (slot, v) in slots.iter().zip(vs.iter()) {
            if let Some(body) = columns.body.get_mut(slot.index()) {
                body.velocity = v.0;
            }
        }
    }
}

pub(crate) fn clear_forces<V: Space>(mut columns: ResMut<Columns<V>>) {
    columns.load.fill(Load::default());
}

fn write_forces<V: Space>(columns: Res<Columns<V>>, mut particles: Query<(&Slot, &mut Force<V>)>) {
    for (slots, mut forces) in particles.contiguous_iter_mut().expect(DENSE) {
        for (slot, force) in slots.iter().zip(forces.bypass_change_detection()) {
            if let Some(from) = columns.load.get(slot.index()) {
                force.0 = from.force;
            }
        }
    }
}

/// What has to be booked before slots are dealt out anew (the columns still hold the old state) belongs here.
#[derive(SystemSet, Clone, Debug, PartialEq, Eq, Hash)]
pub struct BeforeRenumbering;

/// The system that deals out slots; spawners run before it.
#[derive(SystemSet, Clone, Debug, PartialEq, Eq, Hash)]
pub struct Renumbering;

/// The columns hold x(t+dt), v(t+dt/2) after this set of [`Phase::Neighbours`].
#[derive(SystemSet, Clone, Debug, PartialEq, Eq, Hash)]
pub struct Gathered;

/// The columns know what a scheme that looks ahead needs after this set, before the neighbour search.
#[derive(SystemSet, Clone, Debug, PartialEq, Eq, Hash)]
pub struct LookedAhead;

/// The columns hold v(t+dt) after this set, at the end of [`Phase::Kick`].
#[derive(SystemSet, Clone, Debug, PartialEq, Eq, Hash)]
pub struct GatheredVelocities;

/// The columns and the passes that fill and empty them.
pub struct ColumnsPlugin<V: Space>(pub PhantomData<V>);

impl<V: Space> Plugin for ColumnsPlugin<V> {
    fn build(&self, app: &mut App) {
        app.init_resource::<Columns<V>>().insert_resource(PopulationChanged(true));
        app.edit_schedule(Step, |schedule| {
            schedule
                .configure_sets((BeforeRenumbering, Renumbering).chain().run_if(renumbering_due).in_set(Phase::Spawn));
        });
        app.add_systems(
            Step,
            (
                renumber::<V>.in_set(Renumbering),
                gather::<V>.in_set(Phase::Neighbours).in_set(Gathered),
                clear_forces::<V>.in_set(ForceStage::Contacts).before(crate::contact::ContactForces),
                write_forces::<V>.in_set(ForceStage::Written),
                gather_velocities::<V>.in_set(Phase::Kick).in_set(GatheredVelocities),
            ),
        );
    }
}
