//! Whether grains, silo and gravity fit together: mistakes that no rule forbids and that a run shows late.
//!
//! * Gravity that points upwards.
//! * A feed whose region lies beside all walls, or below them.
//! * A silo file whose discs are much larger or smaller than the grains: the unit is probably another one.
//! * An outlet a few grains wide. Spheres clog at every circular outlet below 4.9 diameters (Zuriguel et al., Phys. Rev. E 71, 051303, 2005); the
//!   warning begins at [`CLOGS`] diameters, and not where the scene has a clog in mind.
//! * A step far below what the contacts need.

use crate::ending::stop::conditions::StopCondition;
use crate::scene::check::Estimates;
use crate::scene::check::doors::door_width;
use crate::scene::loaded::Loaded;
use siloflow_dem::space::{Dimension, Solid};
use siloflow_dem::walls::config::Wall;
use siloflow_text::fault::Warning;

/// Diameters of the smallest grain below which an outlet is sure to clog.
const CLOGS: f64 = 3.0;

/// Ratio of radii from which on a unit is suspicious: 100 is the step from cm to m.
const OTHER_UNIT: f64 = 20.0;

/// The stability limit over the step from which on a step is suspiciously short.
const SHORT: f64 = 1e4;

/// Adds the warnings that need no estimates.
pub(super) fn examine(loaded: &Loaded, warnings: &mut Vec<Warning>) {
    gravity(loaded, warnings);
    feeds(loaded, warnings);
    unit(loaded, warnings);
}

fn gravity(loaded: &Loaded, warnings: &mut Vec<Warning>) {
    let gravity = loaded.scene.gravity.padded();
    let up = loaded.scene.space.count() - 1;
    let is_told = warnings.iter().any(|warning| warning.code == "check::heights_across_gravity");
    if !is_told && gravity.to_array()[up] > 0.5 * gravity.length() {
        let axis = ["x", "y", "z"][up];
        warnings.push(Warning {
            code: "check::gravity_upwards",
            message: format!("gravity points upwards, along +{axis}: grains fall to the top"),
            help: format!("give the component along {axis} a minus sign, if grains are to fall"),
        });
    }
}

/// The box of all walls that have ends and of all discs, m.
fn box_of_walls(loaded: &Loaded) -> Option<[Solid; 2]> {
    let walls = loaded.scene.walls.iter().filter_map(Wall::bounds);
    let discs = loaded.wall_discs();
    let discs = discs.iter().map(|disc| {
        let centre = disc.centre.extend(0.0);
        [centre - Solid::splat(disc.radius), centre + Solid::splat(disc.radius)]
    });
    walls.chain(discs).reduce(|[low, high], [a, b]| [low.min(a), high.max(b)])
}

fn feeds(loaded: &Loaded, warnings: &mut Vec<Warning>) {
    let Some([low, high]) = box_of_walls(loaded) else { return };
    let up = loaded.scene.space.count() - 1;
    for (index, feed) in loaded.scene.feed.iter().enumerate() {
        let (from, to) = feed.region.bounds();
        let beside = (0..up).any(|axis| to[axis] < low[axis] || from[axis] > high[axis]);
        if beside || to[up] < low[up] {
            let middle = (from + to) * 0.5;
            let [x, y, z] = middle.to_array();
            warnings.push(Warning {
                code: "check::feed_outside",
                message: format!(
                    "the region of `feed[{index}]`, about ({x:.3}, {y:.3}, {z:.3}) m, lies {} all walls",
                    if beside { "beside" } else { "below" }
                ),
                help: format!("move `feed[{index}].region` into or over the silo; are its numbers in m?"),
            });
        }
    }
}

fn unit(loaded: &Loaded, warnings: &mut Vec<Warning>) {
    let Some((_, largest)) = loaded.grain_radii() else { return };
    let discs = loaded.silo.wall.iter().map(|disc| disc.radius);
    let Some(wall) = discs.reduce(f64::max) else { return };
    let ratio = wall / largest;
    if !(1.0 / OTHER_UNIT..=OTHER_UNIT).contains(&ratio) {
        warnings.push(Warning {
            code: "check::silo_size",
            message: format!(
                "the discs of the silo file have radii up to {wall:.3e} m, and the grains up to {largest:.3e} m"
            ),
            help: "is `silo.unit` the unit of the numbers in the file? `Centimetre` makes the silo a hundred times smaller than `Metre`".to_owned(),
        });
    }
}

/// Adds the warnings that need estimates.
pub(super) fn examine_with(loaded: &Loaded, estimates: &Estimates, warnings: &mut Vec<Warning>) {
    outlet(loaded, estimates.radius, warnings);
    short_step(loaded, estimates, warnings);
}

