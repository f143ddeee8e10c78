//! Rules on `door` and `doors`: each needs walls, a way to open that its walls have, and times that follow each other.

use crate::door::{DoorControl, DoorMotion, DoorOpens};
use crate::scene::loaded::Loaded;
use crate::scene::rules::directions::has_no_direction;
use siloflow_dem::values::NonNegative;
use siloflow_text::fault::Fault;

pub(super) fn doors(loaded: &Loaded) -> Result<(), Fault> {
    let scene = &loaded.scene;
    if scene.door.is_some() && loaded.silo.door.is_empty() && !scene.walls.iter().any(|wall| wall.door) {
        return Err(loaded
            .fault("scene::no_door", "door", "there is no door to open: no silo file announces door grains")
            .help(
                "remove `door`, or give a silo file whose first line has a second count above 0, or a wall with `door: true`",
            ));
    }
    for index in 0..scene.doors.len() {
        names(loaded, index)?;
    }
    if scene.doors.len() > usize::from(u16::MAX) {
        return Err(loaded
            .fault("scene::out_of_range", "doors", "more doors than 65535")
            .help("join doors of one schedule"));
    }
    scene.door_controls().iter().try_for_each(|(number, key, control)| door(loaded, *number, key, control))
}

/// The walls of a named door exist, and belong to nothing else that moves them.
fn names(loaded: &Loaded, index: usize) -> Result<(), Fault> {
    let scene = &loaded.scene;
    let key = format!("doors[{index}].walls");
    let name = &scene.doors[index].walls;
    let walls = scene.walls.iter().filter(|wall| wall.name() == Some(name));
    if walls.clone().next().is_none() {
        return Err(loaded
            .fault("scene::no_such_wall", &key, format!("no wall has the name {name:?}"))
            .help(loaded.help_for_wall(name)));
    }
    let (code, message, help) = if walls.clone().any(|wall| wall.door) {
        (
            "scene::two_doors",
            format!("a wall named {name:?} has `door: true`, so it belongs to the key `door` as well"),
            "remove `door: true` from the wall",
        )
    } else if scene.doors[..index].iter().any(|door| door.walls == *name) {
        ("scene::two_doors", format!("{name:?} is already a door"), "give each door one entry")
    } else {
        return Ok(());
    };
    Err(loaded.fault(code, &key, message).help(help))
}

fn door(loaded: &Loaded, number: u16, key: &str, control: &DoorControl) -> Result<(), Fault> {
    let how = format!("{key}.how");
    let opens = format!("{key}.opens");
    let has_grains = number == 0 && !loaded.silo.door.is_empty();
    let has_surfaces = loaded.scene.walls.iter().any(|wall| loaded.scene.door_of(wall) == Some(number));
    let (code, key, message, help) = match (&control.opens, control.how) {
        (DoorOpens::AtRest, _) if loaded.scene.rest.is_none() => (
            "scene::missing_key",
            "rest".to_owned(),
            "the door opens at rest, but nothing detects rest",
            "add `rest: (speed: 2.0e-3, energy: 1.0e-6, hold: 0.1)`",
        ),
        (_, DoorMotion::Slide(_)) if has_surfaces || !has_grains => (
            "scene::no_slide",
            how,
            "only door grains of a silo file slide",
            "write `how: Move(by: ..., speed: ...)`, or leave the key out",
        ),
        (_, DoorMotion::Move { .. }) if has_grains => (
            "scene::no_slide",
            how,
            "door grains of a silo file do not move by a vector",
            "write `how: Slide(...)`, with a speed in m/s, or leave the key out",
        ),
        (_, DoorMotion::Move { by, .. }) if has_no_direction(by.padded()) => (
            "scene::out_of_range",
            format!("{how}.by"),
            "the door moves nowhere",
            "give the shift from shut to open, m",
        ),
        (DoorOpens::Schedule(_), DoorMotion::Remove | DoorMotion::Slide(_)) => (
            "scene::no_schedule",
            how,
            "a door that shuts again must move, because a wall that appears between grains would throw them",
            "write `how: Move(by: ..., speed: ...)`, with the shift from shut to open (m) and a speed (m/s)",
        ),
        (DoorOpens::Schedule(times), _) if !ascends(times) => (
            "scene::out_of_range",
            opens,
            "expected pairs of times, each of opening before shutting, one pair after the other",
            "write for example `Schedule([(1.0, 1.5), (3.0, 3.5)])`, in s",
        ),
        _ => return Ok(()),
    };
    Err(loaded.fault(code, &key, message).help(help))
}

fn ascends(pairs: &[(NonNegative, NonNegative)]) -> bool {
    let times = pairs.iter().flat_map(|(open, shut)| [open.get(), shut.get()]);
    !pairs.is_empty() && times.is_sorted_by(|a, b| a < b)
}
