//! Rules on `slopes`: names that differ, a horizontal direction, a box, and a window that can begin.

use std::collections::HashSet;

use crate::measure::moment::Moment;
use crate::measure::slope::Slope;
use crate::scene::loaded::Loaded;
use crate::scene::rules::directions::{has_no_direction, is_box};
use crate::scene::rules::outflow::can_happen;
use siloflow_text::fault::Fault;

/// Checks all slopes.
pub(super) fn slopes(loaded: &Loaded) -> Result<(), Fault> {
    let mut names = HashSet::new();
    for (index, slope) in loaded.scene.slopes.iter().enumerate() {
        let fault = |code, key: &str, message: &str, help: &str| {
            loaded.fault(code, &format!("slopes[{index}].{key}"), message.to_owned()).help(help.to_owned())
        };
        if !names.insert(&slope.name) {
            return Err(fault("scene::taken", "name", "another slope has this name", "give each slope its own name"));
        }
        if let Some((key, message, help)) = broken(slope) {
            return Err(fault("scene::slope", key, message, help));
        }
        let Some(from) = slope.from else { continue };
        let key = format!("slopes[{index}].from");
        can_happen(loaded, &key, from)?;
        if matches!(from, Moment::Out(_)) {
            let help = "give a time in s, `AfterDoor(s)` or `AfterRest(s)`";
            return Err(fault(
                "scene::slope",
                "from",
                "a share of the grains is known at the end of the run only",
                help,
            ));
        }
        if from.fixed().is_some_and(|from| from > loaded.scene.until.get()) {
            let help = "give an earlier time, or raise `until`";
            return Err(fault("scene::out_of_range", "from", "the window begins after the end of the run", help));
        }
    }
    Ok(())
}

/// Finds a rule that a slope breaks by itself: key, message, help.
fn broken(slope: &Slope) -> Option<(&'static str, &'static str, &'static str)> {
    if slope.name.is_empty() || slope.name.chars().any(|letter| letter == ',' || letter == '"' || letter.is_control()) {
        Some((
            "name",
            "a name has at least one letter, and no comma, quote or control character",
            "for example \"left flank\"",
        ))
    } else if slope.level_direction().is_some_and(has_no_direction) {
        Some(("falls", "the direction has no horizontal part", "for example `Along((1.0, 0.0))`: to the right"))
    } else if !is_box(slope.low, slope.high) {
        Some(("high", "the box is empty: `low` must be below `high` along every axis", "give corners in m"))
    } else if slope.heights.is_some_and(|(low, high)| low.get() >= high.get()) {
        Some(("heights", "the part is empty", "give shares of the height such as `heights: (0.2, 0.8)`"))
    } else {
        None
    }
}
