//! Rules on walls: on the numbers of each shape, on names, and on the number of wall discs.

use crate::scene::loaded::Loaded;
use crate::scene::rules::directions::{has_no_direction, is_oblique};
use siloflow_dem::space::Dimension;
use siloflow_dem::walls::config::shape::WallShape;
use siloflow_text::fault::Fault;

/// Most corners of a polygon and of its hole.
const MOST_CORNERS: usize = 500;

fn polygon(loaded: &Loaded, index: usize, shape: &WallShape) -> Result<(), Fault> {
    let WallShape::Polygon { points, hole } = shape else { return Ok(()) };
    let fault = |code, message| Err(loaded.fault(code, &format!("walls[{index}].points"), message));
    if points.len().max(hole.len()) > MOST_CORNERS {
        let message = format!("{} corners are more than the limit of {MOST_CORNERS}", points.len().max(hole.len()));
        return fault("scene::out_of_range", message).map_err(|fault| fault.help("divide the polygon"));
    }
    shape.triangles().map(drop).or_else(|message| {
        fault("scene::degenerate_wall", message).map_err(|fault| {
            fault.help("give at least three corners in one plane, in order round the polygon, and a hole inside")
        })
    })
}

/// A shape has an extent, and its vectors have directions.
pub(super) fn shapes(loaded: &Loaded) -> Result<(), Fault> {
    let largest = loaded.grain_radii().map_or(0.0, |(_, largest)| largest);
    for (index, wall) in loaded.scene.walls.iter().enumerate() {
        polygon(loaded, index, &wall.shape)?;
        let (key, message) = match &wall.shape {
            WallShape::HalfPlane { normal, .. } if has_no_direction(normal.padded()) => {
                ("normal", "the normal has no direction")
            }
            WallShape::HalfPlane { normal, velocity: Some(velocity), .. }
                if is_oblique(velocity.padded(), normal.padded()) =>
            {
                ("velocity", "a half-plane moves along itself only: its velocity must be at right angles to its normal")
            }
            WallShape::Segment { from, to, .. } if has_no_direction(to.padded() - from.padded()) => {
                ("to", "the segment has no length")
            }
            WallShape::Panel { along, .. } if has_no_direction(along.padded()) => ("along", "the panel has no length"),
            WallShape::Panel { across, .. } if has_no_direction(across.padded()) => {
                ("across", "the panel has no width")
            }
            WallShape::Panel { along, across, .. } if is_oblique(along.padded(), across.padded()) => {
                ("across", "the edges of a panel must be at right angles to each other")
            }
            WallShape::Cylinder { from, to, .. } | WallShape::Cone { from, to, .. }
                if has_no_direction(to.padded() - from.padded()) =>
            {
                ("to", "the axis has no length")
            }
            WallShape::Cone { radii, .. } if radii.0.get() == 0.0 && radii.1.get() == 0.0 => {
                ("radii", "the cone has no width")
            }
            WallShape::Annulus { normal, .. } if has_no_direction(normal.padded()) => {
                ("normal", "the normal has no direction")
            }
            WallShape::Annulus { inner: Some(inner), outer, .. } if inner.get() >= outer.get() => {
                ("inner", "the hole is as wide as the ring")
            }
            WallShape::SphericalZone { axis: Some(axis), .. } if has_no_direction(axis.padded()) => {
                ("axis", "the axis has no direction")
            }
            WallShape::SphericalZone { radius, .. } if radius.get() <= largest => {
                ("radius", "a grain of the scene is as large as the sphere: a wall of this size is a fixed `Sphere`")
            }
            WallShape::SphericalZone { heights: Some((low, high)), radius, .. }
                if low.get() >= high.get() || low.get() >= radius.get() || high.get() <= -radius.get() =>
            {
                ("heights", "no part of the sphere lies between these heights")
            }
            _ => continue,
        };
        return Err(loaded.fault("scene::degenerate_wall", &format!("walls[{index}].{key}"), message).help(
            "give two different points, a normal with a direction, edges and belts at right angles, inner < outer, \
             heights from low to high",
        ));
    }
    Ok(())
}

/// Most wall discs of a planar scene. Each pair of them is compared, to find the outline.
const MOST_WALL_DISCS: usize = 20_000;

/// A name of a wall stands in CSV files and messages.
pub(super) fn names(loaded: &Loaded) -> Result<(), Fault> {
    let is_plain = |letter: char| letter.is_alphanumeric() || " -_.".contains(letter);
    for (index, wall) in loaded.scene.walls.iter().enumerate() {
        let Some(name) = wall.name() else { continue };
        if name.is_empty() || name.chars().count() > 60 || !name.chars().all(is_plain) {
            let message = format!("{name:?} is no name of a wall");
            return Err(loaded
                .fault("scene::wall_name", &format!("{}.name", loaded.key_of_wall(index)), message)
                .help("give 1 to 60 letters, digits, blanks, or characters of `-_.`"));
        }
    }
    Ok(())
}

/// The walls and wall grains are not too many.
pub(super) fn discs(loaded: &Loaded) -> Result<(), Fault> {
    let of_fills = loaded.walls_of_fills.len();
    // Number of walls or wall grains by key, and whether they are only wall grains, which in solid space have no outline.
    let counts = [
        ("silo.file", loaded.silo.wall.len() + loaded.silo.door.len(), true),
        ("fill", loaded.fixed.len(), true),
        ("fill", of_fills, false),
        ("walls", loaded.scene.walls.len() - of_fills, false),
    ];
    let total: usize = counts.iter().map(|(_, count, _)| count).sum();
    let most = counts.into_iter().max_by_key(|(_, count, _)| *count);
    let Some((key, _, are_grains)) = most.filter(|_| total > MOST_WALL_DISCS) else {
        return Ok(());
    };
    if loaded.scene.space == Dimension::Solid && are_grains {
        return Ok(());
    }
    let message = format!("{total} walls and wall grains are more than the limit of {MOST_WALL_DISCS}");
    Err(loaded.fault("scene::out_of_range", key, message).help("describe the walls by segments, or by larger discs"))
}
