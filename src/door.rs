//! Door controller: decides when the door opens, and opens it.
//!
//! The door consists of the wall grains and wall surfaces ([`WallIndex`](crate::walls::surfaces::WallIndex)) marked
//! [`Door`]. It opens when the bed has come to rest, at a given time, or never. It is removed at once, or it slides
//! along the orifice at a constant speed until the orifice is clear, and drags the grains that it touches.

use bevy_app::{App, Plugin};
use bevy_ecs::prelude::*;
use serde::{Deserialize, Serialize};

use crate::messages::{CameToRest, DoorOpened};
use crate::particle::{Door, Fixed, Position, Radius, Velocity};
use crate::persist::PersistApp as _;
use crate::rest::RestDetection;
use crate::space::Vector;
use crate::step::{Clock, Phase, Step};
use crate::store::PlainCommands;
use crate::values::{NonNegative, Positive};
use crate::walls::outline::Link;

/// The scene key `door`.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct DoorControl {
    /// When the door opens.
    pub opens: DoorOpens,
    /// How the door opens.
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
    /// The door vanishes at once, with the elastic energy of its contacts.
    #[default]
    Remove,
    /// The door slides sideways at this speed, m/s.
    Slide(Positive),
}

/// State of the door.
#[derive(Resource, Debug)]
pub struct DoorState {
    control: DoorControl,
    /// When the door began to open, s; `None` before.
    pub open_time: Option<f64>,
    sliding: Option<Slide>,
}

/// A sliding motion: velocity (m/s) and end time (s).
#[derive(Clone, Copy, Debug, Deserialize, Serialize)]
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

#[expect(clippy::too_many_arguments, reason = "opening depends on all of them")]
fn open(
    mut commands: Commands,
    clock: Res<Clock>,
    mut state: ResMut<DoorState>,
    mut at_rest: MessageReader<CameToRest>,
    mut opened: MessageWriter<DoorOpened>,
    orifice: Option<Res<Orifice>>,
    parts: Query<Entity, With<Door>>,
    grains: Query<(&Position, &Radius), DoorGrain>,
) {
    let is_due = match state.control.opens {
        DoorOpens::AtRest => at_rest.read().next().is_some(),
        DoorOpens::At(time) => clock.has_reached(time.get()),
        DoorOpens::Never => false,
    };
    if !is_due {
        return;
    }
    state.open_time = Some(clock.time());
    opened.write(DoorOpened);
    match state.control.how {
        DoorMotion::Remove => parts.iter().for_each(|part| commands.entity(part).despawn()),
        DoorMotion::Slide(speed) => {
            let places: Vec<_> = grains.iter().map(|(x, radius)| (x.0, radius.0)).collect();
            let Some(orifice) = orifice.map(|orifice| orifice.0) else { return };
            let (direction, distance) = slide_path(&places, &orifice);
            let velocity = speed.get() * direction;
            state.sliding = Some(Slide { velocity, until: clock.time() + distance / speed.get() });
        }
    }
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

/// Filter: wall grains of the door. It is disjoint from all movable particles.
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

fn is_closed(state: Res<DoorState>) -> bool {
    !state.is_open()
}

fn is_sliding(state: Res<DoorState>) -> bool {
    state.sliding.is_some()
}

/// The line between the flanks of a door made of wall grains.
#[derive(Resource, Clone, Copy, Debug)]
pub struct Orifice(pub Link);

/// Adds the door controller of a scene.
pub struct DoorPlugin(pub DoorControl);

impl Plugin for DoorPlugin {
    fn build(&self, app: &mut App) {
        app.insert_resource(DoorState { control: self.0, open_time: None, sliding: None });
        app.persist_part::<DoorState, _>(
            |door| Ok((door.open_time, door.sliding)),
            |door, state| {
                (door.open_time, door.sliding) = state;
                Ok(())
            },
        );
        if self.0.opens != DoorOpens::Never {
            app.add_systems(
                Step,
                open.in_set(Phase::Control).in_set(PlainCommands).after(RestDetection).run_if(is_closed),
            );
        }
        if matches!(self.0.how, DoorMotion::Slide(_)) {
            app.add_systems(Step, slide.in_set(Phase::Drift).run_if(is_sliding));
        }
    }
}

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
