//! Assigns slots to particles, in spatial order, and moves the rows of the store to them.
//!
//! The store owns the state of the particles that it has rows for; these rows move to the new slots. Components are
//! read only from entities that the [population](super::population) recorded: all components of entering particles, and
//! permanent properties of altered ones.

use bevy_ecs::prelude::*;
use bevy_ecs::query::QueryData;
use rustc_hash::FxHashMap;

use crate::bodies::{Orientation, RigidShape, Shape, ShapeSphere};
use crate::nearly_sorted::sort_into;
use crate::particle::{Fixed, Force, GrainId, Mass, Position, Radius, Slot, Species, Velocity};
use crate::space::{Rotor, Space};
use crate::spin::{Inertia, Spin, Torque};
use crate::store::bodies::{BodyColumns, BodySlot, Layout, NO_SPHERE};
use crate::store::spatial_sort::{Place, SpatialOrder};
use crate::store::{Body, ParticleStore, Rotation};

/// The components of a particle.
#[derive(QueryData)]
pub(crate) struct EntityRow<V: Space> {
    entity: Entity,
    id: &'static GrainId,
    position: &'static Position<V>,
    velocity: &'static Velocity<V>,
    force: Option<&'static Force<V>>,
    radius: &'static Radius,
    mass: Option<&'static Mass>,
    species: Option<&'static Species>,
    shape: Option<(&'static Shape, &'static Orientation<V>)>,
    is_marked_fixed: Has<Fixed>,
    turning: Option<(&'static Spin<V::Spin>, &'static Inertia)>,
    torque: Option<&'static Torque<V::Spin>>,
}

/// Properties of a particle that change by insertion alone, as the store holds them.
#[derive(Clone, Copy, Debug)]
struct Properties {
    id: GrainId,
    radius: f64,
    mass: f64,
    /// 1/m as contacts see it, 1/kg: 0 for fixed particles.
    inverse_mass: f64,
    inverse_inertia: f64,
    species: Species,
}

impl Properties {
    fn of<V: Space>(row: &EntityRowItem<'_, '_, V>) -> Self {
        let inverse_mass = row.mass.map_or(0.0, |mass| if row.is_marked_fixed { 0.0 } else { 1.0 / mass.0 });
        Self {
            id: *row.id,
            radius: row.radius.0,
            mass: row.mass.map_or(0.0, |mass| mass.0),
            inverse_mass,
            inverse_inertia: row.turning.map_or(0.0, |(_, inertia)| 1.0 / inertia.0),
            species: row.species.copied().unwrap_or_default(),
        }
    }

    /// Whether the particle is fixed: it has the mark [`Fixed`], or no mass.
    fn is_fixed(&self) -> bool {
        self.inverse_mass == 0.0
    }
}

/// The kinds of rows, in the order of the rows.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum RowKind {
    FreeBody,
    FreeGrain,
    FreeSphere,
    FixedSphere,
    FixedBody,
}

/// An entering particle, or a sphere of an entering body, with the data that determine its slot.
struct Entering<V: Space> {
    entity: Entity,
    id: GrainId,
    kind: RowKind,
    /// Number in the shape of a body, or [`NO_SPHERE`].
    number: u16,
    /// Radius, m.
    radius: f64,
    /// Centre, m.
    position: V,
}

impl<V: Space> Entering<V> {
    /// Adds the particle of `row` to `entering`; a body with its spheres, by the shapes of the scene.
    fn push(row: &EntityRowItem<'_, '_, V>, shapes: &[RigidShape<V>], entering: &mut Vec<Self>) {
        let properties = Properties::of(row);
        let Properties { id, radius, .. } = properties;
        let entity = row.entity;
        let position = row.position.0;
        let form = row.shape.and_then(|(shape, rotor)| Some((shapes.get(shape.index())?, rotor.0)));
        let Some((shape, rotor)) = form else {
            let kind = if properties.is_fixed() { RowKind::FixedSphere } else { RowKind::FreeGrain };
            entering.push(Self { entity, id, kind, number: NO_SPHERE, radius, position });
            return;
        };
        let [body, sphere] = RowKind::of_body(properties.is_fixed());
        entering.push(Self { entity, id, kind: body, number: NO_SPHERE, radius, position });
        let scale = shape.scale(radius);
        entering.extend((0..).zip(&shape.spheres).map(|(number, ShapeSphere { at, radius })| Self {
            entity,
            id,
            kind: sphere,
            number,
            radius: radius * scale,
            position: position + rotor.turn(*at * scale),
        }));
    }
}

