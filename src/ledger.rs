//! Grain accounting: each released grain is inside, out, lost, or removed by a request of a behaviour. The culler removes grains that have fallen far enough.
//!
//! * *Out*: the path of the grain crossed the orifice while the door was open. The orifice is the line between the two
//!   wall grains that flank the door.
//! * *Lost*: its path crossed the line between neighbouring wall grains elsewhere, the closed door or a wall surface; or
//!   it left the bounding box of the walls over the top; or it fell below `cull.below` without crossing the orifice. A
//!   loss is reported with id, step, position and nearest wall grain.
//!
//! Paths are straight between two checks. A grain is checked again at the latest when it has moved by a quarter of the
//! smallest radius since its last check, or after one step if it is faster. A bed at rest therefore costs almost
//! nothing. A grain that passes through a wall within one step, without touching it, is found in that step, and the
//! report states how far it moved.
//!
//! In solid space the walls are wall surfaces, the orifice is the place of a door, and grains cannot leave over a
//! top. Moving wall grains ([`siloflow_dem::walls::conveyor`]) have no lines. A system that releases a grain must write
//! `GrainReleased`; otherwise the grain is not counted.
//!
//! Doors count at their shut places: a grain that crosses the place of a door is out if the door was not shut since the last
//! check. The orifice is open from the first step of opening. A wall with a motion is crossed if the path, as seen from the
//! wall, passes through it.

mod cull;
mod departures;
mod grain_accounting;

use std::sync::Arc;

use bevy_app::{App, Plugin};
use bevy_ecs::prelude::*;
use bevy_ecs::system::SystemParam;
use serde::{Deserialize, Serialize};

use self::cull::CullLine;
pub use self::cull::{Cull, CullPlugin};
pub use self::departures::{Departure, Departures};
pub use self::grain_accounting::{GrainsAccounted, Ledger, LedgerPlugin, LossRecord, OnLoss};
use crate::door::DoorState;
use siloflow_dem::displacement_trigger::DisplacementTrigger;
use siloflow_dem::messages::{GrainLost, GrainOut};
use siloflow_dem::particle::{Grain, GrainId};
use siloflow_dem::particles::Particles;
use siloflow_dem::periodic::Periodic;
use siloflow_dem::persist::{PersistApp as _, Problem};
use siloflow_dem::space::{Plane, Space};
use siloflow_dem::step::{Clock, Phase, Step};
use siloflow_dem::store::{AfterRenumbering, ParticleStore, Renumber};
use siloflow_dem::walls::paths::{Crossing, Paths};
use siloflow_dem::walls::surfaces::Surfaces;

/// State of each particle in the grain accounting, by slot.
#[derive(Resource, Default, Deserialize, Serialize)]
#[serde(bound = "")]
struct GrainStates<V: Space> {
    states: Vec<GrainState>,
    /// Positions of grains inside at their last check, m. A state stored beside its position would take 8 B in place of one.
    checked_positions: Vec<V>,
    /// When the last pass over all grains ran, s. If walls move, a pass checks every grain.
    checked_at: f64,
    /// The travel of the walls then, m.
    wall_travel: f64,
    /// The coordinates of free walls then, m or rad.
    coordinates: Vec<f64>,
}

/// State of one particle in the grain accounting.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
enum GrainState {
    /// The particle is not a grain.
    NotAGrain,
    /// The grain has just entered.
    New,
    /// The grain was inside at its last check.
    Inside,
    /// The grain left through the orifice.
    Out,
    /// The grain was lost.
    Lost,
}

/// Lines that paths must not cross, and the length scale of checks.
#[derive(Resource)]
pub struct Enclosure<V: Space = Plane> {
    /// The lines.
    pub paths: Arc<dyn Paths<V>>,
    /// Radius of the smallest grain, m.
    pub smallest_radius: f64,
}

/// Fires when a grain may have moved far enough for a check of its path.
#[derive(Resource, Default, Deserialize, Serialize)]
struct PathTrigger(DisplacementTrigger);

