//! The outlet: sites outside the outline that are wall until the door opens, and then a sink.

use bevy_app::{App, Plugin};
use bevy_ecs::prelude::*;
use serde::{Deserialize, Serialize};

use crate::lattice::rest::RestDetection;
use crate::lattice::sites::Sites;
use crate::messages::{CameToRest, DoorOpened};
use crate::space::Vector;
use crate::step::{Clock, Phase, Step};
use crate::values::FiniteVector;

/// The scene's `door`.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Door {
    /// One end, on an edge of the outline, m.
    pub from: FiniteVector,
    /// The other end, m.
    pub to: FiniteVector,
    /// When it opens. Default `AtRest`.
    #[serde(default)]
    pub opens: DoorOpens,
}

impl Door {
    /// Its ends, m.
    #[must_use]
    pub fn ends(self) -> (Vector, Vector) {
        (self.from.padded().truncate(), self.to.padded().truncate())
    }
}

/// When the door opens.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize, Serialize)]
pub enum DoorOpens {
    /// When everything has entered and is at rest (`rest`).
    #[default]
    AtRest,
    /// At a step.
    At(u64),
    /// Never.
    Never,
}

/// The door's state.
#[derive(Resource, Debug)]
pub struct DoorState {
    opens: DoorOpens,
    /// The step at whose end it opened.
    pub open_step: Option<u64>,
}

impl DoorState {
    /// Steps since it opened.
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

/// Opens the door as the scene says.
pub(super) struct DoorPlugin(pub Door);

impl Plugin for DoorPlugin {
    fn build(&self, app: &mut App) {
        app.insert_resource(DoorState { opens: self.0.opens, open_step: None });
        if self.0.opens != DoorOpens::Never {
            app.add_systems(Step, open.in_set(Phase::Control).after(RestDetection).run_if(is_closed));
        }
    }
}
