//! Triangulation of a planar polygon of solid space, with or without a hole.
//!
//! Ears are clipped (`ears`). A slit between its two nearest corners first joins a hole to the outline.
//!
//! A corner on a straight edge of a polygon of the scene is left out. In a face of a mesh such a corner stays, because another face may have
//! a corner there.

mod ears;

use std::ops::ControlFlow;

use self::ears::{STRAIGHT, Straight, clip};
use crate::math;
use crate::space::Solid;
use crate::walls::box_tree::BoxTree;

/// Largest distance of a corner from the plane of a wall of the scene, in lengths of its longest edge.
const FLAT: f64 = 1e-9;

/// Most corners of a polygon. A polygon of twice as many corners takes a second.
const MOST_CORNERS: usize = 5_000;

const CROSSING: &str = "the edges of the polygon cross each other";

/// Returns the triangles of a polygon.
///
/// # Errors
/// In words, if the corners are not in one plane or do not enclose an area without crossings.
pub(crate) fn triangles(outline: &[Solid], hole: &[Solid]) -> Result<Vec<[Solid; 3]>, String> {
    at_most(outline.len() + hole.len())?;
    let Some(normal) = normal(outline) else { return Err("the polygon encloses no area".to_owned()) };
    let all = || outline.iter().chain(hole);
    let size = all().map(|x| x.distance(outline[0])).fold(0.0, f64::max);
    if let Some(off) = all().find(|x| (**x - outline[0]).dot(normal).abs() > FLAT * size) {
        return Err(format!("the corner ({}, {}, {}) m is outside the plane of the polygon", off.x, off.y, off.z));
    }
    if crosses_itself(outline, normal) {
        return Err(CROSSING.to_owned());
    }
    let ring = if hole.is_empty() { outline.to_vec() } else { with_slit(outline, hole, normal)? };
    let reason =
        if hole.is_empty() { CROSSING } else { "the hole is not inside the polygon, or edges cross each other" };
    let triangles = clip(ring, normal, Straight::LeftOut).ok_or(reason)?;
    let area = |points: &[Solid]| area_vector(points).length();
    let expected = area(outline) - if hole.is_empty() { 0.0 } else { area(hole) };
    let sum: f64 = triangles.iter().map(|triangle| area(triangle)).sum();
    if (sum - expected).abs() > 1e-9 * size * size {
        return Err(reason.to_owned());
    }
    Ok(triangles)
}

/// Returns the triangles of a face of a mesh, whose corners are at most `flat` sizes of the face away from its plane. All triangles of a convex face
/// meet at its first corner.
///
/// # Errors
/// In words, as [`triangles`].
pub(crate) fn of_face(points: &[Solid], flat: f64) -> Result<Vec<[Solid; 3]>, String> {
    at_most(points.len())?;
    let centre = points.iter().sum::<Solid>() / f64::from(u32::try_from(points.len()).unwrap_or(1));
    let Some(normal) = normal(points) else {
        return Err("they enclose no area, or its edges cross each other".to_owned());
    };
    let size = points.iter().map(|x| x.distance(points[0])).fold(0.0, f64::max);
    let height = |x: &Solid| (*x - centre).dot(normal).abs();
    let is_flat = |x: &Solid| height(x) <= flat * size;
    if let Some(off) = points.iter().position(|x| !is_flat(x)) {
        let share = height(&points[off]) / size;
        return Err(format!(
            "corner {} is outside the plane of the others, by {share:.1e} of the size of the face; divide the face into triangles",
            off + 1
        ));
    }
    let fan: Vec<_> = points[1..].windows(2).map(|pair| [points[0], pair[0], pair[1]]).collect();
    let corners = points.iter().zip(points.iter().cycle().skip(1)).zip(points.iter().cycle().skip(2));
    let is_left = |[a, b, c]: [Solid; 3]| {
        let area = (b - a).cross(c - b).dot(normal);
        area > STRAIGHT * (b - a).length() * (c - b).length()
    };
    if fan.iter().copied().chain(corners.map(|((a, b), c)| [*a, *b, *c])).all(is_left) {
        return Ok(fan);
    }
    if crosses_itself(points, normal) {
        return Err("its edges cross each other".to_owned());
    }
    clip(points.to_vec(), normal, Straight::Kept).ok_or_else(|| "its edges touch or cross each other".to_owned())
}

