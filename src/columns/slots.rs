//! Slots: which entry of the columns belongs to whom, and when they are dealt out anew.

use bevy_app::App;
use bevy_ecs::change_detection::ContiguousRef;
use bevy_ecs::lifecycle::HookContext;
use bevy_ecs::prelude::*;
use bevy_ecs::query::QueryData;
use bevy_ecs::world::DeferredWorld;

use crate::columns::order::{Order, Place};
use crate::columns::{Body, Columns, DENSE, Entering, Newcomer, Rotation, Turnover};
use crate::particle::{Fixed, Force, GrainBundle, GrainId, Mass, Position, Radius, Species, Velocity};
use crate::space::Space;
use crate::spin::{Inertia, Spin, Torque};
use crate::step::{Clock, Phase, Step};

/// Index of a particle in the [`Columns`].
#[derive(Component, Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Slot(u32);

impl Default for Slot {
    /// No place yet.
    fn default() -> Self {
        Self(u32::MAX)
    }
}

impl Slot {
    #[cfg(test)]
    pub(crate) fn at(index: u32) -> Self {
        Self(index)
    }

    /// That of entry `i`, of which there are fewer than 2^32.
    pub(super) fn of(i: usize) -> Self {
        u32::try_from(i).map_or_else(|_| Self::default(), Self)
    }

    /// The index, out of range as long as the particle has no place.
    #[must_use]
    pub fn index(self) -> usize {
        self.0 as usize
    }
}

/// What the columns hold of a particle, and its slot.
#[derive(QueryData)]
#[query_data(mutable)]
pub(crate) struct Particle<V: Space> {
    entity: Entity,
    id: &'static GrainId,
    position: &'static Position<V>,
    velocity: &'static Velocity<V>,
    force: &'static Force<V>,
    radius: &'static Radius,
    mass: Option<&'static Mass>,
    species: Option<&'static Species>,
    is_fixed: Has<Fixed>,
    turning: Option<(&'static Spin<V::Spin>, &'static Torque<V::Spin>, &'static Inertia)>,
    slot: &'static mut Slot,
}

impl<V: Space> ParticleReadOnlyItem<'_, '_, V> {
    /// Whether no force moves it.
    fn never_moves(&self) -> bool {
        inverse_mass(self.mass, self.is_fixed) == 0.0
    }
}

/// 1/m as contacts see it, 1/kg.
fn inverse_mass(mass: Option<&Mass>, is_fixed: bool) -> f64 {
    mass.map_or(0.0, |mass| if is_fixed { 0.0 } else { 1.0 / mass.0 })
}

/// Where a particle comes in the order of slots.
type Key = (bool, Place, GrainId);

/// A particle that will have a slot: where it comes, its number, and the slot that it had. Numbered are newcomers, then entities as
/// they come, then bare grains that stay.
type Entrant = (Key, u32, Slot);

impl<V: Space> Columns<V> {
    /// Deals out slots to bare grains and to particles that are entities, and fills the columns.
    fn refill(&mut self, turnover: &Turnover<V>, particles: &mut Query<Particle<V>>) {
        let newcomers = &turnover.entering;
        self.order = self.next_order(turnover, particles);
        let altered: Vec<_> = self.entities_altered(particles).collect();
        let entrants = self.entrants(turnover, particles);
        self.movable_end = entrants.partition_point(|&((is_fixed, ..), ..)| !is_fixed);
        self.id.clear();
        self.id.extend(entrants.iter().map(|&((.., id), ..)| id));
        self.former.clear();
        self.former.extend(entrants.iter().map(|&(.., former)| former));
        let mut slots = vec![Slot::default(); entrants.len()];
        for (slot, (_, number, _)) in (0u32..).zip(entrants) {
            slots[number as usize] = Slot(slot);
        }
        let (of_newcomers, of_others) = slots.split_at(newcomers.len());
        self.altered.clear();
        self.altered.extend(altered.into_iter().map(|entity: usize| of_others[entity]));
        self.altered.sort_unstable();
        self.make_room();
        for (newcomer, slot) in newcomers.iter().zip(of_newcomers) {
            self.fill_newcomer(newcomer, slot.index());
        }
        for (mut particle, &slot) in particles.iter_mut().zip(of_others) {
            self.fill_entity(&mut particle, slot);
        }
        let radii = || self.body.iter().map(|body| body.radius);
        let (smallest, largest) = (radii().fold(f64::INFINITY, f64::min), radii().fold(0.0, f64::max));
        self.smallest_share = smallest / (smallest + largest);
        self.generation += 1;
    }

