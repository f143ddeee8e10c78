//! Rules on `free_walls`: each lets walls go that exist, that nothing else moves, with one kind of inertia and stops around the place in the scene.

use std::borrow::Cow;

use crate::scene::loaded::Loaded;
use crate::scene::rules::directions::has_no_direction;
use crate::scene::rules::motions::movable_walls;
use siloflow_dem::space::Dimension;
use siloflow_dem::walls::free::{FreeWall, Freedom};
use siloflow_text::fault::Fault;

/// A broken rule: code, key within the entry, message, help.
type Broken<'a> = (&'static str, &'a str, String, Cow<'a, str>);

pub(super) fn free_walls(loaded: &Loaded) -> Result<(), Fault> {
    let all = &loaded.scene.free_walls;
    for (index, free) in all.iter().enumerate() {
        let fault = |(code, key, message, help): Broken<'_>| {
            let dot = if key.is_empty() { "" } else { "." };
            loaded.fault(code, &format!("free_walls[{index}]{dot}{key}"), message).help(help)
        };
        let moved = loaded.scene.motions.iter().map(|motion| motion.walls.as_str());
        let others: Vec<_> = moved.chain(all[..index].iter().map(|other| other.walls.as_str())).collect();
        movable_walls(loaded, &free.walls, &others, true).map_err(fault)?;
        way(loaded, free).map_err(fault)?;
        inertia(free).map_err(fault)?;
        ends(free).map_err(fault)?;
    }
    Ok(())
}

fn way(loaded: &Loaded, free: &FreeWall) -> Result<(), Broken<'static>> {
    let is_solid = loaded.scene.space == Dimension::Solid;
    let (code, key, message, help) = match &free.moves {
        Freedom::Along(direction) if has_no_direction(direction.padded()) => (
            "scene::out_of_range",
            "moves",
            "the direction has no length",
            "give a vector of any non-zero length, such as `Along((0.0, 1.0))`",
        ),
        Freedom::About { axis: Some(_), .. } if !is_solid => {
            ("scene::dimension", "moves.axis", "in the plane the axis always points to the reader", "remove `axis`")
        }
        Freedom::About { axis: None, .. } if is_solid => {
            ("scene::missing_key", "moves", "a hinge in solid space needs an axis", "add `axis: (0.0, 1.0, 0.0)`")
        }
        Freedom::About { axis: Some(axis), .. } if has_no_direction(axis.padded()) => {
            ("scene::out_of_range", "moves.axis", "the axis has no direction", "give a vector of any non-zero length")
        }
        _ => return Ok(()),
    };
    Err((code, key, message.to_owned(), help.into()))
}

fn inertia(free: &FreeWall) -> Result<(), Broken<'static>> {
    let hinged = matches!(free.moves, Freedom::About { .. });
    let (key, message, help) = match (free.gain.is_some(), hinged) {
        (true, _) if free.inertia.is_some() || (free.mass.is_some() && !hinged && !free.gravity) => {
            ("gain", "a servo has no inertia", "give `gain`, or `mass` and for a hinge `inertia`")
        }
        (true, _) if free.damping.is_some() || free.motor.is_some() || free.rate.is_some() => (
            "gain",
            "a servo follows the forces at once, so it has no `damping`, `motor` or `rate`",
            "remove them, or give the wall an inertia in place of `gain`",
        ),
        (false, false) if free.mass.is_none() => {
            ("", "the walls have neither `mass` nor `gain`", "add for example `mass: 2.0`, kg")
        }
        (false, false) if free.inertia.is_some() => {
            ("inertia", "walls that do not turn have no moment of inertia", "remove `inertia`; their `mass` counts")
        }
        (false, true) if free.inertia.is_none() => {
            ("", "the hinged walls have neither `inertia` nor `gain`", "add for example `inertia: 1.0e-3`, kg m^2")
        }
        (_, false) if free.centre.is_some() => {
            ("centre", "the centre of mass counts for hinges alone", "remove `centre`")
        }
        _ => return Ok(()),
    };
    Err(("scene::free_wall", key, message.to_owned(), help.into()))
}

fn ends(free: &FreeWall) -> Result<(), Broken<'static>> {
    let [low, high] = free.range();
    let (key, message, help) = if !(low <= 0.0 && high >= 0.0 && low < high) {
        (
            "stops",
            format!("the stops {low} and {high} do not lie around the place in the scene, 0"),
            "give the lowest and the highest shift, m (angle, rad), such as `stops: (-0.1, 0.1)`",
        )
    } else if free.load.as_ref().is_some_and(|load| !load.is_ordered()) {
        (
            "load",
            "the times of the table do not ascend, or there is no row".to_owned(),
            "give times, s, and loads, N, such as `load: [(0.0, -100.0), (1.0, -300.0)]`; a jump is a short slope",
        )
    } else if free.rate.is_some() && free.from.is_some() {
        ("rate", "a wall that is held until `from` has no rate at the start".to_owned(), "remove `rate` or `from`")
    } else {
        return Ok(());
    };
    Err(("scene::free_wall", key, message, help.into()))
}