/// Reorders the states by the new slots after a renumbering.
fn reorder_states<V: Space>(
    store: Res<ParticleStore<V>>,
    mut states: ResMut<GrainStates<V>>,
    grains: Query<(), With<Grain>>,
) {
    let state = |i: usize| match states.states.get(store.former[i].index()) {
        Some(&state) if state != GrainState::NotAGrain => state,
        _ if store.is_whole(i) && grains.contains(store.entity[i]) => GrainState::New,
        _ => GrainState::NotAGrain,
    };
    states.states = (0..store.len()).map(state).collect();
    let position = |i: usize| states.checked_positions.get(store.former[i].index()).copied().unwrap_or(V::ZERO);
    states.checked_positions = (0..store.len()).map(position).collect();
}

/// Forgets the ways of all grains: their present places are inside. For a caller that has put them there.
pub(crate) fn forget_ways<V: Space>(world: &mut World) {
    let Some(mut states) = world.get_resource_mut::<GrainStates<V>>() else { return };
    for state in states.states.iter_mut().filter(|state| **state == GrainState::Inside) {
        *state = GrainState::New;
    }
}

/// Lines and faces that a grain leaves through or passes when it is lost.
#[derive(SystemParam)]
struct Boundaries<'w, V: Space> {
    enclosure: Res<'w, Enclosure<V>>,
    doors: Option<Res<'w, DoorState>>,
    walls: Res<'w, Surfaces<V>>,
    cull: Option<Res<'w, CullLine>>,
}

/// Checks the paths of all grains that have moved far enough, and reports grains that are out or lost.
fn watch_paths<V: Space>(
    clock: Res<Clock>,
    particles: Particles<V>,
    boundaries: Boundaries<V>,
    mut out: MessageWriter<GrainOut<V>>,
    mut lost: MessageWriter<GrainLost<V>>,
    mut states: ResMut<GrainStates<V>>,
    mut trigger: ResMut<PathTrigger>,
) {
    let Boundaries { enclosure, doors, walls, cull } = boundaries;
    if !trigger.0.has_fired(particles.travel_meter(), walls.travel() - states.wall_travel) {
        return;
    }
    let times = [states.checked_at, clock.time()];
    states.checked_at = clock.time();
    states.wall_travel = walls.travel();
    let coordinates = std::mem::replace(&mut states.coordinates, walls.coordinates());
    let mut longest = 0.0f64;
    let mut lowest = f64::INFINITY;
    let limit_squared = (0.25 * enclosure.smallest_radius).powi(2);
    let walls_move = walls.move_in_time();
    let is_open = |number: u16| doors.as_ref().is_some_and(|doors| doors.lets_pass(number, times[0]));
    let cull_height = cull.map_or(f64::NEG_INFINITY, |line| line.0);
    let GrainStates { states, checked_positions, .. } = &mut *states;
    for (row, (state, checked_position)) in states.iter_mut().zip(checked_positions).enumerate() {
        let here = particles.position(row);
        match *state {
            GrainState::New => (*state, *checked_position) = (GrainState::Inside, here),
            GrainState::Inside => {}
            GrainState::Out | GrainState::Lost | GrainState::NotAGrain => continue,
        }
        let way = particles.separation(here, *checked_position);
        // Comparisons, because WebAssembly calls a function for `min` and `max`.
        if here.height() < lowest {
            lowest = here.height();
        }
        let squared = way.length_squared();
        // Half of the distance limit is enough for a check now, so that the next pass is not due at once.
        if !walls_move && squared < 0.25 * limit_squared && here.height() >= cull_height {
            if squared > longest {
                longest = squared;
            }
            continue;
        }
        *checked_position = here;
        let distance = way.length();
        // In a periodic scene, the image of the last position that is nearest to the present one.
        let before = here - way;
        let fate = fate(&*enclosure.paths, particles.periodic(), is_open, before, here).or_else(|| {
            let is_crossed = walls_move && walls.is_moving_wall_crossed(before, here, times, &coordinates);
            is_crossed.then(|| Fate::Lost("through a moving wall".to_owned()))
        });
        let Some(fate) = fate else { continue };
        // Grains removed by other systems are reported in the grain accounting itself.
        if !particles.is_present(row) {
            *state = GrainState::NotAGrain;
            continue;
        }
        let id = particles.id(row);
        match fate {
            Fate::Out => {
                *state = GrainState::Out;
                out.write(GrainOut { id, position: here, mass: particles.mass(row), species: particles.species(row) });
            }
            Fate::Lost(way) => {
                *state = GrainState::Lost;
                let way = loss_text(way, distance, enclosure.smallest_radius);
                lost.write(GrainLost { id, position: here, way, nearest: nearest_fixed(here, &particles) });
            }
        }
    }
    // No grain is due for a check before some particle has moved this far.
    let distance_left = limit_squared.sqrt() - longest.sqrt();
    trigger.0 = DisplacementTrigger::for_distance(particles.travel_meter(), distance_left.min(lowest - cull_height));
}

