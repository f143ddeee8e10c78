//! Points of surfaces, each with the largest sphere (disc) that touches it from inside: ellipsoids, polygons, closed meshes.
//!
//! **Ellipsoid**, half-axes a >= b >= c: at the point p, with the gradient g = (x/a^2, y/b^2, z/c^2), the sphere has its centre at p - c^2 g, in the
//! plane of the longer axes, and the radius c^2 |g|.
//!
//! **Polygon, mesh**: a sphere that touches at p with the inward normal n has its centre at p + t n and the radius t. If a place q of the surface
//! is nearer to the centre than p, the sphere through both has t = |q - p|^2/(2 n . (q - p)). This is repeated until no place is nearer (the
//! shrinking ball of Ma, Bae and Choi, Vis. Comput. 28, 7, 2012).

use rustc_hash::FxHashMap;

use crate::bodies::cover::SurfacePoint;
use crate::bodies::sphere_union::Ball;
use crate::space::{Linear, Plane, Solid, Space as _};

/// Cells along a face of the cube whose cells are the points of an ellipsoid. An odd number, so that the ends of the axes are among them.
const CELLS: u32 = 15;

/// Number of points of a polygon or mesh, about.
const POINTS: u32 = 1200;

/// Most corners of a polygon that a shape is made of. The work grows with their square.
const MOST_CORNERS: usize = 1000;

/// Most triangles of a mesh that a shape is made of.
const MOST_TRIANGLES: usize = 20_000;

/// Returns points of the ellipsoid with these half-axes, m, the longest first.
#[must_use]
pub fn ellipsoid(half: Solid) -> Vec<SurfacePoint> {
    let cell = |number: u32| (f64::from(number) + 0.5) * 2.0 / f64::from(CELLS) - 1.0;
    let mut points = Vec::new();
    for (axis, sign) in (0..3).flat_map(|axis| [(axis, 1.0), (axis, -1.0)]) {
        for (u, v) in (0..CELLS).flat_map(|u| (0..CELLS).map(move |v| (cell(u), cell(v)))) {
            let on_cube = Solid::ZERO.with_axis(axis, sign).with_axis((axis + 1) % 3, u).with_axis((axis + 2) % 3, v);
            let length = Linear::length(on_cube);
            let direction = on_cube / length;
            let at = direction * half;
            let gradient = direction / half;
            // The solid angle of the cell, times the area of the ellipsoid over it.
            let weight = Linear::length(gradient) / length.powi(3);
            let squared = half.z * half.z;
            let centre = (at - gradient * squared).with_axis(2, 0.0);
            points.push(SurfacePoint { at, weight, ball: Ball { centre, radius: squared * Linear::length(gradient) } });
        }
    }
    points
}

/// Returns the largest sphere that touches at `at` from the side of the unit vector `inward`. `nearest` returns the place of the surface nearest to
/// a place; `reach` is longer than the surface, m.
fn largest_ball(at: Solid, inward: Solid, reach: f64, nearest: impl Fn(Solid) -> Solid) -> Ball {
    let mut radius = reach;
    for _ in 0..200 {
        let centre = at + inward * radius;
        let other = nearest(centre);
        if other.distance(centre) >= radius * (1.0 - 1e-12) {
            break;
        }
        let to_other = other - at;
        let smaller = to_other.length_squared() / (2.0 * to_other.dot(inward));
        // Rounding ends the sequence too.
        if !(smaller > 0.0 && smaller < radius) {
            break;
        }
        radius = smaller;
    }
    let centre = at + inward * radius;
    Ball { centre, radius: radius.min(nearest(centre).distance(centre)) }
}

/// Most moves of [`enlarge`].
const MOST_MOVES: usize = 1000;

