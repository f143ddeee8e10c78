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

use std::collections::HashSet;
use std::marker::PhantomData;
use std::sync::Arc;

use bevy_app::{App, Plugin};
use bevy_ecs::entity::EntityHashSet;
use bevy_ecs::prelude::*;
use serde::{Deserialize, Serialize};

use crate::columns::{self, BeforeRenumbering, Columns, Gate, Renumbering};
use crate::door::DoorState;
use crate::messages::{GrainLost, GrainOut, GrainReleased};
use crate::outcome::{Failure, Outcome};
use crate::particle::{Fixed, Grain, GrainId, Position};
use crate::scene::values::Finite;
use crate::space::{Plane, Space};
use crate::step::{Clock, Phase, Step};
use crate::wait::Wait;
use crate::walls::paths::{Crossing, Paths};

/// The scene's `cull`.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Cull {
    /// Grains whose centre is below this height are removed, m.
    pub below: Finite,
}

/// The scene's `on_loss`: what a lost grain does to the run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
pub enum OnLoss {
    /// The run stops and has failed.
    #[default]
    Stop,
    /// The run goes on; it has failed all the same when it ends.
    Continue,
}

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

/// One lost grain.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LossRecord {
    /// Its id.
    pub grain: u32,
    /// The step in which it was noticed.
    pub step: u64,
    /// Simulated time, s.
    pub time_s: f64,
    /// Where it was, m.
    pub position_m: Vec<f64>,
    /// How it went.
    pub way: String,
    /// The nearest wall grain, by its number in the silo file.
    pub nearest_wall_grain: Option<u32>,
}

/// The books.
#[derive(Resource, Default, Debug)]
pub struct Ledger {
    /// Grains that have entered.
    pub released: u32,
    /// When each grain that is out crossed the orifice, s, in order.
    pub out_times: Vec<f64>,
    /// Who was lost, in order.
    pub lost: Vec<LossRecord>,
    /// Grains removed below the cull line, whether out or lost.
    pub culled: u32,
    /// Who is out or lost.
    gone: HashSet<GrainId>,
}

/// Entities that the culler has removed, until the ECS reports them.
#[derive(Resource, Default)]
struct Culled(EntityHashSet);

impl Ledger {
    /// Grains that are out.
    #[must_use]
    pub fn out(&self) -> u32 {
        count(self.out_times.len())
    }

    /// Grains that are lost.
    #[must_use]
    pub fn lost(&self) -> u32 {
        count(self.lost.len())
    }

    /// Whether a grain is out or lost.
    #[must_use]
    pub fn is_gone(&self, grain: GrainId) -> bool {
        self.gone.contains(&grain)
    }

    /// Grains that are inside: released, neither out nor lost.
    #[must_use]
    pub fn inside(&self) -> u32 {
        self.released.saturating_sub(self.out() + self.lost())
    }
}

fn count(n: usize) -> u32 {
    u32::try_from(n).expect("grain ids are 31 bits wide")
}

/// The lines that paths must not cross, and the scale of a look.
#[derive(Resource)]
pub struct Enclosure<V: Space = Plane> {
    /// The lines.
    pub paths: Arc<dyn Paths<V>>,
    /// Radius of the smallest grain, m.
    pub smallest_radius: f64,
}

fn count_released(mut ledger: ResMut<Ledger>, mut released: MessageReader<GrainReleased>) {
    ledger.released += count(released.read().count());
}

/// Places go along with their grains when slots are dealt out anew.
fn move_places<V: Space>(
    columns: Res<Columns<V>>,
    mut whereabouts: ResMut<Whereabouts<V>>,
    grains: Query<(), With<Grain>>,
) {
    let place = |i: usize| match whereabouts.0.get(columns.former[i].index()) {
        Some(&place) if place != Place::Nowhere => place,
        _ if columns.is_somebody(i, |entity| grains.contains(entity)) => Place::New,
        _ => Place::Nowhere,
    };
    whereabouts.0 = (0..columns.len()).map(place).collect();
}

