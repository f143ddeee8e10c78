//! The columns: what the force pass reads and writes, packed in the order of [`Slot`]s.
//!
//! Components are the live state and keep whatever order the ECS gives them; a behaviour may add components, which
//! moves rows between tables. So a step copies positions and velocities into these columns, works here, and copies
//! the forces back. The order of slots makes every sum that runs over particles, contacts first of all, independent of
//! table order, thread count and neighbour search: it *is* the order that the determinism of a run rests on.
//!
//! Slots go row by row through space ([`crate::order`]; within a cell, by id), so that neighbours in space are neighbours
//! in memory; what is fixed comes last. They are dealt out anew at the end of [`Phase::Spawn`] when a particle was
//! added, removed, fixed or freed, or a radius or mass changed; and every [`TIDY_EVERY`] steps, if more than a tenth of
//! the grains have left that order. That hangs on nothing but the state. Until then a particle that vanished in the middle
//! of a step keeps a ghost in its slot, and one that appeared has none.

use std::marker::PhantomData;

use bevy_app::{App, Plugin};
use bevy_ecs::change_detection::ContiguousRef;
use bevy_ecs::lifecycle::HookContext;
use bevy_ecs::prelude::*;
use bevy_ecs::query::ArchetypeFilter;
use bevy_ecs::world::DeferredWorld;

use crate::contact::ContactForces;
use crate::contact::history::History;
use crate::gravity::Gravity;
use crate::order::Order;
use crate::particle::{Fixed, Force, GrainId, Mass, Position, Radius, Species, Velocity};
use crate::periodic::Periodic;
use crate::space::{Dimension, Linear, Plane, Solid, Space};
use crate::step::{Clock, ForceStage, Phase, Step, is_step_zero};

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

/// Where a particle is: all that tells whether it touches another.
#[derive(Clone, Copy, Debug)]
pub struct Body<V: Space = Plane> {
    /// Centre, m.
    pub position: V,
    /// Radius, m.
    pub radius: f64,
}

/// What a particle is made of.
#[derive(Clone, Copy, Debug)]
pub struct Make {
    /// Radius, m.
    pub radius: f64,
    /// Inverse mass as contacts see it, 1/kg: 0 for what is fixed.
    pub inverse_mass: f64,
}

/// The force on a particle.
#[derive(Clone, Copy, Debug, Default)]
pub struct Load<V: Space = Plane> {
    /// Of contacts, walls and weight together, N.
    pub force: V,
    /// The part of it that the normal damping makes, N.
    pub drag: V,
}

impl<V: Space> Load<V> {
    /// The weight of a mass (kg) where gravity is this (m/s^2): what every sum begins with.
    #[inline]
    #[must_use]
    pub fn weight(gravity: V, mass: f64) -> Self {
        Self { force: gravity * mass, drag: V::ZERO }
    }
}

