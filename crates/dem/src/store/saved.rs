//! The saved form of the particle store, between two steps: no kick is pending, and velocities belong to the end of the step.
//!
//! Slots are saved as they are, because they fix the order of sums and depend on the positions at the last renumbering. Two
//! kinds of numbers are not saved: those that the scene decides (inertia and periodic sides), and those that
//! exist within a step alone (velocities in its middle). The smallest share of a radius is computed anew.
//!
//! The restored state is checked ([`consistent`]): rows and components that do not fit would end in a panic of a later step.

use bevy_app::App;
use bevy_ecs::prelude::*;
use serde::{Deserialize, Serialize};

use crate::bodies::Shape;
use crate::particle::{GrainId, Slot, Species};
use crate::persist::{EntityNumbers, PersistApp as _, PersistWith as _, Problem, SavedEntities, encode, numbers};
use crate::space::{Rotor, Space};
use crate::store::bodies::{BodyColumns, Layout, NO_SPHERE};
use crate::store::mirror_set::MirrorSet;
use crate::store::population::Population;
use crate::store::reorder::smallest_share;
use crate::store::spatial_sort::SpatialOrder;
use crate::store::{Body, Loads, ParticleStore, Rotation, consistent};

/// A body without its velocity in the middle of the step.
#[derive(Clone, Copy, Deserialize, Serialize)]
#[serde(bound = "")]
struct SavedBody<V: Space> {
    position: V,
    velocity: V,
    radius: f64,
    inverse_mass: f64,
}

/// The numbers of [`Prediction`](crate::store::Prediction) that change during a run.
#[derive(Deserialize, Serialize)]
struct SavedPrediction {
    velocities_ahead: f64,
    share: f64,
    spin_share: f64,
    margin: f64,
    lone: Vec<u8>,
}

/// The bodies of several spheres, in the order of [`BodyColumns`].
#[derive(Deserialize, Serialize)]
#[serde(bound = "")]
struct SavedBodies<V: Space> {
    layout: Layout,
    shape: Vec<Shape>,
    rotor: Vec<V::Rotor>,
    momentum: Vec<V::Spin>,
    /// The id of the body and the number in its shape of each row from the first sphere to the end of contact rows.
    spheres: Vec<(GrainId, u16)>,
}

/// The store as it is saved.
#[derive(Deserialize, Serialize)]
#[serde(bound = "")]
struct SavedStore<V: Space> {
    id: Vec<GrainId>,
    /// Numbers of the entities; `None` for particles that have left.
    entity: Vec<Option<u32>>,
    vacated: Vec<usize>,
    body: Vec<SavedBody<V>>,
    mass: Vec<f64>,
    species: Vec<Species>,
    loads: Loads<V>,
    rotation: Vec<Rotation<V>>,
    prediction: SavedPrediction,
    half_step: f64,
    added: Vec<V>,
    added_power: Option<f64>,
    lifted: f64,
    is_suspect: bool,
    free_end: usize,
    bodies: Option<SavedBodies<V>>,
    generation: u64,
    travel: f64,
    kick_sum: Option<V>,
    spin_kick_sum: Option<V::Spin>,
    order: SpatialOrder,
}

/// The population as it is saved.
#[derive(Deserialize, Serialize)]
struct SavedPopulation {
    /// Numbers of the touched entities.
    touched: Vec<u32>,
    is_out_of_date: bool,
}

/// Registers the store and the population.
pub(super) fn register<V: Space>(app: &mut App) {
    app.persist_with::<ParticleStore<V>, SavedStore<V>>(
        |world, numbers| encode(&world.resource::<ParticleStore<V>>().to_saved(numbers)).map(Some),
        |world, saved: SavedStore<V>, entities| {
            numbers::check(&saved)?;
            world.resource_mut::<ParticleStore<V>>().restore(saved, entities)
        },
    );
    app.check_restored(consistent::check::<V>);
    app.persist_with::<Population, SavedPopulation>(
        |world, numbers| encode(&world.resource::<Population>().to_saved(numbers)).map(Some),
        |world, saved, entities| {
            world.resource_mut::<Population>().restore(saved, entities);
            Ok(())
        },
    );
}