    /// The order of slots for all who are not fixed.
    fn next_order(&self, turnover: &Turnover<V>, particles: &Query<Particle<V>>) -> Order {
        let grains = || turnover.entering.iter().map(|newcomer| &newcomer.grain.particle);
        let free = || particles.iter().filter(|row| !row.is_fixed);
        let bare = || self.bare(turnover).map(|i| &self.body[i]);
        let places = grains().map(|grain| grain.position.0).chain(free().map(|row| row.position.0));
        let radii = grains().map(|grain| grain.radius.0).chain(free().map(|row| row.radius.0));
        let largest = radii.chain(bare().map(|body| body.radius)).fold(0.0, f64::max);
        Order::of(places.chain(bare().map(|body| body.position)), 2.0 * largest)
    }

    /// All who will have slots, in the order of these.
    fn entrants(&self, turnover: &Turnover<V>, particles: &Query<Particle<V>>) -> Vec<Entrant> {
        let key = |is_fixed, position: V, id| (is_fixed, self.order.place(position), id);
        let of_newcomers =
            turnover.entering.iter().map(|Newcomer { grain: GrainBundle { particle: grain, .. }, .. }| {
                (key(false, grain.position.0, grain.id), Slot::default())
            });
        // Tables are walked several times: that takes less room than to keep who was met.
        let of_entities = particles.iter().map(|row| {
            let former = if self.knows(&row) { *row.slot } else { Slot::default() };
            (key(row.never_moves(), row.position.0, *row.id), former)
        });
        let of_bare = self.bare(turnover).map(|i| (key(false, self.body[i].position, self.id[i]), Slot::of(i)));
        let all = of_newcomers.chain(of_entities).chain(of_bare);
        let mut entrants: Vec<_> = (0u32..).zip(all).map(|(number, (key, former))| (key, number, former)).collect();
        entrants.sort_unstable_by_key(|&(key, ..)| key);
        entrants
    }

    /// Which entities, as they come, had another radius in the slots that they had, or were fixed and are free, or the reverse.
    fn entities_altered(&self, particles: &Query<Particle<V>>) -> impl Iterator<Item = usize> {
        particles.iter().enumerate().filter_map(|(number, row)| {
            let i = row.slot.index();
            let is_same =
                |was: &Body<V>| was.radius.total_cmp(&row.radius.0).is_eq() && self.is_fixed(i) == row.never_moves();
            (self.knows(&row) && !is_same(&self.body[i])).then_some(number)
        })
    }

    /// Whether the slot of an entity is its own.
    fn knows(&self, row: &ParticleReadOnlyItem<'_, '_, V>) -> bool {
        self.entity.get(row.slot.index()) == Some(&row.entity)
    }

    /// Makes room for all who have slots now, with what the columns hold of bare grains.
    fn make_room(&mut self) {
        let Self { former, is_bare, has_books, inertia, loads, .. } = self;
        let size = former.len();
        let nobody = Body { position: V::ZERO, velocity: V::ZERO, radius: 0.0, inverse_mass: 0.0 };
        refit(&mut self.entity, size, Entity::PLACEHOLDER);
        if *is_bare {
            rearrange(&mut self.body, former, nobody);
            rearrange(&mut self.mass, former, 0.0);
            rearrange(&mut self.species, former, Species::default());
            loads.force.rearrange(former, *has_books);
            if inertia.is_some() {
                rearrange(&mut self.rotation, former, Rotation::default());
                loads.torque.rearrange(former, *has_books);
            }
        } else {
            refit(&mut self.body, size, nobody);
            refit(&mut self.mass, size, 0.0);
            refit(&mut self.species, size, Species::default());
            loads.force.reset(size, *has_books);
            if inertia.is_some() {
                refit(&mut self.rotation, size, Rotation::default());
                loads.torque.reset(size, *has_books);
            }
        }
        if !loads.contacts.is_empty() {
            rearrange(&mut loads.contacts, former, MANY);
        }
    }

    fn fill_newcomer(&mut self, newcomer: &Newcomer<V>, i: usize) {
        let GrainBundle { particle, mass, species, .. } = &newcomer.grain;
        self.body[i] = Body {
            position: particle.position.0,
            velocity: particle.velocity.0,
            radius: particle.radius.0,
            inverse_mass: inverse_mass(Some(mass), false),
        };
        self.loads.force.set(i, particle.force.0);
        self.mass[i] = mass.0;
        self.species[i] = *species;
        if let Some(law) = self.inertia {
            let (spin, _, inertia) = newcomer.turning(law);
            self.rotation[i] = Rotation { spin: spin.0, inverse_inertia: 1.0 / inertia.0 };
        }
    }

