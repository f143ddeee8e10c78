//! Door controllers: decide when doors open and shut, and move them.
//!
//! A door consists of the wall grains and wall surfaces ([`WallIndex`](siloflow_dem::walls::leaving::WallIndex)) marked [`Door`] with
//! its number: 0 for the key `door` (door grains of the silo file, and walls with `door: true`), then 1, 2, ... for the entries
//! of `doors`, which name their walls. A door opens when the bed has come to rest, at a given time, by a schedule, or never.
//!
//! * `Remove`: it vanishes at once.
//! * `Slide`: door grains slide along the orifice at a constant speed until the orifice is clear, and drag grains.
//! * `Move`: wall surfaces move by a vector at a constant speed ([`moving`](siloflow_dem::walls::moving)), and back when the door shuts.
//!
//! Grains that pass through the place of a shut door while it is open or moves are out ([`crate::ledger`]).

use std::marker::PhantomData;

use bevy_app::{App, Plugin};
use bevy_ecs::prelude::*;
use serde::{Deserialize, Serialize};

use crate::rest::RestDetection;
use siloflow_dem::messages::{CameToRest, DoorOpened};
use siloflow_dem::particle::{Door, Fixed, Position, Radius, Velocity};
use siloflow_dem::persist::PersistApp as _;
use siloflow_dem::space::{Space, Vector};
use siloflow_dem::step::{Clock, Phase, Step};
use siloflow_dem::store::PlainCommands;
use siloflow_dem::values::{FiniteVector, NonNegative, Positive};
use siloflow_dem::walls::link::Link;
use siloflow_dem::walls::surfaces::Surfaces;

/// The scene key `door`.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct DoorControl {
    /// When the door opens.
    pub opens: DoorOpens,
    /// How the door opens.
    #[serde(default)]
    pub how: DoorMotion,
}

/// One entry of the scene key `doors`.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct NamedDoor {
    /// The `name` of the walls that are the door.
    pub walls: String,
    /// When the door opens.
    pub opens: DoorOpens,
    /// How the door opens.
    #[serde(default)]
    pub how: DoorMotion,
}

/// When a door opens.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
pub enum DoorOpens {
    /// When all grains have been released and have come to rest (`rest`).
    AtRest,
    /// At a time, s.
    At(NonNegative),
    /// Again and again: pairs of the times, s, at which the door begins to open and to shut, ascending.
    Schedule(Vec<(NonNegative, NonNegative)>),
    /// Never.
    Never,
}

/// How a door opens.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize, Serialize)]
pub enum DoorMotion {
    /// The door vanishes at once, with the elastic energy of its contacts.
    #[default]
    Remove,
    /// The door grains slide sideways at this speed, m/s.
    Slide(Positive),
    /// The wall surfaces of the door move, and back when the door shuts.
    Move {
        /// Shift from shut to open, m.
        by: FiniteVector,
        /// Speed, m/s.
        speed: Positive,
    },
}

/// The doors of the scene.
#[derive(Resource, Debug)]
pub struct DoorState {
    doors: Vec<(u16, DoorControl)>,
    /// One for each door.
    progress: Vec<Progress>,
    sliding: Option<Slide>,
}

/// The progress of one door so far.
#[derive(Clone, Copy, Debug, Default, Deserialize, Serialize)]
struct Progress {
    /// When the door began to open for the first time, s.
    open_time: Option<f64>,
    /// How often the door has begun to open or to shut.
    turns: usize,
    /// When the door was shut, or will be, after it has begun to shut, s.
    shut_time: f64,
}

impl Progress {
    fn is_open(self) -> bool {
        self.turns % 2 == 1
    }
}

/// A sliding motion: velocity (m/s) and end time (s).
#[derive(Clone, Copy, Debug, Deserialize, Serialize)]
struct Slide {
    velocity: Vector,
    until: f64,
}

impl DoorState {
    /// When the first door began to open, s; `None` before.
    #[must_use]
    pub fn open_time(&self) -> Option<f64> {
        self.progress.iter().filter_map(|door| door.open_time).reduce(f64::min)
    }

