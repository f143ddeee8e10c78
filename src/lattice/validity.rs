//! Rules across the keys of a scene of the lattice gas: what one number's range cannot say.

use crate::fault::Fault;
use crate::lattice::door::DoorOpens;
use crate::lattice::load::{LoadedLattice, polygon};
use crate::lattice::sites::Sites;
use crate::space::Plane;

/// Sites of the largest lattice.
const MOST_SITES: usize = 100_000_000;

/// Checks a scene.
///
/// # Errors
/// The first rule that it breaks, pointing at the key.
pub(super) fn check(loaded: &LoadedLattice) -> Result<(), Fault> {
    outline(loaded)?;
    door(loaded)?;
    particles(loaded)?;
    outputs(loaded)
}

fn outline(loaded: &LoadedLattice) -> Result<(), Fault> {
    let named = loaded.scene.inserts.iter().enumerate().map(|(n, corners)| (format!("inserts[{n}]"), corners));
    for (key, corners) in std::iter::once(("outline".to_owned(), &loaded.scene.outline)).chain(named) {
        let is_planar = corners.iter().all(|corner| corner.count() == 2);
        if !is_planar || corners.len() < 3 || polygon(corners).area() == 0.0 {
            let message = "expected a polygon of at least three corners (x, y) that encloses an area";
            return Err(loaded.fault("scene::degenerate_wall", &key, message, "give the corners in turn, in m"));
        }
    }
    let (columns, rows) = Sites::extent(&loaded.outline(), loaded.rules.spacing.get());
    if columns.saturating_mul(rows) > MOST_SITES {
        let message = format!("{columns} columns of {rows} sites are more than {MOST_SITES} sites");
        return Err(loaded.fault("scene::out_of_range", "method.spacing", message, "give a larger spacing, in m"));
    }
    if loaded.sites().runs.is_empty() {
        let message = "no site of the lattice is inside the outline";
        return Err(loaded.fault(
            "scene::empty_box",
            "outline",
            message,
            "give a smaller `spacing` or a larger outline",
        ));
    }
    Ok(())
}

fn door(loaded: &LoadedLattice) -> Result<(), Fault> {
    let scene = &loaded.scene;
    let Some(door) = scene.door else {
        if scene.discharge.is_some() {
            let message = "a run ends so many steps after the door has opened, but there is no door";
            return Err(loaded.fault("scene::no_door", "discharge", message, "add `door`, or remove `discharge`"));
        }
        return Ok(());
    };
    let is_planar = door.from.count() == 2 && door.to.count() == 2;
    if !is_planar || door.from == door.to {
        let message = "the door goes from one place (x, y) to another";
        return Err(loaded.fault("scene::degenerate_wall", "door", message, "give two different places, in m"));
    }
    if loaded.sites().doorway.is_empty() {
        let message = "there is no site to go out by: the door is not on the outline";
        return Err(loaded.fault(
            "scene::no_door",
            "door",
            message,
            "give two places on one edge of the outline, in m",
        ));
    }
    if door.opens == DoorOpens::AtRest && scene.rest.is_none() {
        let message = "the door opens at rest, but nothing detects rest";
        return Err(loaded.fault("scene::missing_key", "rest", message, "add `rest: (hold: 800)`, in steps"));
    }
    Ok(())
}

fn particles(loaded: &LoadedLattice) -> Result<(), Fault> {
    let scene = &loaded.scene;
    for (n, thrown) in scene.particles.iter().enumerate() {
        if thrown.velocity > 12 {
            let (key, message) = (format!("particles[{n}].velocity"), "expected a direction from 0 (at rest) to 12");
            return Err(loaded.fault("scene::out_of_range", &key, message, "1 is up, 4 is down, 7 obliquely up"));
        }
        let is_inside = thrown.at.count() == 2 && loaded.outline().holds(thrown.at.get::<Plane>(), 0.0);
        if !is_inside {
            let message = "the particle is not inside the outline";
            return Err(loaded.fault("scene::outside", &format!("particles[{n}].at"), message, "give (x, y) in m"));
        }
    }
    let full = 13.0;
    let wanted = [("fill", scene.fill.map(|f| f.per_site)), ("pour", scene.pour.map(|p| p.per_site))];
    for (key, per_site) in wanted {
        if per_site.is_some_and(|per_site| per_site.get() > full) {
            let message = "a site holds at most 13 particles";
            return Err(loaded.fault("scene::out_of_range", &format!("{key}.per_site"), message, "6 is usual"));
        }
    }
    if scene.fill.is_none() && scene.pour.is_none() && scene.particles.is_empty() {
        let message = "nothing enters: there are no particles";
        return Err(loaded.fault(
            "scene::missing_key",
            "fill",
            message,
            "add `fill: (per_site: 6.0)`, `pour` or `particles`",
        ));
    }
    Ok(())
}

fn outputs(loaded: &LoadedLattice) -> Result<(), Fault> {
    if let Some(pictures) = &loaded.scene.pictures
        && !(50.0..=20_000.0).contains(&pictures.width.get())
    {
        let message = "expected a width of 50 to 20000 px";
        return Err(loaded.fault("scene::out_of_range", "pictures.width", message, "480 is a good width"));
    }
    let Some(flow) = loaded.scene.flow else { return Ok(()) };
    if flow.from >= flow.to {
        let message = format!("the window is empty: it begins at {} and ends at {}", flow.from.get(), flow.to.get());
        return Err(loaded.fault("scene::out_of_range", "flow.to", message, "give a share above `flow.from`"));
    }
    if flow.from.get() > 0.0 && loaded.scene.door.is_none() {
        let message = "no particle will ever be out: there is no door";
        return Err(loaded.fault("scene::no_door", "flow", message, "add `door`, or write `from: 0.0`"));
    }
    Ok(())
}
