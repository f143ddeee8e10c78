//! The door: sites outside the outline that are walls until the door opens, and sinks afterwards.

use bevy_app::{App, Plugin};
use bevy_ecs::prelude::*;
use serde::{Deserialize, Serialize};

use crate::lattice_silo::rest::{RestDetection, not_later_than_now};
use siloflow_dem::messages::{CameToRest, DoorOpened};
use siloflow_dem::persist::PersistApp as _;
use siloflow_dem::space::Vector;
use siloflow_dem::step::{Clock, Phase, Step};
use siloflow_dem::values::FiniteVector;
use siloflow_lattice::sites::Sites;

/// The scene's key `door`.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Door {
    /// First end of the door, on an edge of the outline, m.
    pub from: FiniteVector,
    /// Second end of the door, on the same edge, m.
    pub to: FiniteVector,
    /// When the door opens. Default `AtRest`.
    #[serde(default)]
    pub opens: DoorOpens,
}

impl Door {
    /// Returns the two ends of the door, m.
    #[must_use]
    pub fn ends(self) -> (Vector, Vector) {
        (self.from.padded().truncate(), self.to.padded().truncate())
    }
}

/// When the door opens.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize, Serialize)]
pub enum DoorOpens {
    /// When all particles have entered and the gas is at rest (scene key `rest`).
    #[default]
    AtRest,
    /// At the end of this step.
    At(u64),
    /// Never.
    Never,
}

/// State of the door.
#[derive(Resource, Debug)]
pub struct DoorState {
    opens: DoorOpens,
    /// Step at the end of which the door opened; `None` while it is closed.
    pub open_step: Option<u64>,
}

impl DoorState {
    /// Returns the number of steps since the door opened; `None` while it is closed.
    #[must_use]
    pub fn steps_since(&self, clock: &Clock) -> Option<u64> {
        self.open_step.map(|opened| clock.steps - opened)
    }
}

fn open(
    clock: Res<Clock>,
    mut state: ResMut<DoorState>,
    mut at_rest: MessageReader<CameToRest>,
    mut sites: ResMut<Sites>,
    mut opened: MessageWriter<DoorOpened>,
) {
    let due = match state.opens {
        DoorOpens::AtRest => at_rest.read().next().is_some(),
        DoorOpens::At(step) => clock.steps >= step,
        DoorOpens::Never => false,
    };
    if due {
        sites.open();
        state.open_step = Some(clock.steps);
        opened.write(DoorOpened);
    }
}

fn is_closed(state: Res<DoorState>) -> bool {
    state.open_step.is_none()
}

/// Plugin that opens the door when the scene's `door.opens` says so.
pub(super) struct DoorPlugin(pub Door);

impl Plugin for DoorPlugin {
    fn build(&self, app: &mut App) {
        app.insert_resource(DoorState { opens: self.0.opens, open_step: None });
        app.persist_sound_part::<DoorState, _>(
            |door| Ok(door.open_step),
            |door, open_step| {
                door.open_step = open_step;
                Ok(())
            },
        );
        app.check_restored(|world| {
            let opened = world.resource::<DoorState>().open_step.unwrap_or(0);
            not_later_than_now(world, opened)
        });
        if self.0.opens != DoorOpens::Never {
            app.add_systems(Step, open.in_set(Phase::Control).after(RestDetection).run_if(is_closed));
        }
    }
}
