//! The ledger: every grain released is inside, out or lost; and the culler, which removes what has fallen far enough.
//!
//! * *Out*: its path crossed the orifice, the line between the two wall grains that flank the door, while the door
//!   was open.
//! * *Lost*: its path crossed the line of neighbouring wall grains anywhere else, or the closed door, or a flat
//!   wall, or it left the walls' bounding box over the top; or it fell below `cull.below` by any way but the
//!   orifice. Named by id, step, place and nearest wall grain.
//!
//! Paths are straight between two looks. A grain is looked at again at the latest when it has moved by a quarter of the
//! smallest radius since the last look (or in one step, if it is faster), so that a bed at rest costs next to nothing. So a
//! grain that is on the other side of a wall after one step, without having touched it, is seen in that step, and the
//! loss tells how far it moved.
//! In solid space the walls are flat ones, the orifice is where a door panel was, and there is no top to leave by. Wall
//! grains that move ([`crate::walls::conveyor`]) have no line.
//! Who releases a grain writes `GrainReleased`, or the ledger does not know of it.
//! Limit: what happens to a door grain's line while the door slides is not followed; from the first step of opening
//! the orifice is open.

mod cull;
mod grain_accounting;

use std::sync::Arc;

use bevy_app::{App, Plugin};
use bevy_ecs::prelude::*;

use self::cull::CullLine;
pub use self::cull::{Cull, CullPlugin};
pub use self::grain_accounting::{GrainsAccounted, Ledger, LedgerPlugin, LossRecord, OnLoss};
use crate::displacement_trigger::DisplacementTrigger;
use crate::door::DoorState;
use crate::messages::{GrainLost, GrainOut};
use crate::particle::{Grain, GrainId};
use crate::particles::Particles;
use crate::periodic::Periodic;
use crate::space::{Plane, Space};
use crate::step::{Phase, Step};
use crate::store::{ParticleStore, Renumber, Renumbering, renumber};
use crate::walls::paths::{Crossing, Paths};

/// Where the ledger holds grains to be, in the order of slots.
#[derive(Resource)]
struct Whereabouts<V: Space>(Vec<Place<V>>);

#[derive(Clone, Copy, Debug, PartialEq)]
enum Place<V> {
    /// It is no grain.
    Nowhere,
    /// It has just entered.
    New,
    /// It was there when it was looked at, m.
    Inside(V),
    Out,
    Lost,
}

/// The lines that paths must not cross, and the scale of a look.
#[derive(Resource)]
pub struct Enclosure<V: Space = Plane> {
    /// The lines.
    pub paths: Arc<dyn Paths<V>>,
    /// Radius of the smallest grain, m.
    pub smallest_radius: f64,
}

/// Places go along with their grains when slots are dealt out anew.
fn move_places<V: Space>(
    store: Res<ParticleStore<V>>,
    mut whereabouts: ResMut<Whereabouts<V>>,
    grains: Query<(), With<Grain>>,
) {
    let place = |i: usize| match whereabouts.0.get(store.former[i].index()) {
        Some(&place) if place != Place::Nowhere => place,
        _ if grains.contains(store.entity[i]) => Place::New,
        _ => Place::Nowhere,
    };
    whereabouts.0 = (0..store.len()).map(place).collect();
}