impl<V: Space> ParticleStore<V> {
    fn to_saved(&self, numbers: &EntityNumbers) -> SavedStore<V> {
        let body = |body: &Body<V>| {
            let Body { position, velocity, radius, inverse_mass, middle: _ } = *body;
            SavedBody { position, velocity, radius, inverse_mass }
        };
        let prediction = &self.prediction;
        SavedStore {
            id: self.id.clone(),
            entity: self.entity.iter().map(|&entity| numbers.get(entity)).collect(),
            vacated: self.vacated.clone(),
            body: self.body.iter().map(body).collect(),
            mass: self.mass.clone(),
            species: self.species.clone(),
            loads: self.loads.clone(),
            rotation: self.rotation.clone(),
            prediction: SavedPrediction {
                velocities_ahead: prediction.velocities_ahead,
                share: prediction.share,
                spin_share: prediction.spin_share,
                margin: prediction.margin,
                lone: prediction.lone.clone(),
            },
            half_step: self.half_step,
            added: self.added.clone(),
            added_power: self.added_power,
            lifted: self.lifted,
            is_suspect: self.is_suspect,
            free_end: self.free_end,
            bodies: self.saved_bodies(),
            generation: self.generation,
            travel: self.travel,
            kick_sum: self.kick_sum,
            spin_kick_sum: self.spin_kick_sum,
            order: self.order,
        }
    }

    fn restore(&mut self, saved: SavedStore<V>, entities: &SavedEntities) -> Result<(), Problem> {
        let rows = saved.id.len();
        let spins = if self.inertia.is_some() { rows } else { 0 };
        let has_all = [saved.entity.len(), saved.body.len(), saved.mass.len(), saved.species.len()] == [rows; 4]
            && saved.rotation.len() == spins
            && saved.free_end <= rows;
        let loads = &saved.loads;
        // The other lists get their lengths with the next force pass.
        let has_loads = loads.force.fits(rows) && (loads.torque.fits(spins) || loads.torque.is_empty());
        let has_lone = saved.prediction.lone.is_empty() || saved.prediction.lone.len() == rows;
        if !has_all || !has_loads || !has_lone {
            return Err("its columns differ in length".to_owned());
        }
        saved.order.check()?;
        let entity = |number: Option<u32>| match number {
            Some(number) => entities.get(number).ok_or("an entity does not exist"),
            None => Ok(Entity::PLACEHOLDER),
        };
        self.entity = saved.entity.into_iter().map(entity).collect::<Result<_, _>>()?;
        let body = |SavedBody { position, velocity, radius, inverse_mass }| Body {
            position,
            velocity,
            radius,
            inverse_mass,
            middle: V::MiddleInBody::default(),
        };
        self.body = saved.body.into_iter().map(body).collect();
        self.id = saved.id;
        // No cache holds slots from before the restore.
        self.former = vec![Slot::default(); rows];
        self.altered = Vec::new();
        self.vacated = saved.vacated;
        self.mass = saved.mass;
        self.species = saved.species;
        self.tracks_energy = saved.loads.force.tracks_energy();
        self.loads = saved.loads;
        self.rotation = saved.rotation;
        let prediction = &mut self.prediction;
        prediction.velocities_ahead = saved.prediction.velocities_ahead;
        prediction.share = saved.prediction.share;
        prediction.spin_share = saved.prediction.spin_share;
        prediction.margin = saved.prediction.margin;
        prediction.lone = saved.prediction.lone;
        if prediction.velocities_ahead > 0.0 {
            prediction.middle = vec![V::MiddleBesideBody::default(); rows];
            prediction.middle_spin = vec![V::Spin::default(); spins];
        }
        self.half_step = saved.half_step;
        self.lifted = saved.lifted;
        self.is_suspect = saved.is_suspect;
        self.added = saved.added;
        self.added_power = saved.added_power;
        self.free_end = saved.free_end;
        self.restore_bodies(saved.bodies)?;
        self.smallest_share = smallest_share(&self.body[self.contact_rows()]);
        self.generation = saved.generation;
        self.travel = saved.travel;
        self.order = saved.order;
        self.kick_sum = saved.kick_sum;
        self.spin_kick_sum = saved.spin_kick_sum;
        self.stale = MirrorSet::ALL;
        Ok(())
    }
}

