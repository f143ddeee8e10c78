//! The sites of the lattice: fluid, wall and sink sites, and the blocked directions of each site.
//!
//! Site (column c, row r) is stored at index s = c stride + r. Its integer coordinates are X = c and Y = 2 r + (c mod
//! 2). Its position is x = x0 + X sqrt(3)/2 a, y = y0 + Y/2 a, with the spacing a. The columns are centred in the width
//! of the outline. The lowest fluid row of even columns is at the height of the outline's lowest point.
//!
//! A site is fluid if it is inside or on the outline and not inside or on an insert. A margin of wall sites surrounds
//! the lattice, so that no step leads to an index out of range.
//!
//! A direction is blocked if it ends at a wall site. A direction to a second-nearest neighbour is also blocked if both
//! sites beside the bond are walls. Blocking is symmetric: a bond is blocked from both ends or from neither.
//!
//! The doorway consists of the sites outside the outline that are at most 3 spacings from the door. They become sinks
//! when the door opens. Friction acts at all blocked directions, except at sites that touch the lid. A site touches the
//! lid if one of its blocked directions leads above the highest fluid site.

use bevy_ecs::prelude::*;

use crate::outline::{Polygon, distance, nearest_tangent};
use crate::reflection::{Reflection, Reflections};
use crate::velocities::{FLANKS, STEPS, directions, in_bonds};
use siloflow_dem::space::Vector;

/// The kind of a site.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Holds particles.
    Fluid,
    /// Holds no particles.
    Wall,
    /// Removes each particle that arrives.
    Sink,
}

/// Width of the wall margin on each side, in columns and rows. Even, so that columns keep their parity. Wide enough for
/// the doorway and one step from it.
const MARGIN: usize = 6;

/// Depth of the doorway, spacings. No step crosses it: at right angles to a horizontal door, a step is at most 1.5
/// long.
const DOORWAY: f64 = 3.0;

/// A run: consecutive fluid sites of a column.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Run {
    /// Index of the lowest site.
    pub start: usize,
    /// Number of sites.
    pub len: usize,
    /// Column number modulo 2.
    pub parity: usize,
}

/// A fluid site with blocked directions.
#[derive(Clone, Copy, Debug)]
pub struct Edge {
    /// Index of the site.
    pub site: usize,
    /// Blocked directions, as a state.
    pub blocked: u16,
    /// Blocked directions at which friction acts, as a state.
    pub rough: u16,
    /// Reflected direction of each blocked direction.
    pub reflection: Reflection,
}

/// All sites of the lattice.
#[derive(Resource, Clone, Debug)]
pub struct Sites {
    /// Distance between nearest neighbours, m.
    pub spacing: f64,
    /// Number of stored sites in a column.
    pub stride: usize,
    /// Kind of each stored site.
    pub kinds: Vec<Kind>,
    /// Runs of fluid sites, in ascending order.
    pub runs: Vec<Run>,
    /// Blocked directions of each stored site, as a state; 0 unless the site is fluid.
    pub blocked: Vec<u16>,
    /// Fluid sites with blocked directions, in ascending order.
    pub edges: Vec<Edge>,
    /// Sites of the doorway: walls while the door is closed, sinks once it is open.
    pub doorway: Vec<usize>,
    offsets: [[isize; 13]; 2],
    origin: Vector,
    lines: Vec<(Vector, Vector)>,
}

impl Sites {
    /// Creates the sites of a silo with its door closed. The outline, the inserts, the ends of the door and the spacing
    /// are in m.
    #[must_use]
    pub fn new(outline: &Polygon, inserts: &[Polygon], door: Option<(Vector, Vector)>, spacing: f64) -> Self {
        let (low, high) = outline.bounds();
        let (columns, rows) = Self::extent(outline, spacing);
        let width = in_bonds((1, 0)).0 * spacing;
        #[expect(clippy::cast_precision_loss, reason = "a number of columns")]
        let left = 0.5 * (low.x + high.x) - 0.5 * (columns - 1) as f64 * width;
        #[expect(clippy::cast_precision_loss, reason = "6")]
        let margin = MARGIN as f64 * Vector::new(width, spacing);
        let stride = rows + 2 * MARGIN;
        let lines = std::iter::once(outline).chain(inserts).flat_map(Polygon::edges).collect();
        let count = Self::stored(columns, rows);
        let mut sites = Self {
            spacing,
            stride,
            kinds: vec![Kind::Wall; count],
            runs: Vec::new(),
            blocked: vec![0; count],
            edges: Vec::new(),
            doorway: Vec::new(),
            offsets: [0, 1].map(|parity| STEPS.map(|step| offset(step, parity, stride))),
            origin: Vector::new(left, low.y) - margin,
            lines,
        };
        let tolerance = 1e-6 * spacing;
        for s in 0..count {
            let x = sites.position(s);
            if outline.holds(x, tolerance) {
                if x.y <= high.y + tolerance && !inserts.iter().any(|insert| insert.holds(x, tolerance)) {
                    sites.kinds[s] = Kind::Fluid;
                }
            } else if door.is_some_and(|door| is_in_doorway(x, door, spacing, tolerance)) {
                sites.doorway.push(s);
            }
        }
        sites.find_runs();
        sites.find_edges();
        sites
    }

