//! Warnings about grains and walls that may pass each other within one step.

use std::collections::BTreeMap;

use crate::door::DoorMotion;
use crate::scene::check::quantities::Estimates;
use crate::scene::loaded::Loaded;
use siloflow_dem::space::Solid;
use siloflow_dem::walls::config::Wall;
use siloflow_dem::walls::motion::Motion;
use siloflow_text::fault::Warning;

/// Returns the largest speed of a wall that moves, m/s. Of a half-plane that turns it is the speed at the farthest grain or end of a wall.
fn fastest_wall(loaded: &Loaded) -> f64 {
    let ends = || loaded.scene.walls.iter().filter_map(Wall::bounds).flatten();
    let places = || loaded.grains.iter().map(|grain| grain.position).chain(ends());
    let speed = |motion: &Motion| {
        let walls = loaded.scene.walls.iter().filter(|wall| wall.name() == Some(&motion.walls));
        let about = motion.rotate.as_ref().map_or(Solid::ZERO, |turn| turn.about.padded());
        let reach = |wall: &Wall| match wall.bounds() {
            Some([low, high]) => (high - about).abs().max((low - about).abs()).length(),
            None if motion.rotate.is_some() => places().map(|x| x.distance(about)).fold(0.0, f64::max),
            None => 0.0,
        };
        motion.fastest(walls.map(reach).fold(0.0, f64::max))
    };
    let doors = loaded.scene.door_controls().into_iter().map(|(_, _, control)| match control.how {
        DoorMotion::Move { speed, .. } | DoorMotion::Slide(speed) => speed.get(),
        DoorMotion::Remove => 0.0,
    });
    // Motions of one wall add up.
    let mut by_wall: BTreeMap<&str, f64> = BTreeMap::new();
    for motion in &loaded.scene.motions {
        *by_wall.entry(&motion.walls).or_default() += speed(motion);
    }
    by_wall.into_values().chain(doors).fold(0.0, f64::max)
}

/// Warns of grains and walls that may pass each other within one step.
pub(super) fn examine(loaded: &Loaded, estimates: &Estimates, warnings: &mut Vec<Warning>) {
    // For a wall surface: the distance of a centre from first touch to the other side.
    let flat = loaded.scene.walls.iter().any(Wall::is_surface).then_some(0.0);
    let discs = loaded.fixed_radii();
    let thickness = estimates.radius + discs.chain(flat).fold(f64::INFINITY, f64::min);
    let driven = loaded.fixed.iter().map(|grain| grain.velocity.length()).fold(fastest_wall(loaded), f64::max);
    let way = (estimates.impact_speed + driven) * estimates.dt;
    if thickness.is_finite() && way > thickness {
        warnings.push(Warning {
            code: "check::fast_grains",
            message: format!(
                "a grain moves up to {way:.3} m in a step, and may pass a wall of {thickness:.3} m unseen"
            ),
            help: "lower `step`".to_owned(),
        });
    } else if loaded.grains.len() > 1 && 2.0 * way > 2.0 * estimates.radius {
        warnings.push(Warning {
            code: "check::fast_grains",
            message: format!(
                "two grains approach by up to {:.3} m in a step, and may pass each other unseen: a grain is {:.3} m wide",
                2.0 * way,
                2.0 * estimates.radius
            ),
            help: "lower `step`".to_owned(),
        });
    }
}