/// Moves the largest ball to where it can be largest, and sets its radius. It moves along x, y and, unless `is_planar`, z, and along the diagonals
/// between them: where two sides are equally near, no move along an axis helps. `nearest` returns the place of the surface nearest to a place.
fn enlarge(points: &mut [SurfacePoint], is_planar: bool, nearest: impl Fn(Solid) -> Solid) {
    let Some(point) = points.iter_mut().max_by(|a, b| a.ball.radius.total_cmp(&b.ball.radius)) else { return };
    let radius_at = |at: Solid| nearest(at).distance(at);
    let Ball { mut centre, mut radius } = point.ball;
    let signs = [-1.0, 0.0, 1.0];
    let heights = if is_planar { &signs[1..2] } else { &signs[..] };
    let in_plane = signs.into_iter().flat_map(|x| signs.map(|y| (x, y)));
    let directions: Vec<_> = in_plane.flat_map(|(x, y)| heights.iter().map(move |&z| Solid::new(x, y, z))).collect();
    let least = 1e-8 * radius;
    let mut step = 0.25 * radius;
    for _ in 0..MOST_MOVES {
        // Steps are shorter than the radius, so the centre stays inside.
        let moves = directions.iter().map(|direction| centre + *direction * step);
        let best = moves.max_by(|a, b| radius_at(*a).total_cmp(&radius_at(*b)));
        match best.filter(|best| radius_at(*best) > radius) {
            Some(better) => (centre, radius) = (better, radius_at(better)),
            None => step *= 0.5,
        }
        if step < least {
            break;
        }
    }
    point.ball = Ball { centre, radius };
}

/// Returns the place between `from` and `to` that is nearest to `at`.
fn nearest_of_segment(at: Solid, from: Solid, to: Solid) -> Solid {
    let along = to - from;
    from + along * ((at - from).dot(along) / along.length_squared()).clamp(0.0, 1.0)
}

/// Returns the place of a triangle that is nearest to `at`.
fn nearest_of_triangle(at: Solid, [a, b, c]: [Solid; 3]) -> Solid {
    let normal = (b - a).cross(c - a);
    // Beyond an edge?
    let is_inside = |from: Solid, to: Solid| (to - from).cross(at - from).dot(normal) >= 0.0;
    if is_inside(a, b) && is_inside(b, c) && is_inside(c, a) {
        return at - normal * ((at - a).dot(normal) / normal.length_squared());
    }
    let on_edges = [(a, b), (b, c), (c, a)].map(|(from, to)| nearest_of_segment(at, from, to));
    on_edges.into_iter().min_by(|x, y| x.distance_squared(at).total_cmp(&y.distance_squared(at))).unwrap_or(a)
}

fn twice_the_area(points: &[Plane]) -> f64 {
    let next = points.iter().cycle().skip(1);
    points.iter().zip(next).map(|(a, b)| (*a - points[0]).perp_dot(*b - points[0])).sum()
}

/// Whether two segments have a place in common.
fn cross([a, b]: [Plane; 2], [c, d]: [Plane; 2]) -> bool {
    let side = |from: Plane, to: Plane, at: Plane| (to - from).perp_dot(at - from);
    let sides = [side(a, b, c) * side(a, b, d), side(c, d, a) * side(c, d, b)];
    sides[0] <= 0.0 && sides[1] <= 0.0 && (sides[0] < 0.0 || sides[1] < 0.0)
}

