//! Warnings about a lattice-gas scene that need no run.

use crate::lattice_silo::door::DoorOpens;
use crate::lattice_silo::loaded::LoadedLattice;
use crate::lattice_silo::rest::Rest;
use siloflow_text::fault::Warning;

/// Returns the thickness of the layer over which the density falls to 0 at the surface, m. It is about 12/g sites,
/// because a site gets one kick a step with probability g, against at most 12 movers. `None` if g = 0.
#[must_use]
pub fn diffuse_layer(loaded: &LoadedLattice) -> Option<f64> {
    let g = loaded.rules.g.get();
    (g > 0.0).then(|| 12.0 / g * loaded.rules.spacing.get())
}

/// Returns warnings about effects of the scene that its author may not want.
#[must_use]
pub fn warnings(loaded: &LoadedLattice) -> Vec<Warning> {
    let scene = &loaded.scene;
    let rules = &loaded.rules;
    let (low, high) = loaded.outline().bounds();
    let height = high.y - low.y;
    let layer = diffuse_layer(loaded).unwrap_or(f64::INFINITY);
    let mut warnings = loaded.source.unused_parameters();
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
            "with h = 0 a stopped particle moves again only in a collision: the silo will not run empty".to_owned(),
            "give a small `h` above 0, unless h = 0 is intended",
        );
    }
    if let Some(door) = scene.door {
        let opens = opens(door.opens, scene.rest);
        if opens.is_some_and(|step| step >= scene.until) || (opens.is_none() && scene.discharge.is_some()) {
            warn(
                "check::never_opens",
                format!("the run ends at step {}, before the door opens", scene.until),
                "raise `until`, lower `rest.hold`, or change `door.opens`",
            );
        }
        if door.opens == DoorOpens::AtRest && scene.rest.is_some_and(|rest| rest.stop) {
            warn(
                "check::ends_at_rest",
                "the run ends at rest, in the step in which the door opens: nothing will flow".to_owned(),
                "remove `rest.stop`, or the door",
            );
        }
    }
    if scene.pour.is_some_and(|pour| pour.chance.get() == 0.0) {
        warn("check::no_pour", "no particle is poured: `pour.chance` is 0".to_owned(), "raise `pour.chance`");
    }
    warnings
}

/// Returns the earliest step in which the door can open; `None` if it never opens.
fn opens(when: DoorOpens, rest: Option<Rest>) -> Option<u64> {
    match when {
        DoorOpens::AtRest => rest.map(|rest| rest.hold),
        DoorOpens::At(step) => Some(step),
        DoorOpens::Never => None,
    }
}
