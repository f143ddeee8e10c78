//! Rules on holes and patches of walls.

use super::directions::{has_no_direction, is_oblique};
use crate::scene::loaded::Loaded;
use siloflow_dem::space::Solid;
use siloflow_dem::walls::config::cut::Cut;
use siloflow_dem::walls::config::geometry::Cuts;
use siloflow_dem::walls::config::shape::WallShape;
use siloflow_dem::walls::shapes::trimmed::RimFault;
use siloflow_text::fault::Fault;

/// A hole lies on its wall as a whole, and the wall meets its outline from one side.
pub(super) fn cuts(loaded: &Loaded) -> Result<(), Fault> {
    for (index, wall) in loaded.scene.walls.iter().enumerate() {
        let Some((key, cut)) = (match wall.shape.cuts() {
            Cuts { hole: Some(hole), patch: None } => Some(("hole", hole)),
            Cuts { patch: Some(patch), .. } => Some(("patch", patch)),
            Cuts { hole: None, patch: None } => None,
        }) else {
            continue;
        };
        if let Some((of_cut, message, help)) = broken(&wall.shape, cut) {
            let key = format!("walls[{index}].{key}{of_cut}");
            return Err(loaded.fault("scene::cut", &key, message).help(help));
        }
    }
    Ok(())
}

/// Returns the fault of a hole or patch: the key behind its own one, a message and a help.
fn broken(shape: &WallShape, cut: &Cut) -> Option<(&'static str, String, &'static str)> {
    if let Cuts { hole: Some(_), patch: Some(_) } = shape.cuts() {
        let message = "a wall has a hole, or it is a patch".to_owned();
        return Some(("", message, "give two walls of the same shape: one with the hole, the other with the patch"));
    }
    if shape.moves_in_place() {
        let message = "a wall with a hole does not keep its place when it spins".to_owned();
        return Some(("", message, "give the wall a name, and turn it by `motions`"));
    }
    let (of_cut, message) = match cut {
        Cut::Circle { normal: Some(normal), .. } if has_no_direction(normal.padded()) => {
            (".normal", "the normal has no direction")
        }
        Cut::Rectangle { along, .. } if has_no_direction(along.padded()) => (".along", "the rectangle has no length"),
        Cut::Rectangle { across, .. } if has_no_direction(across.padded()) => (".across", "the rectangle has no width"),
        Cut::Rectangle { along, across, .. } if is_oblique(along.padded(), across.padded()) => {
            (".across", "the edges of a rectangle must be at right angles to each other")
        }
        Cut::Circle { normal: None, centre, .. } if is_on_the_axis(shape, centre.padded()) => {
            let message = "the centre is on the axis of the wall, so the wall does not tell on which side the hole is";
            return Some((".centre", message.to_owned(), "move the centre towards the wall, or add a `normal`"));
        }
        _ => return off_the_wall(shape),
    };
    Some((of_cut, message.to_owned(), "give a direction, or two edges at right angles, of non-zero lengths"))
}

/// Whether a point is on the axis of a cylinder, to rounding.
fn is_on_the_axis(shape: &WallShape, x: Solid) -> bool {
    let WallShape::Cylinder { from, to, radius, .. } = shape else { return false };
    let arm = x - from.padded();
    let axis = (to.padded() - from.padded()).normalize_or_zero();
    (arm - axis * arm.dot(axis)).length() <= 1e-9 * radius.get()
}

fn off_the_wall(shape: &WallShape) -> Option<(&'static str, String, &'static str)> {
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
