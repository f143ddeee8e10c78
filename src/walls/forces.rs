//! The force pass over flat walls: for each grain the walls in the scene's order, after all particles.
//!
//! What the grains do to a wall is summed too ([`WallLoad`]): the force *on the wall*, so a floor under gravity has
//! one that points down.

use std::sync::Arc;

use bevy_app::{App, Plugin};
use bevy_ecs::prelude::*;

use crate::columns::Columns;
use crate::contact::history::{History, Recall};
use crate::contact::sums::{self, Ended};
use crate::contact::{Demands, LargestOverlap, Law, Memory, Pair, PairForce, PairLaw, memory_step};
use crate::messages::DoorOpened;
use crate::space::Space;
use crate::step::{Clock, ForceStage, Phase, Step};
use crate::walls::surfaces::{Surfaces, WallLoad, pair, touching};

fn wall_forces<V: Space, L: PairLaw<V> + Demands>(
    law: Res<Law<L>>,
    clock: Res<Clock>,
    mut walls: ResMut<Surfaces<V>>,
    mut columns: ResMut<Columns<V>>,
    mut history: ResMut<History<V>>,
    mut largest: ResMut<LargestOverlap>,
) {
    let dt = memory_step(&clock);
    let (before, pages) = history.walls.turn();
    walls.0.iter_mut().for_each(|wall| wall.load = WallLoad::default());
    for i in 0..columns.movable_end {
        let mut recall = L::MEMORY.then(|| Recall::new(before, i));
        let mut ended = Ended::default();
        for index in 0..if columns.is_fixed(i) { 0 } else { walls.0.len() } {
            let pair = if L::AHEAD {
                touching::<true, V>(&columns, i, &walls.0[index], dt)
            } else {
                touching::<false, V>(&columns, i, &walls.0[index], dt)
            };
            let Some(pair) = pair else { continue };
            let number = u32::try_from(index).expect("fewer than 2^32 walls");
            let mut memory = recall.as_mut().map_or_else(Memory::default, |recall| {
                recall
                    .of::<L>(number, |wall, memory| forget(&mut ended, &*law.0, &columns, i, &walls, wall, memory, dt))
            });
            let on_i = law.0.force(&pair, &mut memory);
            if L::AHEAD {
                columns.contacts[i] += 1;
            }
            add_load::<V, L>(&mut columns, i, &mut walls.0[index].load, &pair, &on_i);
            if L::MEMORY {
                pages.push::<L>(number, &memory);
            }
            largest.0.raise(pair.overlap, pair.radii[0]);
        }
        if let Some(recall) = &mut recall {
            recall.finish::<L>(|wall, memory| forget(&mut ended, &*law.0, &columns, i, &walls, wall, memory, dt));
            pages.end_row();
        }
        // Most grains are far from every wall: their entries are left alone.
        if L::SPIN && ended.is_any() {
            ended.book(&mut columns.turn[i]);
        }
    }
}

/// Books the contact of entry `i` with a wall that it has just left; not of a door that has gone, which took all its
/// contacts' energy with it.
#[cold]
#[expect(clippy::too_many_arguments, reason = "one contact, and where to book it")]
fn forget<V: Space, L: PairLaw<V>>(
    ended: &mut Ended,
    law: &L,
    columns: &Columns<V>,
    i: usize,
    walls: &Surfaces<V>,
    wall: u32,
    memory: &Memory<V>,
    dt: f64,
) {
    let wall = &walls.0[wall as usize];
    if wall.is_present {
        let (distance, normal) = wall.surface.distance(columns.body[i].position);
        ended.add_pair(law, &pair(columns, i, wall, distance, normal, dt), memory);
    }
}

/// Adds what a contact does to grain and wall.
#[inline]
fn add_load<V: Space, L: Demands>(
    columns: &mut Columns<V>,
    i: usize,
    on_wall: &mut WallLoad<V>,
    pair: &Pair<V>,
    on_i: &PairForce<V>,
) {
    let sum = sums::total::<L, V>(on_i);
    columns.load[i].force += sum;
    columns.load[i].drag += on_i.drag;
    on_wall.force -= sum;
    on_wall.drag -= on_i.drag;
    if L::SPIN {
        sums::turn::<L, V>(&mut columns.turn[i], pair, on_i, 0);
        sums::book_losses::<L, V>(&mut columns.turn[i], on_i);
        on_wall.friction_drag -= on_i.turning.friction_drag;
    }
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
            app.add_systems(Step, open_door::<V>.in_set(Phase::Drift));
        }
    }
}
