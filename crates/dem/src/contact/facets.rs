//! Facets: triangles of one wall that stand for a curved surface.
//!
//! Two facets that a grain touches are linked if they belong to one wall and their normals there differ by less than 15 degrees.
//! Facets that are linked through others count as linked too. Of all facets that are linked, the grain has a contact with the
//! nearest one alone. In a hollow surface it would otherwise get several forces at every seam. The energy of the contact is that of the
//! distance to the union of the linked facets, and has no jump where another facet becomes the nearest.

use crate::space::Space;
use crate::walls::surface_wall::SurfaceWall;

/// Cosine of 15 degrees: facets that meet at a smaller angle stand for a smooth surface.
const SMOOTH: f64 = 0.965_925_826_289_068_3;

/// A facet that a grain touches.
#[derive(Clone, Copy, Debug)]
pub(super) struct FacetTouch<V> {
    /// Index of the surface.
    pub(super) index: usize,
    /// Unit normal.
    pub(super) normal: V,
    /// Distance of the grain's centre, m.
    pub(super) distance: f64,
}

/// Returns, for each facet that a grain touches, the place of the one that has the contact: its own, or that of a nearer
/// facet that is linked to it.
pub(super) fn nearest_facets<V: Space>(walls: &[SurfaceWall<V>], touches: &[FacetTouch<V>]) -> Vec<usize> {
    let are_linked = |one: &FacetTouch<V>, other: &FacetTouch<V>| {
        walls[one.index].number == walls[other.index].number && one.normal.dot(other.normal) > SMOOTH
    };
    let mut nearest_first: Vec<usize> = (0..touches.len()).collect();
    nearest_first.sort_by(|&a, &b| touches[a].distance.total_cmp(&touches[b].distance));
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
                if holder[to] == usize::MAX && are_linked(&touches[from], &touches[to]) {
                    holder[to] = nearest;
                    reached.push(to);
                }
            }
        }
    }
    holder
}
