//! Rules on `stop`: a condition must be able to hold.

use crate::ending::stop::conditions::StopCondition;
use crate::scene::loaded::Loaded;
use siloflow_dem::space::Solid;
use siloflow_text::fault::Fault;

/// Every condition needs what it watches: rest, a door that opens, an outlet.
pub(super) fn stop(loaded: &Loaded) -> Result<(), Fault> {
    let scene = &loaded.scene;
    for (index, condition) in scene.stop.iter().enumerate() {
        let (code, message, help) = match condition {
            StopCondition::AtRest if scene.rest.is_none() => (
                "scene::missing_key",
                "the run is to end at rest, but nothing detects rest",
                "add `rest: (speed: 2.0e-3, energy: 1.0e-6, hold: 0.1)`",
            ),
            StopCondition::EndOfFlow { .. } | StopCondition::Clogged { .. } if !scene.opens_a_door() => (
                "scene::no_door",
                "the end of the flow counts from the opening of the door, and no door opens",
                "add for example `door: (opens: At(0.0))`, or use `Out(...)` or `until`",
            ),
            StopCondition::Out(0) => {
                ("scene::out_of_range", "expected a number of grains of at least 1", "a run starts with no grain out")
            }
            StopCondition::Out(_) if !loaded.has_outlet() => (
                "scene::no_door",
                "no grain will ever be out: the scene has no door",
                "give a silo file whose first line has a second count above 0, or in solid space a wall with `door: true`",
            ),
            _ => continue,
        };
        return Err(loaded.fault(code, &format!("stop[{index}]"), message).help(help));
    }
    kick(loaded)
}

/// A kick needs a door that opens, a force, and a bound.
fn kick(loaded: &Loaded) -> Result<(), Fault> {
    let Some(kick) = loaded.scene.kick else { return Ok(()) };
    let (code, key, message, help) = if !loaded.scene.opens_a_door() {
        (
            "scene::no_door",
            "kick",
            "a kick restarts the flow through a door, and no door opens",
            "add for example `door: (opens: At(0.0))`, or remove `kick`",
        )
    } else if kick.acceleration.padded() == Solid::ZERO {
        (
            "scene::out_of_range",
            "kick.acceleration",
            "the kick has no force",
            "give an acceleration of some times g, m/s^2",
        )
    } else if !(1..=10_000).contains(&kick.most) {
        ("scene::out_of_range", "kick.most", "expected 1 to 10000 kicks", "`summary.json` lists an avalanche for each")
    } else {
        return Ok(());
    };
    Err(loaded.fault(code, key, message).help(help))
}