/// Returns points of a polygon in the plane, m.
///
/// # Errors
/// If the corners bound no area, with the reason.
pub fn polygon(corners: &[Plane]) -> Result<Vec<SurfacePoint>, String> {
    let count = corners.len();
    if count < 3 {
        return Err("a polygon has at least three corners".to_owned());
    }
    if count > MOST_CORNERS {
        return Err(format!(
            "the polygon has {count} corners, and a shape is made of at most {MOST_CORNERS}: simplify it"
        ));
    }
    let edge = |i: usize| [corners[i], corners[(i + 1) % count]];
    if let Some(i) = (0..count).find(|&i| edge(i)[0] == edge(i)[1]) {
        return Err(format!("corners {} and {} of the polygon are at the same place", i + 1, (i + 1) % count + 1));
    }
    for (i, j) in (0..count).flat_map(|i| (i + 2..count).map(move |j| (i, j))) {
        let are_neighbours = i == 0 && j == count - 1;
        if !are_neighbours && cross(edge(i), edge(j)) {
            return Err(format!("sides {} and {} of the polygon cross", i + 1, j + 1));
        }
    }
    let area = twice_the_area(corners);
    let length: f64 = (0..count).map(|i| edge(i)[0].distance(edge(i)[1])).sum();
    if area.abs() <= 1e-12 * length * length {
        return Err("the polygon has no area".to_owned());
    }
    let spread = |[from, to]: [Plane; 2]| [from.extend(0.0), to.extend(0.0)];
    let edges: Vec<_> = (0..count).map(|i| spread(edge(i))).collect();
    let nearest = |at: Solid| {
        let places = edges.iter().map(|[from, to]| nearest_of_segment(at, *from, *to));
        places.min_by(|x, y| x.distance_squared(at).total_cmp(&y.distance_squared(at))).unwrap_or(at)
    };
    let mut points = Vec::new();
    for [from, to] in &edges {
        let along = *to - *from;
        let inward = Solid::new(-along.y, along.x, 0.0).normalize() * area.signum();
        let parts = (0.5 * f64::from(POINTS) * along.length() / length).ceil().max(8.0);
        let mut number = 0.5;
        while number < parts {
            let at = *from + along * (number / parts);
            let ball = largest_ball(at, inward, length, nearest);
            points.push(SurfacePoint { at, weight: along.length() / parts, ball });
            number += 1.0;
        }
    }
    enlarge(&mut points, true, nearest);
    Ok(points)
}

/// Returns six times the volume inside a mesh, negative if its triangles turn the other way.
///
/// # Errors
/// If the mesh is not closed, with the reason.
fn six_volumes(triangles: &[[Solid; 3]]) -> Result<f64, String> {
    let bits = |corner: Solid| (corner + Solid::ZERO).to_array().map(f64::to_bits);
    let mut edges = FxHashMap::default();
    for [from, to] in triangles.iter().flat_map(|[a, b, c]| [[a, b], [b, c], [c, a]]) {
        *edges.entry([bits(*from), bits(*to)]).or_insert(0_u32) += 1;
    }
    let partner = |edge: &[[u64; 3]; 2]| edges.get(&[edge[1], edge[0]]).copied().unwrap_or(0);
    let open = edges.iter().filter(|(edge, count)| partner(edge) == 0 && **count == 1).count();
    if open > 0 {
        return Err(format!(
            "the mesh is not closed: {open} edges belong to one triangle alone. Each edge of a shape joins two triangles, with the same corners to the last digit"
        ));
    }
    let bad = edges.iter().filter(|(edge, count)| **count != 1 || partner(edge) != 1).count();
    if bad > 0 {
        return Err(format!(
            "{bad} edges of the mesh join more than two triangles, or triangles whose corners turn opposite ways"
        ));
    }
    let origin = triangles[0][0];
    Ok(triangles.iter().map(|[a, b, c]| (*a - origin).dot((*b - origin).cross(*c - origin))).sum())
}

/// A triangle, with a sphere that holds it.
struct Facet {
    corners: [Solid; 3],
    middle: Solid,
    reach: f64,
}

