//! The force pass over flat walls: for each grain the walls in the scene's order, after all particles.
//!
//! What the grains do to a wall is summed too ([`WallLoad`]): the force *on the wall*, so a floor under gravity has
//! one that points down.
//!
//! Threads sum a range of rows each, in whole blocks with about as many grains near walls. What a wall gets is summed block by block,
//! so that no bit depends on their number.

use std::ops::Range;
use std::sync::Arc;

use bevy_app::{App, Plugin};
use bevy_ecs::prelude::*;

use crate::columns::{BOOKED, Columns, Late, WHOLE};
use crate::contact::batch::Batch;
use crate::contact::history::{History, Lost, Pages, Walk};
use crate::contact::kernel::{Desk, Desks};
use crate::contact::lanes::LANES;
use crate::contact::sums::{Share, Sums};
use crate::contact::{Demands, LargestOverlap, Law, Memory, PairLaw, memory_step};
use crate::instructions::Instructions;
use crate::neighbours::list::BLOCK;
use crate::neighbours::list::Candidate;
use crate::space::Space;
use crate::step::{Clock, ForceStage, Part, Phase, Step};
use crate::threads::Threads;
use crate::walls::ahead::{AT_ONCE, fetch};
use crate::walls::near::NearWalls;
use crate::walls::surfaces::{FlatWall, LeavingWalls, Surfaces, WallLoad, pair, touching, walls_leave};

/// From how many grains near walls on threads share them.
const WORTHWHILE: usize = 500;

fn wall_forces<V: Space, L: PairLaw<V> + Demands>(
    (law, clock): (Res<Law<L>>, Res<Clock>),
    (threads, instructions): (Res<Threads>, Res<Instructions>),
    mut walls: ResMut<Surfaces<V>>,
    mut columns: ResMut<Columns<V>>,
    mut history: ResMut<History<V>>,
    mut largest: ResMut<LargestOverlap>,
    (mut near, mut desks): (Local<NearWalls>, ResMut<Desks<V>>),
) {
    // This system's own writes do not count as changes.
    let have_changed = walls.is_changed();
    let near = near.of(&columns, &walls.0, have_changed);
    let mut loads = std::mem::take(&mut columns.loads);
    let pass =
        Pass { law: &*law.0, dt: memory_step(&clock), instructions: *instructions, view: &*columns, walls: &walls.0 };
    let shares = share_out(near, columns.len(), threads.count());
    let desks = desks.at_least(shares.len());
    let mut rest = (Share::all(&mut loads), history.bypass_change_detection().wall_pages(&columns), near);
    let mut workers = Vec::with_capacity(shares.len());
    for (rows, Desk { batch, spare, .. }) in shares.into_iter().zip(desks) {
        let pages = rest.1.split_off_mut(..rows.len().div_ceil(BLOCK)).unwrap_or_default();
        let near = rest.2.split_off(..rest.2.partition_point(|contact| contact.first() < rows.end)).unwrap_or_default();
        let sums = Sums::new(rows.clone(), rest.0.cut_off(rows.len()));
        let worker = Worker { pass: &pass, sums, batch, largest: largest.0, on_walls: Vec::new() };
        workers.push(move || worker.sum(rows, near, pages, spare));
    }
    let done = threads.share(workers);
    columns.loads = loads;
    walls.0.iter_mut().for_each(|wall| wall.load = WallLoad::default());
    for (deepest, on_walls) in done {
        largest.0 = largest.0.max(deepest);
        for of_block in on_walls.chunks(walls.0.len().max(1)) {
            walls.0.iter_mut().zip(of_block).for_each(|(wall, load)| wall.load += *load);
        }
    }
}

/// The rows of each share, in whole blocks.
fn share_out(near: &[Candidate], rows: usize, threads: usize) -> Vec<Range<usize>> {
    let shares = if near.len() < WORTHWHILE { 1 } else { threads.min(rows.div_ceil(BLOCK)) };
    let border = |number: usize| match number {
        0 => 0,
        _ if number == shares => rows,
        _ => rows.min((near[number * near.len() / shares].first() + BLOCK / 2) / BLOCK * BLOCK),
    };
    (0..shares).map(|number| border(number)..border(number + 1)).collect()
}

/// What all read.
struct Pass<'a, V: Space, L> {
    law: &'a L,
    /// By how much memories advance, s.
    dt: f64,
    instructions: Instructions,
    view: &'a Columns<V>,
    walls: &'a [FlatWall<V>],
}

/// What one thread writes.
struct Worker<'a, V: Space, L> {
    pass: &'a Pass<'a, V, L>,
    sums: Sums<'a, V>,
    /// The contacts at hand, the partner being the wall's index.
    batch: &'a mut Batch<V>,
    largest: f64,
    /// What each wall gets of each block that has grains near any.
    on_walls: Vec<WallLoad<V>>,
}

