//! The wall surfaces of a run, under the same contact law as contacts between grains.
//!
//! Walls may turn about their axis, and half-planes may move along themselves like a belt. Both keep the shape in its
//! place. Other motions of walls are in [`moving`](crate::walls::moving). The force pass sums contacts with walls ([`crate::contact`]). Where walls meet, a grain touches each of them
//! only at a point that is nearest on both ([`seams`](crate::walls::seams)).

use bevy_ecs::prelude::*;
use serde::{Deserialize, Serialize};

use crate::space::{Plane, Space};
use crate::walls::free::FreeState;
use crate::walls::mover::{LeafState, Mover};
use crate::walls::shapes::box_around;
use crate::walls::surface_index::{Candidates, SurfaceIndex};
use crate::walls::surface_wall::{SurfaceWall, WallLoad};
use crate::walls::twins::Twins;

/// Wall surfaces, in the order of the scene.
#[derive(Resource, Clone, Debug)]
pub struct Surfaces<V: Space = Plane> {
    /// The surfaces.
    pub all: Vec<SurfaceWall<V>>,
    /// Moving walls, each group with its motion.
    pub(super) movers: Vec<Mover<V>>,
    /// Radius of the largest grain, m.
    pub(super) largest: f64,
    /// The end of the last step for which the walls were placed, s.
    pub(super) placed_at: f64,
    /// Sum over the steps of the longest way of any point of a wall in a step, m.
    pub(super) travel: f64,
    /// The part of `travel` since the index was made, m.
    pub(super) drift: f64,
    pub(super) index: SurfaceIndex,
    /// The images of each surface that has some.
    twins: Twins,
    /// For each wall of the scene, its first surface.
    first: Vec<usize>,
    /// For each wall of the scene, the load of the grains on it in the last step.
    pub loads: Vec<WallLoad<V>>,
}

/// Returns the box around `x` with this half-width, m.
fn around<V: Space>(x: V, reach: f64) -> [V; 2] {
    let reach = V::from_components(|_| reach);
    [x - reach, x + reach]
}

/// The part of the walls that changes in a run.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[serde(bound = "")]
pub struct SavedWalls<V: Space> {
    are_present: Vec<bool>,
    loads: Vec<WallLoad<V>>,
    leaves: Vec<Option<LeafState>>,
    free: Vec<Option<FreeState>>,
    placed_at: f64,
    travel: f64,
}

impl<V: Space> Surfaces<V> {
    /// Takes the surfaces of a scene whose largest grain has the radius `largest`, m.
    #[must_use]
    pub fn new(all: Vec<SurfaceWall<V>>, largest: f64) -> Self {
        let first: Vec<_> = (0..all.len()).filter(|&at| at == 0 || all[at].number != all[at - 1].number).collect();
        let loads = vec![WallLoad::default(); first.len()];
        Self {
            index: SurfaceIndex::new(&all, largest),
            twins: Twins::of(&all),
            movers: Vec::new(),
            largest,
            placed_at: 0.0,
            travel: 0.0,
            drift: 0.0,
            all,
            first,
            loads,
        }
    }

    /// The images of surfaces beyond periodic sides.
    #[must_use]
    pub fn twins(&self) -> &Twins {
        &self.twins
    }

    /// Whether a wall has ends.
    pub(crate) fn have_ends(&self) -> bool {
        self.all.iter().any(|wall| wall.surface.bounds().is_some())
    }

    /// Returns the first surface of the wall of the scene with this number, from 0.
    #[must_use]
    pub fn first_surface(&self, number: usize) -> &SurfaceWall<V> {
        &self.all[self.first[number]]
    }

    /// Returns each wall of the scene, by its first surface, with its load.
    pub fn with_loads(&self) -> impl Iterator<Item = (&SurfaceWall<V>, &WallLoad<V>)> {
        self.first.iter().map(|&at| &self.all[at]).zip(&self.loads)
    }

    /// Sets the loads to the sums of these loads of surfaces, given by their indices.
    pub(crate) fn set_loads<'a>(&mut self, of_contacts: impl Iterator<Item = &'a (usize, WallLoad<V>)>) {
        self.loads.fill(WallLoad::default());
        for (surface, load) in of_contacts {
            self.loads[self.all[*surface].number] += *load;
        }
    }

    /// Whether there are so many surfaces that they are searched by place.
    pub(crate) fn are_many(&self) -> bool {
        self.index.has_grid()
    }

    /// Returns the surfaces that may be near any place, ascending: all if they are few.
    pub(crate) fn everywhere(&self) -> Vec<u32> {
        self.index.everywhere().to_vec()
    }

    /// Sets `found` to the surfaces that may be nearer to `x` than `reach` (m), ascending.
    pub(crate) fn find_near(&self, x: V, reach: f64, found: &mut Vec<u32>) {
        self.index.find(around(x, reach + self.drift), found);
    }

    /// Returns the surfaces that may be nearer to `x` than `reach` (m), ascending.
    pub fn near(&self, x: V, reach: f64) -> Candidates {
        self.index.candidates(around(x, reach + self.drift), self.all.len())
    }

    /// Returns the surfaces that a straight path may cross, ascending.
    pub(crate) fn on_path(&self, from: V, to: V) -> Candidates {
        if !self.are_many() {
            return Candidates::all(self.all.len());
        }
        let bounds = box_around(&[from, to]).unwrap_or([from, to]);
        self.index.candidates(bounds, self.all.len())
    }

    /// Returns the part that changes in a run.
    pub fn saved(&self) -> SavedWalls<V> {
        SavedWalls {
            are_present: self.all.iter().map(|wall| wall.is_present).collect(),
            loads: self.loads.clone(),
            leaves: self.movers.iter().map(Mover::leaf).collect(),
            free: self.movers.iter().map(|mover| mover.free().map(|(_, state)| *state)).collect(),
            placed_at: self.placed_at,
            travel: self.travel,
        }
    }

    /// Takes over what [`Self::saved`] returned.
    ///
    /// # Errors
    /// If it has another number of surfaces.
    pub fn restore(&mut self, saved: SavedWalls<V>) -> Result<(), &'static str> {
        let sizes = (saved.are_present.len(), saved.loads.len(), saved.leaves.len());
        let have_leaves =
            saved.leaves.iter().zip(&self.movers).all(|(leaf, mover)| leaf.is_some() == mover.leaf().is_some());
        let have_free = saved.free.len() == self.movers.len()
            && saved.free.iter().zip(&self.movers).all(|(free, mover)| free.is_some() == mover.free().is_some());
        if sizes != (self.all.len(), self.loads.len(), self.movers.len()) || !have_leaves || !have_free {
            return Err("the checkpoint has another number of walls");
        }
        self.all.iter_mut().zip(saved.are_present).for_each(|(wall, is_present)| wall.is_present = is_present);
        self.loads = saved.loads;
        self.movers.iter_mut().zip(saved.leaves).for_each(|(mover, leaf)| mover.set_leaf(leaf));
        self.movers.iter_mut().zip(saved.free).for_each(|(mover, free)| mover.set_free(free));
        self.place(saved.placed_at, None);
        self.list_anew();
        self.travel = saved.travel;
        Ok(())
    }
}