/// What turns a particle: only in scenes with spin.
#[derive(Clone, Copy, Debug, Default)]
pub struct Turn<V: Space = Plane> {
    /// The torque of all contacts, N m.
    pub torque: V::Spin,
    /// The part of the force that the tangential dashpots make, N.
    pub friction_drag: V,
    /// The part of the torque that they make, N m.
    pub friction_drag_torque: V::Spin,
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

/// The packed state, one entry a particle, in the order of slots. SI units.
#[derive(Resource)]
pub struct Columns<V: Space = Plane> {
    /// Names.
    pub id: Vec<GrainId>,
    /// Whose entry this is.
    pub entity: Vec<Entity>,
    /// Positions and radii.
    pub body: Vec<Body<V>>,
    /// v(t+dt/2) while forces are evaluated, v(t) from the end of [`Phase::Kick`] on, m/s.
    pub velocity: Vec<V>,
    /// What a contact asks for besides.
    pub make: Vec<Make>,
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
    /// The part of the torques that the dashpots of rolling resistance make, N m; empty where there is none.
    pub rolling_drag: Vec<V::Spin>,
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
    /// How many are not fixed: they come first.
    pub movable_end: usize,
    /// Counts the renumberings; whoever caches indices compares it.
    pub generation: u64,
    /// The sum over the steps of the longest move of any particle in a step, m: how far anyone can have gone. Not a number
    /// once somebody's position is not.
    pub travel: f64,
    /// Of all particles, m.
    pub smallest_radius: f64,
    /// What the order of slots goes by.
    pub(crate) order: Order,
}

impl<V: Space> Default for Columns<V> {
    fn default() -> Self {
        Self {
            id: Vec::new(),
            entity: Vec::new(),
            body: Vec::new(),
            velocity: Vec::new(),
            make: Vec::new(),
            mass: Vec::new(),
            species: Vec::new(),
            load: Vec::new(),
            spin: Vec::new(),
            inertia: Vec::new(),
            turn: Vec::new(),
            rolling_drag: Vec::new(),
            gain: Vec::new(),
            contacts: Vec::new(),
            spin_gain: Vec::new(),
            lookahead: 0.0,
            margin: 0.0,
            periodic: None,
            movable_end: 0,
            generation: 0,
            travel: 0.0,
            smallest_radius: 0.0,
            order: Order::default(),
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
        i >= self.movable_end
    }

    /// The entries in ascending order of id.
    #[must_use]
    pub fn by_id(&self) -> Vec<usize> {
        let mut entries: Vec<_> = (0..self.len()).collect();
        entries.sort_unstable_by_key(|&i| self.id[i]);
        entries
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
        if self.is_fixed(i) { 0.0 } else { 0.5 * self.mass[i] * self.velocity[i].length_squared() }
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
        let inverse = |mass: Option<&Mass>, fixed: bool| mass.map_or(0.0, |m| if fixed { 0.0 } else { 1.0 / m.0 });
        let largest = rows.iter().filter(|row| !row.7).map(|row| row.4.0).fold(0.0, f64::max);
        self.order = Order::of(rows.iter().filter(|row| !row.7).map(|row| row.2.0), 2.0 * largest);
        rows.sort_by_cached_key(|row| (inverse(row.5, row.7) == 0.0, self.order.place(row.2.0), *row.1));
        self.smallest_radius = rows.iter().map(|row| row.4.0).fold(f64::INFINITY, f64::min);
        let contacts = |row: &ParticleItem<V>| self.contacts.get(row.8.index()).copied().unwrap_or(MANY);
        if !self.contacts.is_empty() {
            self.contacts = rows.iter().map(contacts).collect();
        }
        self.id = rows.iter().map(|row| *row.1).collect();
        self.entity = rows.iter().map(|row| row.0).collect();
        self.body = rows.iter().map(|&(_, _, x, _, radius, ..)| Body { position: x.0, radius: radius.0 }).collect();
        self.velocity = rows.iter().map(|row| row.3.0).collect();
        let make = |row: &ParticleItem<V>| Make { radius: row.4.0, inverse_mass: inverse(row.5, row.7) };
        self.make = rows.iter().map(make).collect();
        self.mass = rows.iter().map(|row| row.5.map_or(0.0, |mass| mass.0)).collect();
        self.species = rows.iter().map(|row| row.6.copied().unwrap_or_default()).collect();
        self.load = vec![Load::default(); rows.len()];
        self.movable_end = self.make.partition_point(|make| make.inverse_mass != 0.0);
        self.generation += 1;
    }

    /// Whether more than a tenth of the grains come after one whose place is later.
    fn is_untidy(&self) -> bool {
        let places = self.body[..self.movable_end].iter().map(|body| self.order.place(body.position));
        10 * places.clone().zip(places.skip(1)).filter(|(one, next)| next < one).count() > self.movable_end
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
    &'static Slot,
);

type ParticleItem<'a, V> = (
    Entity,
    &'a GrainId,
    &'a Position<V>,
    &'a Velocity<V>,
    &'a Radius,
    Option<&'a Mass>,
    Option<&'a Species>,
    bool,
    &'a Slot,
);

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
    (radii, changed_radii): (Query<Ref<Radius>>, Query<(), Changed<Radius>>),
    (masses, changed_masses): (Query<Ref<Mass>>, Query<(), Changed<Mass>>),
) -> bool {
    // A table's summary is looked at first, for it is one for all rows; it also counts rows that have only moved.
    changed.0
        || (is_any_touched(&radii) && !changed_radii.is_empty())
        || (is_any_touched(&masses) && !changed_masses.is_empty())
}

/// Whether the summary of any table says that its column has changed.
fn is_any_touched<T: Component>(column: &Query<Ref<T>>) -> bool {
    let mut tables = column.contiguous_iter().expect(DENSE);
    tables.any(|rows| ContiguousRef::split(rows).1.summary_tick_is_changed() != Some(false))
}

/// How often the order of slots is looked over, in steps.
pub const TIDY_EVERY: u64 = 1000;

/// What stands for the number of contacts where it is not known: a grain that has just entered counts as touched by many.
pub(crate) const MANY: u32 = 2;

fn tidy_up<V: Space>(columns: Res<Columns<V>>, mut changed: ResMut<PopulationChanged>) {
    changed.0 |= columns.is_untidy();
}

/// Run condition: slots have been dealt out in this step.
pub(crate) fn has_renumbered(count: Res<Renumberings>, mut known: Local<u64>) -> bool {
    std::mem::replace(&mut *known, count.0) != count.0
}

/// How often slots have been dealt out.
#[derive(Resource, Default)]
pub(crate) struct Renumberings(u64);

fn is_time_to_tidy(clock: Res<Clock>) -> bool {
    clock.steps.is_multiple_of(TIDY_EVERY) && !clock.is_step_zero()
}

pub(crate) fn renumber<V: Space>(
    mut columns: ResMut<Columns<V>>,
    (mut changed, mut count): (ResMut<PopulationChanged>, ResMut<Renumberings>),
    mut particles: ParamSet<(Query<ParticleData<V>>, Query<&mut Slot>)>,
) {
    columns.refill(particles.p0().iter());
    let mut slots = particles.p1();
    for (slot, &entity) in (0..).zip(&columns.entity) {
        if let Ok(mut place) = slots.get_mut(entity) {
            place.0 = slot;
        }
    }
    changed.0 = false;
    count.0 += 1;
}

/// The longest of many ways.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Longest {
    squared: f64,
    are_finite: bool,
}