impl RowKind {
    /// Returns the kinds of a body and of its spheres.
    fn of_body(is_fixed: bool) -> [Self; 2] {
        if is_fixed { [Self::FixedBody, Self::FixedSphere] } else { [Self::FreeBody, Self::FreeSphere] }
    }
}

/// Sort key of a row. Slots are in the order of these keys, which compare field by field.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct SlotKey {
    kind: RowKind,
    /// The numbers of the place, the first one highest. One number is compared faster than four.
    place: u128,
    /// The id, then the number in the shape of a body, or [`NO_SPHERE`].
    of_grain: u64,
}

impl SlotKey {
    fn new(kind: RowKind, place: Place, id: GrainId, number: u16) -> Self {
        // The sign is turned, so that the order stays.
        let place =
            place.into_iter().fold(0, |packed, one| (packed << 32) | u128::from(one.cast_unsigned() ^ (1 << 31)));
        Self { kind, place, of_grain: id.bits() << 16 | u64::from(number) }
    }

    fn id(&self) -> GrainId {
        GrainId::of_bits(self.of_grain >> 16)
    }

    #[expect(clippy::cast_possible_truncation, reason = "the lowest bits are the number")]
    fn number(&self) -> u16 {
        self.of_grain as u16
    }
}

/// A particle that gets a slot.
struct SlotTaker {
    key: SlotKey,
    /// A number below the row count is the former row of the particle. A higher one is the row count plus an index into the entering
    /// particles.
    source: u32,
}

impl<V: Space> ParticleStore<V> {
    /// Assigns slots to all particles. `touched` lists the entities that entered or were altered. Grains that enter without a force
    /// get their weight by `gravity`, m/s^2.
    pub(super) fn reorder(
        &mut self,
        touched: Vec<Entity>,
        particles: &Query<EntityRow<V>>,
        slots: &mut Query<&mut Slot>,
        gravity: V,
    ) {
        let (entering, altered) = self.read(touched, particles, slots);
        let rows = self.len();
        self.order = self.next_order(&entering, &altered);
        let takers = self.takers(&entering, &altered);
        let end_of = |kind: RowKind| takers.partition_point(|taker| taker.key.kind <= kind);
        let layout = Layout {
            bodies: end_of(RowKind::FreeBody),
            grains: end_of(RowKind::FreeGrain),
            free: end_of(RowKind::FreeSphere),
            contacts: end_of(RowKind::FixedSphere),
            all: takers.len(),
        };
        // Which rows are spheres of bodies.
        let in_bodies = if layout.has_bodies() { &takers[layout.grains..layout.contacts] } else { &[] };
        let spheres: Vec<_> = in_bodies.iter().map(|taker| (taker.key.id(), taker.key.number())).collect();
        self.id.clear();
        self.id.extend(takers.iter().map(|taker| taker.key.id()));
        self.former.clear();
        let former = |source: u32| if (source as usize) < rows { Slot::new(source) } else { Slot::default() };
        self.former.extend(takers.iter().map(|taker| former(taker.source)));
        let newcomer = |taker: &SlotTaker| {
            let new = entering.get((taker.source as usize).checked_sub(rows)?)?;
            // A sphere of a body gets its numbers from the body.
            (new.number == NO_SPHERE).then_some(new.entity)
        };
        let newcomers = takers.iter().zip(0u32..).filter_map(|(taker, slot)| Some((newcomer(taker)?, slot)));
        let newcomers: Vec<_> = newcomers.collect();
        // Memory use is highest here when all grains of a scene enter at once.
        drop((takers, entering));
        if layout.has_bodies() || !self.bodies.is_empty() {
            self.rearrange_bodies(&layout);
        }
        self.free_end = layout.free;
        self.make_room();
        self.apply_altered(&altered);
        for (entity, slot) in newcomers {
            if let Ok(row) = particles.get(entity) {
                self.fill(slot as usize, &row, gravity);
            }
        }
        if layout.has_bodies() {
            let ids: Vec<_> = layout.bodies().map(|row| self.id[row]).collect();
            self.bodies.set_spheres(&spheres, &ids);
            self.renew_spheres();
            self.alter_spheres();
        }
        for (i, (entity, former)) in self.entity.iter().zip(&self.former).enumerate() {
            if *former != Slot::of(i)
                && self.is_whole(i)
                && let Ok(mut slot) = slots.get_mut(*entity)
            {
                *slot.bypass_change_detection() = Slot::of(i);
            }
        }
        self.vacated.clear();
        self.smallest_share = smallest_share(&self.body[self.contact_rows()]);
        self.generation += 1;
    }

