//! Rules on `motions`: each moves walls that exist and that no door moves. Several motions of a wall add up, as does its own velocity, if at most one of
//! them turns it, or none.

use std::borrow::Cow;

use crate::scene::loaded::Loaded;
use crate::scene::rules::directions::has_no_direction;
use siloflow_dem::space::Dimension;
use siloflow_dem::values::NonNegative;
use siloflow_dem::walls::motion::Motion;
use siloflow_text::fault::Fault;

pub(super) fn motions(loaded: &Loaded) -> Result<(), Fault> {
    let motions = &loaded.scene.motions;
    for (index, motion) in motions.iter().enumerate() {
        let fault = |(code, key, message, help): Broken<'_>| {
            let key = if key.is_empty() { format!("motions[{index}]") } else { format!("motions[{index}].{key}") };
            loaded.fault(code, &key, message).help(help)
        };
        let turning = motions[..index].iter().filter(|other| other.rotate.is_some());
        let turning: Vec<_> = turning.map(|other| other.walls.as_str()).collect();
        let turns = motion.rotate.is_some();
        movable_walls(loaded, &motion.walls, if turns { &turning } else { &[] }, turns).map_err(fault)?;
        course(loaded, motion).map_err(fault)?;
    }
    Ok(())
}

/// A broken rule: code, key within the motion, message, help.
type Broken<'a> = (&'static str, &'a str, String, Cow<'a, str>);

/// The walls of a name exist, and no door moves them; `others` are the names of walls that move by other entries. If they are to stay `in_place`, they
/// have no velocity of their own.
pub(super) fn movable_walls(
    loaded: &Loaded,
    name: &String,
    others: &[&str],
    in_place: bool,
) -> Result<(), Broken<'static>> {
    let scene = &loaded.scene;
    let mut walls = scene.walls.iter().filter(|wall| wall.name() == Some(name));
    if walls.clone().next().is_none() {
        let message = format!("no wall has the name {name:?}");
        return Err(("scene::no_such_wall", "walls", message, loaded.help_for_wall(name).into()));
    }
    let other = if others.contains(&name.as_str()) {
        "another motion"
    } else if walls.clone().any(|wall| scene.door_of(wall).is_some()) {
        "a door"
    } else if in_place && walls.any(|wall| wall.shape.moves_in_place()) {
        "its own `velocity` or `spin`"
    } else {
        return Ok(());
    };
    let message = format!("a wall named {name:?} already moves by {other}");
    Err((
        "scene::two_motions",
        "walls",
        message,
        "move a wall by one thing; only motions that do not turn it may be added to another".into(),
    ))
}

/// There is something to do, from a beginning to a later end, about an axis that the space has.
fn course(loaded: &Loaded, motion: &Motion) -> Result<(), Broken<'static>> {
    let is_solid = loaded.scene.space == Dimension::Solid;
    let axis = motion.rotate.as_ref().map(|turn| turn.axis);
    let (code, key, message, help) = match axis {
        None if motion.translate.is_none() => (
            "scene::missing_key",
            "",
            "the walls are to move, but neither `translate` nor `rotate` says how",
            "add for example `translate: Oscillate(amplitude: (0.0, 1.0e-3), frequency: 50.0)`, in m and Hz",
        ),
        Some(Some(_)) if !is_solid => {
            ("scene::dimension", "rotate.axis", "in the plane the axis always points to the reader", "remove `axis`")
        }
        Some(None) if is_solid => {
            ("scene::missing_key", "rotate", "a rotation in solid space needs an axis", "add `axis: (0.0, 0.0, 1.0)`")
        }
        Some(Some(axis)) if has_no_direction(axis.padded()) => {
            ("scene::out_of_range", "rotate.axis", "the axis has no direction", "give a vector of any non-zero length")
        }
        _ if motion.until.is_some_and(|until| until.get() <= motion.from.map_or(0.0, NonNegative::get)) => {
            ("scene::out_of_range", "until", "the motion ends before it begins", "give a time after `from`, s")
        }
        _ => return Ok(()),
    };
    Err((code, key, message.to_owned(), help.into()))
}