    /// Returns the number of stored sites for this many columns and rows of the silo.
    #[must_use]
    pub fn stored(columns: usize, rows: usize) -> usize {
        columns.saturating_add(2 * MARGIN).saturating_mul(rows.saturating_add(2 * MARGIN))
    }

    /// Returns the numbers of columns and rows that fit into the bounding box of an outline.
    #[must_use]
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "saturates; the caller compares it with a limit"
    )]
    pub fn extent(outline: &Polygon, spacing: f64) -> (usize, usize) {
        let (low, high) = outline.bounds();
        let fitting = |length: f64, step: f64| ((length / step + 1e-6).floor() as usize).saturating_add(1);
        (fitting(high.x - low.x, in_bonds((1, 0)).0 * spacing), fitting(high.y - low.y, spacing))
    }

    fn find_runs(&mut self) {
        let is_fluid = |s: usize| self.kinds[s] == Kind::Fluid;
        let mut s = 0;
        while s < self.kinds.len() {
            let len = (s..self.kinds.len()).take_while(|&s| is_fluid(s)).count();
            if len > 0 {
                self.runs.push(Run { start: s, len, parity: s / self.stride % 2 });
            }
            s += len + 1;
        }
    }

    /// Finds the blocked directions of all fluid sites, and their reflections.
    fn find_edges(&mut self) {
        let top = self.runs.iter().map(|run| self.coordinates(run.start + run.len - 1).1).max().unwrap_or(0);
        let mut reflections = Reflections::default();
        self.edges.clear();
        let runs = std::mem::take(&mut self.runs);
        for s in runs.iter().flat_map(|run| run.start..run.start + run.len) {
            let is_wall = |d: usize| self.kinds[self.neighbour(s, d)] == Kind::Wall;
            let is_between_walls = |d: usize| d >= 7 && is_wall(FLANKS[d - 7].0) && is_wall(FLANKS[d - 7].1);
            let blocked = (1..=12).filter(|&d| is_wall(d) || is_between_walls(d)).fold(0, |set, d| set | 1 << d);
            self.blocked[s] = blocked;
            if blocked != 0 {
                let touches_lid = directions(blocked).any(|d| self.coordinates(s).1 + STEPS[d].1 > top);
                let reflection = reflections.reflection(blocked, nearest_tangent(self.position(s), &self.lines));
                self.edges.push(Edge { site: s, blocked, rough: if touches_lid { 0 } else { blocked }, reflection });
            }
        }
        self.runs = runs;
    }

    /// Opens the door: the sites of the doorway become sinks.
    pub fn open(&mut self) {
        for &s in &self.doorway {
            self.kinds[s] = Kind::Sink;
        }
        self.find_edges();
    }

    /// Whether the door has been opened.
    #[must_use]
    pub fn is_open(&self) -> bool {
        self.doorway.iter().any(|&s| self.kinds[s] == Kind::Sink)
    }

    /// Returns the indices of all fluid sites, ascending.
    pub fn fluid(&self) -> impl Iterator<Item = usize> {
        self.runs.iter().flat_map(|run| run.start..run.start + run.len)
    }

    /// Returns the number of fluid sites.
    #[must_use]
    pub fn fluid_count(&self) -> usize {
        self.runs.iter().map(|run| run.len).sum()
    }

    /// Returns the integer coordinates (X, Y) of a site.
    #[must_use]
    #[expect(clippy::cast_possible_truncation, clippy::cast_possible_wrap, reason = "at most 2^31 stored sites")]
    pub fn coordinates(&self, site: usize) -> (i32, i32) {
        let column = site / self.stride;
        let row = site % self.stride;
        (column as i32, (2 * row + column % 2) as i32)
    }

    /// Returns the position of a site, m.
    #[must_use]
    pub fn position(&self, site: usize) -> Vector {
        let (x, y) = in_bonds(self.coordinates(site));
        self.origin + self.spacing * Vector::new(x, y)
    }

    /// Returns the fluid site nearest to a position (m); `None` if there are no fluid sites.
    #[must_use]
    pub fn nearest(&self, x: Vector) -> Option<usize> {
        let distance = |s: usize| self.position(s).distance_squared(x);
        self.fluid().min_by(|&a, &b| distance(a).total_cmp(&distance(b)))
    }

    /// Returns the site that one step in a direction leads to from a fluid site.
    #[inline]
    #[must_use]
    pub fn neighbour(&self, site: usize, direction: usize) -> usize {
        site.wrapping_add_signed(self.offset(site / self.stride % 2, direction))
    }

    /// Returns the difference of index that a step in a direction makes, for sites in columns of this parity.
    #[inline]
    #[must_use]
    pub fn offset(&self, parity: usize, direction: usize) -> isize {
        self.offsets[parity][direction]
    }

    /// Returns the edges of the outline and of the inserts, m.
    #[must_use]
    pub fn lines(&self) -> &[(Vector, Vector)] {
        &self.lines
    }
}

