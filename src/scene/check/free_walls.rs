//! The step for walls that forces move: dt < 2 sqrt(M/K) with the inertia M and the stiffness K of all contacts with the wall, and for a servo of gain G
//! dt < 2/(G K). The number of contacts is that of the largest grains side by side on the wall, and one where the wall has no ends. A hinge whose walls have no ends has no
//! longest lever and is not examined.

use crate::scene::check::Estimates;
use crate::scene::loaded::Loaded;
use siloflow_dem::math;
use siloflow_dem::space::{Dimension, Solid};
use siloflow_dem::values::Positive;
use siloflow_dem::walls::config::Wall;
use siloflow_dem::walls::free::{FreeWall, Freedom, Load};
use siloflow_text::fault::Warning;

pub(super) fn examine(loaded: &Loaded, estimates: &Estimates, warnings: &mut Vec<Warning>) {
    for free in &loaded.scene.free_walls {
        let walls = || loaded.scene.walls.iter().filter(|wall| wall.name() == Some(&free.walls));
        let contacts = walls().map(|wall| contacts(loaded, wall, estimates.radius)).sum::<f64>().max(1.0);
        let Some(lever) = lever(free, walls()) else { continue };
        let stiffness = contacts * estimates.stiffness * lever.powi(2);
        let limit = match (free.moved_inertia(), free.gain.map(Positive::get)) {
            (Some(inertia), _) => 2.0 * (inertia / stiffness).sqrt(),
            (None, Some(gain)) => 2.0 / (gain * stiffness),
            (None, None) => continue,
        };
        // With half of the limit the error of the rate is some per cent.
        if estimates.dt > 0.5 * limit {
            warnings.push(Warning {
                code: "check::free_wall_step",
                message: format!(
                    "the step of {:.3e} s is long for the free walls {:?}: with {contacts:.0} contacts it must stay below {limit:.3e} s",
                    estimates.dt, free.walls
                ),
                help: "give the walls more mass (`mass`, `inertia`) or less `gain`, or lower `step` to half of this limit".to_owned(),
            });
        }
    }
}

/// The largest force (N) of a free wall on one grain, when as many grains as find a place carry its load, its weight, and what its motor can pull.
pub(super) fn pressed_by_free_walls(loaded: &Loaded, radius: f64) -> f64 {
    let force = |free: &FreeWall| {
        let walls = || loaded.scene.walls.iter().filter(|wall| wall.name() == Some(&free.walls));
        let contacts = walls().map(|wall| contacts(loaded, wall, radius)).fold(1.0, f64::max);
        let Some(lever) = lever(free, walls()) else { return 0.0 };
        let weight = free.mass.filter(|_| free.gravity).map_or(0.0, Positive::get);
        let weight = weight * loaded.scene.gravity.padded().length();
        let load = free.load.as_ref().map_or(0.0, Load::largest) + free.motor.map_or(0.0, |motor| motor.limit.get());
        (load / lever + weight) / contacts
    };
    loaded.scene.free_walls.iter().map(force).fold(0.0, f64::max)
}

/// How many of the largest grains find a place side by side on a wall; 1 without ends.
fn contacts(loaded: &Loaded, wall: &Wall, radius: f64) -> f64 {
    let Some([low, high]) = wall.bounds() else { return 1.0 };
    let mut sides = (high - low).to_array();
    sides.sort_by(f64::total_cmp);
    let [_, short, long] = sides.map(|side| (0.5 * side / radius).max(1.0));
    if loaded.scene.space == Dimension::Plane { math::hypot(short, long) } else { short * long }
}

/// Meters of way per unit of the coordinate: 1, or the longest lever about the axis of a hinge, m; `None` for a hinge whose walls have no ends.
fn lever<'a>(free: &FreeWall, walls: impl Iterator<Item = &'a Wall>) -> Option<f64> {
    let Freedom::About { point, .. } = &free.moves else { return Some(1.0) };
    let point = point.padded();
    let far = |[low, high]: [Solid; 2]| (high - point).abs().max((low - point).abs()).length();
    walls.filter_map(Wall::bounds).map(far).reduce(f64::max).filter(|&lever| lever > 0.0)
}