    /// Reads the entities that entered, and the properties of altered ones, keyed by row.
    fn read(
        &self,
        touched: Vec<Entity>,
        particles: &Query<EntityRow<V>>,
        slots: &Query<&mut Slot>,
    ) -> (Vec<Entering<V>>, FxHashMap<usize, Properties>) {
        let mut entering = Vec::new();
        let mut altered = FxHashMap::default();
        for entity in touched {
            // An entity that is already gone, or is no particle, has no row.
            let (Ok(row), Ok(slot)) = (particles.get(entity), slots.get(entity)) else { continue };
            match self.row_of(entity, *slot) {
                Some(i) => {
                    altered.insert(i, Properties::of(&row));
                }
                None => Entering::push(&row, &self.bodies.shapes, &mut entering),
            }
        }
        (entering, altered)
    }

    /// Derives the spatial order from all free particles.
    fn next_order(&self, entering: &[Entering<V>], altered: &FxHashMap<usize, Properties>) -> SpatialOrder {
        let known = || {
            self.contact_rows().filter(|&i| self.is_present(i)).filter_map(|i| match altered.get(&i) {
                Some(properties) => (!properties.is_fixed()).then_some((self.body[i].position, properties.radius)),
                None => (!self.is_fixed(i)).then_some((self.body[i].position, self.body[i].radius)),
            })
        };
        let new = || {
            let free = entering.iter().filter(|new| matches!(new.kind, RowKind::FreeGrain | RowKind::FreeSphere));
            free.map(|entering| (entering.position, entering.radius))
        };
        let largest = known().chain(new()).map(|(_, radius)| radius).fold(0.0, f64::max);
        SpatialOrder::of(known().chain(new()).map(|(position, _)| position), 2.0 * largest)
    }

    /// Returns all particles, in the order of their new slots.
    fn takers(&self, entering: &[Entering<V>], altered: &FxHashMap<usize, Properties>) -> Vec<SlotTaker> {
        let known = (0u32..).zip(0..self.len()).filter(|&(_, i)| self.is_present(i)).map(|(source, i)| {
            let sphere = self.bodies.sphere(i);
            // A sphere is fixed with its body.
            let whole = sphere.map_or(i, |sphere| self.row_of_body(sphere.body));
            let is_fixed = altered.get(&whole).map_or(self.is_fixed(whole), Properties::is_fixed);
            let kind = match (sphere, self.body_of_row(i)) {
                (Some(_), _) => RowKind::of_body(is_fixed)[1],
                (None, Some(_)) => RowKind::of_body(is_fixed)[0],
                (None, None) => {
                    if is_fixed {
                        RowKind::FixedSphere
                    } else {
                        RowKind::FreeGrain
                    }
                }
            };
            let place = self.order.place(self.body[i].position);
            let number = sphere.map_or(NO_SPHERE, |sphere| sphere.number);
            SlotTaker { key: SlotKey::new(kind, place, self.id[i], number), source }
        });
        let first = u32::try_from(self.len()).expect("fewer than 2^32 particles");
        let new = (first..).zip(entering).map(|(source, &Entering { id, kind, number, position, .. })| {
            let place = self.order.place(position);
            SlotTaker { key: SlotKey::new(kind, place, id, number), source }
        });
        let mut takers = Vec::with_capacity(self.len() + entering.len());
        sort_into(&mut takers, known.chain(new), |taker| taker.key);
        takers
    }

