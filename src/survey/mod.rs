//! A survey of the contacts as they stand: for measurements, books and pictures, not for the hot loop.
//!
//! It looks at the positions of the columns with the neighbour search of the last force pass, and at what contacts
//! remembered after it, so it is right at any time between that pass and the next renumbering.

pub mod pair_forces;
pub mod pair_map;
pub mod touching;
pub mod view;

use bevy_ecs::prelude::*;
use bevy_ecs::system::SystemParam;

use crate::contact::history::History;
use crate::contact::{AnyLaw, Memory, Pair, PairLaw, geometry};
use crate::neighbours::Search;
use crate::particles::Motion;
use crate::space::{Plane, Space};
use crate::store::ParticleStore;
use crate::walls::surfaces::{FlatWall, Surfaces};

/// Who is touched.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Partner {
    /// The particle at this index of the columns.
    Particle(usize),
    /// The flat wall of this index.
    Wall(usize),
}

/// What a system needs for a survey.
#[derive(SystemParam)]
pub struct SurveyParam<'w, V: Space = Plane> {
    motion: Motion<'w, V>,
    search: Res<'w, Search<V>>,
    walls: Res<'w, Surfaces<V>>,
    law: Res<'w, AnyLaw<V>>,
    history: Res<'w, History<V>>,
}

impl<V: Space> SurveyParam<'_, V> {
    /// The survey.
    #[must_use]
    pub fn survey(&self) -> Survey<'_, V> {
        Survey {
            store: self.motion.store(),
            search: &self.search,
            walls: &self.walls.0,
            law: &*self.law.0,
            history: &self.history,
        }
    }
}

/// Everything that contacts depend on.
#[derive(Clone, Copy)]
pub struct Survey<'a, V: Space = Plane> {
    /// Particles.
    pub store: &'a ParticleStore<V>,
    /// Candidates.
    pub search: &'a Search<V>,
    /// Flat walls.
    pub walls: &'a [FlatWall<V>],
    /// The law.
    pub law: &'a dyn PairLaw<V>,
    /// What contacts remember.
    pub history: &'a History<V>,
}

impl<'a, V: Space> Survey<'a, V> {
    /// The survey of a world.
    #[must_use]
    pub fn of_world(world: &'a World) -> Self {
        Self {
            store: world.resource(),
            search: world.resource(),
            walls: &world.resource::<Surfaces<V>>().0,
            law: &*world.resource::<AnyLaw<V>>().0,
            history: world.resource(),
        }
    }

    /// Calls `visit` once for each contact: with the index of one particle, its partner, and the pair and its memory as
    /// seen from that particle. Between particles the first is the one with the lower slot.
    pub fn contacts(&self, visit: impl FnMut(usize, Partner, &Pair<V>, &Memory<V>)) {
        self.contacts_among(|_, _| true, visit);
    }

    /// The same for those contacts alone that `counts` accepts; of others not even the geometry is found.
    fn contacts_among(
        &self,
        counts: impl Fn(usize, Partner) -> bool,
        mut visit: impl FnMut(usize, Partner, &Pair<V>, &Memory<V>),
    ) {
        self.pairs(&counts, &mut visit);
        let (store, root, mut memories) = (self.store, self.law.needs_mass_root(), self.history.read_walls());
        for i in (0..store.movable_end).filter(|&i| !store.is_fixed(i)) {
            for (index, wall) in self.walls.iter().enumerate().filter(|&(index, _)| counts(i, Partner::Wall(index))) {
                if let Some(pair) = geometry::touching_wall::<false, V>(store, i, wall, root, 0.0) {
                    let memory = memories.look_up(i, index).unwrap_or_default();
                    visit(i, Partner::Wall(index), &pair, &memory);
                }
            }
        }
    }

    fn pairs(
        &self,
        counts: &impl Fn(usize, Partner) -> bool,
        visit: &mut impl FnMut(usize, Partner, &Pair<V>, &Memory<V>),
    ) {
        let (root, mut memories) = (self.law.needs_mass_root(), self.history.read_pairs());
        let candidates = self.search.list.pairs().iter().map(|candidate| candidate.both());
        for [i, j] in candidates.filter(|&[i, j]| counts(i, Partner::Particle(j))) {
            if let Some(pair) = geometry::touching(self.store, i, j, root) {
                let memory = memories.look_up(i, j).unwrap_or_default();
                visit(i, Partner::Particle(j), &pair, &memory);
            }
        }
    }

    /// Elastic energy of all contacts that `counts` accepts, J.
    pub fn elastic_energy(&self, counts: impl Fn(usize, Partner) -> bool) -> f64 {
        let mut energy = 0.0;
        self.contacts_among(counts, |_, _, pair, memory| energy += self.law.elastic_energy(pair, memory));
        energy
    }
}
