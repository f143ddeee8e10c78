//! Seams: where wall surfaces meet, a grain touches their union, not each of them.
//!
//! A grain touches a surface at its nearest point p. If p lies on an edge and another wall passes through p, or lies between p and
//! the centre, then p is no nearest point of the union, because beside p that other wall is nearer. So the contact at p is left out. Two
//! walls whose nearest points lie in one direction from the centre, and on no edge, are one wall there, as where walls overlap in one
//! plane. If two walls would leave out each other, because both end at p or both lie at p, one stays: the nearer one, or if rounding
//! alone parts them the one that comes first in the scene.
//!
//! So there is one contact on a flat seam, on an overlap and round a convex edge, and one for each wall in a concave corner.
//!
//! # Tolerances
//!
//! Coordinates of walls are rounded: by hand to a few digits, or to single precision in a binary STL file. For a grain of radius R
//! whose centre has the largest coordinate c:
//!
//! * Along the walls p may be off by a gap of `GAP` R. In a gap of width w a grain sinks by w^2/(8 R), 1.3e-5 R at most,
//!   which is far less than an overlap.
//! * Across them it may stand out by a step of `STEP` R, or of `DIGITS` c with the rounding of single precision, up to `GAP` R. Where
//!   the grain rolls over such a step its overlap changes by the height of the step at once. A higher step is an obstacle, and its edge pushes.
//! * Two directions are one if they differ by less than `GAP` rad, which is the angle at which a grain sees a gap.
//!
//! Limit: where two walls of the scene meet in a concave seam between 0.6 and about 3 degrees, a contact ends although the
//! grain still overlaps the wall that it leaves, and the forces of both act in a strip beside the seam.

use crate::space::Space;
use crate::walls::surface_wall::SurfaceWall;

/// Largest gap between walls that continue each other, in radii of the grain.
const GAP: f64 = 0.01;

/// Largest step between walls that continue each other, in radii of the grain.
const STEP: f64 = 1e-4;

/// Largest step, in the largest coordinate of the grain: eight units in the last place of single precision. Two coordinates that are
/// rounded to it differ by one unit, and sums of two or three of them by a few.
const DIGITS: f64 = 8.0 * f32::EPSILON as f64;

/// Distances of two walls that differ by less, in radii of the grain, are equal: above the rounding of positions.
const ROUNDING: f64 = 1e-9;

/// A wall that a grain touches.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Touch<V: Space> {
    /// Index of the wall.
    pub index: usize,
    /// Unit normal towards the centre of the grain.
    pub normal: V,
    /// Distance of the centre, m.
    pub distance: f64,
    /// Whether the nearest point lies on an edge.
    pub at_edge: bool,
}

impl<V: Space> Touch<V> {
    /// Whether both lie in one direction from the centre.
    #[inline]
    pub fn is_towards(&self, other: &Self) -> bool {
        (self.normal - other.normal).length_squared() < GAP * GAP
    }
}

/// The walls that a grain touches, with the lengths that count as nothing.
pub(crate) struct Seams<'a, V: Space> {
    walls: &'a [SurfaceWall<V>],
    touches: &'a [Touch<V>],
    /// Centre of the grain, m.
    x: V,
    gap: f64,
    step: f64,
    rounding: f64,
}

impl<'a, V: Space> Seams<'a, V> {
    /// Takes the walls that a grain with centre `x` and this radius (m) touches.
    pub fn new(walls: &'a [SurfaceWall<V>], touches: &'a [Touch<V>], (x, radius): (V, f64)) -> Self {
        let largest = (0..V::COMPONENTS).fold(0.0, |largest: f64, axis| largest.max(x.axis(axis).abs()));
        let gap = GAP * radius;
        Self {
            walls,
            touches,
            x,
            gap,
            step: (DIGITS * largest).max(STEP * radius).min(gap),
            rounding: ROUNDING * radius,
        }
    }

    /// Returns, for each wall that the grain touches, the place in the list of the one that has its contact: its own, or that of the
    /// wall that continues it.
    pub fn holders(&self) -> Vec<usize> {
        let next: Vec<_> = (0..self.touches.len()).map(|place| self.continued_by(place)).collect();
        (0..next.len()).map(|place| self.end_of_chain(&next, place)).collect()
    }

    /// Returns the wall for which the contact at `place` is left out, or `None` if it counts.
    fn continued_by(&self, place: usize) -> Option<usize> {
        let lead = |other: usize| self.touches[place].distance - self.touches[other].distance;
        let others = (0..self.touches.len()).filter(|&other| {
            self.covers(other, place) && !(self.comes_first(place, other) && self.covers(place, other))
        });
        others.max_by(|&a, &b| lead(a).total_cmp(&lead(b)).then(b.cmp(&a)))
    }

    /// Whether the wall at `other` passes through the nearest point of the one at `place`, or between it and the centre.
    fn covers(&self, other: usize, place: usize) -> bool {
        if other == place {
            return false;
        }
        let touch = &self.touches[place];
        let by = &self.touches[other];
        if !touch.at_edge {
            return !by.at_edge && touch.is_towards(by);
        }
        let point = self.x - touch.normal * touch.distance;
        let away = self.walls[by.index].surface.nearest(point).away();
        let height = away.dot(by.normal);
        height <= self.step && (away - by.normal * height).length() <= self.gap
    }

    /// Whether the wall at `place` keeps its contact, if each of the two covers the other. Both then end at their nearest points, or neither does.
    fn comes_first(&self, place: usize, other: usize) -> bool {
        let lead = self.touches[other].distance - self.touches[place].distance;
        if lead.abs() > self.rounding { lead > 0.0 } else { place < other }
    }

    /// Follows walls that continue each other to the one that counts. If they go round in a circle, the best of the circle counts, so that
    /// a grain never loses all its contacts.
    fn end_of_chain(&self, next: &[Option<usize>], place: usize) -> usize {
        let mut end = place;
        for _ in 0..next.len() {
            let Some(other) = next[end] else { return end };
            end = other;
        }
        let circle = std::iter::successors(next[end], |&at| next[at].filter(|_| at != end)).take(next.len());
        let rank = |place: usize| (self.touches[place].at_edge, self.touches[place].distance);
        let best = circle.min_by(|&a, &b| {
            let a_rank = rank(a);
            let b_rank = rank(b);
            a_rank.0.cmp(&b_rank.0).then(a_rank.1.total_cmp(&b_rank.1)).then(a.cmp(&b))
        });
        best.unwrap_or(end)
    }
}