impl<V: Space, L: PairLaw<V> + Demands> Worker<'_, V, L> {
    /// Sums what happens between grains of these rows and walls that are near each other, in ascending order. Gives the largest
    /// overlap, and what walls get.
    fn sum(
        mut self,
        rows: Range<usize>,
        mut near: &[Candidate],
        pages: &mut [Pages<V>],
        spare: &mut Pages<V>,
    ) -> (f64, Vec<WallLoad<V>>) {
        for (page, first) in pages.iter_mut().zip(rows.step_by(BLOCK)) {
            let (mut walk, mut lost) = (Walk::new(page, spare), Lost::default());
            let of_block = near.partition_point(|contact| contact.first() < first + BLOCK);
            self.block(near.split_off(..of_block).unwrap_or_default(), &mut walk, &mut lost);
            walk.end::<L>(lost, |contact, memory| self.pass.forget(contact, memory));
        }
        (self.largest, self.on_walls)
    }

    /// Those of a block.
    fn block(&mut self, near: &[Candidate], walk: &mut Walk<'_, V>, lost: &mut Lost) {
        if !near.is_empty() {
            self.on_walls.resize(self.on_walls.len() + self.pass.walls.len(), WallLoad::default());
        }
        for (number, &contact) in near.iter().enumerate() {
            if number % AT_ONCE == 0 {
                let next = near[number..].iter().take(AT_ONCE);
                fetch(self.pass.view, &self.sums, next.map(|contact| contact.first()));
            }
            let ([i, touched], &Pass { view, walls, dt, .. }) = (contact.both(), self.pass);
            let pair = if L::AHEAD {
                touching::<true, V>(view, i, &walls[touched], dt)
            } else {
                touching::<false, V>(view, i, &walls[touched], dt)
            };
            if let Some(pair) = pair {
                self.batch.push::<L>(contact, &pair);
                if self.batch.len == LANES {
                    self.flush(walk, lost);
                }
            }
        }
        self.flush(walk, lost);
    }

    /// Sums what the batch does to grains and walls, and keeps the books.
    fn flush(&mut self, walk: &mut Walk<'_, V>, lost: &mut Lost) {
        let Self { pass, batch, .. } = self;
        if batch.len == 0 {
            return;
        }
        if L::MEMORY {
            batch.recall::<L>(walk, |contact, memory| lost.add(pass.forget(contact, memory)));
        }
        let has_books = pass.view.has_books;
        if has_books {
            self.answer::<BOOKED>();
        } else {
            self.answer::<WHOLE>();
        }
        if L::SPIN && has_books {
            *lost += self.batch.lost::<L>();
        }
        if L::MEMORY {
            walk.remember_all::<L>(&self.batch.pairs[..self.batch.len], &self.batch.memory);
        }
        self.batch.len = 0;
    }

    /// Asks the law, takes records of overlap into account, and adds, so many numbers to an entry.
    fn answer<const EACH: usize>(&mut self) {
        let Self { pass, batch, largest, on_walls, .. } = self;
        let deepest = *largest * (1.0 - 8.0 * f64::EPSILON);
        if batch.ask::<L, EACH>(pass.law, pass.dt, pass.instructions, deepest) {
            for lane in 0..batch.len {
                *largest = largest.max(batch.bodies.overlap[lane] / batch.bodies.reach[lane]);
            }
        }
        self.sums.add_to_one::<L, EACH, 0>(batch);
        let of_block = on_walls.len() - pass.walls.len();
        for lane in (0..batch.len).filter(|&lane| batch.answer.counts::<L>(lane)) {
            let (load, force) =
                (&mut on_walls[of_block + batch.pairs[lane].second()], batch.answer.force::<EACH>(lane));
            load.force -= force[0];
            if let Some(&drag) = force.get(1) {
                load.drag -= drag;
            }
        }
    }
}

impl<V: Space, L: PairLaw<V>> Pass<'_, V, L> {
    /// What goes with a contact of an entry with a wall that it has just left, J; nothing if it is a door that has gone,
    /// which took all its contacts' energy with it.
    #[cold]
    fn forget(&self, contact: Candidate, memory: &Memory<V>) -> [f64; 2] {
        let [i, wall] = contact.both();
        let (view, wall) = (self.view, &self.walls[wall]);
        if !(wall.is_present && view.has_books) {
            return [0.0; 2];
        }
        let (distance, normal) = wall.surface.distance(view.body[i].position);
        self.law.forget(&pair(view, i, wall, distance, normal, self.dt), memory)
    }
}

/// Walls whose entities have gone are no more there. In the step after that, so that what their contacts held is booked first.
fn remove_walls<V: Space>(mut leaving: ResMut<LeavingWalls>, mut walls: ResMut<Surfaces<V>>) {
    for wall in leaving.0.drain(..) {
        walls.0[wall].is_present = false;
    }
}

/// Flat walls under the law `law`.
pub struct SurfacesPlugin<V: Space, L>(std::marker::PhantomData<(V, L)>);

impl<V: Space, L: PairLaw<V> + Demands> SurfacesPlugin<V, L> {
    /// Under the law that [`ContactPlugin`](crate::contact::ContactPlugin) has brought.
    #[must_use]
    pub fn new(_: &Arc<L>) -> Self {
        Self(std::marker::PhantomData)
    }
}

impl<V: Space, L: PairLaw<V> + Demands> Plugin for SurfacesPlugin<V, L> {
    fn build(&self, app: &mut App) {
        app.add_systems(Step, wall_forces::<V, L>.in_set(ForceStage::Walls));
        let remove = remove_walls::<V>.in_set(Part::Engine(Phase::Drift)).after(Late).run_if(walls_leave);
        app.add_systems(Step, remove);
    }
}