    /// Moves the rows of known particles to their new slots, and adds blank rows for the others.
    fn make_room(&mut self) {
        let Self { former, tracks_energy, inertia, loads, .. } = self;
        let size = former.len();
        let kept = &former[..];
        let blank = Body {
            position: V::ZERO,
            velocity: V::ZERO,
            radius: 0.0,
            inverse_mass: 0.0,
            middle: V::MiddleInBody::default(),
        };
        rearrange(&mut self.entity, size, kept, Entity::PLACEHOLDER);
        rearrange(&mut self.body, size, kept, blank);
        rearrange(&mut self.mass, size, kept, 0.0);
        rearrange(&mut self.species, size, kept, Species::default());
        loads.force.rearrange(size, kept, *tracks_energy);
        if inertia.is_some() {
            rearrange(&mut self.rotation, size, kept, Rotation::default());
            loads.torque.rearrange(size, kept, *tracks_energy);
        }
        if !self.prediction.lone.is_empty() {
            rearrange(&mut self.prediction.lone, size, kept, 0);
        }
    }

    /// Writes the properties of altered particles, given by former row. Records in `altered` the particles that
    /// neighbour lists must not carry over: particles that were fixed or freed, or got another radius.
    fn apply_altered(&mut self, altered: &FxHashMap<usize, Properties>) {
        self.altered.clear();
        if altered.is_empty() {
            return;
        }
        for i in 0..self.former.len() {
            let Some(properties) = altered.get(&self.former[i].index()) else { continue };
            let before = &self.body[i];
            let is_same = before.radius.total_cmp(&properties.radius).is_eq()
                && (before.inverse_mass == 0.0) == properties.is_fixed();
            if !is_same {
                self.altered.push(Slot::of(i));
            }
            self.set_properties(i, properties);
        }
    }

    /// Counts the spheres of altered bodies as altered.
    fn alter_spheres(&mut self) {
        let bodies = self.altered.iter().filter_map(|row| self.body_of_row(row.index()));
        let spheres: Vec<_> = bodies.flat_map(|body| self.bodies.rows_of(body)).map(|&row| Slot::new(row)).collect();
        if !spheres.is_empty() {
            self.altered.extend(spheres);
            self.altered.sort_unstable();
        }
    }

    fn set_properties(&mut self, i: usize, properties: &Properties) {
        let Properties { radius, mass, inverse_mass, inverse_inertia, species, .. } = *properties;
        self.body[i].radius = radius;
        self.body[i].inverse_mass = inverse_mass;
        self.mass[i] = mass;
        self.species[i] = species;
        if let Some(rotation) = self.rotation.get_mut(i) {
            rotation.inverse_inertia = inverse_inertia;
        }
        self.set_size(i, mass, radius);
    }

