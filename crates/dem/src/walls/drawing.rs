//! Points, lines and triangles that draw a wall surface.
//!
//! | shape | drawing |
//! |---|---|
//! | segment | one line |
//! | panel, triangle | two triangles, one triangle |
//! | cylinder, cone, ring | a pair of triangles for each sector |
//! | disc | a line for each sector |
//! | spherical zone, sphere | rings of a pair of triangles for each sector, as high as they are wide |
//! | surface with a hole, or the part that fills a hole | convex pieces of the above, cut by a polygon with a side for each sector |
//! | half-plane, half-space | the line or square around the middle of the domain that reaches half its diagonal to each side |
//!
//! Limit: a polygon of 48 corners has 0.3 % less area than its circle.

use std::f64::consts::TAU;

use crate::math;
use crate::space::Solid;

/// The fineness of a drawing, and the part of space for which it is made.
#[derive(Clone, Copy, Debug)]
pub struct Detail {
    /// Number of flat sectors of a round surface.
    pub sectors: u32,
    /// Lowest and highest corner of the part of space in which a surface without ends is drawn, m.
    pub domain: [Solid; 2],
}

/// Points, and the lines and triangles between them.
#[derive(Clone, Debug, Default)]
pub struct Drawing {
    /// Points, m.
    pub points: Vec<Solid>,
    /// Lines, each by the indices of its ends.
    pub lines: Vec<[u32; 2]>,
    /// Triangles, each by the indices of its corners.
    pub triangles: Vec<[u32; 3]>,
}

impl Drawing {
    /// Draws a line.
    pub(super) fn line(ends: [Solid; 2]) -> Self {
        Self { points: ends.to_vec(), lines: vec![[0, 1]], triangles: Vec::new() }
    }

    /// Draws a triangle.
    pub(super) fn triangle(corners: [Solid; 3]) -> Self {
        Self { points: corners.to_vec(), lines: Vec::new(), triangles: vec![[0, 1, 2]] }
    }

    /// Draws a convex quadrangle from its corners, in order round it.
    pub(super) fn quadrangle(corners: [Solid; 4]) -> Self {
        Self { points: corners.to_vec(), lines: Vec::new(), triangles: vec![[0, 1, 2], [0, 2, 3]] }
    }

    /// Draws a closed line through points.
    pub(super) fn closed_line(points: Vec<Solid>) -> Self {
        let count = count(points.len());
        Self { points, lines: (0..count).map(|n| [n, (n + 1) % count]).collect(), triangles: Vec::new() }
    }

    /// Draws convex polygons as triangles round their middles, because corners may lie on an edge.
    pub(super) fn fans(polygons: Vec<Vec<Solid>>) -> Self {
        let mut drawing = Self::default();
        for polygon in polygons {
            let corners = count(polygon.len());
            let middle = polygon.iter().sum::<Solid>() / f64::from(corners);
            let triangles = (0..corners).map(|n| [n, (n + 1) % corners, corners]).collect();
            drawing.add(Self { points: [polygon, vec![middle]].concat(), lines: Vec::new(), triangles });
        }
        drawing
    }

    /// Draws the surface that a line makes about an axis through `base`: sector by sector the points of its profile (r, z), and triangles
    /// between them. Triangles without area are left out.
    pub(super) fn revolved(base: Solid, axis: Solid, profile: &[[f64; 2]], sectors: u32) -> Self {
        let first = axis.any_orthonormal_vector();
        let second = axis.cross(first);
        let mut points = Vec::new();
        let mut triangles = Vec::new();
        let height = count(profile.len());
        for sector in 0..sectors {
            let angle = TAU * f64::from(sector) / f64::from(sectors);
            let outwards = first * math::cos(angle) + second * math::sin(angle);
            points.extend(profile.iter().map(|[r, z]| base + axis * *z + outwards * *r));
            let [a, b] = [height * sector, height * ((sector + 1) % sectors)];
            for (place, ends) in (0..).zip(profile.windows(2)) {
                let [a, b] = [a + place, b + place];
                if ends[0][0] > 0.0 {
                    triangles.push([a, b, a + 1]);
                }
                if ends[1][0] > 0.0 {
                    triangles.push([b, b + 1, a + 1]);
                }
            }
        }
        Self { points, lines: Vec::new(), triangles }
    }

    /// Adds another drawing.
    pub fn add(&mut self, more: Self) {
        let first = count(self.points.len());
        self.points.extend(more.points);
        self.lines.extend(more.lines.into_iter().map(|line| line.map(|index| first + index)));
        self.triangles.extend(more.triangles.into_iter().map(|triangle| triangle.map(|index| first + index)));
    }
}

fn count(length: usize) -> u32 {
    u32::try_from(length).unwrap_or(u32::MAX)
}
