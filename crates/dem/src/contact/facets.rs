//! Facets: triangles of one wall that stand for a curved surface.
//!
//! Two contacts of a grain belong together if their walls are facets of one wall and their normals differ by less than 15
//! degrees. Of all contacts that are linked in this way, through others as well, the grain keeps the one with the nearest
//! facet alone: in a hollow of facets, several forces would act beside every seam. The energy of the contact is then that
//! of the distance from the union of the linked facets, which has no jump where the nearest facet changes.

use crate::space::Space;
use crate::walls::surface_wall::SurfaceWall;

/// Cosine of 15 degrees: facets that meet at a smaller angle stand for a smooth surface.
const SMOOTH: f64 = 0.965_925_826_289_068_3;

/// A wall that a grain touches: its index, the unit normal, and the distance of the grain's centre, m.
pub(super) type Touch<V> = (usize, V, f64);

/// Returns, for each wall that a grain touches, the place of the one that has the contact: its own, or that of a nearer
/// facet of the same smooth surface.
pub(super) fn nearest_facets<V: Space>(walls: &[SurfaceWall<V>], touches: &[Touch<V>]) -> Vec<usize> {
    let linked = |(one, normal, _): &Touch<V>, (other, beside, _): &Touch<V>| {
        walls[*one].number == walls[*other].number && normal.dot(*beside) > SMOOTH
    };
    let mut nearest_first: Vec<usize> = (0..touches.len()).collect();
    nearest_first.sort_by(|&a, &b| touches[a].2.total_cmp(&touches[b].2));
    let mut holder = vec![usize::MAX; touches.len()];
    let mut reached = Vec::new();
    for nearest in nearest_first {
        if holder[nearest] != usize::MAX {
            continue;
        }
        holder[nearest] = nearest;
        reached.push(nearest);
        while let Some(from) = reached.pop() {
            for to in 0..touches.len() {
                if holder[to] == usize::MAX && linked(&touches[from], &touches[to]) {
                    holder[to] = nearest;
                    reached.push(to);
                }
            }
        }
    }
    holder
}
