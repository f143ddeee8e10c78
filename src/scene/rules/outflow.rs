//! Rules on `outflow`: a window that a run can complete, an outlet, and zones that are apart.

use crate::measure::moment::Moment;
use crate::measure::outflow::Outflow;
use crate::scene::loaded::Loaded;
use siloflow_text::fault::Fault;

/// Checks the window and the zones.
pub(super) fn outflow(loaded: &Loaded) -> Result<(), Fault> {
    let Some(outflow) = loaded.scene.outflow else { return Ok(()) };
    window(loaded, &outflow)?;
    if !loaded.has_outlet() {
        return Err(loaded.fault("scene::no_door", "outflow", "no grain will ever be out: the scene has no door").help(
            "give a silo file whose first line has a second count above 0, or in solid space a wall with `door: true`",
        ));
    }
    let Some(zones) = outflow.mass_flow else { return Ok(()) };
    if [outflow.from, outflow.to].iter().any(|moment| matches!(moment, Moment::Out(_))) {
        let message =
            "velocities are sampled during the window, and a window of shares is known at the end of the run only";
        return Err(loaded
            .fault("scene::outflow", "outflow.mass_flow", message)
            .help("give times, `AfterDoor(s)` or `AfterRest(s)`, or leave `mass_flow` out"));
    }
    let (key, message) = if zones.low.get() >= zones.high.get() {
        ("outflow.mass_flow.high", "the zones have no height: `low` must be below `high`")
    } else if zones.centre.get() >= zones.wall.get() {
        ("outflow.mass_flow.wall", "the zone near the wall must begin outside of that near the axis")
    } else {
        return Ok(());
    };
    Err(loaded.fault("scene::empty_box", key, message).help("give heights and distances from the axis in m"))
}

/// Checks that the event of a moment can happen.
pub(super) fn can_happen(loaded: &Loaded, key: &str, moment: Moment) -> Result<(), Fault> {
    let (message, help) = match moment {
        Moment::AfterDoor(_) if !loaded.scene.opens_a_door() => (
            "the window follows a door, and no door opens",
            "add for example `door: (opens: At(0.0))`, or give times in s",
        ),
        Moment::AfterRest(_) if loaded.scene.rest.is_none() => (
            "the window follows rest, and nothing detects rest",
            "add `rest`, for example `rest: (speed: 0.1, energy: 1.0e-4, hold: 0.02)`",
        ),
        _ => return Ok(()),
    };
    Err(loaded.fault("scene::outflow", key, message).help(help))
}

/// Checks the moments of the window: they must come in their order, their events must be able to happen.
fn window(loaded: &Loaded, outflow: &Outflow) -> Result<(), Fault> {
    let until = loaded.scene.until.get();
    for (key, moment) in [("outflow.from", outflow.from), ("outflow.to", outflow.to)] {
        can_happen(loaded, key, moment)?;
    }
    let order = match (outflow.from, outflow.to) {
        (Moment::At(from), Moment::At(to))
        | (Moment::AfterDoor(from), Moment::AfterDoor(to))
        | (Moment::AfterRest(from), Moment::AfterRest(to)) => Some((from.get(), to.get())),
        (Moment::Out(from), Moment::Out(to)) => Some((from.get(), to.get())),
        _ => None,
    };
    if order.is_some_and(|(from, to)| from >= to) {
        let message = format!("the window is empty: it begins at {} and ends at {}", outflow.from, outflow.to);
        return Err(loaded
            .fault("scene::out_of_range", "outflow.to", message)
            .help("give times in s, `from` before `to`"));
    }
    if let Some(to) = outflow.to.fixed().filter(|to| *to > until) {
        let message = format!("the window ends at {to} s, and the run at {until} s at the latest");
        return Err(loaded
            .fault("scene::out_of_range", "outflow.to", message)
            .help("give an earlier end, or raise `until`"));
    }
    Ok(())
}