fn at_most(corners: usize) -> Result<(), String> {
    if corners <= MOST_CORNERS {
        return Ok(());
    }
    Err(format!("it has {corners} corners, more than the limit of {MOST_CORNERS}; divide it"))
}

/// Returns half the sum of the cross products of neighbouring corners: the normal, as long as the area.
fn area_vector(points: &[Solid]) -> Solid {
    let Some(&first) = points.first() else { return Solid::ZERO };
    points.windows(2).map(|pair| 0.5 * (pair[0] - first).cross(pair[1] - first)).sum()
}

/// Returns the unit normal; `None` if the area is nothing but round-off.
fn normal(points: &[Solid]) -> Option<Solid> {
    let size = points.iter().map(|x| x.distance(points[0])).fold(0.0, f64::max);
    let area = area_vector(points);
    area.try_normalize().filter(|_| area.length() > 1e-12 * size * size)
}

/// Returns the outline and the hole as one ring, with a slit between their nearest corners.
fn with_slit(outline: &[Solid], hole: &[Solid], up: Solid) -> Result<Vec<Solid>, String> {
    let Some(of_hole) = normal(hole) else { return Err("the hole encloses no area".to_owned()) };
    let pairs = (0..outline.len()).flat_map(|i| (0..hole.len()).map(move |j| (i, j)));
    let apart = |&(i, j): &(usize, usize)| outline[i].distance_squared(hole[j]);
    let (i, j) = pairs.min_by(|a, b| apart(a).total_cmp(&apart(b))).ok_or("the hole has no corner")?;
    // The hole runs the other way round.
    let mut inner = hole.to_vec();
    inner.rotate_left(j);
    if of_hole.dot(up) > 0.0 {
        inner[1..].reverse();
    }
    let mut ring = outline[..=i].to_vec();
    ring.extend(&inner);
    ring.push(inner[0]);
    ring.extend(&outline[i..]);
    Ok(ring)
}