    /// Fills row `i` for an entering particle, in `gravity`, m/s^2.
    fn fill(&mut self, i: usize, entering: &EntityRowItem<'_, '_, V>, gravity: V) {
        self.entity[i] = entering.entity;
        self.body[i].position = entering.position.0;
        self.body[i].velocity = entering.velocity.0;
        let properties = Properties::of(entering);
        let body = self.body_of_row(i).map(BodySlot::index);
        if let (Some(body), Some((shape, rotor))) = (body, entering.shape) {
            self.bodies.shape[body] = *shape;
            self.bodies.rotor[body] = rotor.0.normalised().unwrap_or(V::Rotor::IDENTITY);
        }
        let weight = || entering.mass.map_or(V::ZERO, |mass| gravity * mass.0);
        self.loads.force.set(i, entering.force.map_or_else(weight, |force| force.0));
        self.set_properties(i, &properties);
        if let (Some(rotation), Some((spin, _))) = (self.rotation.get_mut(i), entering.turning) {
            rotation.spin = spin.0;
            if let Some(body) = body {
                let BodyColumns { rotor, inverse_inertia, momentum, .. } = &mut self.bodies;
                momentum[body] = rotor[body].momentum(spin.0, inverse_inertia[body]);
            }
            self.loads.torque.set(i, entering.torque.copied().unwrap_or_default().0);
        }
    }
}

/// Returns r_min/(r_min + r_max) over all bodies.
pub(super) fn smallest_share<V: Space>(bodies: &[Body<V>]) -> f64 {
    let radii = || bodies.iter().map(|body| body.radius);
    let smallest = radii().fold(f64::INFINITY, f64::min);
    let largest = radii().fold(0.0, f64::max);
    smallest / (smallest + largest)
}

/// Resizes a column to `size`. The first entries take the values of their former slots; the others are blank.
fn rearrange<T: Copy>(column: &mut Vec<T>, size: usize, former: &[Slot], blank: T) {
    let before = |i: usize| column.get(former.get(i)?.index()).copied();
    *column = (0..size).map(|i| before(i).unwrap_or(blank)).collect();
}

#[cfg(test)]
mod tests {
    use bevy_ecs::system::RunSystemOnce;

    use super::*;
    use crate::particle::{Grain, GrainBundle, Particle};
    use crate::space::Plane;
    use crate::store::population;
    use crate::store::renumbering::{Renumberings, renumber};

    fn grain(number: u32) -> GrainBundle {
        GrainBundle {
            particle: Particle {
                id: GrainId::grain(number).unwrap(),
                position: Position(Plane::new(f64::from(number), 0.0)),
                velocity: Velocity::default(),
                radius: Radius(0.1),
            },
            mass: Mass(1.0),
            species: Species(0),
            grain: Grain,
        }
    }

    #[test]
    fn slots_follow_entering_leaving_and_altered_particles() {
        let mut world = World::new();
        world.init_resource::<ParticleStore>();
        population::add::<Plane>(&mut world);
        world.init_resource::<Renumberings>();
        let [gone, grown, held, same] = [0, 1, 2, 3].map(|number| world.spawn(grain(number)).id());
        world.run_system_once(renumber::<Plane>).unwrap();
        let no_slot = Slot::default();
        assert_eq!(world.resource::<ParticleStore>().entity, [gone, grown, held, same]);
        assert_eq!(world.resource::<ParticleStore>().former, [no_slot; 4]);
        assert!(!world.resource::<population::Population>().is_due());
        world.despawn(gone);
        let store = world.resource::<ParticleStore>();
        assert!(!store.is_present(0) && store.is_present(1) && store.vacated() == [0]);
        world.entity_mut(grown).insert(Radius(0.2));
        world.entity_mut(held).insert(Fixed);
        let new = world.spawn(grain(4)).id();
        world.run_system_once(renumber::<Plane>).unwrap();
        let store = world.resource::<ParticleStore>();
        assert_eq!((&store.entity[..], store.free_end), (&[grown, same, new, held][..], 3));
        assert_eq!(store.former, [Slot::new(1), Slot::new(3), no_slot, Slot::new(2)]);
        let same_before: Vec<_> = (0..4).map(|i| store.same_before(i)).collect();
        assert_eq!(same_before, [no_slot, Slot::new(3), no_slot, no_slot]);
        assert!(store.body[0].radius > 0.15 && store.is_fixed(3) && store.vacated().is_empty());
    }
}