    /// How often doors have begun to open or to shut.
    #[must_use]
    pub fn turns(&self) -> usize {
        self.progress.iter().map(|progress| progress.turns).sum()
    }

    /// Whether any door has begun to open, and has not begun to shut.
    #[must_use]
    pub fn is_open(&self) -> bool {
        self.progress.iter().any(|door| door.is_open())
    }

    /// How often a door has begun to open, by its number; `None` if there is no such door.
    #[must_use]
    pub fn openings(&self, number: u16) -> Option<usize> {
        Some(self.of(number)?.turns.div_ceil(2))
    }

    /// Whether the door was not shut at some time from `since` (s) on: grains may have passed.
    pub(crate) fn lets_pass(&self, number: u16, since: f64) -> bool {
        self.of(number).is_some_and(|door| door.is_open() || (door.turns > 0 && since < door.shut_time))
    }

    fn of(&self, number: u16) -> Option<&Progress> {
        let place = self.doors.iter().position(|(own, _)| *own == number)?;
        self.progress.get(place)
    }
}

/// Whether a door turns now: begins to open or to shut.
fn is_due(opens: &DoorOpens, turns: usize, clock: &Clock, is_at_rest: bool) -> bool {
    match opens {
        DoorOpens::AtRest => turns == 0 && is_at_rest,
        DoorOpens::At(time) => turns == 0 && clock.has_reached(time.get()),
        DoorOpens::Schedule(times) => times
            .get(turns / 2)
            .is_some_and(|&(open, shut)| clock.has_reached(if turns.is_multiple_of(2) { open } else { shut }.get())),
        DoorOpens::Never => false,
    }
}

fn open_or_shut<V: Space>(
    mut commands: Commands,
    clock: Res<Clock>,
    mut state: ResMut<DoorState>,
    mut walls: ResMut<Surfaces<V>>,
    mut at_rest: MessageReader<CameToRest>,
    mut opened: MessageWriter<DoorOpened>,
    parts: Query<(Entity, &Door)>,
) {
    let is_at_rest = at_rest.read().next().is_some();
    let DoorState { doors, progress, .. } = &mut *state;
    for ((number, control), progress) in doors.iter().zip(progress) {
        if !is_due(&control.opens, progress.turns, &clock, is_at_rest) {
            continue;
        }
        progress.turns += 1;
        let opens = progress.is_open();
        if opens {
            progress.open_time.get_or_insert(clock.time());
            opened.write(DoorOpened);
        }
        match control.how {
            DoorMotion::Remove => {
                let parts = parts.iter().filter(|(_, door)| door.0 == *number);
                parts.for_each(|(part, _)| commands.entity(part).despawn());
            }
            DoorMotion::Move { .. } => {
                let arrival = walls.bypass_change_detection().command(*number, opens, clock.time());
                progress.shut_time = arrival.unwrap_or_default();
            }
            // `start_sliding` moves door grains.
            DoorMotion::Slide(_) => {}
        }
    }
}

/// Sets the door grains in motion once their door has begun to open.
fn start_sliding(
    clock: Res<Clock>,
    mut state: ResMut<DoorState>,
    orifice: Option<Res<Orifice>>,
    grains: Query<(&Position, &Radius), DoorGrain>,
) {
    let Some((_, DoorControl { how: DoorMotion::Slide(speed), .. })) = state.doors.first() else { return };
    let places: Vec<_> = grains.iter().map(|(x, radius)| (x.0, radius.0)).collect();
    let Some(orifice) = orifice.map(|orifice| orifice.0) else { return };
    let (direction, distance) = slide_path(&places, &orifice);
    let velocity = speed.get() * direction;
    state.sliding = Some(Slide { velocity, until: clock.time() + distance / speed.get() });
}

/// Returns the direction in which the door slides (rightwards or upwards along the orifice), and how far (m). The door
/// stops when its last grain is behind the far flank.
fn slide_path(grains: &[(Vector, f64)], orifice: &Link) -> (Vector, f64) {
    let along = (orifice.to - orifice.from).try_normalize().unwrap_or(Vector::X);
    let direction = if (along.x, along.y) < (0.0, 0.0) { -along } else { along };
    let last = grains.iter().map(|(x, _)| x.dot(direction)).fold(f64::INFINITY, f64::min);
    let flank = orifice.from.dot(direction).max(orifice.to.dot(direction));
    let radius = grains.iter().map(|(_, radius)| *radius).fold(0.0, f64::max);
    (direction, flank - last + radius)
}

