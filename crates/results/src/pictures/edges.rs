//! The edges of a surface that a drawing shows: borders, creases, and the outline where the surface turns away from the observer.

use rustc_hash::FxHashMap;

use glam::DVec3;

/// Cosine of the smallest angle between neighbours that is a crease. Sectors of a round wall meet at less.
const CREASE: f64 = 0.9;

/// A flat piece of a surface.
#[derive(Clone, Debug)]
pub(super) struct Face {
    /// Corners, m.
    pub corners: Vec<DVec3>,
    pub normal: DVec3,
    /// Whether it is in front of the grains.
    pub is_front: bool,
}

/// An edge that is drawn.
#[derive(Clone, Debug)]
pub(super) struct Edge {
    /// Ends, m.
    pub ends: [DVec3; 2],
    /// Whether it is in front of the grains.
    pub is_front: bool,
}

/// The properties that the faces at an edge share.
struct Shared {
    ends: [DVec3; 2],
    first: usize,
    others: Vec<(usize, bool)>,
}

/// A point as a whole number of small lengths along each axis. Neighbours may name the same point with other roundings.
type Place = [i64; 3];

/// Returns the edges that are drawn. `depth` is the direction of looking, `size` the size of the scene, m.
pub(super) fn edges(faces: &[Face], depth: DVec3, size: f64) -> Vec<Edge> {
    #[expect(clippy::cast_possible_truncation, reason = "a float of any size is clamped")]
    let place = |x: DVec3| -> Place { (x / (1e-7 * size)).to_array().map(|number| number.round() as i64) };
    let mut order: Vec<Shared> = Vec::new();
    let mut found: FxHashMap<(Place, Place), usize> = FxHashMap::default();
    for (number, face) in faces.iter().enumerate() {
        for (n, &from) in face.corners.iter().enumerate() {
            let to = face.corners[(n + 1) % face.corners.len()];
            let a = place(from);
            let b = place(to);
            if a == b {
                continue;
            }
            let key = if a < b { (a, b) } else { (b, a) };
            if let Some(&at) = found.get(&key) {
                let is_opposite = place(order[at].ends[0]) == b;
                order[at].others.push((number, is_opposite));
            } else {
                found.insert(key, order.len());
                order.push(Shared { ends: [from, to], first: number, others: Vec::new() });
            }
        }
    }
    let is_drawn = |shared: &Shared| {
        let normal = faces[shared.first].normal;
        shared.others.len() != 1
            || shared.others.iter().any(|&(other, is_opposite)| {
                // Neighbours that pass their edge in opposite directions have normals on the same side.
                let other = if is_opposite { faces[other].normal } else { -faces[other].normal };
                normal.dot(other) < CREASE || normal.dot(depth) * other.dot(depth) < -1e-12
            })
    };
    let is_front =
        |shared: &Shared| faces[shared.first].is_front || shared.others.iter().any(|&(face, _)| faces[face].is_front);
    order.iter().filter(|s| is_drawn(s)).map(|s| Edge { ends: s.ends, is_front: is_front(s) }).collect()
}
