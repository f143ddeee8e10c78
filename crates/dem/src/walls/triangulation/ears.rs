//! Ears of a polygon.
//!
//! An ear is a corner at which the polygon turns to its inside, and whose triangle with the corners beside it encloses no other corner. The triangle
//! is one of the triangulation, and the corner is removed. After a corner is removed, only the corners beside it are judged anew, so the time
//! grows with the square of the number of corners.

use std::collections::BTreeSet;

use crate::space::Solid;

/// Sine of the largest angle that counts as straight.
pub(super) const STRAIGHT: f64 = 1e-12;

/// The treatment of a corner on a straight edge.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Straight {
    LeftOut,
    Kept,
}

/// The corners that are left of a polygon.
struct Ring {
    points: Vec<Solid>,
    before: Vec<usize>,
    after: Vec<usize>,
    /// A corner that is left.
    some: usize,
    left: usize,
    up: Solid,
    /// Sine of the angle within which a corner counts as lying on the edge of an ear.
    rounding: f64,
    straight: BTreeSet<usize>,
    ears: BTreeSet<usize>,
}

impl Ring {
    fn new(points: Vec<Solid>, up: Solid, straight: Straight) -> Self {
        let n = points.len();
        let neighbour = |by: usize| (0..n).map(|at| (at + by) % n.max(1)).collect();
        let before = neighbour(n.saturating_sub(1));
        let after = neighbour(1);
        let rounding = if straight == Straight::Kept { STRAIGHT } else { 0.0 };
        Self { points, before, after, some: 0, left: n, up, rounding, straight: BTreeSet::new(), ears: BTreeSet::new() }
    }

    fn corner(&self, at: usize) -> [Solid; 3] {
        [self.points[self.before[at]], self.points[at], self.points[self.after[at]]]
    }

    fn turn(&self, [a, b, c]: [Solid; 3]) -> f64 {
        (b - a).cross(c - b).dot(self.up)
    }

    fn all(&self) -> impl Iterator<Item = usize> {
        std::iter::successors(Some(self.some), |&at| Some(self.after[at])).take(self.left)
    }

    fn is_straight(&self, at: usize) -> bool {
        let [a, b, c] = self.corner(at);
        self.turn([a, b, c]).abs() <= STRAIGHT * (b - a).length() * (c - b).length()
    }

    fn is_ear(&self, at: usize) -> bool {
        let [a, b, c] = self.corner(at);
        let encloses = |x: Solid| {
            let is_inside = |[a, b, x]: [Solid; 3]| {
                let rounding = self.rounding * (b - a).length() * (x - b).length();
                self.turn([a, b, x]) >= -rounding
            };
            x != a && x != b && x != c && [[a, b, x], [b, c, x], [c, a, x]].into_iter().all(is_inside)
        };
        self.turn([a, b, c]) > 0.0 && !self.straight.contains(&at) && !self.all().any(|at| encloses(self.points[at]))
    }

    fn judge_straight(&mut self, at: usize) {
        if self.is_straight(at) {
            self.straight.insert(at)
        } else {
            self.straight.remove(&at)
        };
    }

    fn judge_ear(&mut self, at: usize) {
        if self.is_ear(at) {
            self.ears.insert(at)
        } else {
            self.ears.remove(&at)
        };
    }

    fn remove(&mut self, at: usize) {
        let before = self.before[at];
        let after = self.after[at];
        (self.after[before], self.before[after]) = (after, before);
        self.straight.remove(&at);
        self.ears.remove(&at);
        (self.some, self.left) = (after, self.left - 1);
        self.judge_straight(before);
        self.judge_straight(after);
    }

    /// Removes corners on straight edges, and returns the corners beside them.
    fn remove_straight(&mut self) -> Vec<usize> {
        let mut beside = Vec::new();
        while self.left >= 3
            && let Some(&at) = self.straight.first()
        {
            beside.extend([self.before[at], self.after[at]]);
            self.remove(at);
        }
        beside
    }

    /// Returns the ear to clip: the first one; if corners on straight edges stay, the first one beside such a corner, which is then a corner of the
    /// triangle.
    fn ear(&self) -> Option<usize> {
        let is_beside = |at: &usize| [self.before[*at], self.after[*at]].iter().any(|at| self.straight.contains(at));
        let beside = if self.straight.is_empty() { None } else { self.ears.iter().copied().find(is_beside) };
        beside.or_else(|| self.ears.first().copied())
    }
}

/// Returns the triangles of a polygon with the normal `up`; `None` if at some point no corner is an ear.
pub(super) fn clip(points: Vec<Solid>, up: Solid, straight: Straight) -> Option<Vec<[Solid; 3]>> {
    let mut triangles = Vec::with_capacity(points.len());
    let mut ring = Ring::new(points, up, straight);
    (0..ring.left).for_each(|at| ring.judge_straight(at));
    if straight == Straight::LeftOut {
        ring.remove_straight();
    }
    let judge_all = |ring: &mut Ring| {
        let left: Vec<_> = ring.all().collect();
        for at in left {
            ring.judge_ear(at);
        }
    };
    judge_all(&mut ring);
    while ring.left >= 3 {
        let mut ear = ring.ear();
        if ear.is_none() {
            // A corner that has gone may have been the only one inside an ear.
            judge_all(&mut ring);
            ear = ring.ear();
        }
        let Some(at) = ear else {
            // The rest of the polygon encloses no area if every corner is on a straight edge.
            let is_done = ring.straight.len() == ring.left;
            return is_done.then_some(triangles);
        };
        triangles.push(ring.corner(at));
        let mut beside = vec![ring.before[at], ring.after[at]];
        ring.remove(at);
        if straight == Straight::LeftOut {
            beside.extend(ring.remove_straight());
        }
        for at in beside {
            let is_left = ring.left >= 3 && ring.after[ring.before[at]] == at;
            if is_left {
                ring.judge_ear(at);
            } else {
                ring.ears.remove(&at);
            }
        }
    }
    Some(triangles)
}
