//! Rules on holes and patches of walls.

use super::directions::{has_no_direction, is_oblique};
use crate::scene::loaded::Loaded;
use siloflow_dem::space::Solid;
use siloflow_dem::walls::config::Wall;
use siloflow_dem::walls::figure::Figure;
use siloflow_dem::walls::shapes::trimmed::RimFault;
use siloflow_dem::walls::surfaces::Surface;
use siloflow_text::fault::Fault;

/// A hole lies on its wall as a whole, and the wall meets its outline from one side.
pub(super) fn cuts(loaded: &Loaded) -> Result<(), Fault> {
    for (index, wall) in loaded.scene.walls.iter().enumerate() {
        let Some((key, figure)) = (match wall.cuts() {
            (Some(hole), None) => Some(("hole", hole)),
            (_, Some(patch)) => Some(("patch", patch)),
            (None, None) => None,
        }) else {
            continue;
        };
        if let Some((of_figure, message, help)) = broken(wall, figure) {
            let key = format!("walls[{index}].{key}{of_figure}");
            return Err(loaded.fault("scene::cut", &key, message).help(help));
        }
    }
    Ok(())
}

/// Returns the fault of a hole or patch: the key behind its own one, a message and a help.
fn broken(wall: &Wall, figure: &Figure) -> Option<(&'static str, String, &'static str)> {
    if let (Some(_), Some(_)) = wall.cuts() {
        let message = "a wall has a hole, or it is a patch".to_owned();
        return Some(("", message, "give two walls of the same shape: one with the hole, the other with the patch"));
    }
    if wall.moves_in_place() {
        let message = "a wall with a hole does not keep its place when it spins".to_owned();
        return Some(("", message, "give the wall a name, and turn it by `motions`"));
    }
    let (of_figure, message) = match figure {
        Figure::Circle { normal: Some(normal), .. } if has_no_direction(normal.padded()) => {
            (".normal", "the normal has no direction")
        }
        Figure::Rectangle { along, .. } if has_no_direction(along.padded()) => {
            (".along", "the rectangle has no length")
        }
        Figure::Rectangle { across, .. } if has_no_direction(across.padded()) => {
            (".across", "the rectangle has no width")
        }
        Figure::Rectangle { along, across, .. } if is_oblique(along.padded(), across.padded()) => {
            (".across", "the edges of a rectangle must be at right angles to each other")
        }
        Figure::Circle { normal: None, centre, .. } if is_on_the_axis(wall, centre.padded()) => {
            let message = "the centre is on the axis of the wall, so the wall does not tell on which side the hole is";
            return Some((".centre", message.to_owned(), "move the centre towards the wall, or add a `normal`"));
        }
        _ => return off_the_wall(wall),
    };
    Some((of_figure, message.to_owned(), "give a direction, or two edges at right angles, of non-zero lengths"))
}

/// Whether a point is on the axis of a cylinder, to rounding.
fn is_on_the_axis(wall: &Wall, x: Solid) -> bool {
    let Wall::Cylinder { from, to, radius, .. } = wall else { return false };
    let arm = x - from.padded();
    let axis = (to.padded() - from.padded()).normalize_or_zero();
    (arm - axis * arm.dot(axis)).length() <= 1e-9 * radius.get()
}

fn off_the_wall(wall: &Wall) -> Option<(&'static str, String, &'static str)> {
    let surface = wall.surfaces::<Solid>(0).pop()?.surface;
    let Surface::Trimmed(shape) = surface else { return None };
    let place = |x: Solid| format!("({:.3e}, {:.3e}, {:.3e}) m", x.x, x.y, x.z);
    Some(match shape.rim_fault()? {
        RimFault::OffTheSurface(x) => (
            "",
            format!("its outline leaves the wall or reaches the edge of the wall, near {}", place(x)),
            "make it smaller, or move it, so that the wall surrounds it",
        ),
        RimFault::Grazing(x) => (
            "",
            format!("the wall is nearly parallel to the normal of the outline near {}", place(x)),
            "make it smaller, or turn it towards the wall",
        ),
    })
}