impl Default for Longest {
    fn default() -> Self {
        Self { squared: 0.0, are_finite: true }
    }
}

impl Longest {
    /// Takes another one into account, m.
    #[inline]
    pub(crate) fn raise<V: Space>(&mut self, way: V) {
        let squared = way.length_squared();
        self.squared = if squared > self.squared { squared } else { self.squared };
        self.are_finite &= squared < f64::INFINITY;
    }

    /// Its length, m; not a number if one of them had none.
    pub(crate) fn length(self) -> f64 {
        if self.are_finite { self.squared.sqrt() } else { f64::NAN }
    }
}

/// Copies positions and velocities of those whom `F` accepts into the columns.
pub(crate) fn gather<V: Space, F: ArchetypeFilter + 'static>(
    mut columns: ResMut<Columns<V>>,
    particles: Query<(&Slot, &Position<V>, &Velocity<V>), F>,
) {
    let columns = &mut *columns;
    let mut longest = Longest::default();
    for (slots, xs, vs) in particles.contiguous_iter().expect(DENSE) {
        for (slot, (x, v)) in slots.iter().zip(xs.iter().zip(vs.iter())) {
            let slot = slot.index();
            if let (Some(body), Some(velocity)) = (columns.body.get_mut(slot), columns.velocity.get_mut(slot)) {
                let way = x.0 - body.position;
                longest.raise(columns.periodic.map_or(way, |periodic| periodic.shortest(way)));
                body.position = x.0;
                *velocity = v.0;
            }
        }
    }
    columns.travel += longest.length();
}

/// Where behaviours may have changed them.
pub(crate) fn gather_velocities<V: Space>(mut columns: ResMut<Columns<V>>, particles: Query<(&Slot, &Velocity<V>)>) {
    for (slots, vs) in particles.contiguous_iter().expect(DENSE) {
        for (slot, v) in slots.iter().zip(vs.iter()) {
            if let Some(velocity) = columns.velocity.get_mut(slot.index()) {
                *velocity = v.0;
            }
        }
    }
}

