//! The phase of a run for its progress line: filling, settling or discharge, with the share that is done where it is known.

use bevy_ecs::prelude::*;

use crate::door::DoorState;
use crate::grains::pending::Pending;
use crate::ledger::Ledger;
use crate::rest::RestDetector;

/// Returns the phase with a separator behind it; nothing for a run that neither fills, nor waits for rest, nor empties.
pub(super) fn phase(world: &World) -> String {
    let ledger = world.resource::<Ledger>();
    let share = |done: u32, of: u32| 100.0 * f64::from(done) / f64::from(of.max(1));
    let pending = world.get_resource::<Pending>().map_or(0, |pending| pending.0);
    if pending > 0 {
        return format!("filling, {:.0} % | ", share(ledger.released, ledger.released + pending));
    }
    if world.get_resource::<DoorState>().is_some_and(DoorState::is_open) {
        return format!("discharge, {:.0} % | ", share(ledger.out(), ledger.out() + ledger.inside()));
    }
    let waits = world.get_resource::<RestDetector>().is_some_and(|detector| detector.rest_time.is_none());
    if waits { "settling | ".to_owned() } else { String::new() }
}
