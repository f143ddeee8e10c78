//! Rules between the keys of a lattice-gas scene, beyond the range of each single value.

use std::collections::HashSet;

use crate::lattice_silo::door::DoorOpens;
use crate::lattice_silo::enter::Thrown;
use crate::lattice_silo::limits;
use crate::lattice_silo::loaded::{LoadedLattice, polygon};
use crate::lattice_silo::scene::LatticeScene;
use siloflow_lattice::outline::distance;
use siloflow_lattice::rules::Rules;
use siloflow_text::fault::Fault;
use siloflow_text::source::Source;

/// Checks the polygons, the door and the number of sites, before the sites are created.
///
/// # Errors
/// The first rule that is broken, pointing at the key.
pub(super) fn shapes(scene: &LatticeScene, rules: &Rules, source: &Source) -> Result<(), Fault> {
    limits::corners(scene, source)?;
    let named = scene.inserts.iter().enumerate().map(|(n, corners)| (format!("inserts[{n}]"), corners));
    for (key, corners) in std::iter::once(("outline".to_owned(), &scene.outline)).chain(named) {
        let is_planar = corners.iter().all(|corner| corner.count() == 2);
        let polygon = polygon(corners);
        let (message, help) = if !is_planar || polygon.0.len() < 3 {
            (
                "expected a polygon of at least three corners (x, y)",
                "give the corners in order along the boundary, in m",
            )
        } else if polygon.crosses_itself() || polygon.area() == 0.0 {
            ("the edges of the polygon cross or touch each other", "give the corners in order along the boundary")
        } else {
            continue;
        };
        return Err(source.fault("scene::degenerate_wall", &key, message).help(help));
    }
    if let Some(door) = scene.door
        && (door.from.count() != 2 || door.to.count() != 2 || door.from == door.to)
    {
        let message = "expected two different points (x, y) as the ends of the door";
        return Err(source.fault("scene::degenerate_wall", "door", message).help("give `from` and `to`, in m"));
    }
    limits::sites(scene, rules, source)
}

/// Checks a scene after its sites have been created.
///
/// # Errors
/// The first rule that is broken, pointing at the key.
pub(super) fn check(loaded: &LoadedLattice) -> Result<(), Fault> {
    if loaded.sites.runs.is_empty() {
        let message = "no site of the lattice is inside the outline";
        let help = "give a smaller `spacing` or a larger outline";
        return Err(loaded.fault("scene::empty_box", "outline", message, help));
    }
    if loaded.scene.until == 0 {
        let message = "a run needs at least one step";
        return Err(loaded.fault("scene::out_of_range", "until", message, "give the number of the last step"));
    }
    door(loaded)?;
    particles(loaded)?;
    outputs(loaded)
}

fn door(loaded: &LoadedLattice) -> Result<(), Fault> {
    let scene = &loaded.scene;
    let Some(door) = scene.door else {
        if scene.discharge.is_some() {
            let message = "`discharge` counts steps from the opening of the door, but there is no door";
            return Err(loaded.fault("scene::no_door", "discharge", message, "add `door`, or remove `discharge`"));
        }
        return Ok(());
    };
    // The tolerance allows for coordinates that the scene gives with a few digits only.
    let ends = door.ends();
    let near = 0.5 * loaded.rules.spacing.get();
    let is_on = |edge| distance(ends.0, edge) <= near && distance(ends.1, edge) <= near;
    if !loaded.outline().edges().any(is_on) || loaded.sites.doorway.is_empty() {
        let message = "the door is not on an edge of the outline";
        return Err(loaded.fault(
            "scene::no_door",
            "door",
            message,
            "give two points on one edge of the outline, in m",
        ));
    }
    if door.opens == DoorOpens::AtRest && scene.rest.is_none() {
        let message = "the door opens at rest, but the scene has no `rest`";
        return Err(loaded.fault("scene::missing_key", "rest", message, "add `rest: (hold: 800)`, in steps"));
    }
    Ok(())
}

/// Returns the start site of a single particle: the nearest fluid site. `None` if it is more than a spacing away, or
/// the particle's place is not two-dimensional.
fn site_of(loaded: &LoadedLattice, thrown: &Thrown) -> Option<usize> {
    let at = thrown.at.padded().truncate();
    let site = loaded.sites.nearest(at).filter(|_| thrown.at.count() == 2)?;
    (loaded.sites.position(site).distance(at) <= loaded.rules.spacing.get()).then_some(site)
}

fn particles(loaded: &LoadedLattice) -> Result<(), Fault> {
    let scene = &loaded.scene;
    let mut taken = HashSet::new();
    for (n, thrown) in scene.particles.iter().enumerate() {
        if thrown.velocity > 12 {
            let key = format!("particles[{n}].velocity");
            let message = "expected a direction from 0 (at rest) to 12";
            return Err(loaded.fault("scene::out_of_range", &key, message, "1 is up, 4 is down, 7 obliquely up"));
        }
        let key = format!("particles[{n}].at");
        let Some(site) = site_of(loaded, thrown) else {
            let message = "there is no site for the particle: it is not inside the silo";
            return Err(loaded.fault(
                "scene::outside",
                &key,
                message,
                "give (x, y) in m, inside the outline and outside all inserts",
            ));
        };
        if !taken.insert((site, thrown.velocity)) {
            let message = "another particle of the scene has this site and this velocity";
            return Err(loaded.fault(
                "scene::two_at_one_place",
                &key,
                message,
                "a site holds one particle of each velocity",
            ));
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
        let message = "the scene has no particles";
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
    limits::check(loaded)?;
    let Some(flow) = loaded.scene.flow else { return Ok(()) };
    if flow.from >= flow.to {
        let message = format!("the window is empty: it begins at {} and ends at {}", flow.from.get(), flow.to.get());
        return Err(loaded.fault("scene::out_of_range", "flow.to", message, "give a share above `flow.from`"));
    }
    let sample = flow.sample.get();
    let spacing = loaded.rules.spacing.get();
    if sample < 1.0 || sample.fract() != 0.0 {
        let message = format!("expected a whole number of steps, got {sample}");
        return Err(loaded.fault("scene::out_of_range", "flow.sample", message, "5.0 is usual"));
    }
    if flow.cell.get() < spacing {
        let message = format!("cells of {} m are smaller than the spacing of the sites, {spacing} m", flow.cell.get());
        return Err(loaded.fault(
            "scene::out_of_range",
            "flow.cell",
            message,
            "give cells as large as several sites, in m",
        ));
    }
    if flow.from.get() > 0.0 && loaded.scene.door.is_none() {
        let message = "no particle can leave: there is no door";
        return Err(loaded.fault("scene::no_door", "flow", message, "add `door`, or write `from: 0.0`"));
    }
    Ok(())
}