fn outlet(loaded: &Loaded, radius: f64, warnings: &mut Vec<Warning>) {
    let scene = &loaded.scene;
    let expects_clogs = scene.kick.is_some()
        || scene
            .stop
            .iter()
            .any(|stop| matches!(stop, StopCondition::Clogged { .. } | StopCondition::EndOfFlow { .. }));
    let Some(width) = door_width(loaded, radius).filter(|_| !expects_clogs && scene.opens_a_door()) else { return };
    let diameters = width / (2.0 * radius);
    if (1.0..CLOGS).contains(&diameters) {
        let kind = if scene.space == Dimension::Plane { "discs" } else { "spheres" };
        warnings.push(Warning {
            code: "check::outlet_clogs",
            message: format!("the outlet is {diameters:.1} grains wide: {kind} form an arch over it sooner or later, and the flow stops"),
            help: "widen the door to five grains or more; or add `stop: [Clogged(still: 2.0)]`, which ends a run at a clog".to_owned(),
        });
    }
}

fn short_step(loaded: &Loaded, estimates: &Estimates, warnings: &mut Vec<Warning>) {
    let limit = estimates.pair_limit.min(estimates.bed_limit);
    let steps = loaded.scene.until.get() / estimates.dt;
    if limit.is_finite() && limit / estimates.dt > SHORT {
        warnings.push(Warning {
            code: "check::short_step",
            message: format!(
                "the step of {:.1e} s is {:.0e} times shorter than the stability limit, {limit:.1e} s: up to `until` the run takes {steps:.1e} steps",
                estimates.dt,
                limit / estimates.dt
            ),
            help: "is `step` in s? `step: Auto(error: 1.0e-3)` chooses one".to_owned(),
        });
    }
}

#[cfg(test)]
mod tests {
    use crate::scene::check::warnings;
    use crate::scene::load::from_text;

    /// The codes of the warnings about a planar scene with these further keys.
    fn codes(keys: &str) -> Vec<&'static str> {
        let text = format!(
            "(contact: Linear(k: 1.0e4, damping: Restitution(0.5)), mass: Disc(2500.0), until: 1.0, pictures: None, cull: (below: -1.0),
              walls: [Segment(from: (-0.5, 0.0), to: (-0.05, 0.0)), Segment(from: (0.05, 0.0), to: (0.5, 0.0)),
                  Segment(from: (-0.5, 0.0), to: (-0.5, 1.0)), Segment(from: (0.5, 0.0), to: (0.5, 1.0)),
                  Segment(from: (-0.05, 0.0), to: (0.05, 0.0), door: true)],
              rest: (speed: 0.1, energy: 1.0e-3, hold: 0.1), door: (opens: AtRest), {keys})"
        );
        let loaded = from_text("a.ron", "a", std::path::Path::new("."), text, &[]).unwrap();
        warnings(&loaded).into_iter().map(|warning| warning.code).collect()
    }

    const DOWN: &str = "gravity: (0.0, -9.81), step: Fixed(1.0e-5)";

    fn fill(radius: f64) -> String {
        format!("fill: [(low: (-0.4, 0.1), high: (0.4, 0.5), place: Random, count: 5, radius: Fixed({radius}))]")
    }

    #[test]
    fn mistakes_of_a_beginner_are_told() {
        let sound = codes(&format!("{DOWN}, {}", fill(0.01)));
        assert!(
            !sound
                .iter()
                .any(|code| ["check::gravity_upwards", "check::outlet_clogs", "check::short_step"].contains(code)),
            "{sound:?}"
        );
        let cases = [
            (format!("gravity: (0.0, 9.81), step: Fixed(1.0e-5), {}", fill(0.01)), "check::heights_across_gravity"),
            (format!("{DOWN}, {}", fill(0.02)), "check::outlet_clogs"),
            (format!("gravity: (0.0, -9.81), step: Fixed(4.0e-12), {}", fill(0.01)), "check::short_step"),
            (
                format!(
                    "{DOWN}, feed: [(region: Box(low: (3.0, 1.0), high: (3.2, 1.2)), rate: Grains(10.0), total: Grains(5), radius: Fixed(0.01), velocity: (0.0, 0.0))]"
                ),
                "check::feed_outside",
            ),
            (
                format!(
                    "{DOWN}, feed: [(region: Box(low: (-0.1, -2.0), high: (0.1, -1.8)), rate: Grains(10.0), total: Grains(5), radius: Fixed(0.01), velocity: (0.0, 0.0))]"
                ),
                "check::feed_outside",
            ),
        ];
        for (keys, code) in cases {
            let found = codes(&keys);
            assert!(found.contains(&code), "{code}: {found:?}");
        }
        let clogging = codes(&format!("{DOWN}, stop: [Clogged(still: 1.0)], {}", fill(0.02)));
        assert!(!clogging.contains(&"check::outlet_clogs"), "{clogging:?}");
    }
}