impl<V: Space> ParticleStore<V> {
    fn saved_bodies(&self) -> Option<SavedBodies<V>> {
        if self.bodies.is_empty() {
            return None;
        }
        let rows = self.bodies.first_sphere..self.bodies.contact_end;
        let sphere = |row: usize| match self.bodies.sphere(row) {
            Some(sphere) => (self.id[row], sphere.number),
            None => (self.id[row], NO_SPHERE),
        };
        Some(SavedBodies {
            layout: self.layout(),
            shape: self.bodies.shape.clone(),
            rotor: self.bodies.rotor.clone(),
            momentum: self.bodies.momentum.clone(),
            spheres: rows.map(sphere).collect(),
        })
    }

    /// Restores the bodies, after all rows. Spheres follow from their bodies, except for their places and velocities, which have rows.
    fn restore_bodies(&mut self, saved: Option<SavedBodies<V>>) -> Result<(), Problem> {
        self.bodies = BodyColumns::with_shapes(self.bodies.shapes.clone());
        let Some(SavedBodies { layout, shape, rotor, momentum, spheres }) = saved else { return Ok(()) };
        let ends = [0, layout.bodies, layout.grains, layout.free, layout.contacts, layout.all];
        let count = layout.bodies().count();
        let are_known = shape.iter().all(|shape| shape.index() < self.bodies.shapes.len());
        let are_rotors = rotor.iter().all(|rotor| rotor.normalised().is_some());
        let fits = ends.is_sorted()
            && [layout.all, layout.free] == [self.id.len(), self.free_end]
            && [shape.len(), rotor.len(), momentum.len()] == [count; 3]
            && spheres.len() == layout.contacts - layout.grains
            && self.rotation.len() == self.id.len();
        let ids: Vec<_> = layout.bodies().map(|row| self.id[row]).collect();
        if !fits
            || !are_known
            || !are_rotors
            || !spheres.iter().zip(layout.grains..).all(|(one, i)| one.0 == self.id[i])
        {
            return Err("its bodies do not fit its rows".to_owned());
        }
        self.bodies.take_layout(&layout);
        self.bodies.scale = vec![1.0; count];
        self.bodies.inverse_inertia = vec![V::Principal::default(); count];
        self.bodies.shape = shape;
        self.bodies.rotor = rotor;
        self.bodies.momentum = momentum;
        if !self.bodies.has_all_spheres(&spheres, &ids) {
            return Err("the spheres of a body differ from its shape".to_owned());
        }
        self.bodies.set_spheres(&spheres, &ids);
        for row in layout.bodies() {
            self.set_size(row, self.mass[row], self.body[row].radius);
        }
        self.renew_arms();
        Ok(())
    }
}

impl Population {
    fn to_saved(&self, numbers: &EntityNumbers) -> SavedPopulation {
        let touched = self.touched.iter().filter_map(|&entity| numbers.get(entity)).collect();
        SavedPopulation { touched, is_out_of_date: self.is_out_of_date }
    }

    fn restore(&mut self, saved: SavedPopulation, entities: &SavedEntities) {
        self.touched = saved.touched.into_iter().filter_map(|number| entities.get(number)).collect();
        self.is_out_of_date = saved.is_out_of_date;
    }
}
