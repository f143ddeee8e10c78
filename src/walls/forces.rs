//! The force pass over flat walls: for each grain the walls in the scene's order, after all particles.
//!
//! What the grains do to a wall is summed too ([`WallLoad`]): the force *on the wall*, so a floor under gravity has
//! one that points down.

use std::sync::Arc;

use bevy_app::{App, Plugin};
use bevy_ecs::prelude::*;

use crate::columns::{AT_ONCE, Columns, Late, Loads};
use crate::contact::history::{History, Lost};
use crate::contact::sums;
use crate::contact::{Demands, LargestOverlap, Law, Memory, Pair, PairForce, PairLaw, memory_step};
use crate::messages::DoorOpened;
use crate::neighbours::list::Candidate;
use crate::space::{Linear, Space};
use crate::step::{Clock, ForceStage, Phase, Step};
use crate::walls::near::NearWalls;
use crate::walls::surfaces::{Surfaces, WallLoad, pair, touching};

fn wall_forces<V: Space, L: PairLaw<V> + Demands>(
    law: Res<Law<L>>,
    clock: Res<Clock>,
    mut walls: ResMut<Surfaces<V>>,
    mut columns: ResMut<Columns<V>>,
    mut history: ResMut<History<V>>,
    mut largest: ResMut<LargestOverlap>,
    mut near: Local<NearWalls>,
) {
    let dt = memory_step(&clock);
    let (mut walk, mut lost) = (history.walk_on_walls(), Lost::default());
    // This system's own writes do not count as changes.
    let have_changed = walls.is_changed();
    walls.0.iter_mut().for_each(|wall| wall.load = WallLoad::default());
    let near = near.of(&columns, &walls.0, have_changed);
    for (number, &contact) in near.iter().enumerate() {
        if number % AT_ONCE == 0 {
            columns.fetch(near[number..].iter().take(AT_ONCE).map(|contact| contact.first()));
        }
        let [i, index] = contact.both();
        let pair = if L::AHEAD {
            touching::<true, V>(&columns, i, &walls.0[index], dt)
        } else {
            touching::<false, V>(&columns, i, &walls.0[index], dt)
        };
        let Some(pair) = pair else { continue };
        let mut memory = Memory::default();
        if L::MEMORY {
            let forgotten = |contact, memory: &Memory<V>| {
                lost.add(forget(&*law.0, &columns, contact, &walls, memory, dt));
            };
            memory = walk.recall::<L>(contact, forgotten).unwrap_or_default();
        }
        let on_i = law.0.force(&pair, &mut memory);
        if L::AHEAD {
            columns.loads.contacts[i] += 1;
        }
        add_load::<V, L>(&mut columns.loads, i, &mut walls.0[index].load, &pair, &on_i);
        if L::SPIN && columns.has_books {
            let rolling = if L::ROLLING { on_i.turning.lost_by_rolling } else { 0.0 };
            let dashpots = pair.taken_by_dashpot::<L>(&on_i.turning);
            lost += Lost { sliding: on_i.turning.lost_by_sliding, rolling, dashpots };
        }
        if L::MEMORY {
            walk.remember::<L>(contact, &memory);
        }
        largest.0 = largest.0.max(pair.overlap / pair.radii[0]);
    }
    walk.end::<L>(lost, |contact, memory| forget(&*law.0, &columns, contact, &walls, memory, dt));
}

/// What goes with a contact of an entry with a wall that it has just left, J; nothing if it is a door that has gone,
/// which took all its contacts' energy with it.
#[cold]
fn forget<V: Space, L: PairLaw<V>>(
    law: &L,
    columns: &Columns<V>,
    contact: Candidate,
    walls: &Surfaces<V>,
    memory: &Memory<V>,
    dt: f64,
) -> [f64; 2] {
    let [i, wall] = contact.both();
    let wall = &walls.0[wall];
    if !(wall.is_present && columns.has_books) {
        return [0.0; 2];
    }
    let (distance, normal) = wall.surface.distance(columns.body[i].position);
    law.forget(&pair(columns, i, wall, distance, normal, dt), memory)
}

/// Adds what a contact does to grain and wall.
#[inline]
fn add_load<V: Space, L: Demands>(
    loads: &mut Loads<V>,
    i: usize,
    on_wall: &mut WallLoad<V>,
    pair: &Pair<V>,
    on_i: &PairForce<V>,
) {
    let (force, drag) = (sums::total::<L, V>(on_i), sums::drag::<L, V>(on_i));
    loads.force.add(i, force, drag);
    on_wall.force -= force;
    on_wall.drag -= drag;
    if L::SPIN {
        let turning = &on_i.turning;
        let arm = pair.normal * -turning.arms[0];
        loads.torque.add(i, arm.cross(turning.friction), arm.cross(turning.friction_drag));
        if L::ROLLING {
            loads.torque.add(i, turning.rolling, V::Spin::ZERO);
            if let Some(drag) = loads.rolling_drag.get_mut(i) {
                *drag += turning.rolling_drag;
            }
        }
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
            app.add_systems(Step, open_door::<V>.in_set(Phase::Drift).after(Late));
        }
    }
}
