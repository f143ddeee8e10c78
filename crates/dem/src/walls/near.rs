//! Near walls: lists which grains are near which walls, so that all others need no wall test in most steps.
//!
//! A grain is near a wall if the gap between their surfaces is less than a slack: the largest grain radius, and for meshes
//! a part of it, because a grain is near many triangles. The list is valid until a grain and a wall may have come nearer by the
//! slack, or a wall has changed. All grains are near a half-plane that turns. A grain that may pass through a periodic side before the list
//! expires is also near the walls that it meets beyond.

use std::ops::Range;

use bevy_ecs::change_detection::Tick;
use bevy_ecs::prelude::*;

use crate::displacement_trigger::DisplacementTrigger;
use crate::neighbours::ROWS_PER_THREAD;
use crate::neighbours::list::Candidate;
use crate::space::Space;
use crate::store::ParticleStore;
use crate::threads::Threads;
use crate::walls::mover::Mover;
use crate::walls::surfaces::Surfaces;

/// Slack beside meshes, in radii of the largest grain.
const MESH_SLACK: f64 = 0.2;

/// Pairs of a slot and a wall index, ascending.
#[derive(Resource, Debug, Default)]
pub struct NearWalls {
    pairs: Vec<Candidate>,
    trigger: DisplacementTrigger,
    /// The travel of the walls when the pairs were listed, m.
    wall_travel: f64,
    /// When the walls had changed last, at the end of the last force pass.
    walls_changed: Tick,
}

/// The grains and walls that are listed, and which of them are near.
#[derive(Clone, Copy)]
struct Nearness<'a, V: Space> {
    store: &'a ParticleStore<V>,
    walls: &'a Surfaces<V>,
    /// Walls that all grains are near.
    always: &'a [usize],
    /// Gap below which a grain is near a wall, m.
    slack: f64,
}

impl<V: Space> Nearness<'_, V> {
    /// Returns the pairs of these rows, ascending.
    fn pairs_of(self, rows: Range<usize>) -> Vec<Candidate> {
        let Self { store, walls, always, slack } = self;
        let mut pairs = Vec::new();
        let mut candidates = walls.everywhere();
        let sides = store.periodic.filter(|_| walls.have_ends());
        for (i, body) in (0u32..).skip(rows.start).zip(&store.body[rows]) {
            let distance = body.radius + slack;
            let beyond = sides.map(|sides| sides.images_beyond(body.position, slack));
            if let Some(beyond) = beyond.filter(|images| !images.is_empty()) {
                pairs.append(&mut self.pairs_at(i, &[&[body.position], &beyond[..]].concat(), distance));
                continue;
            }
            if walls.are_many() {
                walls.find_near(body.position, distance, &mut candidates);
            }
            for &number in &candidates {
                // A distance that is not a number counts as not near.
                let wall = number as usize;
                if walls.all[wall].surface.distance(body.position) < distance || always.contains(&wall) {
                    pairs.push(Candidate::new(i, number));
                }
            }
        }
        pairs
    }

    /// Returns the pairs of a grain that may come to any of these places, with the walls whose distance from its centre is below `distance`, m.
    #[cold]
    fn pairs_at(self, i: u32, places: &[V], distance: f64) -> Vec<Candidate> {
        let Self { walls, always, .. } = self;
        let mut own = Vec::new();
        for &x in places {
            let near = walls.near(x, distance);
            let near =
                near.iter().filter(|wall| walls.all[*wall].surface.distance(x) < distance || always.contains(wall));
            own.extend(near.filter_map(|wall| Some(Candidate::new(i, u32::try_from(wall).ok()?))));
        }
        own.sort_unstable();
        own.dedup();
        own
    }
}

impl NearWalls {
    /// Returns the present pairs; updates them if needed.
    pub fn of<V: Space>(
        &mut self,
        store: &ParticleStore<V>,
        walls: &Surfaces<V>,
        threads: &Threads,
        has_changed: bool,
    ) -> &[Candidate] {
        if walls.all.is_empty() {
            return &[];
        }
        if has_changed || self.has_expired(store, walls) {
            let rows = store.free_rows();
            let largest = store.body[rows.clone()].iter().map(|body| body.radius).fold(0.0, f64::max);
            let slack = if walls.are_many() { MESH_SLACK * largest } else { largest };
            let always: Vec<_> = walls.movers.iter().flat_map(Mover::endless_that_turn).collect();
            let nearness = Nearness { store, walls, always: &always, slack };
            let parts = threads.share_rows(rows, ROWS_PER_THREAD, |rows| nearness.pairs_of(rows));
            self.pairs.clear();
            self.pairs.extend(parts.into_iter().flatten());
            self.trigger = DisplacementTrigger::for_distance(store.travel_meter(), slack);
            self.wall_travel = walls.travel();
        }
        &self.pairs
    }

    /// Whether a particle and a wall may have come nearer by the slack, or particles have new slots.
    fn has_expired<V: Space>(&self, store: &ParticleStore<V>, walls: &Surfaces<V>) -> bool {
        let ahead = store.prediction.margin + store.prediction.range + (walls.travel() - self.wall_travel);
        self.trigger.has_fired(store.travel_meter(), ahead)
    }

    /// Notes when the walls have changed last. Called after the force pass, which sets their loads.
    pub(crate) fn note(&mut self, walls_changed: Tick) {
        self.walls_changed = walls_changed;
    }

    /// Returns the pairs of the last force pass, if they are valid for particles and walls as they are.
    pub(crate) fn present<V: Space>(
        &self,
        store: &ParticleStore<V>,
        walls: &Surfaces<V>,
        walls_changed: Tick,
    ) -> Option<&[Candidate]> {
        (self.walls_changed == walls_changed && !self.has_expired(store, walls)).then_some(&self.pairs)
    }
}
