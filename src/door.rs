//! The door controller: when the door opens, and how.
//!
//! The door is the grains marked [`Door`]. It opens when the bed has come to rest, at a time, or never; it is
//! removed at once, or slides along its own line at a speed until it has cleared the orifice, pushing what it meets.

use bevy_app::{App, Plugin};
use bevy_ecs::prelude::*;
use serde::{Deserialize, Serialize};

use crate::messages::{CameToRest, DoorOpened};
use crate::particle::{Door, Fixed, Position, Velocity};
use crate::rest::RestDetection;
use crate::scene::values::{NonNegative, Positive};
use crate::space::Vector;
use crate::step::{Clock, ClockAdvanced, Phase, Step};

/// The scene's `door`.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct DoorControl {
    /// When it opens.
    pub opens: DoorOpens,
    /// How it opens.
    #[serde(default)]
    pub how: DoorMotion,
}

/// When the door opens.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
pub enum DoorOpens {
    /// When all grains have been released and have come to rest (`rest`).
    AtRest,
    /// At a time, s.
    At(NonNegative),
    /// Never.
    Never,
}

/// How the door opens.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize, Serialize)]
pub enum DoorMotion {
    /// It is gone at once, and with it the elastic energy of what rested on it.
    #[default]
    Remove,
    /// It slides sideways at this speed, m/s.
    Slide(Positive),
}

/// The door's state.
#[derive(Resource, Debug)]
pub struct DoorState {
    control: DoorControl,
    /// When the door began to open, s.
    pub open_time: Option<f64>,
    sliding: Option<Slide>,
}

#[derive(Clone, Copy, Debug)]
struct Slide {
    velocity: Vector,
    until: f64,
}

impl DoorState {
    /// Whether the door has begun to open.
    #[must_use]
    pub fn is_open(&self) -> bool {
        self.open_time.is_some()
    }
}

fn open(
    mut commands: Commands,
    clock: Res<Clock>,
    mut state: ResMut<DoorState>,
    mut at_rest: MessageReader<CameToRest>,
    mut opened: MessageWriter<DoorOpened>,
    mut door: Query<(Entity, &Position, &mut Velocity), With<Door>>,
) {
    let due = match state.control.opens {
        DoorOpens::AtRest => at_rest.read().next().is_some(),
        DoorOpens::At(time) => clock.has_reached(time.get()),
        DoorOpens::Never => false,
    };
    if !due {
        return;
    }
    state.open_time = Some(clock.time());
    opened.write(DoorOpened);
    match state.control.how {
        DoorMotion::Remove => door.iter().for_each(|(grain, ..)| commands.entity(grain).despawn()),
        DoorMotion::Slide(speed) => {
            let (direction, length) = line(door.iter().map(|(_, x, _)| x.0).collect());
            let velocity = speed.get() * direction;
            door.iter_mut().for_each(|(_, _, mut v)| v.0 = velocity);
            // Its own length and once more the gap to the next grain clear the orifice.
            state.sliding = Some(Slide { velocity, until: clock.time() + length / speed.get() });
        }
    }
}

/// Direction of the line through the door's grains, towards the right or upwards, and the way it has to slide, m.
fn line(centres: Vec<Vector>) -> (Vector, f64) {
    let by_x = |a: &&Vector, b: &&Vector| (a.x, a.y).partial_cmp(&(b.x, b.y)).unwrap_or(std::cmp::Ordering::Equal);
    let (first, last) = (centres.iter().min_by(by_x), centres.iter().max_by(by_x));
    let along = first.zip(last).map_or(Vector::ZERO, |(first, last)| *last - *first);
    #[expect(clippy::cast_precision_loss, reason = "doors have few grains")]
    let spacing = along.length() / (centres.len().max(2) - 1) as f64;
    (along.try_normalize().unwrap_or(Vector::X), along.length() + 2.0 * spacing)
}

/// Wall grains of the door; disjoint from all that forces move.
type DoorGrain = (With<Door>, With<Fixed>);

fn slide(clock: Res<Clock>, mut state: ResMut<DoorState>, mut door: Query<(&mut Position, &mut Velocity), DoorGrain>) {
    let Some(sliding) = state.sliding else { return };
    let arrived = clock.has_reached(sliding.until);
    for (mut x, mut v) in &mut door {
        x.0 += clock.dt * sliding.velocity;
        if arrived {
            v.0 = Vector::ZERO;
        }
    }
    if arrived {
        state.sliding = None;
    }
}

fn is_closed(state: Res<DoorState>) -> bool {
    !state.is_open()
}

fn is_sliding(state: Res<DoorState>) -> bool {
    state.sliding.is_some()
}

/// Opens the door as the scene says.
pub struct DoorPlugin(pub DoorControl);

impl Plugin for DoorPlugin {
    fn build(&self, app: &mut App) {
        app.insert_resource(DoorState { control: self.0, open_time: None, sliding: None });
        if self.0.opens != DoorOpens::Never {
            app.add_systems(Step, open.in_set(Phase::Control).after(RestDetection).run_if(is_closed));
        }
        if matches!(self.0.how, DoorMotion::Slide(_)) {
            app.add_systems(Step, slide.in_set(Phase::Drift).after(ClockAdvanced).run_if(is_sliding));
        }
    }
}