    fn fill_entity(&mut self, row: &mut ParticleItem<'_, '_, V>, slot: Slot) {
        let i = slot.index();
        self.entity[i] = row.entity;
        self.body[i] = Body {
            position: row.position.0,
            velocity: row.velocity.0,
            radius: row.radius.0,
            inverse_mass: inverse_mass(row.mass, row.is_fixed),
        };
        self.loads.force.set(i, row.force.0);
        self.mass[i] = row.mass.map_or(0.0, |mass| mass.0);
        self.species[i] = row.species.copied().unwrap_or_default();
        if let (Some((spin, torque, inertia)), Some(rotation)) = (row.turning, self.rotation.get_mut(i)) {
            *rotation = Rotation { spin: spin.0, inverse_inertia: 1.0 / inertia.0 };
            self.loads.torque.set(i, torque.0);
        }
        *row.slot = slot;
    }

    /// The slot that who has slot `i` had before, if it was what it is now.
    pub(crate) fn same_before(&self, i: usize) -> Slot {
        let is_altered = self.altered.binary_search(&Slot::of(i)).is_ok();
        if is_altered { Slot::default() } else { self.former[i] }
    }

    /// Whether more than a tenth of the grains come after one whose place is later.
    fn is_untidy(&self) -> bool {
        let places = self.body[..self.movable_end].iter().map(|body| self.order.place(body.position));
        10 * places.clone().zip(places.skip(1)).filter(|(one, next)| next < one).count() > self.movable_end
    }
}

/// Makes a column as long as this, of blanks.
fn refit<T: Copy>(column: &mut Vec<T>, size: usize, blank: T) {
    column.clear();
    column.resize(size, blank);
}

/// Brings what was of the slot that each had to the slot that it has now; who had none is given a blank.
fn rearrange<T: Copy>(column: &mut Vec<T>, former: &[Slot], blank: T) {
    *column = former.iter().map(|slot| column.get(slot.index()).copied().unwrap_or(blank)).collect();
}

/// Whether particles were added, removed, fixed or freed since slots were dealt out.
#[derive(Resource, Default)]
pub struct PopulationChanged(bool);

impl PopulationChanged {
    /// It has.
    pub(crate) fn note(&mut self) {
        self.0 = true;
    }
}

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

/// Run condition: every [`TIDY_EVERY`] steps.
pub(crate) fn is_time_to_tidy(clock: Res<Clock>) -> bool {
    clock.steps.is_multiple_of(TIDY_EVERY) && !clock.is_step_zero()
}

pub(crate) fn renumber<V: Space>(
    mut columns: ResMut<Columns<V>>,
    (mut changed, mut count): (ResMut<PopulationChanged>, ResMut<Renumberings>),
    mut turnover: ResMut<Turnover<V>>,
    mut particles: Query<Particle<V>>,
) {
    columns.refill(&std::mem::take(&mut *turnover), &mut particles);
    changed.0 = false;
    count.0 += 1;
}

/// What has to be booked before slots are dealt out anew (the columns still hold the old state) belongs here.
#[derive(SystemSet, Clone, Debug, PartialEq, Eq, Hash)]
pub struct BeforeRenumbering;

/// The system that deals out slots; spawners run before it.
#[derive(SystemSet, Clone, Debug, PartialEq, Eq, Hash)]
pub struct Renumbering;

/// Deals out slots where they are due.
pub(super) fn add<V: Space>(app: &mut App) {
    app.insert_resource(PopulationChanged(true)).init_resource::<Renumberings>().init_resource::<Turnover<V>>();
    app.edit_schedule(Step, |schedule| {
        schedule.configure_sets(Entering.in_set(Phase::Spawn).before(BeforeRenumbering));
        schedule.configure_sets((BeforeRenumbering, Renumbering).chain().run_if(renumbering_due).in_set(Phase::Spawn));
    });
    app.add_systems(
        Step,
        (
            tidy_up::<V>.in_set(Phase::Spawn).before(Entering).before(BeforeRenumbering).run_if(is_time_to_tidy),
            renumber::<V>.in_set(Renumbering),
        ),
    );
}