/// Filter: wall grains of the door. It is disjoint from all free particles.
type DoorGrain = (With<Door>, With<Fixed>);

fn slide(clock: Res<Clock>, mut state: ResMut<DoorState>, mut door: Query<(&mut Position, &mut Velocity), DoorGrain>) {
    let Some(sliding) = state.sliding else { return };
    let arrived = clock.has_reached(sliding.until);
    for (mut x, mut v) in &mut door {
        x.0 += clock.dt * sliding.velocity;
        v.0 = if arrived { Vector::ZERO } else { sliding.velocity };
    }
    if arrived {
        state.sliding = None;
    }
}

fn may_turn(state: Res<DoorState>) -> bool {
    state.doors.iter().zip(&state.progress).any(|((_, control), progress)| match &control.opens {
        DoorOpens::AtRest | DoorOpens::At(_) => progress.turns == 0,
        DoorOpens::Schedule(times) => progress.turns < 2 * times.len(),
        DoorOpens::Never => false,
    })
}

/// Whether the door of wall grains begins to open in this step.
fn opens_now(state: Res<DoorState>, clock: Res<Clock>) -> bool {
    state.of(0).and_then(|door| door.open_time).is_some_and(|open| open >= clock.time())
}

fn is_sliding(state: Res<DoorState>) -> bool {
    state.sliding.is_some()
}

/// The line between the flanks of a door made of wall grains.
#[derive(Resource, Clone, Copy, Debug)]
pub struct Orifice(pub Link);

/// Adds the door controllers of a scene, each with its number.
pub struct DoorPlugin<V: Space>(pub Vec<(u16, DoorControl)>, pub PhantomData<V>);

impl<V: Space> Plugin for DoorPlugin<V> {
    fn build(&self, app: &mut App) {
        let progress = vec![Progress::default(); self.0.len()];
        app.insert_resource(DoorState { doors: self.0.clone(), progress, sliding: None });
        app.persist_sound_part::<DoorState, _>(
            |door| Ok((door.progress.clone(), door.sliding)),
            |door, (progress, sliding): (Vec<Progress>, _)| {
                if progress.len() != door.doors.len() {
                    return Err("the checkpoint has another number of doors".into());
                }
                door.progress = progress;
                door.sliding = sliding;
                Ok(())
            },
        );
        if self.0.iter().any(|(_, control)| control.opens != DoorOpens::Never) {
            let turn = open_or_shut::<V>.in_set(Phase::Control).in_set(PlainCommands).in_set(DoorsTurn);
            app.add_systems(Step, turn.after(RestDetection).run_if(may_turn));
        }
        // Rules admit this for the door grains of the silo file alone, of which there is one door.
        if self.0.iter().any(|(_, control)| matches!(control.how, DoorMotion::Slide(_))) {
            let start = start_sliding.in_set(Phase::Control).after(DoorsTurn).run_if(opens_now);
            app.add_systems(Step, (start, slide.in_set(Phase::Drift).run_if(is_sliding)));
        }
    }
}

/// The set in which doors begin to open or to shut.
#[derive(SystemSet, Clone, Debug, PartialEq, Eq, Hash)]
struct DoorsTurn;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_door_slides_until_its_last_grain_is_behind_the_far_flank() {
        let orifice = Link { from: Vector::new(0.13, 0.0), to: Vector::new(-0.13, 0.0) };
        for grains in
            [vec![(Vector::ZERO, 0.03)], vec![(Vector::new(0.04, 0.0), 0.03), (Vector::new(-0.04, 0.0), 0.03)]]
        {
            let (direction, distance) = slide_path(&grains, &orifice);
            let last = grains.iter().map(|(x, _)| x.x).fold(f64::INFINITY, f64::min);
            assert_eq!(direction, Vector::X);
            assert!((last + distance - 0.16).abs() < 1e-15, "{distance}");
        }
    }
}
