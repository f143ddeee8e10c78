//! Survey of all contacts at the present moment: for measurements, energy balance and pictures, not for the force pass.
//!
//! It uses the positions of the store, the neighbour list of the last force pass, and the contact history after it. It
//! is therefore valid from that pass until the next renumbering.

pub mod contact_state;
mod elastic_energy;
pub mod pair_forces;
pub mod pair_map;
pub mod touching;
pub mod view;

use bevy_ecs::prelude::*;
use bevy_ecs::system::SystemParam;

use crate::contact::batch_law::{AnyLaw, BatchLaw};
use crate::contact::geometry;
use crate::contact::history::History;
use crate::contact::memory::{Memory, MemoryLayout};
use crate::contact::pair::Pair;
use crate::neighbours::Search;
use crate::neighbours::list::Candidate;
use crate::particles::Motion;
use crate::space::{Plane, Space};
use crate::store::ParticleStore;
use crate::walls::near::NearWalls;
use crate::walls::surfaces::Surfaces;

/// Partner of a particle in a contact.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Partner {
    /// The particle in this slot.
    Particle(usize),
    /// The wall surface with this index.
    Wall(usize),
}

/// System parameters of a survey.
#[derive(SystemParam)]
pub struct SurveyParam<'w, V: Space = Plane> {
    motion: Motion<'w, V>,
    search: Res<'w, Search<V>>,
    walls: Res<'w, Surfaces<V>>,
    law: Res<'w, AnyLaw<V>>,
    history: Res<'w, History>,
    near: Res<'w, NearWalls>,
}

impl<V: Space> SurveyParam<'_, V> {
    /// Returns the survey.
    #[must_use]
    pub fn survey(&self) -> Survey<'_, V> {
        let store = self.motion.store();
        let walls = &self.walls;
        let near = self.near.present(store, walls, walls.last_changed());
        Survey { store, search: &self.search, walls, law: &*self.law.0, history: &self.history, near }
    }
}

/// Everything that determines the contacts.
#[derive(Clone, Copy)]
pub struct Survey<'a, V: Space = Plane> {
    /// Particles.
    pub store: &'a ParticleStore<V>,
    /// Candidate pairs.
    pub search: &'a Search<V>,
    /// Wall surfaces.
    pub walls: &'a Surfaces<V>,
    /// Contact law.
    pub law: &'a dyn BatchLaw<V>,
    /// Contact history.
    pub history: &'a History,
    /// Pairs of a particle and a wall that are near each other; `None` if they have to be searched.
    near: Option<&'a [Candidate]>,
}

impl<'a, V: Space> Survey<'a, V> {
    /// Returns the survey of a world.
    #[must_use]
    pub fn of_world(world: &'a World) -> Self {
        let (store, walls): (&ParticleStore<V>, _) = (world.resource(), world.resource_ref::<Surfaces<V>>());
        let near = world.resource::<NearWalls>().present(store, &walls, walls.last_changed());
        Self {
            store,
            search: world.resource(),
            walls: walls.into_inner(),
            law: &*world.resource::<AnyLaw<V>>().0,
            history: world.resource(),
            near,
        }
    }

    /// Calls `visit` once for each contact, with the slot of one particle, its partner, the pair and its memory. Pair
    /// and memory are seen from that particle. In a contact of two particles it is the particle in the lower slot.
    pub fn contacts(&self, visit: impl FnMut(usize, Partner, &Pair<V>, &Memory)) {
        self.contacts_among(|_, _| true, visit);
    }

    /// Like [`Self::contacts`], for contacts that `accepts` returns true for. The geometry of other contacts between
    /// particles is not computed. At seams, a contact with a wall depends on the other walls.
    pub fn contacts_among(
        &self,
        accepts: impl Fn(usize, Partner) -> bool,
        mut visit: impl FnMut(usize, Partner, &Pair<V>, &Memory),
    ) {
        self.visit_pairs(self.search.list.pairs(), &accepts, &mut visit);
        self.visit_walls(&accepts, &mut visit);
    }

    /// Visits the accepted contacts with walls.
    fn visit_walls(
        &self,
        accepts: &impl Fn(usize, Partner) -> bool,
        visit: &mut impl FnMut(usize, Partner, &Pair<V>, &Memory),
    ) {
        let store = self.store;
        let mut memories = self.history.read_walls();
        let mut visit_contacts = |i: usize, contacts: Vec<(usize, Pair<V>)>| {
            for (index, pair) in contacts.into_iter().filter(|(index, _)| accepts(i, Partner::Wall(*index))) {
                let memory = memories.look_up(i, index).unwrap_or_default();
                if self.exists(&pair, || memory) {
                    visit(i, Partner::Wall(index), &pair, &memory);
                }
            }
        };
        if let Some(near) = self.near {
            for row in near.chunk_by(|a, b| a.row() == b.row()).filter(|row| !store.is_fixed(row[0].row())) {
                let i = row[0].row();
                visit_contacts(i, self.contacts_with(i, row.iter().map(|pair| pair.partner())));
            }
        } else {
            for i in store.free_rows() {
                visit_contacts(i, self.contacts_with_walls(i));
            }
        }
    }

    /// Returns the contacts of the free particle in slot `i` with walls, ascending.
    fn contacts_with_walls(&self, i: usize) -> Vec<(usize, Pair<V>)> {
        let body = &self.store.body[i];
        self.contacts_with(i, self.walls.near(body.position, body.radius + self.store.prediction.range).iter())
    }

    /// Returns the contacts of the free particle in slot `i` with these walls, ascending.
    fn contacts_with(&self, i: usize, walls: impl Iterator<Item = usize>) -> Vec<(usize, Pair<V>)> {
        let mut contacts = geometry::WallContacts::default();
        contacts.find(self.store, i, (&self.walls.all, walls), 0.0, |_, _| {});
        contacts.pairs(self.store, i, &self.walls.all, self.law.needs_mass_root()).collect()
    }

    /// Returns the layout of the memories of contacts.
    #[must_use]
    pub fn layout(&self) -> MemoryLayout {
        self.law.needs().memory.unwrap_or_default()
    }

    /// Returns whether two bodies are in contact: they overlap, or their contact exists beyond touch. `memory` returns the memory of the contact.
    fn exists(&self, pair: &Pair<V>, memory: impl FnOnce() -> Memory) -> bool {
        pair.overlap > 0.0 || pair.overlap + self.law.range_of(pair, &memory()) > 0.0
    }

    /// Visits the accepted contacts between particles among these candidates, which are in ascending order.
    fn visit_pairs(
        &self,
        candidates: &[Candidate],
        accepts: &impl Fn(usize, Partner) -> bool,
        visit: &mut impl FnMut(usize, Partner, &Pair<V>, &Memory),
    ) {
        let root = self.law.needs_mass_root();
        let mut memories = self.history.read_pairs();
        let candidates = candidates.iter().map(|candidate| candidate.slots());
        for [i, j] in candidates.filter(|&[i, j]| accepts(i, Partner::Particle(j))) {
            if let Some(pair) = geometry::touching(self.store, i, j, root) {
                let memory = memories.look_up(j, i).unwrap_or_default();
                if self.exists(&pair, || memory) {
                    visit(i, Partner::Particle(j), &pair, &memory);
                }
            }
        }
    }
}
