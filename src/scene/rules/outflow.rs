//! Rules on `outflow`: a window that a run can complete, an outlet, and zones that are apart.

use crate::scene::loaded::Loaded;
use siloflow_text::fault::Fault;

/// Checks the window and the zones.
pub(super) fn outflow(loaded: &Loaded) -> Result<(), Fault> {
    let Some(outflow) = loaded.scene.outflow else { return Ok(()) };
    let from = outflow.from.get();
    let to = outflow.to.get();
    let until = loaded.scene.until.get();
    if from >= to {
        let message = format!("the window is empty: it begins at {from} s and ends at {to} s");
        return Err(loaded
            .fault("scene::out_of_range", "outflow.to", message)
            .help("give times in s, `from` before `to`"));
    }
    if to > until {
        let message = format!("the window ends at {to} s, and the run at {until} s at the latest");
        return Err(loaded
            .fault("scene::out_of_range", "outflow.to", message)
            .help("give an earlier end, or raise `until`"));
    }
    if !loaded.has_outlet() {
        return Err(loaded.fault("scene::no_door", "outflow", "no grain will ever be out: the scene has no door").help(
            "give a silo file whose first line has a second count above 0, or in solid space a wall with `door: true`",
        ));
    }
    let Some(zones) = outflow.mass_flow else { return Ok(()) };
    let (key, message) = if zones.low.get() >= zones.high.get() {
        ("outflow.mass_flow.high", "the zones have no height: `low` must be below `high`")
    } else if zones.centre.get() >= zones.wall.get() {
        ("outflow.mass_flow.wall", "the zone near the wall must begin outside of that near the axis")
    } else {
        return Ok(());
    };
    Err(loaded.fault("scene::empty_box", key, message).help("give heights and distances from the axis in m"))
}