/// Whether two edges cross at points inside both. A corner that touches an edge is no crossing, and neither are edges that lie on each other, as
/// those of a slit do.
fn crosses_itself(points: &[Solid], up: Solid) -> bool {
    let along = up.any_orthonormal_vector();
    let across = up.cross(along);
    let flat: Vec<[f64; 2]> =
        points.iter().map(|x| [(*x - points[0]).dot(along), (*x - points[0]).dot(across)]).collect();
    let edges: Vec<[[f64; 2]; 2]> =
        flat.iter().zip(flat.iter().cycle().skip(1)).map(|(from, to)| [*from, *to]).collect();
    let boxes: Vec<_> =
        edges.iter().map(|[a, b]| [[a[0].min(b[0]), a[1].min(b[1])], [a[0].max(b[0]), a[1].max(b[1])]]).collect();
    let tree = BoxTree::new(&boxes);
    // The side of a line on which a point is, or 0 within rounding.
    let side = |[a, b]: [[f64; 2]; 2], x: [f64; 2]| {
        let way = [b[0] - a[0], b[1] - a[1]];
        let to = [x[0] - a[0], x[1] - a[1]];
        let area = way[0] * to[1] - way[1] * to[0];
        let rounding = STRAIGHT * math::hypot(way[0], way[1]) * math::hypot(to[0], to[1]);
        if area.abs() <= rounding { 0.0 } else { area.signum() }
    };
    let parts = |line: [[f64; 2]; 2], [a, b]: [[f64; 2]; 2]| side(line, a) * side(line, b) < 0.0;
    (0..edges.len()).any(|one| {
        let [low, high] = boxes[one];
        let meets = |[l, h]: &[[f64; 2]; 2]| (0..2).all(|axis| l[axis] <= high[axis] && h[axis] >= low[axis]);
        let found = tree.search(meets, |other| {
            let cross = parts(edges[one], edges[other]) && parts(edges[other], edges[one]);
            if cross { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        });
        found.is_break()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ring(points: &[(f64, f64)]) -> Vec<Solid> {
        // In an oblique plane.
        let along = Solid::new(1.0, 0.0, 0.5).normalize();
        let across = Solid::new(-0.2, 1.0, 0.4).normalize();
        points.iter().map(|&(x, y)| Solid::new(0.1, 0.2, 0.3) + x * along + y * across).collect()
    }

    const SQUARE: [(f64, f64); 4] = [(0.0, 0.0), (4.0, 0.0), (4.0, 4.0), (0.0, 4.0)];

    #[test]
    fn triangles_cover_the_area_and_nothing_else() {
        let shapes = [
            (SQUARE.to_vec(), Vec::new()),
            (vec![(0.0, 0.0), (4.0, 0.0), (4.0, 4.0), (2.0, 1.0), (0.0, 4.0)], Vec::new()),
            (vec![(0.0, 0.0), (2.0, 0.0), (4.0, 0.0), (4.0, 4.0), (0.0, 4.0)], Vec::new()),
            (SQUARE.to_vec(), vec![(1.0, 1.0), (3.0, 1.0), (3.0, 3.0), (1.0, 3.0)]),
            (SQUARE.to_vec(), vec![(1.0, 3.0), (3.0, 2.5), (2.0, 1.0)]),
        ];
        for (outline, hole) in shapes {
            for reversed in [false, true] {
                let mut points = ring(&outline);
                if reversed {
                    points.reverse();
                }
                let triangles = triangles(&points, &ring(&hole)).unwrap();
                // No triangle covers the centre of another.
                let centres: Vec<Solid> = triangles.iter().map(|t| (t[0] + t[1] + t[2]) / 3.0).collect();
                for (centre, own) in centres.iter().zip(0..) {
                    for (other, [a, b, c]) in triangles.iter().enumerate() {
                        let up = (*b - *a).cross(*c - *a);
                        let inside = [[a, b], [b, c], [c, a]]
                            .iter()
                            .all(|[from, to]| (**to - **from).cross(*centre - **from).dot(up) > 0.0);
                        assert_eq!(inside, own == other, "{outline:?}");
                    }
                }
            }
        }
    }

    /// The area that triangles cover, and the number of their corners that are not among the points.
    fn area_of(triangles: &[[Solid; 3]]) -> f64 {
        triangles.iter().map(|triangle| area_vector(triangle).length()).sum()
    }

    #[test]
    fn faces_are_divided_whichever_corner_comes_first() {
        // A floor with a slot, a comb, a spiral, and a plate whose hole is joined by a bridge that is passed twice.
        let slot = vec![
            (-10.0, -10.0),
            (10.0, -10.0),
            (10.0, 10.0),
            (3.0, 10.0),
            (3.0, -5.0),
            (-3.0, -5.0),
            (-3.0, 10.0),
            (-10.0, 10.0),
        ];
        let comb: Vec<_> = (0..20)
            .map(|n| (f64::from(n), if n % 2 == 0 { 1.0 } else { 9.0 }))
            .chain([(19.0, 0.0), (0.0, 0.0)])
            .rev()
            .collect();
        let turns = |r: f64, n: i32| {
            (
                (r + 0.1 * f64::from(n)) * (0.3 * f64::from(n)).cos(),
                (r + 0.1 * f64::from(n)) * (0.3 * f64::from(n)).sin(),
            )
        };
        let spiral: Vec<_> = (0..60).map(|n| turns(1.0, n)).chain((0..60).rev().map(|n| turns(0.5, n))).collect();
        let bridge = vec![
            (0.0, 0.0),
            (4.0, 0.0),
            (4.0, 4.0),
            (0.0, 4.0),
            (0.0, 0.0),
            (1.0, 1.0),
            (1.0, 3.0),
            (3.0, 3.0),
            (3.0, 1.0),
            (1.0, 1.0),
        ];
        for shape in [slot, comb, spiral, bridge] {
            let points = ring(&shape);
            let expected = area_vector(&points).length();
            for first in 0..points.len() {
                let mut turned = points.clone();
                turned.rotate_left(first);
                for points in [turned.clone(), turned.into_iter().rev().collect()] {
                    let triangles = of_face(&points, 1e-3).unwrap();
                    assert_eq!(triangles.len(), points.len() - 2, "{points:?}: {triangles:?}");
                    assert!((area_of(&triangles) / expected - 1.0).abs() < 1e-12, "{shape:?}");
                    assert!(triangles.iter().flatten().all(|corner| points.contains(corner)));
                }
            }
        }
    }

    #[test]
    fn convex_faces_are_divided_at_their_first_corner_and_corners_on_straight_edges_stay() {
        let points = ring(&[(0.0, 0.0), (2.0, 0.0), (3.0, 1.0), (2.0, 3.0), (0.0, 2.0)]);
        let fan: Vec<_> = (1..4).map(|n| [points[0], points[n], points[n + 1]]).collect();
        assert_eq!(of_face(&points, 1e-3).unwrap(), fan);
        // Wherever the straight corners are, each is a corner of triangles and no edge passes it.
        for straight in 1..16u32 {
            let mut shape = Vec::new();
            for (n, corner) in SQUARE.iter().enumerate() {
                let next = SQUARE[(n + 1) % 4];
                shape.push(*corner);
                if straight & 1 << n != 0 {
                    shape.push((0.5 * (corner.0 + next.0), 0.5 * (corner.1 + next.1)));
                }
            }
            let points = ring(&shape);
            let triangles = of_face(&points, 1e-3).unwrap();
            assert_eq!(triangles.len(), points.len() - 2, "{shape:?}");
            assert!((area_of(&triangles) - 16.0).abs() < 1e-12);
            assert!(triangles.iter().all(|triangle| area_vector(triangle).length() > 0.1), "{shape:?}");
        }
    }

    #[test]
    fn bad_faces_are_refused() {
        let bad = |points: &[Solid], words: &str| {
            let message = of_face(points, 1e-3).unwrap_err();
            assert!(message.contains(words), "{message}");
        };
        // A bow-tie, unequal so that it has an area, and a star that winds round its centre twice.
        bad(&ring(&[(0.0, 0.0), (4.0, 0.0), (0.0, 4.0), (3.0, 5.0)]), "cross");
        bad(&ring(&[(0.0, 0.0), (4.0, 4.0), (4.0, 0.0), (0.0, 4.0)]), "cross");
        let star: Vec<_> = (0..5).map(|n| (0.8 * std::f64::consts::PI * f64::from(n)).sin_cos()).collect();
        bad(&ring(&star), "cross");
        let mut bent = ring(&SQUARE);
        bent[2].z += 0.1;
        bad(&bent, "corner");
        bent[2].z -= 0.0999;
        assert_eq!(of_face(&bent, 1e-3).unwrap().len(), 2);
        bad(&vec![Solid::X; MOST_CORNERS + 1], "limit");
    }

    #[test]
    fn bad_polygons_are_refused() {
        let bad = |outline: &[Solid], hole: &[Solid], words: &str| {
            let message = triangles(outline, hole).unwrap_err();
            assert!(message.contains(words), "{message}");
        };
        bad(&ring(&[(0.0, 0.0), (1.0, 0.0)]), &[], "no area");
        bad(&ring(&[(0.0, 0.0), (1.0, 0.0), (2.0, 0.0)]), &[], "no area");
        let mut bent = ring(&SQUARE);
        bent[2].z += 0.1;
        bad(&bent, &[], "outside the plane");
        bad(&ring(&[(0.0, 0.0), (4.0, 0.0), (0.0, 4.0), (3.0, 5.0)]), &[], "cross");
        let star: Vec<_> = (0..5).map(|n| (0.8 * std::f64::consts::PI * f64::from(n)).sin_cos()).collect();
        bad(&ring(&star), &[], "cross");
        bad(&ring(&SQUARE), &ring(&[(5.0, 1.0), (6.0, 1.0), (6.0, 2.0)]), "not inside");
    }
}
