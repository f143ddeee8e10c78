//! The force pass over flat walls: for each grain the walls in the scene's order, after all particles.
//!
//! What the grains do to a wall is summed too ([`WallLoad`]): the force *on the wall*, so a floor under gravity has
//! one that points down.

use std::sync::Arc;

use bevy_app::{App, Plugin};
use bevy_ecs::prelude::*;

use crate::columns::{AT_ONCE, BOOKED, Columns, Late, WHOLE};
use crate::contact::batch::Batch;
use crate::contact::history::{History, Lost, Walk};
use crate::contact::kernel::Desks;
use crate::contact::lanes::LANES;
use crate::contact::sums::{Share, Sums};
use crate::contact::{Demands, LargestOverlap, Law, Memory, PairLaw, memory_step};
use crate::instructions::Instructions;
use crate::messages::DoorOpened;
use crate::neighbours::list::Candidate;
use crate::space::Space;
use crate::step::{Clock, ForceStage, Phase, Step};
use crate::walls::near::NearWalls;
use crate::walls::surfaces::{FlatWall, Surfaces, WallLoad, pair, touching};

fn wall_forces<V: Space, L: PairLaw<V> + Demands>(
    (law, clock, instructions): (Res<Law<L>>, Res<Clock>, Res<Instructions>),
    mut walls: ResMut<Surfaces<V>>,
    mut columns: ResMut<Columns<V>>,
    mut history: ResMut<History<V>>,
    mut largest: ResMut<LargestOverlap>,
    (mut near, mut desks): (Local<NearWalls>, ResMut<Desks<V>>),
) {
    // This system's own writes do not count as changes.
    let have_changed = walls.is_changed();
    walls.0.iter_mut().for_each(|wall| wall.load = WallLoad::default());
    let near = near.of(&columns, &walls.0, have_changed);
    let pass = Pass {
        law: &*law.0,
        dt: memory_step(&clock),
        instructions: *instructions,
        columns: &mut columns,
        walls: &mut walls.0,
        walk: history.bypass_change_detection().walk_on_walls(),
        batch: &mut desks.first().batch,
        lost: Lost::default(),
        largest: &mut largest.0,
    };
    pass.sum(near);
}

/// What the pass reads and writes.
struct Pass<'a, V: Space, L> {
    law: &'a L,
    /// By how much memories advance, s.
    dt: f64,
    instructions: Instructions,
    columns: &'a mut Columns<V>,
    walls: &'a mut [FlatWall<V>],
    walk: Walk<'a, V>,
    /// The contacts at hand, the partner being the wall's index.
    batch: &'a mut Batch<V>,
    lost: Lost,
    largest: &'a mut f64,
}

impl<V: Space, L: PairLaw<V> + Demands> Pass<'_, V, L> {
    /// Sums what happens between grains and walls that are near each other, in ascending order.
    fn sum(mut self, near: &[Candidate]) {
        for (number, &contact) in near.iter().enumerate() {
            if number % AT_ONCE == 0 {
                self.columns.fetch(near[number..].iter().take(AT_ONCE).map(|contact| contact.first()));
            }
            let ([i, wall], dt) = (contact.both(), self.dt);
            let pair = if L::AHEAD {
                touching::<true, V>(self.columns, i, &self.walls[wall], dt)
            } else {
                touching::<false, V>(self.columns, i, &self.walls[wall], dt)
            };
            if let Some(pair) = pair {
                self.batch.push::<L>(contact, &pair);
                if self.batch.len == LANES {
                    self.flush();
                }
            }
        }
        self.flush();
        let Self { law, columns, walls, dt, .. } = self;
        self.walk.end::<L>(self.lost, |contact, memory| forget(law, columns, walls, contact, memory, dt));
    }

    /// Sums what the batch does to grains and walls, and keeps the books.
    fn flush(&mut self) {
        let Self { law, columns, walls, walk, batch, lost, dt, .. } = self;
        if batch.len == 0 {
            return;
        }
        if L::MEMORY {
            let forgotten = |contact, memory: &Memory<V>| lost.add(forget(*law, columns, walls, contact, memory, *dt));
            batch.recall::<L>(walk, forgotten);
        }
        if columns.has_books {
            self.answer::<BOOKED>();
        } else {
            self.answer::<WHOLE>();
        }
        if L::SPIN && self.columns.has_books {
            self.lost += self.batch.lost::<L>();
        }
        if L::MEMORY {
            self.walk.remember_all::<L>(&self.batch.pairs[..self.batch.len], &self.batch.memory);
        }
        self.batch.len = 0;
    }

    /// Asks the law, takes records of overlap into account, and adds, so many numbers to an entry.
    fn answer<const EACH: usize>(&mut self) {
        let Self { law, columns, walls, batch, largest, .. } = self;
        let deepest = **largest * (1.0 - 8.0 * f64::EPSILON);
        if batch.ask::<L, EACH>(*law, self.dt, self.instructions, deepest) {
            for lane in 0..batch.len {
                **largest = largest.max(batch.bodies.overlap[lane] / batch.bodies.reach[lane]);
            }
        }
        let everybody = 0..columns.len();
        Sums::new(everybody, Share::all(&mut columns.loads)).add_to_one::<L, EACH, 0>(batch);
        for lane in (0..batch.len).filter(|&lane| batch.answer.counts::<L>(lane)) {
            let (on_wall, force) = (&mut walls[batch.pairs[lane].second()].load, batch.answer.force::<EACH>(lane));
            on_wall.force -= force[0];
            if let Some(&drag) = force.get(1) {
                on_wall.drag -= drag;
            }
        }
    }
}

/// What goes with a contact of an entry with a wall that it has just left, J; nothing if it is a door that has gone,
/// which took all its contacts' energy with it.
#[cold]
fn forget<V: Space, L: PairLaw<V>>(
    law: &L,
    columns: &Columns<V>,
    walls: &[FlatWall<V>],
    contact: Candidate,
    memory: &Memory<V>,
    dt: f64,
) -> [f64; 2] {
    let [i, wall] = contact.both();
    let wall = &walls[wall];
    if !(wall.is_present && columns.has_books) {
        return [0.0; 2];
    }
    let (distance, normal) = wall.surface.distance(columns.body[i].position);
    law.forget(&pair(columns, i, wall, distance, normal, dt), memory)
}

/// A door made of panels goes when it opens.
fn open_door<V: Space>(mut opened: MessageReader<DoorOpened>, mut walls: ResMut<Surfaces<V>>) {
    if opened.read().next().is_some() {
        walls.0.iter_mut().filter(|wall| wall.is_door).for_each(|wall| wall.is_present = false);
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
        if app.world().resource::<Surfaces<V>>().0.iter().any(|wall| wall.is_door) {
            // In the step after the one that opens the door, so that what it held is booked first.
            app.add_systems(Step, open_door::<V>.in_set(Phase::Drift).after(Late));
        }
    }
}
