//! The sites of the lattice: which hold material, which are wall, which ways are blocked.
//!
//! Site (column c, row r) is stored at s = c stride + r, with X = c and Y = 2 r + (c mod 2), and stands at
//! x = x0 + X sqrt(3)/2 a, y = y0 + Y/2 a, a the spacing. The columns are set symmetrically into the width of the outline and
//! the lowest site of even columns stands at its lowest point. A site is fluid if it is inside the outline or on it, and
//! not inside or on an insert. Around all is a margin of wall, so that no step leads out of the store.
//!
//! A direction is blocked if it ends at a wall, or, for the second-nearest neighbours, if both sites beside the bond are wall.
//! That is the same seen from both ends. The doorway are the wall sites outside the outline, less than 3 spacings below the
//! door; they become sinks when the door opens. Friction acts wherever a wall blocks, except at sites that touch the lid: one
//! of whose blocked directions leads above the highest site.

use bevy_ecs::prelude::*;

use crate::lattice::outline::{Polygon, distance, nearest_tangent};
use crate::lattice::reflection::{MirrorSet, Reflection};
use crate::lattice::velocities::{FLANKS, STEPS, directions, in_bonds};
use crate::space::Vector;

/// What a site is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// It holds particles.
    Fluid,
    /// It holds none.
    Wall,
    /// What arrives there is out.
    Sink,
}

/// Wall around the sites: even, so that columns keep their parity, and as wide as the doorway and a step from there.
const MARGIN: usize = 6;

/// How far below the door the doorway reaches, in spacings: no step is longer than 1.5 at right angles to a level door.
const DOORWAY: f64 = 3.0;

/// A run of fluid sites, one above the other.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Run {
    /// The lowest one.
    pub start: usize,
    /// How many.
    pub len: usize,
    /// Their column, modulo 2.
    pub parity: usize,
}

/// A fluid site at a wall.
#[derive(Clone, Copy, Debug)]
pub struct Edge {
    /// Which.
    pub site: usize,
    /// Blocked directions, as a state.
    pub blocked: u16,
    /// Those at which friction acts.
    pub rough: u16,
    /// Where blocked movers go.
    pub reflection: Reflection,
}

/// The sites.
#[derive(Resource, Clone, Debug)]
pub struct Sites {
    /// Distance of nearest neighbours, m.
    pub spacing: f64,
    /// Length of a stored column.
    pub stride: usize,
    /// What each site is.
    pub kinds: Vec<Kind>,
    /// Fluid sites in ascending order.
    pub runs: Vec<Run>,
    /// Blocked directions of each fluid site, as a state.
    pub blocked: Vec<u16>,
    /// Fluid sites at walls, in ascending order.
    pub edges: Vec<Edge>,
    /// Wall sites that the door closes off; sinks once it is open.
    pub doorway: Vec<usize>,
    offsets: [[isize; 13]; 2],
    origin: Vector,
    lines: Vec<(Vector, Vector)>,
}

impl Sites {
    /// The sites of a silo: outline, inserts, door (from, to), in m, and spacing.
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

    /// How many sites are stored for so many columns and rows.
    #[must_use]
    pub fn stored(columns: usize, rows: usize) -> usize {
        columns.saturating_add(2 * MARGIN).saturating_mul(rows.saturating_add(2 * MARGIN))
    }

