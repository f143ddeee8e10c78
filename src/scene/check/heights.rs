//! Whether gravity points along the axis of heights. Heights are coordinates on the last axis, y in the plane and z in solid space, whatever
//! gravity does. On an incline they may be tilted, so a warning begins at [`STEEP`].

use crate::ending::stop::conditions::StopCondition;
use crate::scene::loaded::Loaded;
use siloflow_dem::space::{Dimension, Solid, Space as _};
use siloflow_dem::walls::config::Wall;
use siloflow_text::fault::Warning;

/// Cosine of the angle between gravity and downwards from which on the scene has another axis of heights in mind: 60 degrees.
const STEEP: f64 = 0.5;

/// Adds the warning.
pub(super) fn examine(loaded: &Loaded, warnings: &mut Vec<Warning>) {
    let up = loaded.scene.space.count() - 1;
    let gravity = loaded.scene.gravity.padded().unit_or_zero();
    if gravity == Solid::ZERO || -gravity.to_array()[up] >= STEEP {
        return;
    }
    let users = users_of_heights(loaded);
    if users.is_empty() {
        return;
    }
    let axis = ["x", "y", "z"][up];
    warnings.push(Warning {
        code: "check::heights_across_gravity",
        message: format!(
            "gravity points along {}, but heights are along {axis}, with {axis} upwards: {} would not see what falls",
            direction(gravity),
            users.join(", ")
        ),
        help: format!(
            "turn the scene so that gravity points along -{axis}; or leave out these keys, and end the scene with walls that hold \
             all grains"
        ),
    });
}

/// The axis along which a unit vector points, or the vector.
fn direction(unit: Solid) -> String {
    let parts = unit.to_array();
    let along = (0..3).find(|&axis| parts[axis].abs() > 1.0 - 1e-6);
    along.map_or_else(
        || format!("({:.3}, {:.3}, {:.3})", parts[0], parts[1], parts[2]),
        |axis| format!("{}{}", if parts[axis] < 0.0 { "-" } else { "+" }, ["x", "y", "z"][axis]),
    )
}

/// Returns the keys and searches of a scene that read heights.
fn users_of_heights(loaded: &Loaded) -> Vec<&'static str> {
    let scene = &loaded.scene;
    let is_planar = scene.space == Dimension::Plane;
    let has_walls = scene.walls.iter().any(Wall::is_surface) || !loaded.wall_discs().is_empty();
    let counts_above = |condition: &StopCondition| matches!(condition, StopCondition::Clogged { .. });
    [
        (scene.cull.is_some(), "`cull`"),
        (!scene.wall_bands.is_empty(), "`wall_bands`"),
        (scene.outflow.is_some_and(|outflow| outflow.mass_flow.is_some()), "`outflow.mass_flow`"),
        (scene.bed.is_some(), "`bed`"),
        (!scene.slopes.is_empty(), "`slopes`"),
        (scene.stop.iter().any(counts_above), "`stop: [Clogged(...)]`"),
        (scene.kick.is_some(), "`kick`"),
        (is_planar && has_walls && scene.periodic.is_open(), "the search for grains that are lost past the walls"),
    ]
    .into_iter()
    .filter_map(|(uses, name)| uses.then_some(name))
    .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::load::from_text;

    /// Returns the warning about a scene in solid space with this gravity and these further keys.
    fn found(gravity: &str, keys: &str) -> Option<String> {
        let text = format!(
            "(space: Solid, gravity: {gravity}, contact: Linear(k: 1.0e4, damping: Restitution(0.5)), step: Fixed(1.0e-5),
              walls: [HalfPlane(point: (0.0, 0.0, 0.0), normal: (0.0, 1.0, 0.0))], until: 1.0, pictures: None, {keys})"
        );
        let loaded = from_text("heights.ron", "heights", std::path::Path::new("."), text, &[]).unwrap();
        let mut warnings = Vec::new();
        examine(&loaded, &mut warnings);
        warnings.pop().map(|warning| warning.message)
    }

    #[test]
    fn gravity_across_the_heights_is_told_to_those_who_use_heights() {
        let said = found("(0.0, -9.81, 0.0)", "cull: (below: -0.1)").expect("a warning");
        assert!(said.contains("along -y") && said.contains("along z") && said.contains("`cull`"), "{said}");
        assert!(found("(0.0, 0.0, 9.81)", "cull: (below: -0.1)").expect("upwards").contains("along +z"));
        // Nothing reads a height; no gravity; an incline of 30 degrees.
        assert_eq!(found("(0.0, -9.81, 0.0)", ""), None);
        assert_eq!(found("(0.0, 0.0, 0.0)", "cull: (below: -0.1)"), None);
        assert_eq!(found("(4.9, 0.0, -8.5)", "cull: (below: -0.1)"), None);
    }
}
