//! What can be told of a scene of the lattice gas before a run.

use crate::check::Warning;
use crate::lattice::door::DoorOpens;
use crate::lattice::load::LoadedLattice;

/// Thickness of the layer over which the density falls off at the surface, m: one kick a site and step, with probability g,
/// against at most 12 movers, so about 12/g sites.
#[must_use]
pub fn diffuse_layer(loaded: &LoadedLattice) -> f64 {
    12.0 / loaded.rules.g.get() * loaded.rules.spacing.get()
}

/// What to expect of this scene that its author may not want.
#[must_use]
pub fn warnings(loaded: &LoadedLattice) -> Vec<Warning> {
    let (scene, rules) = (&loaded.scene, &loaded.rules);
    let (low, high) = loaded.outline().bounds();
    let (height, layer) = (high.y - low.y, diffuse_layer(loaded));
    let mut warnings = Vec::new();
    let mut warn = |code, message: String, help: &str| {
        warnings.push(Warning { code, message, help: help.to_owned() });
    };
    let is_filled = scene.fill.is_some() || scene.pour.is_some();
    if is_filled && layer > height {
        warn(
            "check::all_gas",
            format!(
                "the upper layer is about {layer:.2} m thick and the silo {height:.2} m high: there will be no surface"
            ),
            "raise `g`, or lower `spacing`",
        );
    }
    if is_filled && rules.h.get() == 0.0 && rules.p.get() > 0.0 {
        warn(
            "check::stuck_particles",
            "with h = 0 a particle that has stopped moves again only when another meets it: the silo will not run empty"
                .to_owned(),
            "give `h` a little above 0, or take it as a study of h",
        );
    }
    let opens_at_rest = scene.door.is_some_and(|door| door.opens == DoorOpens::AtRest);
    if opens_at_rest && scene.rest.is_some_and(|rest| rest.hold >= scene.until) {
        warn(
            "check::never_opens",
            format!(
                "the door opens at rest, in step {} or later, but the run ends at step {}",
                rest_at(loaded),
                scene.until
            ),
            "raise `until`, or lower `rest.hold`",
        );
    }
    warnings
}

fn rest_at(loaded: &LoadedLattice) -> u64 {
    loaded.scene.rest.map_or(0, |rest| rest.hold)
}