    /// How many columns and rows an outline holds.
    #[must_use]
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "saturates; compared with a limit")]
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

    /// What is blocked, and how it is reflected.
    fn find_edges(&mut self) {
        let top = self.runs.iter().map(|run| self.coordinates(run.start + run.len - 1).1).max().unwrap_or(0);
        let mut mirrors = MirrorSet::default();
        self.edges.clear();
        let runs = std::mem::take(&mut self.runs);
        for s in runs.iter().flat_map(|run| run.start..run.start + run.len) {
            let is_wall = |d: usize| self.kinds[self.neighbour(s, d)] == Kind::Wall;
            let is_squeezed = |d: usize| d >= 7 && is_wall(FLANKS[d - 7].0) && is_wall(FLANKS[d - 7].1);
            let blocked = (1..=12).filter(|&d| is_wall(d) || is_squeezed(d)).fold(0, |set, d| set | 1 << d);
            self.blocked[s] = blocked;
            if blocked != 0 {
                let touches_lid = directions(blocked).any(|d| self.coordinates(s).1 + STEPS[d].1 > top);
                let reflection = mirrors.reflection(blocked, nearest_tangent(self.position(s), &self.lines));
                self.edges.push(Edge { site: s, blocked, rough: if touches_lid { 0 } else { blocked }, reflection });
            }
        }
        self.runs = runs;
    }

    /// Opens the door: the doorway becomes a sink.
    pub fn open(&mut self) {
        for &s in &self.doorway {
            self.kinds[s] = Kind::Sink;
        }
        self.find_edges();
    }

    /// All fluid sites, ascending.
    pub fn fluid(&self) -> impl Iterator<Item = usize> {
        self.runs.iter().flat_map(|run| run.start..run.start + run.len)
    }

    /// How many fluid sites there are.
    #[must_use]
    pub fn fluid_count(&self) -> usize {
        self.runs.iter().map(|run| run.len).sum()
    }

    /// Integer coordinates (X, Y) of a site.
    #[must_use]
    #[expect(clippy::cast_possible_truncation, clippy::cast_possible_wrap, reason = "a store of at most 2^31 sites")]
    pub fn coordinates(&self, site: usize) -> (i32, i32) {
        let (column, row) = (site / self.stride, site % self.stride);
        (column as i32, (2 * row + column % 2) as i32)
    }

    /// The place of a site, m.
    #[must_use]
    pub fn position(&self, site: usize) -> Vector {
        let (x, y) = in_bonds(self.coordinates(site));
        self.origin + self.spacing * Vector::new(x, y)
    }

    /// The fluid site nearest to a place (m), if there is one.
    #[must_use]
    pub fn nearest(&self, x: Vector) -> Option<usize> {
        let distance = |s: usize| self.position(s).distance_squared(x);
        self.fluid().min_by(|&a, &b| distance(a).total_cmp(&distance(b)))
    }

    /// The site one step in a direction from a fluid site.
    #[inline]
    #[must_use]
    pub fn neighbour(&self, site: usize, direction: usize) -> usize {
        site.wrapping_add_signed(self.offset(site / self.stride % 2, direction))
    }

    /// What a step adds to the index of a site in a column of this parity.
    #[inline]
    #[must_use]
    pub fn offset(&self, parity: usize, direction: usize) -> isize {
        self.offsets[parity][direction]
    }

    /// The outline's and inserts' edges, m.
    #[must_use]
    pub fn lines(&self) -> &[(Vector, Vector)] {
        &self.lines
    }
}

/// What a step (dX, dY) adds to the index of a site in a column of this parity.
#[expect(clippy::cast_possible_truncation, clippy::cast_possible_wrap, reason = "a store of at most 2^31 sites")]
fn offset((dx, dy): (i32, i32), parity: usize, stride: usize) -> isize {
    let parity = parity as i32;
    let rows = (dy + parity - (parity + dx).rem_euclid(2)) / 2;
    (dx * stride as i32 + rows) as isize
}

/// Whether a place outside the outline is in front of the door and not farther than [`DOORWAY`].
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
    fn the_two_silos_have_their_35_000_sites() {
        assert_eq!(flat_bottomed().fluid_count(), 35_000);
        assert_eq!(hopper().fluid_count(), 35_047);
    }

    #[test]
    fn blocked_ways_are_blocked_from_both_ends() {
        for mut sites in [flat_bottomed(), hopper()] {
            for _ in 0..2 {
                for s in sites.fluid() {
                    for d in 1..=12 {
                        let to = sites.neighbour(s, d);
                        let back = sites.blocked[to] & 1 << crate::lattice::velocities::OPPOSITE[d] != 0;
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
    fn steps_lead_where_they_say() {
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
        // Columns stand at odd multiples of sqrt(3)/4 = 0.433 spacings: 24 of them within 10 spacings of the middle.
        assert_eq!(sites.doorway.len(), 3 * 24);
        for &s in &sites.doorway {
            let x = sites.position(s);
            assert!(x.x.abs() <= 0.1 && x.y < 0.0 && x.y > -3.01 * A);
        }
    }

    #[test]
    fn walls_of_the_two_silos_are_mirrors() {
        for sites in [flat_bottomed(), hopper()] {
            let lines: Vec<_> = sites.lines().to_vec();
            let far_from_corners = |x: Vector| lines.iter().all(|line| x.distance(line.0) > 4.0 * A);
            for edge in sites.edges.iter().filter(|edge| far_from_corners(sites.position(edge.site))) {
                let tangent = nearest_tangent(sites.position(edge.site), &lines);
                for d in directions(edge.blocked) {
                    let to = usize::from(edge.reflection[d]);
                    let off =
                        crate::lattice::velocities::angle(to) + crate::lattice::velocities::angle(d) - 2.0 * tangent;
                    let off = off.rem_euclid(360.0);
                    assert!(off.min(360.0 - off) < 1e-6, "{d} to {to} at {tangent} degrees");
                    assert_eq!(d <= 6, to <= 6);
                }
            }
        }
    }
}