/// Returns points of a closed mesh, m.
///
/// # Errors
/// If the mesh is no surface of a body, with the reason.
pub fn mesh(triangles: &[[Solid; 3]]) -> Result<Vec<SurfacePoint>, String> {
    if triangles.len() > MOST_TRIANGLES {
        let count = triangles.len();
        return Err(format!(
            "the mesh has {count} triangles, and a shape is made of at most {MOST_TRIANGLES}: simplify it"
        ));
    }
    if triangles.is_empty() {
        return Err("the mesh has no triangle".to_owned());
    }
    let volume = six_volumes(triangles)?;
    let facet = |corners: &[Solid; 3]| {
        let middle = (corners[0] + corners[1] + corners[2]) / 3.0;
        let reach = corners.iter().map(|corner| corner.distance(middle)).fold(0.0, f64::max);
        Facet { corners: *corners, middle, reach }
    };
    let facets: Vec<_> = triangles.iter().map(facet).collect();
    let nearest = |at: Solid| {
        let mut best = facets[0].corners[0];
        let mut distance = best.distance(at);
        for facet in &facets {
            if facet.middle.distance(at) - facet.reach < distance {
                let place = nearest_of_triangle(at, facet.corners);
                if place.distance(at) < distance {
                    (best, distance) = (place, place.distance(at));
                }
            }
        }
        best
    };
    let first = triangles[0][0];
    let reach = 2.0 * triangles.iter().flatten().map(|corner| corner.distance(first)).fold(0.0, f64::max);
    let areas: Vec<_> = triangles.iter().map(|[a, b, c]| (*b - *a).cross(*c - *a).length()).collect();
    let total: f64 = areas.iter().sum();
    let mut points = Vec::new();
    // Equal shares of the area, spread over each triangle by Roberts's sequence (multiples of the powers of 1/1.32472).
    let mut walked = 0.0;
    let mut number = 0;
    for ([a, b, c], area) in triangles.iter().zip(&areas) {
        walked += area;
        let inward = (*b - *a).cross(*c - *a).normalize() * -volume.signum();
        while (f64::from(number) + 0.5) * total < walked * f64::from(POINTS) {
            let [mut u, mut v] = [0.754_877_666_246_692_7, 0.569_840_290_998_053_2]
                .map(|step: f64| (0.5 + step * f64::from(number + 1)).fract());
            if u + v > 1.0 {
                [u, v] = [1.0 - u, 1.0 - v];
            }
            let at = *a + (*b - *a) * u + (*c - *a) * v;
            points.push(SurfacePoint { at, weight: 1.0, ball: largest_ball(at, inward, reach, nearest) });
            number += 1;
        }
    }
    enlarge(&mut points, false, nearest);
    Ok(points)
}

