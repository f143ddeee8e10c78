//! Iterates over contacts in the order of the store. This is the cheap way to visit all of them.
//!
//! The iterator computes the geometry of each contact. Its memory and its force are computed only on request.

use bevy_ecs::entity::Entity;

use crate::contact::geometry;
use crate::contact::memory::Memory;
use crate::contact::pair::Pair;
use crate::contact::pair_force::PairForce;
use crate::particle::GrainId;
use crate::space::{Plane, Space};
use crate::survey::contact_state::{ContactState, Touched};
use crate::survey::{Partner, Survey};

/// One contact, seen from the particle in the lower slot, which is free. SI.
#[derive(Clone, Copy)]
pub struct Touching<'a, V: Space = Plane> {
    survey: Survey<'a, V>,
    row: usize,
    partner: Partner,
    pair: Pair<V>,
}

impl<'a, V: Space> Survey<'a, V> {
    /// Iterates over all contacts of particles that are present: first between particles, in ascending order of the
    /// higher slot, then of the lower one; then with wall surfaces.
    pub fn touching(self) -> impl Iterator<Item = Touching<'a, V>> {
        let store = self.store;
        let between = self.search.list.pairs().iter().filter_map(move |candidate| {
            let [i, j] = candidate.slots();
            let pair = geometry::touching(store, i, j, self.law.needs_mass_root());
            let are_present = store.is_present(i) && store.is_present(j);
            let touching = Touching { survey: self, row: i, partner: Partner::Particle(j), pair: pair? };
            Some(touching).filter(|touching| are_present && touching.exists())
        });
        between.chain(self.touching_walls())
    }

    /// Iterates over all contacts with wall surfaces of particles that are present, in ascending order of slots.
    pub fn touching_walls(self) -> impl Iterator<Item = Touching<'a, V>> {
        let rows = self.store.free_rows().filter(move |&i| self.store.is_present(i));
        rows.flat_map(move |i| {
            let of_row = self.contacts_with_walls(i).into_iter();
            let of_row =
                of_row.map(move |(index, pair)| Touching { survey: self, row: i, partner: Partner::Wall(index), pair });
            of_row.filter(Touching::exists)
        })
    }
}

impl<V: Space> Touching<'_, V> {
    /// Returns whether the two are in contact: see [`Survey`].
    fn exists(&self) -> bool {
        self.survey.exists(&self.pair, || self.memory())
    }

    /// Returns the slot of the first particle.
    #[must_use]
    pub fn row(&self) -> usize {
        self.row
    }

    /// Returns the partner.
    #[must_use]
    pub fn partner(&self) -> Partner {
        self.partner
    }

    /// Returns the slot of the partner, if it is a particle.
    #[must_use]
    pub fn partner_row(&self) -> Option<usize> {
        match self.partner {
            Partner::Particle(row) => Some(row),
            Partner::Wall(_) => None,
        }
    }

    /// Returns the entity of the first particle.
    #[must_use]
    pub fn entity(&self) -> Entity {
        self.survey.store.entity[self.row]
    }

    /// Returns the entity of the partner, if it is a particle.
    #[must_use]
    pub fn partner_entity(&self) -> Option<Entity> {
        self.partner_row().map(|row| self.survey.store.entity[row])
    }

    /// Returns the id of the first particle.
    #[must_use]
    pub fn grain(&self) -> GrainId {
        self.survey.store.id[self.row]
    }

    /// Returns the id of the partner.
    #[must_use]
    pub fn with(&self) -> Touched {
        match self.partner {
            Partner::Particle(row) => Touched::Particle(self.survey.store.id[row]),
            Partner::Wall(wall) => Touched::Wall(self.survey.walls.all[wall].number + 1),
        }
    }

    /// Returns the input of a contact law: overlap, normal, relative velocity, radii, reduced mass, spins, materials.
    #[must_use]
    pub fn pair(&self) -> &Pair<V> {
        &self.pair
    }

    /// Returns the overlap, m.
    #[must_use]
    pub fn overlap(&self) -> f64 {
        self.pair.overlap
    }

    /// Returns the unit vector from the partner to the first particle.
    #[must_use]
    pub fn normal(&self) -> V {
        self.pair.normal
    }

    /// Returns the centre of the first particle, m.
    #[must_use]
    pub fn from(&self) -> V {
        self.survey.store.body[self.row].position
    }

    /// Returns the vector from the centre of the first particle to the centre of the partner, or to the nearest point
    /// of the wall, m.
    #[must_use]
    pub fn to_partner(&self) -> V {
        let distance = match self.partner {
            Partner::Particle(_) => self.pair.radii[0] + self.pair.radii[1] - self.pair.overlap,
            Partner::Wall(_) => self.pair.radii[0] - self.pair.overlap,
        };
        self.pair.normal * -distance
    }

    /// Searches for the memory of the contact and returns it as seen from the first particle.
    #[must_use]
    pub fn memory(&self) -> Memory {
        let history = self.survey.history;
        let memory = match self.partner {
            Partner::Particle(row) => history.of_pair(self.row, row),
            Partner::Wall(wall) => history.of_wall(self.row, wall),
        };
        memory.unwrap_or_default()
    }

    /// Evaluates the contact law and returns its force on the first particle.
    #[must_use]
    pub fn force(&self) -> PairForce<V> {
        self.survey.law.force(&self.pair, &mut self.memory())
    }

    /// Returns the contact as seen from the particle with the lower id, as
    /// [`ContactView::all`](crate::survey::view::ContactView::all) lists it. `memory` is the memory of this contact,
    /// `dt` the time step, s.
    pub(super) fn state_with(&self, memory: &Memory, dt: f64) -> ContactState<V> {
        match self.partner {
            Partner::Particle(row) if self.survey.store.id[row] < self.grain() => {
                let partner = Partner::Particle(self.row);
                Self { row, partner, pair: self.pair.seen_from_partner(), ..*self }
                    .state_from_first(&self.survey.layout().seen_from_partner(memory), dt)
            }
            _ => self.state_from_first(memory, dt),
        }
    }

    fn state_from_first(&self, memory: &Memory, dt: f64) -> ContactState<V> {
        let law = self.survey.law;
        let pair = &self.pair;
        let force = law.force(pair, &mut { *memory });
        let normal_force = force.normal.dot(pair.normal);
        let friction = force.resistance.friction;
        // A contact law without friction sets no lever arms.
        let has_friction = force.resistance.arms.iter().any(|&arm| arm > 0.0);
        let is_sliding = has_friction && law.force(&Pair { dt, ..*pair }, &mut { *memory }).resistance.is_sliding;
        let cap = law.friction(pair) * (normal_force + law.pull(pair)).abs();
        let sphere = |row: usize| self.survey.store.bodies.sphere(row).map_or(0, |sphere| sphere.number);
        let partner_sphere = match self.partner {
            Partner::Particle(row) => sphere(row),
            Partner::Wall(_) => 0,
        };
        ContactState {
            grain: self.grain(),
            sphere: sphere(self.row),
            with: self.with(),
            partner_sphere,
            from: self.from(),
            to_partner: self.to_partner(),
            overlap: pair.overlap,
            normal: pair.normal,
            normal_force,
            friction,
            mobilised: if cap > 0.0 { (friction.length() / cap).min(1.0) } else { 0.0 },
            is_sliding,
            memory: *memory,
        }
    }
}
