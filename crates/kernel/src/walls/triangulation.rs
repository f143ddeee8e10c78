//! Triangulation of a planar polygon of solid space, with or without a hole.
//!
//! Ears are clipped: three consecutive corners that turn to the inside of the polygon and enclose no other corner are a
//! triangle, and the middle corner is removed. A hole is first joined to the outline by a slit between the two nearest corners.

use crate::space::Solid;

/// Largest distance of a corner from the plane of the polygon, in lengths of its longest edge.
const FLAT: f64 = 1e-9;

/// Returns the triangles of a polygon.
///
/// # Errors
/// In words, if the corners are not in one plane or do not enclose an area without crossings.
pub(crate) fn triangles(outline: &[Solid], hole: &[Solid]) -> Result<Vec<[Solid; 3]>, String> {
    let Some(normal) = normal(outline) else { return Err("the polygon encloses no area".to_owned()) };
    let all = || outline.iter().chain(hole);
    let size = all().map(|x| x.distance(outline[0])).fold(0.0, f64::max);
    if let Some(off) = all().find(|x| (**x - outline[0]).dot(normal).abs() > FLAT * size) {
        return Err(format!("the corner ({}, {}, {}) m is outside the plane of the polygon", off.x, off.y, off.z));
    }
    let ring = if hole.is_empty() { outline.to_vec() } else { with_slit(outline, hole, normal)? };
    let reason = if hole.is_empty() {
        "the edges of the polygon cross each other"
    } else {
        "the hole is not inside the polygon, or edges cross each other"
    };
    let triangles = clip(ring, normal).ok_or(reason)?;
    let area = |points: &[Solid]| area_vector(points).length();
    let expected = area(outline) - if hole.is_empty() { 0.0 } else { area(hole) };
    let sum: f64 = triangles.iter().map(|triangle| area(triangle)).sum();
    if (sum - expected).abs() > 1e-9 * size * size {
        return Err(reason.to_owned());
    }
    Ok(triangles)
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

/// Clips ears until a triangle is left; `None` if no corner is an ear.
fn clip(mut ring: Vec<Solid>, up: Solid) -> Option<Vec<[Solid; 3]>> {
    let mut triangles = Vec::with_capacity(ring.len());
    while ring.len() >= 3 {
        let n = ring.len();
        let corner = |at: usize| [ring[(at + n - 1) % n], ring[at], ring[(at + 1) % n]];
        let turn = |[a, b, c]: [Solid; 3]| (b - a).cross(c - b).dot(up);
        let flat = |at: usize| {
            let [a, b, c] = corner(at);
            turn(corner(at)).abs() <= 1e-12 * (b - a).length() * (c - b).length()
        };
        // A corner on a straight edge encloses no area.
        if let Some(at) = (0..n).find(|&at| flat(at)) {
            ring.remove(at);
            continue;
        }
        let encloses = |[a, b, c]: [Solid; 3], x: Solid| {
            x != a && x != b && x != c && [[a, b, x], [b, c, x], [c, a, x]].into_iter().all(|side| turn(side) >= 0.0)
        };
        let is_ear = |&at: &usize| turn(corner(at)) > 0.0 && !ring.iter().any(|&x| encloses(corner(at), x));
        let at = (0..n).find(is_ear)?;
        triangles.push(corner(at));
        ring.remove(at);
    }
    Some(triangles)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ring(points: &[(f64, f64)]) -> Vec<Solid> {
        // In an oblique plane.
        let (along, across) = (Solid::new(1.0, 0.0, 0.5).normalize(), Solid::new(-0.2, 1.0, 0.4).normalize());
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
        bad(&ring(&SQUARE), &ring(&[(5.0, 1.0), (6.0, 1.0), (6.0, 2.0)]), "not inside");
    }
}