/// Returns the twelve triangles of a cuboid about the origin with edges of these lengths, m.
#[must_use]
pub fn cuboid(size: Solid) -> Vec<[Solid; 3]> {
    let mut triangles = Vec::new();
    for (axis, sign) in (0..3).flat_map(|axis| [(axis, 1.0), (axis, -1.0)]) {
        let corner = |u: f64, v: f64| {
            let unit =
                Solid::ZERO.with_axis(axis, sign).with_axis((axis + 1) % 3, u).with_axis((axis + 2) % 3, v * sign);
            unit * size * 0.5
        };
        let corners = [corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)];
        triangles.push([corners[0], corners[1], corners[2]]);
        triangles.push([corners[0], corners[2], corners[3]]);
    }
    triangles
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bodies::cover::cover;

    #[test]
    fn spheres_of_an_ellipsoid_touch_it_from_inside() {
        let half = Solid::new(3.0, 2.0, 1.2);
        let points = ellipsoid(half);
        // The area by Thomsen's formula, good to 1.1 %.
        let [ab, ac, bc] = [half.x * half.y, half.x * half.z, half.y * half.z].map(|product| product.powf(1.6075));
        let area = 4.0 * std::f64::consts::PI * ((ab + ac + bc) / 3.0).powf(1.0 / 1.6075);
        let cell = (2.0 / f64::from(CELLS)).powi(2) * half.x * half.y * half.z;
        let sum: f64 = points.iter().map(|point| point.weight * cell).sum();
        assert!((sum / area - 1.0).abs() < 0.015, "{sum} {area}");
        for point in &points {
            assert!((point.at.distance(point.ball.centre) - point.ball.radius).abs() < 1e-12);
            let others = points.iter().map(|other| other.at.distance(point.ball.centre));
            assert!(others.fold(f64::INFINITY, f64::min) >= point.ball.radius - 1e-12);
        }
    }

    #[test]
    fn the_disc_in_the_middle_of_a_square_touches_all_sides() {
        let square = [(0.0, 0.0), (2.0, 0.0), (2.0, 2.0), (0.0, 2.0)].map(|(x, y)| Plane::new(x, y));
        for corners in [square, [square[3], square[2], square[1], square[0]]] {
            let points = polygon(&corners).unwrap();
            let largest = points.iter().map(|point| point.ball.radius).fold(0.0, f64::max);
            assert!((largest - 1.0).abs() < 0.01, "{largest}");
            let one = cover(&points, 1);
            assert!((one.balls[0].centre - Solid::new(1.0, 1.0, 0.0)).length() < 1e-6, "{:?}", one.balls);
            // The mean of sqrt(1 + u^2) over u from 0 to 1 is (sqrt(2) + asinh(1))/2. A corner is at sqrt(2).
            let mean = f64::midpoint(2.0_f64.sqrt(), 1.0_f64.asinh());
            assert!((one.balls[0].radius / mean - 1.0).abs() < 1e-4, "{:?}", one.balls);
            assert!((one.deviation.largest - (2.0_f64.sqrt() - mean)).abs() < 0.01, "{:?}", one.deviation);
        }
    }

    #[test]
    fn more_spheres_come_closer_to_a_cuboid() {
        let points = mesh(&cuboid(Solid::new(2.0, 2.0, 2.0))).unwrap();
        let rms: Vec<_> = [1, 9, 30].map(|count| cover(&points, count).deviation.rms).to_vec();
        assert!(rms[0] > 1.8 * rms[1] && rms[1] > 1.5 * rms[2], "{rms:?}");
        // One sphere about the middle: the standard deviation of sqrt(1 + u^2 + v^2) over a face, by a sum.
        let cells = || (0..200).map(|k| (f64::from(k) + 0.5) / 200.0);
        let distances: Vec<_> = cells().flat_map(|u| cells().map(move |v| (1.0 + u * u + v * v).sqrt())).collect();
        let mean = distances.iter().sum::<f64>() / 40_000.0;
        let deviation = (distances.iter().map(|d| (d - mean).powi(2)).sum::<f64>() / 40_000.0).sqrt();
        assert!((rms[0] / deviation - 1.0).abs() < 0.03, "{} {deviation}", rms[0]);
        for point in &points {
            assert!(point.ball.centre.abs().max_element() + point.ball.radius < 1.0 + 1e-9);
        }
    }

    #[test]
    fn surfaces_that_bound_nothing_are_refused() {
        let refused = |corners: &[(f64, f64)]| {
            polygon(&corners.iter().map(|&(x, y)| Plane::new(x, y)).collect::<Vec<_>>()).unwrap_err()
        };
        assert!(refused(&[(0.0, 0.0), (1.0, 0.0)]).contains("three corners"));
        assert!(refused(&[(0.0, 0.0), (1.0, 0.0), (1.0, 0.0), (0.0, 1.0)]).contains("2 and 3"));
        assert!(refused(&[(0.0, 0.0), (1.0, 1.0), (1.0, 0.0), (0.0, 1.0)]).contains("cross"));
        assert!(refused(&[(0.0, 0.0), (1.0, 0.0), (2.0, 0.0)]).contains("no area"));
        let corners = vec![(0.0, 0.0); MOST_CORNERS + 1];
        assert!(refused(&corners).contains("1001 corners"));
        let whole = cuboid(Solid::ONE);
        assert!(mesh(&whole[1..]).unwrap_err().contains("not closed: 3 edges"));
        let mut turned = whole.clone();
        turned[0].swap(0, 1);
        assert!(mesh(&turned).unwrap_err().contains("opposite ways"), "{:?}", mesh(&turned));
        // All triangles the other way round are the same body.
        let inside_out: Vec<_> = whole.iter().map(|[a, b, c]| [*a, *c, *b]).collect();
        assert!(mesh(&inside_out).unwrap().iter().all(|point| point.ball.centre.abs().max_element() < 0.5));
    }
}
