//! Seams: where wall surfaces meet, a grain touches their union, not each of them.
//!
//! A grain touches a surface at its nearest point p. If p lies on an edge and another wall passes through p, p is a point
//! of the union at which a grain is in contact only if no point of that other wall beside p is nearer. So the contact
//! at p is left out if the other wall comes nearer to the centre, or as near with a point that is not on its edge. If both
//! are equally near at an edge of both, the wall that comes first in the scene has the contact.
//!
//! So there is one contact on a flat seam and round a convex edge, and one for each wall in a concave corner.
//!
//! Limit: where two walls of the scene meet in a concave seam of less than about 3 degrees, a contact ends although the
//! grain still overlaps the wall that it leaves, and the forces of both act in a strip beside the seam.

use crate::space::Space;
use crate::walls::surfaces::SurfaceWall;

/// Largest distance at which a point counts as lying on a wall, in radii of the grain: above the rounding of positions,
/// far below any overlap.
const ON_THE_WALL: f64 = 1e-9;

/// Returns the wall that replaces wall `index` in a contact at the edge point `x - away`, or `None` if the contact counts. `x`
/// is the centre of a grain of this radius, m. `others` are the walls that the grain touches, with their distances (m) and
/// whether their nearest points are on an edge.
#[cold]
pub(crate) fn continued_by<V: Space>(
    walls: &[SurfaceWall<V>],
    index: usize,
    others: impl Iterator<Item = (usize, f64, bool)>,
    (x, radius): (V, f64),
    away: V,
) -> Option<usize> {
    let (point, distance, tolerance) = (x - away, away.length(), ON_THE_WALL * radius);
    let rank = |(other, its_distance, at_edge): (usize, f64, bool)| {
        let lead = distance - its_distance;
        let comes_first = lead > tolerance || (lead >= -tolerance && (!at_edge || other < index));
        let passes = other != index && comes_first && walls[other].surface.distance(point) <= tolerance;
        passes.then_some((lead, other))
    };
    others.filter_map(rank).max_by(|a, b| a.0.total_cmp(&b.0).then(b.1.cmp(&a.1))).map(|(_, other)| other)
}