/// Returns the difference of index that a step (dX, dY) makes, for sites in columns of this parity.
#[expect(clippy::cast_possible_truncation, clippy::cast_possible_wrap, reason = "at most 2^31 stored sites")]
fn offset((dx, dy): (i32, i32), parity: usize, stride: usize) -> isize {
    let parity = parity as i32;
    let rows = (dy + parity - (parity + dx).rem_euclid(2)) / 2;
    (dx * stride as i32 + rows) as isize
}

/// Whether a position outside the outline is opposite the door and at most [`DOORWAY`] spacings from it.
fn is_in_doorway(x: Vector, (from, to): (Vector, Vector), spacing: f64, tolerance: f64) -> bool {
    let along = to - from;
    let place = (x - from).dot(along) / along.length();
    (-tolerance..=along.length() + tolerance).contains(&place)
        && distance(x, (from, to)) <= DOORWAY * spacing + tolerance
}

#[cfg(test)]
mod tests {
    use super::*;

    const A: f64 = 0.01;

    fn polygon(corners: &[(f64, f64)]) -> Polygon {
        Polygon(corners.iter().map(|&(x, y)| Vector::new(x, y)).collect())
    }

    const DOOR: Option<(Vector, Vector)> = Some((Vector::new(-0.1, 0.0), Vector::new(0.1, 0.0)));

    fn flat_bottomed() -> Sites {
        let outline = polygon(&[(-0.602, 0.0), (0.602, 0.0), (0.602, 2.495), (-0.602, 2.495)]);
        Sites::new(&outline, &[], DOOR, A)
    }

    fn hopper() -> Sites {
        let shoulder = 0.502 * 3f64.sqrt();
        let right = [(0.1, 0.0), (0.602, shoulder), (0.602, 2.865)];
        let left = [(-0.602, 2.865), (-0.602, shoulder), (-0.1, 0.0)];
        Sites::new(&polygon(&[right, left].concat()), &[], DOOR, A)
    }

    #[test]
    fn the_two_silos_of_the_study_have_their_numbers_of_sites() {
        assert_eq!(flat_bottomed().fluid_count(), 35_000);
        assert_eq!(hopper().fluid_count(), 35_047);
    }

    #[test]
    fn blocked_bonds_are_blocked_from_both_ends() {
        for mut sites in [flat_bottomed(), hopper()] {
            for _ in 0..2 {
                for s in sites.fluid() {
                    for d in 1..=12 {
                        let to = sites.neighbour(s, d);
                        let back = sites.blocked[to] & 1 << crate::velocities::OPPOSITE[d] != 0;
                        if sites.kinds[to] == Kind::Fluid {
                            assert_eq!(sites.blocked[s] & 1 << d != 0, back);
                        } else if sites.kinds[to] == Kind::Wall {
                            assert!(sites.blocked[s] & 1 << d != 0);
                        }
                    }
                }
                sites.open();
            }
        }
    }

    #[test]
    fn neighbours_are_one_step_away() {
        let sites = hopper();
        for s in sites.fluid().step_by(97) {
            for (d, &step) in STEPS.iter().enumerate() {
                let way = (sites.position(sites.neighbour(s, d)) - sites.position(s)) / A;
                let (x, y) = in_bonds(step);
                // Positions of up to 3 m, in units of 1 cm: 300 x 2^-52 and a few roundings.
                assert!(way.distance(Vector::new(x, y)) < 1e-12, "{s} {d} {way}");
            }
        }
    }

    #[test]
    fn the_doorway_is_three_rows_as_wide_as_the_door() {
        let sites = flat_bottomed();
        // Columns are at odd multiples of sqrt(3)/4 = 0.433 spacings: 24 of them are within 10 spacings of the middle.
        assert_eq!(sites.doorway.len(), 3 * 24);
        for &s in &sites.doorway {
            let x = sites.position(s);
            assert!(x.x.abs() <= 0.1 && x.y < 0.0 && x.y > -3.01 * A);
        }
    }

    #[test]
    fn straight_walls_of_the_two_silos_reflect_specularly() {
        for sites in [flat_bottomed(), hopper()] {
            let lines: Vec<_> = sites.lines().to_vec();
            let far_from_corners = |x: Vector| lines.iter().all(|line| x.distance(line.0) > 4.0 * A);
            for edge in sites.edges.iter().filter(|edge| far_from_corners(sites.position(edge.site))) {
                let tangent = nearest_tangent(sites.position(edge.site), &lines);
                for d in directions(edge.blocked) {
                    let to = usize::from(edge.reflection[d]);
                    let off = crate::velocities::angle(to) + crate::velocities::angle(d) - 2.0 * tangent;
                    let off = off.rem_euclid(360.0);
                    assert!(off.min(360.0 - off) < 1e-6, "{d} to {to} at {tangent} degrees");
                    assert_eq!(d <= 6, to <= 6);
                }
            }
        }
    }
}