fn watch_paths<V: Space>(
    (enclosure, particles): (Res<Enclosure<V>>, Particles<V>),
    (door, cull): (Option<Res<DoorState>>, Option<Res<CullLine>>),
    mut out: MessageWriter<GrainOut<V>>,
    mut lost: MessageWriter<GrainLost<V>>,
    mut whereabouts: ResMut<Whereabouts<V>>,
    mut trigger: Local<DisplacementTrigger>,
) {
    if !trigger.has_fired(particles.travel_meter(), 0.0) {
        return;
    }
    let (mut longest, mut lowest) = (0.0f64, f64::INFINITY);
    let patience = (0.25 * enclosure.smallest_radius).powi(2);
    let door_is_closed = door.is_none_or(|door| !door.is_open());
    let last_chance = cull.map_or(f64::NEG_INFINITY, |line| line.0);
    for (row, place) in whereabouts.0.iter_mut().enumerate() {
        let here = particles.position(row);
        let looked_at = match *place {
            Place::New => {
                *place = Place::Inside(here);
                here
            }
            Place::Inside(looked_at) => looked_at,
            Place::Out | Place::Lost | Place::Nowhere => continue,
        };
        let way = particles.separation(here, looked_at);
        lowest = lowest.min(here.height());
        let squared = way.length_squared();
        // Whoever will soon have moved so far is looked at now, so that there is time until the next pass.
        if squared < 0.25 * patience && here.height() >= last_chance {
            longest = longest.max(squared);
            continue;
        }
        *place = Place::Inside(here);
        let distance = way.length();
        // In a periodic scene, of where it was the image that is nearest to here.
        let before = here - way;
        let fate = fate(&*enclosure.paths, particles.periodic(), door_is_closed, before, here);
        let Some(fate) = fate else { continue };
        // The ledger misses a grain that has left the world by itself.
        if !particles.is_present(row) {
            *place = Place::Nowhere;
            continue;
        }
        let id = particles.id(row);
        match fate {
            Fate::Out => {
                *place = Place::Out;
                out.write(GrainOut { id, position: here });
            }
            Fate::Lost(way) => {
                *place = Place::Lost;
                let way = swept(way, distance, enclosure.smallest_radius);
                lost.write(GrainLost { id, position: here, way, nearest: nearest(here, &particles) });
            }
        }
    }
    // Nobody's next look is due before somebody has gone this far.
    let way_left = patience.sqrt() - longest.sqrt();
    *trigger = DisplacementTrigger::for_distance(particles.travel_meter(), way_left.min(lowest - last_chance));
}

/// How a grain was lost, and whether it was because it moves so far (m) in a step that no force can stop it.
fn swept(way: String, distance: f64, radius: f64) -> String {
    // Of a way that was looked at so late, at most a quarter of the smallest radius is of earlier steps.
    if distance > radius { format!("{way}, moving {distance:.4} m in one step: lower `step`") } else { way }
}

/// How a grain left.
enum Fate {
    Out,
    Lost(String),
}

/// The fate of a grain that went from `before` to `here`; `None` if it is still inside.
fn fate<V: Space>(
    paths: &dyn Paths<V>,
    periodic: Option<&Periodic<V>>,
    door_is_closed: bool,
    before: V,
    here: V,
) -> Option<Fate> {
    let way = match crossing(paths, periodic, before, here) {
        Some(Crossing::Orifice) if !door_is_closed => return Some(Fate::Out),
        Some(Crossing::Orifice) => "through the closed door".to_owned(),
        Some(Crossing::Wall { from, to }) => format!("through the wall between {} and {} m", shown(from), shown(to)),
        Some(Crossing::FlatWall) => "through a flat wall".to_owned(),
        None => paths.beyond(before, here)?.to_owned(),
    };
    Some(Fate::Lost(way))
}

/// The line or face that a path crosses, in any of its periodic images.
fn crossing<V: Space>(paths: &dyn Paths<V>, periodic: Option<&Periodic<V>>, before: V, here: V) -> Option<Crossing<V>> {
    match periodic {
        None => paths.crossing(before, here),
        Some(periodic) => {
            periodic.shifts_of_path(before).find_map(|shift| paths.crossing(before + shift, here + shift))
        }
    }
}

/// A place as messages show it, in m.
fn shown<V: Space>(x: V) -> String {
    let numbers: Vec<_> = x.components().iter().map(|x| format!("{x:.4}")).collect();
    format!("({})", numbers.join(", "))
}

fn nearest<V: Space>(x: V, particles: &Particles<V>) -> Option<GrainId> {
    let walls = particles.all().filter(|&row| particles.is_fixed(row));
    let distances = walls.map(|row| (particles.position(row).distance_squared(x), particles.id(row)));
    distances.min_by(|a, b| a.partial_cmp(b).unwrap_or(std::cmp::Ordering::Equal)).map(|(_, id)| id)
}

/// Watches the paths of grains, where there are walls to cross.
pub struct PathsPlugin<V: Space> {
    /// The walls.
    pub paths: Arc<dyn Paths<V>>,
    /// Radius of the smallest grain, m.
    pub smallest_radius: f64,
}

impl<V: Space> Plugin for PathsPlugin<V> {
    fn build(&self, app: &mut App) {
        app.insert_resource(Whereabouts::<V>(Vec::new()))
            .insert_resource(Enclosure { paths: self.paths.clone(), smallest_radius: self.smallest_radius })
            .add_systems(Renumber, move_places::<V>.in_set(Renumbering).after(renumber::<V>))
            .add_systems(Step, watch_paths::<V>.in_set(Phase::Cull).before(grain_accounting::account_for_grains::<V>));
    }
}
