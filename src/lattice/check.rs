//! What can be told of a scene of the lattice gas before a run.

use crate::fault::Warning;
use crate::lattice::door::DoorOpens;
use crate::lattice::load::LoadedLattice;
use crate::lattice::rest::Rest;

/// Thickness of the layer over which the density falls off at the surface, m: one kick a site and step, with probability g,
/// against at most 12 movers, so about 12/g sites. `None` without gravity.
#[must_use]
pub fn diffuse_layer(loaded: &LoadedLattice) -> Option<f64> {
    let g = loaded.rules.g.get();
    (g > 0.0).then(|| 12.0 / g * loaded.rules.spacing.get())
}

/// What to expect of this scene that its author may not want.
#[must_use]
pub fn warnings(loaded: &LoadedLattice) -> Vec<Warning> {
    let (scene, rules) = (&loaded.scene, &loaded.rules);
    let (low, high) = loaded.outline().bounds();
    let (height, layer) = (high.y - low.y, diffuse_layer(loaded).unwrap_or(f64::INFINITY));
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
    if let Some(door) = scene.door {
        let opens = opens(door.opens, scene.rest);
        if opens.is_some_and(|step| step >= scene.until) || (opens.is_none() && scene.discharge.is_some()) {
            warn(
                "check::never_opens",
                format!("the run ends at step {}, before the door opens", scene.until),
                "raise `until`, let the door open, or lower `rest.hold`",
            );
        }
        if door.opens == DoorOpens::AtRest && scene.rest.is_some_and(|rest| rest.stop) {
            warn(
                "check::ends_at_rest",
                "the run ends at rest, when the door opens: nothing will flow".to_owned(),
                "remove `rest.stop`, or the door",
            );
        }
    }
    if scene.pour.is_some_and(|pour| pour.chance.get() == 0.0) {
        warn("check::no_pour", "nothing is ever poured: the chance is 0".to_owned(), "raise `pour.chance`");
    }
    warnings
}

/// The earliest step in which the door may open.
fn opens(when: DoorOpens, rest: Option<Rest>) -> Option<u64> {
    match when {
        DoorOpens::AtRest => rest.map(|rest| rest.hold),
        DoorOpens::At(step) => Some(step),
        DoorOpens::Never => None,
    }
}