/// Returns the description of a loss. If the grain moved too far (m) in one step for a force to stop it, the
/// description says so.
fn loss_text(way: String, distance: f64, radius: f64) -> String {
    // At most a quarter of the smallest radius of this distance belongs to earlier steps.
    if distance > radius { format!("{way}, moving {distance:.4} m in one step: lower `step`") } else { way }
}

/// How a grain left.
enum Fate {
    Out,
    Lost(String),
}

/// Returns how a grain that moved from `before` to `here` has left; `None` if it is still inside.
fn fate<V: Space>(
    paths: &dyn Paths<V>,
    periodic: Option<&Periodic<V>>,
    is_open: impl Fn(u16) -> bool,
    before: V,
    here: V,
) -> Option<Fate> {
    let way = match crossing(paths, periodic, before, here) {
        Some(Crossing::Orifice(door)) if is_open(door) => return Some(Fate::Out),
        Some(Crossing::Orifice(_)) => "through the closed door".to_owned(),
        Some(Crossing::Wall { from, to }) => {
            format!("through the wall between {} and {} m", format_position(from), format_position(to))
        }
        Some(Crossing::Surface) => "through a wall surface".to_owned(),
        None => paths.beyond(before, here)?.to_owned(),
    };
    Some(Fate::Lost(way))
}

/// Returns the line or face that a path crosses, in any periodic image.
fn crossing<V: Space>(paths: &dyn Paths<V>, periodic: Option<&Periodic<V>>, before: V, here: V) -> Option<Crossing<V>> {
    match periodic {
        None => paths.crossing(before, here),
        Some(periodic) => {
            periodic.shifts_of_path(before).find_map(|shift| paths.crossing(before + shift, here + shift))
        }
    }
}

/// Formats a position for messages, in m.
fn format_position<V: Space>(x: V) -> String {
    let numbers: Vec<_> = x.components().iter().map(|x| format!("{x:.4}")).collect();
    format!("({})", numbers.join(", "))
}

/// Returns the id of the fixed particle nearest to `x`.
fn nearest_fixed<V: Space>(x: V, particles: &Particles<V>) -> Option<GrainId> {
    let walls = particles.all().filter(|&row| particles.is_fixed(row));
    let distances = walls.map(|row| (particles.position(row).distance_squared(x), particles.id(row)));
    distances.min_by(|a, b| a.partial_cmp(b).unwrap_or(std::cmp::Ordering::Equal)).map(|(_, id)| id)
}

/// Refuses restored states that are not those of the rows of the store.
fn check_states<V: Space>(world: &mut World) -> Result<(), Problem> {
    let (Some(states), Some(store)) =
        (world.get_resource::<GrainStates<V>>(), world.get_resource::<ParticleStore<V>>())
    else {
        return Ok(());
    };
    if [states.states.len(), states.checked_positions.len()] == [store.len(); 2] {
        Ok(())
    } else {
        Err("the watched paths belong to other particles".to_owned())
    }
}

/// Checks the paths of grains in scenes with walls that they may cross.
pub struct PathsPlugin<V: Space> {
    /// The walls.
    pub paths: Arc<dyn Paths<V>>,
    /// Radius of the smallest grain, m.
    pub smallest_radius: f64,
}

impl<V: Space> Plugin for PathsPlugin<V> {
    fn build(&self, app: &mut App) {
        app.init_resource::<GrainStates<V>>()
            .init_resource::<PathTrigger>()
            .persist_sound::<GrainStates<V>>()
            .check_restored(check_states::<V>)
            .persist::<PathTrigger>()
            .insert_resource(Enclosure { paths: self.paths.clone(), smallest_radius: self.smallest_radius })
            .add_systems(Renumber, reorder_states::<V>.in_set(AfterRenumbering))
            .add_systems(Step, watch_paths::<V>.in_set(Phase::Cull).before(grain_accounting::account_for_grains::<V>));
    }
}