/// Where no contact pass sets them.
pub(crate) fn clear_forces<V: Space>(gravity: Res<Gravity<V>>, mut columns: ResMut<Columns<V>>) {
    let Columns { load, mass, .. } = &mut *columns;
    for (load, mass) in load.iter_mut().zip(mass) {
        *load = Load::weight(gravity.0, *mass);
    }
}

/// Writes the sums to the forces of those whom `F` accepts.
pub(crate) fn write_forces<V: Space, F: ArchetypeFilter + 'static>(
    columns: Res<Columns<V>>,
    mut particles: Query<(&Slot, &mut Force<V>), F>,
) {
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

/// The columns hold x(t+dt), v(t+dt/2) after this part of [`Gathered`]; the rest of it is about spins.
#[derive(SystemSet, Clone, Debug, PartialEq, Eq, Hash)]
pub struct PlacesGathered;

/// Spins are w(t+dt/2) after this set of [`Phase::Drift`].
#[derive(SystemSet, Clone, Debug, PartialEq, Eq, Hash)]
pub struct SpinsDrifted;

/// The columns know what a scheme that looks ahead needs after this set, before the neighbour search.
#[derive(SystemSet, Clone, Debug, PartialEq, Eq, Hash)]
pub struct LookedAhead;

/// Velocities are v(t+dt) after this set of [`Phase::Kick`].
#[derive(SystemSet, Clone, Debug, PartialEq, Eq, Hash)]
pub struct Kicked;

/// The columns hold v(t+dt) after this set, at the end of [`Phase::Kick`].
#[derive(SystemSet, Clone, Debug, PartialEq, Eq, Hash)]
pub struct GatheredVelocities;

/// Which passes between components and columns a scene needs.
#[derive(Clone, Copy, Debug)]
pub struct Passes {
    /// Whether the drift writes positions to the columns: where nobody else moves grains before forces are evaluated.
    pub drift_gathers: bool,
    /// Whether the kick writes forces and velocities: where no behaviour adds forces or changes velocities.
    pub kick_writes: bool,
}

/// The columns and the passes that fill and empty them.
pub struct ColumnsPlugin<V: Space> {
    /// Which passes there are.
    pub passes: Passes,
    /// The space.
    pub space: PhantomData<V>,
}

impl<V: Space> Plugin for ColumnsPlugin<V> {
    fn build(&self, app: &mut App) {
        app.init_resource::<Columns<V>>().insert_resource(PopulationChanged(true)).init_resource::<Renumberings>();
        app.edit_schedule(Step, |schedule| {
            schedule
                .configure_sets((BeforeRenumbering, Renumbering).chain().run_if(renumbering_due).in_set(Phase::Spawn));
        });
        app.add_systems(
            Step,
            (
                tidy_up::<V>.in_set(Phase::Spawn).before(BeforeRenumbering).run_if(is_time_to_tidy),
                renumber::<V>.in_set(Renumbering),
                clear_forces::<V>
                    .in_set(ForceStage::Contacts)
                    .before(ContactForces)
                    .run_if(not(resource_exists::<History<V>>)),
            ),
        );
        if self.passes.drift_gathers {
            let fixed = gather::<V, With<Fixed>>.in_set(Phase::Neighbours).in_set(Gathered).in_set(PlacesGathered);
            app.add_systems(Step, fixed);
            // In step zero nothing drifts.
            let rest = gather::<V, Without<Fixed>>.in_set(Phase::Neighbours).in_set(Gathered).in_set(PlacesGathered);
            app.add_systems(Step, rest.after(gather::<V, With<Fixed>>).run_if(is_step_zero));
        } else {
            let all = gather::<V, ()>.in_set(Phase::Neighbours).in_set(Gathered).in_set(PlacesGathered);
            app.add_systems(Step, all);
        }
        if self.passes.kick_writes {
            app.add_systems(Step, write_forces::<V, With<Fixed>>.in_set(ForceStage::Written));
            let rest = write_forces::<V, Without<Fixed>>.in_set(ForceStage::Written).run_if(is_step_zero);
            app.add_systems(Step, rest.after(write_forces::<V, With<Fixed>>));
        } else {
            app.add_systems(Step, write_forces::<V, ()>.in_set(ForceStage::Written));
            app.add_systems(Step, gather_velocities::<V>.in_set(Phase::Kick).in_set(GatheredVelocities));
        }
    }
}
