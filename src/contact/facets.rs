//! Facets: triangles of one wall that stand for a curved surface.
//!
//! Two contacts of a grain belong together if their walls are facets of one wall and their normals differ by less than 15
//! degrees. Of all contacts that are linked in this way, through others as well, the grain keeps the one with the nearest
//! facet alone: in a hollow of facets, several forces would act beside every seam. The energy of the contact is then that
//! of the distance from the union of the linked facets, which has no jump where the nearest facet changes.

use crate::contact::Pair;
use crate::space::Space;
use crate::walls::surfaces::SurfaceWall;

/// Cosine of 15 degrees: facets that meet at a smaller angle stand for a smooth surface.
const SMOOTH: f64 = 0.965_925_826_289_068_3;

/// Removes from the contacts of a grain those that a nearer facet of a smooth surface replaces. `follow` receives each wall
/// that is left out, and the one that stays.
pub(super) fn keep_nearest_facets<V: Space>(
    walls: &[SurfaceWall<V>],
    contacts: &mut Vec<(usize, Pair<V>)>,
    mut follow: impl FnMut(usize, usize),
) {
    if contacts.len() < 2 {
        return;
    }
    let linked = |[a, b]: [usize; 2]| {
        let [(one, pair), (other, beside)] = [&contacts[a], &contacts[b]];
        walls[*one].number == walls[*other].number && pair.normal.dot(beside.normal) > SMOOTH
    };
    // For each contact the nearest of those linked with it. Each pass carries it one link further.
    let mut nearest: Vec<usize> = (0..contacts.len()).collect();
    let is_nearer = |a: usize, b: usize| contacts[a].1.overlap > contacts[b].1.overlap;
    let mut has_changed = true;
    while has_changed {
        has_changed = false;
        for a in 0..contacts.len() {
            for b in 0..contacts.len() {
                if nearest[a] != nearest[b] && is_nearer(nearest[b], nearest[a]) && linked([a, b]) {
                    nearest[a] = nearest[b];
                    has_changed = true;
                }
            }
        }
    }
    for (at, &kept) in nearest.iter().enumerate().filter(|&(at, &kept)| at != kept) {
        follow(contacts[at].0, contacts[kept].0);
    }
    let mut at = 0..;
    contacts.retain(|_| at.next().is_some_and(|at| nearest[at] == at));
}
