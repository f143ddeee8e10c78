//! Dealing out slots: who has one, in which order, and what the columns then hold.
//!
//! Entities bring their components; bare grains what the columns already hold of them, or with what they enter.

use bevy_ecs::prelude::*;
use bevy_ecs::query::QueryData;

use crate::columns::order::{Order, Place};
use crate::columns::{Body, Columns, MANY, Newcomer, Rotation, Slot, Turnover};
use crate::particle::{Fixed, Force, GrainBundle, GrainId, Mass, Particle, Position, Radius, Species, Velocity};
use crate::space::Space;
use crate::spin::{Inertia, Spin, Torque, TurningBundle};

/// What the columns hold of a particle, and its slot.
#[derive(QueryData)]
#[query_data(mutable)]
pub(crate) struct EntityRow<V: Space> {
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

impl<V: Space> EntityRowReadOnlyItem<'_, '_, V> {
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
    pub(super) fn refill(&mut self, turnover: &Turnover<V>, particles: &mut Query<EntityRow<V>>) {
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
            slots[number as usize] = Slot::new(slot);
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
    fn next_order(&self, turnover: &Turnover<V>, particles: &Query<EntityRow<V>>) -> Order {
        let grains = || turnover.entering.iter().map(|newcomer| &newcomer.grain.particle);
        let free = || particles.iter().filter(|row| !row.is_fixed);
        let bare = || self.bare(turnover).map(|i| &self.body[i]);
        let places = grains().map(|grain| grain.position.0).chain(free().map(|row| row.position.0));
        let radii = grains().map(|grain| grain.radius.0).chain(free().map(|row| row.radius.0));
        let largest = radii.chain(bare().map(|body| body.radius)).fold(0.0, f64::max);
        Order::of(places.chain(bare().map(|body| body.position)), 2.0 * largest)
    }

    /// All who will have slots, in the order of these.
    fn entrants(&self, turnover: &Turnover<V>, particles: &Query<EntityRow<V>>) -> Vec<Entrant> {
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
    fn entities_altered(&self, particles: &Query<EntityRow<V>>) -> impl Iterator<Item = usize> {
        particles.iter().enumerate().filter_map(|(number, row)| {
            let i = row.slot.index();
            let is_same =
                |was: &Body<V>| was.radius.total_cmp(&row.radius.0).is_eq() && self.is_fixed(i) == row.never_moves();
            (self.knows(&row) && !is_same(&self.body[i])).then_some(number)
        })
    }

    /// Whether the slot of an entity is its own.
    fn knows(&self, row: &EntityRowReadOnlyItem<'_, '_, V>) -> bool {
        self.entity.get(row.slot.index()) == Some(&row.entity)
    }

    /// Makes room for all who have slots now, with what the columns hold of bare grains.
    fn make_room(&mut self) {
        let Self { former, is_bare, has_books, inertia, loads, .. } = self;
        let size = former.len();
        // What is of entities they bring along.
        let kept = if *is_bare { &former[..] } else { &[] };
        let nobody = Body { position: V::ZERO, velocity: V::ZERO, radius: 0.0, inverse_mass: 0.0 };
        rearrange(&mut self.entity, size, &[], Entity::PLACEHOLDER);
        rearrange(&mut self.body, size, kept, nobody);
        rearrange(&mut self.mass, size, kept, 0.0);
        rearrange(&mut self.species, size, kept, Species::default());
        loads.force.rearrange(size, kept, *has_books);
        if inertia.is_some() {
            rearrange(&mut self.rotation, size, kept, Rotation::default());
            loads.torque.rearrange(size, kept, *has_books);
        }
        if !loads.contacts.is_empty() {
            rearrange(&mut loads.contacts, size, former, MANY);
        }
    }

    /// Fills in entry `i`: position (m), velocity (m/s) and force (N); radius (m); mass (kg) and its inverse as contacts see it.
    fn fill(&mut self, i: usize, motion: (V, V, V), radius: f64, masses: (f64, f64), species: Species) {
        let ((position, velocity, force), (mass, inverse_mass)) = (motion, masses);
        self.body[i] = Body { position, velocity, radius, inverse_mass };
        self.loads.force.set(i, force);
        self.mass[i] = mass;
        self.species[i] = species;
    }

    /// The same of how it turns, where grains spin.
    fn fill_turning(&mut self, i: usize, (spin, torque, inertia): TurningBundle<V>) {
        if let Some(rotation) = self.rotation.get_mut(i) {
            *rotation = Rotation { spin: spin.0, inverse_inertia: 1.0 / inertia.0 };
            self.loads.torque.set(i, torque.0);
        }
    }

    fn fill_newcomer(&mut self, newcomer: &Newcomer<V>, i: usize) {
        let GrainBundle { particle, mass, species, .. } = &newcomer.grain;
        let Particle { position, velocity, force, radius, .. } = particle;
        self.fill(i, (position.0, velocity.0, force.0), radius.0, (mass.0, inverse_mass(Some(mass), false)), *species);
        if let Some(law) = self.inertia {
            self.fill_turning(i, newcomer.turning(law));
        }
    }

    fn fill_entity(&mut self, row: &mut EntityRowItem<'_, '_, V>, slot: Slot) {
        let i = slot.index();
        self.entity[i] = row.entity;
        let masses = (row.mass.map_or(0.0, |mass| mass.0), inverse_mass(row.mass, row.is_fixed));
        let species = row.species.copied().unwrap_or_default();
        self.fill(i, (row.position.0, row.velocity.0, row.force.0), row.radius.0, masses, species);
        if let Some((spin, torque, inertia)) = row.turning {
            self.fill_turning(i, (*spin, *torque, *inertia));
        }
        *row.slot = slot;
    }
}

/// Makes a column as long as this: what was of the slots that the first ones had, and blanks for who had none and for the others.
fn rearrange<T: Copy>(column: &mut Vec<T>, size: usize, former: &[Slot], blank: T) {
    let before = |i: usize| column.get(former.get(i)?.index()).copied();
    *column = (0..size).map(|i| before(i).unwrap_or(blank)).collect();
}

#[cfg(test)]
mod tests {
    use bevy_ecs::system::RunSystemOnce;

    use super::*;
    use crate::columns::slots::{PopulationChanged, Renumberings, renumber};
    use crate::particle::Grain;
    use crate::space::Plane;

    fn grain(number: u32) -> GrainBundle {
        GrainBundle {
            particle: Particle {
                id: GrainId::grain(number).unwrap(),
                position: Position(Plane::new(f64::from(number), 0.0)),
                velocity: Velocity::default(),
                force: Force::default(),
                radius: Radius(0.1),
            },
            mass: Mass(1.0),
            species: Species(0),
            grain: Grain,
        }
    }

    #[test]
    fn whoever_is_altered_is_known_but_not_the_same() {
        let mut world = World::new();
        world.init_resource::<Columns>();
        world.init_resource::<Turnover<Plane>>();
        world.init_resource::<PopulationChanged>();
        world.init_resource::<Renumberings>();
        let [gone, grown, held, same] = [0, 1, 2, 3].map(|number| world.spawn(grain(number)).id());
        world.run_system_once(renumber::<Plane>).unwrap();
        let nobody = Slot::default();
        assert_eq!(world.resource::<Columns>().entity, [gone, grown, held, same]);
        assert_eq!(world.resource::<Columns>().former, [nobody; 4]);
        world.despawn(gone);
        world.get_mut::<Radius>(grown).unwrap().0 = 0.2;
        world.entity_mut(held).insert(Fixed);
        let new = world.spawn(grain(4)).id();
        world.run_system_once(renumber::<Plane>).unwrap();
        let columns = world.resource::<Columns>();
        assert_eq!((&columns.entity[..], columns.movable_end), (&[grown, same, new, held][..], 3));
        assert_eq!(columns.former, [Slot::new(1), Slot::new(3), nobody, Slot::new(2)]);
        let same_before: Vec<_> = (0..4).map(|i| columns.same_before(i)).collect();
        assert_eq!(same_before, [nobody, Slot::new(3), nobody, nobody]);
    }
}