fn watch_paths<V: Space>(
    (enclosure, columns): (Res<Enclosure<V>>, Res<Columns<V>>),
    (door, cull): (Option<Res<DoorState>>, Option<Res<CullLine>>),
    mut out: MessageWriter<GrainOut<V>>,
    mut lost: MessageWriter<GrainLost<V>>,
    mut whereabouts: ResMut<Whereabouts<V>>,
    (grains, wall_grains): (Query<(), With<Grain>>, Query<(&GrainId, &Position<V>), With<Fixed>>),
    mut wait: Local<Wait>,
) {
    if !wait.is_over(&columns, 0.0) {
        return;
    }
    let (mut longest, mut lowest) = (0.0f64, f64::INFINITY);
    let patience = (0.25 * enclosure.smallest_radius).powi(2);
    let door_is_closed = door.is_none_or(|door| !door.is_open());
    let last_chance = cull.map_or(f64::NEG_INFINITY, |line| line.0);
    for (i, (place, body)) in whereabouts.0.iter_mut().zip(&columns.body).enumerate() {
        let here = body.position;
        let looked_at = match *place {
            Place::New => {
                *place = Place::Inside(here);
                here
            }
            Place::Inside(looked_at) => looked_at,
            Place::Out | Place::Lost | Place::Nowhere => continue,
        };
        let way = columns.separation(here, looked_at);
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
        let Some(fate) = fate(&*enclosure.paths, door_is_closed, before, here) else { continue };
        // Who has vanished meanwhile is missed by others.
        if !columns.is_somebody(i, |entity| grains.contains(entity)) {
            *place = Place::Nowhere;
            continue;
        }
        let id = columns.id[i];
        match fate {
            Fate::Out => {
                *place = Place::Out;
                out.write(GrainOut { id, position: here });
            }
            Fate::Lost(way) => {
                *place = Place::Lost;
                let way = swept(way, distance, enclosure.smallest_radius);
                lost.write(GrainLost { id, position: here, way, nearest: nearest(here, &wall_grains) });
            }
        }
    }
    // Nobody's next look is due before somebody has gone this far.
    let way_left = patience.sqrt() - longest.sqrt();
    *wait = Wait::for_distance(&columns, way_left.min(lowest - last_chance));
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

/// What became of a grain that went from `before` to `here`, if it is not inside any more.
fn fate<V: Space>(paths: &dyn Paths<V>, door_is_closed: bool, before: V, here: V) -> Option<Fate> {
    let way = match paths.crossing(before, here) {
        Some(Crossing::Orifice) if !door_is_closed => return Some(Fate::Out),
        Some(Crossing::Orifice) => "through the closed door".to_owned(),
        Some(Crossing::Wall { from, to }) => format!("through the wall between {} and {} m", shown(from), shown(to)),
        Some(Crossing::FlatWall) => "through a flat wall".to_owned(),
        None => paths.beyond(before, here)?.to_owned(),
    };
    Some(Fate::Lost(way))
}

/// A place as messages show it, in m.
fn shown<V: Space>(x: V) -> String {
    let numbers: Vec<_> = x.components().iter().map(|x| format!("{x:.4}")).collect();
    format!("({})", numbers.join(", "))
}

fn nearest<V: Space>(x: V, wall_grains: &Query<(&GrainId, &Position<V>), With<Fixed>>) -> Option<GrainId> {
    let distances = wall_grains.iter().map(|(&id, wall)| (wall.0.distance_squared(x), id));
    distances.min_by(|a, b| a.partial_cmp(b).unwrap_or(std::cmp::Ordering::Equal)).map(|(_, id)| id)
}

fn cull<V: Space>(
    mut gate: Gate<V>,
    (line, whereabouts): (Res<CullLine>, Option<Res<Whereabouts<V>>>),
    mut ledger: ResMut<Ledger>,
    mut expected: ResMut<Culled>,
    mut lost: MessageWriter<GrainLost<V>>,
    mut wait: Local<Wait>,
    grains: Query<(), With<Grain>>,
) {
    if !wait.is_over(&gate.columns, 0.0) {
        return;
    }
    let mut lowest = f64::INFINITY;
    for i in 0..gate.columns.len() {
        let (id, position) = (gate.columns.id[i], gate.columns.body[i].position);
        if id.is_wall() || !gate.columns.is_somebody(i, |entity| grains.contains(entity)) {
            continue;
        }
        lowest = lowest.min(position.height());
        if position.height() < line.0 {
            expected.0.extend(gate.dismiss(i));
            ledger.culled += 1;
            let place = whereabouts.as_ref().and_then(|places| places.0.get(i));
            if place.is_none_or(|place| !matches!(place, Place::Out | Place::Lost)) {
                let way = "below the cull line, without having crossed the orifice".to_owned();
                lost.write(GrainLost { id, position, way, nearest: None });
            }
        }
    }
    // Nobody is below the line before somebody has gone this far.
    *wait = Wait::for_distance(&gate.columns, lowest - line.0);
}

/// Grains that left the world by somebody else's hand are lost too; the columns still know their names.
fn miss_vanished<V: Space>(
    mut removed: RemovedComponents<Grain>,
    mut expected: ResMut<Culled>,
    columns: Res<Columns<V>>,
    mut lost: MessageWriter<GrainLost<V>>,
    ledger: Res<Ledger>,
) {
    for entity in removed.read() {
        if expected.0.remove(&entity) {
            continue;
        }
        let Some(i) = columns.entity.iter().position(|&known| known == entity) else { continue };
        if !ledger.gone.contains(&columns.id[i]) {
            let way = "out of the world, removed by a behaviour".to_owned();
            lost.write(GrainLost { id: columns.id[i], position: columns.body[i].position, way, nearest: None });
        }
    }
}

fn keep_books<V: Space>(
    clock: Res<Clock>,
    on_loss: Res<OnLossSetting>,
    mut ledger: ResMut<Ledger>,
    mut out: MessageReader<GrainOut<V>>,
    mut lost: MessageReader<GrainLost<V>>,
    mut outcome: ResMut<Outcome>,
) {
    let (step, time_s) = (clock.steps, clock.time());
    // Whoever leaves in the same step is booked in the order of the ids, whatever tables the grains are in.
    let mut out: Vec<_> = out.read().collect();
    out.sort_unstable_by_key(|grain| grain.id);
    let mut lost: Vec<_> = lost.read().collect();
    lost.sort_unstable_by_key(|grain| grain.id);
    for grain in out {
        ledger.gone.insert(grain.id);
        ledger.out_times.push(time_s);
    }
    for grain in lost {
        tracing::debug!("t = {time_s:.3} s: {} was lost {}", grain.id, grain.way);
        ledger.gone.insert(grain.id);
        ledger.lost.push(LossRecord {
            grain: grain.id.number(),
            step,
            time_s,
            position_m: grain.position.components(),
            way: grain.way.clone(),
            nearest_wall_grain: grain.nearest.map(GrainId::number),
        });
        if on_loss.0 == OnLoss::Stop {
            let GrainLost { id, position, way, .. } = grain.clone();
            outcome.fail(Failure::GrainLost { step, grain: id, position: shown(position), way });
        }
    }
}

#[derive(Resource)]
struct CullLine(f64);

#[derive(Resource)]
struct OnLossSetting(OnLoss);

/// Systems of [`Phase::Cull`] that act on a settled ledger run after this set.
#[derive(SystemSet, Clone, Debug, PartialEq, Eq, Hash)]
pub struct BooksKept;

/// The ledger, with what a loss does.
pub struct LedgerPlugin<V: Space>(pub OnLoss, pub PhantomData<V>);

impl<V: Space> Plugin for LedgerPlugin<V> {
    fn build(&self, app: &mut App) {
        app.init_resource::<Ledger>()
            .insert_resource(OnLossSetting(self.0))
            .init_resource::<Culled>()
            .add_systems(Step, miss_vanished::<V>.in_set(BeforeRenumbering))
            .add_systems(Step, (count_released, keep_books::<V>).chain().in_set(Phase::Cull).in_set(BooksKept));
    }
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
            .add_systems(Step, move_places::<V>.in_set(Renumbering).after(columns::renumber::<V>))
            .add_systems(Step, watch_paths::<V>.in_set(Phase::Cull).before(keep_books::<V>));
    }
}

/// Removes grains below the cull line.
pub struct CullPlugin<V: Space>(pub Cull, pub PhantomData<V>);

impl<V: Space> Plugin for CullPlugin<V> {
    fn build(&self, app: &mut App) {
        app.insert_resource(CullLine(self.0.below.get())).add_systems(
            Step,
            cull::<V>.in_set(Phase::Cull).after(count_released).after(watch_paths::<V>).before(keep_books::<V>),
        );
    }
}
