//! The enclosure of the grains in the plane: the lines that no path of a grain may cross, and the line that is the orifice.
//!
//! * Two wall grains are linked if no grain fits between them and no third wall grain is closer to both than they are
//!   to each other (`disc_links`). This relative neighbourhood graph links neighbours, without chords across corners.
//! * Segments of the scene are links themselves, unless they are doors or move. The region behind a half-plane is outside, and so is
//!   the inside of a disc that is a wall surface.
//! * The orifice is the line between the two wall grains that flank the door. They are nearest to the two ends of the
//!   door, on opposite sides of it.

use rustc_hash::FxHashMap;

use crate::neighbours::cells::floor;
use crate::space::{Plane, Vector};
use crate::walls::clip::hull;
use crate::walls::disc_links::disc_links;
use crate::walls::link::Link;
use crate::walls::paths::{Crossing, Paths};
use crate::walls::shapes::ball::Ball;
use crate::walls::shapes::half_plane::HalfPlane;
use crate::walls::shapes::{Planar, Shape as _};
use crate::walls::silo_file::Disc;
use crate::walls::surface::Surface;
use crate::walls::surface_wall::SurfaceWall;

/// Most door grains that are compared pair by pair.
const MANY: usize = 1000;

/// The lines that enclose the grains of a scene of the plane, and the orifice.
#[derive(Clone, Debug, Default)]
pub struct Enclosure {
    links: Vec<Link>,
    /// Side of a cell, m.
    cell: f64,
    /// Indices of the links in each cell. Queried for every grain that has moved some distance, so the hash is fast.
    links_by_cell: FxHashMap<[i64; 2], Vec<usize>>,
    half_planes: Vec<HalfPlane>,
    balls: Vec<Ball>,
    orifice: Option<Link>,
    /// Surfaces of doors, each with the number of its door.
    doors: Vec<(u16, Surface)>,
    bounds: Option<[Vector; 2]>,
}

impl Enclosure {
    /// Makes the enclosure of wall discs, door discs and wall surfaces, for grains of radius `smallest` (m) or more.
    #[must_use]
    pub fn new(walls: &[Disc], door: &[Disc], surfaces: &[SurfaceWall], smallest: f64) -> Self {
        let mut links = disc_links(walls, smallest);
        let mut corners: Vec<_> = walls.iter().map(|disc| disc.centre).collect();
        let mut half_planes = Vec::new();
        let mut balls = Vec::new();
        for surface in surfaces {
            let is_door = surface.door.is_some();
            match surface.surface.shape().planar() {
                Some(Planar::Segment { from, to }) => {
                    if !is_door {
                        links.push(Link { from, to });
                    }
                    corners.extend([from, to]);
                }
                Some(Planar::Ball { centre, radius }) => {
                    if !is_door {
                        balls.push(Ball { centre, radius });
                    }
                    corners.push(centre);
                }
                Some(Planar::HalfPlane { point, normal }) if !is_door => half_planes.push(HalfPlane { point, normal }),
                _ => {}
            }
        }
        let bounds = corners.iter().copied().reduce(Vector::min).zip(corners.iter().copied().reduce(Vector::max));
        let longest = links.iter().map(|link| link.from.distance(link.to)).fold(smallest, f64::max);
        let mut enclosure = Self {
            links,
            cell: longest,
            links_by_cell: FxHashMap::default(),
            half_planes,
            balls,
            orifice: orifice(walls, door),
            doors: surfaces.iter().filter_map(|wall| Some((wall.door?, wall.surface.clone()))).collect(),
            bounds: bounds.map(|(low, high)| [low, high]),
        };
        for (index, link) in enclosure.links.iter().enumerate() {
            for key in cells(link.from, link.to, enclosure.cell) {
                enclosure.links_by_cell.entry(key).or_default().push(index);
            }
        }
        enclosure
    }

    /// Removes the bounding box. In a periodic scene, every path may leave it; if walls move, the box does not stay.
    #[must_use]
    pub fn unbounded(self) -> Self {
        Self { bounds: None, ..self }
    }

    /// Returns the line between the flanks of the door.
    #[must_use]
    pub fn orifice(&self) -> Option<Link> {
        self.orifice
    }

    /// Returns the links between wall grains, and the segments.
    #[must_use]
    pub fn links(&self) -> &[Link] {
        &self.links
    }

    /// Returns the lower left and upper right corners of the box around all links, m.
    #[must_use]
    pub fn bounds(&self) -> Option<[Vector; 2]> {
        self.bounds
    }
}

impl Paths<Plane> for Enclosure {
    fn crossing(&self, from: Vector, to: Vector) -> Option<Crossing<Vector>> {
        let wall = |link: &Link| Crossing::Wall { from: link.from, to: link.to };
        let mut first: Option<(f64, Crossing<Vector>)> = None;
        let mut consider = |share: Option<f64>, crossing: Crossing<Vector>| {
            if let Some(share) = share
                && first.is_none_or(|(earliest, _)| share < earliest)
            {
                first = Some((share, crossing));
            }
        };
        if let Some(orifice) = self.orifice {
            consider(orifice.crossed_at(from, to), Crossing::Orifice(0));
        }
        for (number, door) in &self.doors {
            consider(door.crossing(from, to), Crossing::Orifice(*number));
        }
        // A path across many cells meets most links, so all of them are tested.
        if (to - from).abs().max_element() > 8.0 * self.cell {
            self.links.iter().for_each(|link| consider(link.crossed_at(from, to), wall(link)));
        } else {
            for key in cells(from, to, self.cell) {
                for link in self.links_by_cell.get(&key).into_iter().flatten().map(|&index| self.links[index]) {
                    consider(link.crossed_at(from, to), wall(&link));
                }
            }
        }
        for plane in &self.half_planes {
            consider(plane.crossing(from, to), Crossing::Surface);
        }
        for ball in &self.balls {
            consider(ball.crossing(from, to), Crossing::Surface);
        }
        first.map(|(_, crossing)| crossing)
    }

    /// Returns the side of the bounding box through which a grain has left, in words. `None` if it was not inside
    /// before, or if the scene has half-planes, which bound without a box.
    fn beyond(&self, before: Vector, here: Vector) -> Option<&'static str> {
        let [low, high] = self.bounds.filter(|_| self.half_planes.is_empty())?;
        // A grain above the top may fall back in; a grain beside or below the box may not.
        let is_beside = |x: Vector| x.x < low.x || x.x > high.x;
        if is_beside(before) || before.y < low.y {
            None
        } else if is_beside(here) {
            Some(if here.y >= high.y { "over the top" } else { "past the side of the walls" })
        } else {
            (here.y < low.y).then_some("past the lower end of the walls")
        }
    }
}

/// Returns the cells of side `cell` that the box around a line overlaps.
fn cells(from: Vector, to: Vector, cell: f64) -> impl Iterator<Item = [i64; 2]> {
    // Callers limit the number of cells.
    let [low, high] = [from.min(to) / cell, from.max(to) / cell].map(|corner| [floor(corner.x), floor(corner.y)]);
    (low[1]..=high[1]).flat_map(move |y| (low[0]..=high[0]).map(move |x| [x, y]))
}

/// Returns the line between the flanks of the door.
fn orifice(walls: &[Disc], door: &[Disc]) -> Option<Link> {
    let [first, last] = farthest_pair(door)?;
    let middle = 0.5 * (first + last);
    let nearest = |to: Vector, admits: &dyn Fn(Vector) -> bool| {
        let centres = walls.iter().map(|disc| disc.centre).filter(|&centre| admits(centre));
        centres.min_by(|a, b| a.distance_squared(to).total_cmp(&b.distance_squared(to)))
    };
    let from = nearest(first, &|_| true)?;
    let to = nearest(last, &|centre| (centre - middle).dot(from - middle) < 0.0)?;
    Some(Link { from, to })
}

/// Returns the centres of the two door grains that are farthest apart.
fn farthest_pair(door: &[Disc]) -> Option<[Vector; 2]> {
    let centres: Vec<_> = door.iter().map(|disc| disc.centre).collect();
    let ends = if centres.len() > MANY { hull(centres) } else { centres };
    let pairs = ends.iter().flat_map(|&a| ends.iter().map(move |&b| [a, b]));
    let length = |[from, to]: [Vector; 2]| from.distance(to);
    pairs.reduce(|best, pair| if length(pair) > length(best) { pair } else { best })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::particle::Species;

    fn discs(centres: &[(f64, f64)]) -> Vec<Disc> {
        centres.iter().map(|&(x, y)| Disc { centre: Vector::new(x, y), radius: 0.3 }).collect()
    }

    /// A square corner, a gap and a far post, with two door grains in the gap.
    fn corner() -> Enclosure {
        let walls = discs(&[(0.0, 2.0), (0.0, 1.0), (0.0, 0.0), (1.0, 0.0), (4.0, 0.0), (5.0, 0.0)]);
        Enclosure::new(&walls, &discs(&[(2.0, 0.0), (3.0, 0.0)]), &[], 0.5)
    }

    #[test]
    fn neighbours_are_linked_and_chords_are_not() {
        assert_eq!(corner().links().len(), 4);
        let diagonal = Link { from: Vector::new(0.0, 1.0), to: Vector::new(1.0, 0.0) };
        assert!(!corner().links().contains(&diagonal));
    }

    #[test]
    fn the_orifice_lies_between_the_flanks_of_the_door() {
        let orifice = corner().orifice().unwrap();
        assert_eq!((orifice.from, orifice.to), (Vector::new(1.0, 0.0), Vector::new(4.0, 0.0)));
        let one = Enclosure::new(&discs(&[(-1.0, 0.0), (-3.0, 0.0), (1.5, 0.0)]), &discs(&[(0.0, 0.0)]), &[], 0.1);
        let orifice = one.orifice().unwrap();
        assert_eq!((orifice.from, orifice.to), (Vector::new(-1.0, 0.0), Vector::new(1.5, 0.0)));
    }

    #[test]
    fn a_door_of_many_discs_has_the_same_ends() {
        let on_a_bow = |n: u32| {
            let x = f64::from(n * 7 % 1500) * 1e-3;
            (x, 0.1 * (2.0 * x).sin())
        };
        let many: Vec<_> = (0..1500).map(on_a_bow).collect();
        let [from, to] = farthest_pair(&discs(&many)).unwrap();
        let pairs = many.iter().flat_map(|a| many.iter().map(move |b| (a.0 - b.0).hypot(a.1 - b.1)));
        let longest = pairs.fold(0.0, f64::max);
        assert!((from.distance(to) - longest).abs() < 1e-12, "{from} {to}");
    }

    #[test]
    fn the_first_line_on_a_path_counts() {
        let enclosure = corner();
        assert_eq!(enclosure.crossing(Vector::new(2.5, 0.1), Vector::new(2.5, -0.1)), Some(Crossing::Orifice(0)));
        let through = enclosure.crossing(Vector::new(0.5, 0.1), Vector::new(-100.0, -0.1));
        assert!(matches!(through, Some(Crossing::Wall { from, to }) if from.x == 0.0 && to.x == 0.0), "{through:?}");
        assert_eq!(enclosure.crossing(Vector::new(0.5, 0.5), Vector::new(0.2, 0.3)), None);
    }

    #[test]
    fn leaving_the_box_sideways_or_downwards_is_noticed() {
        let enclosure = corner();
        let inside = Vector::new(1.0, 1.0);
        assert_eq!(enclosure.beyond(inside, Vector::new(1.0, 9.0)), None);
        assert_eq!(enclosure.beyond(inside, Vector::new(-0.1, 9.0)), Some("over the top"));
        assert_eq!(enclosure.beyond(inside, Vector::new(1.0, -0.1)), Some("past the lower end of the walls"));
        assert_eq!(
            enclosure.beyond(Vector::new(-1.0, 1.0), Vector::new(-2.0, 1.0)),
            None,
            "the grain was never inside"
        );
        let floor = Surface::HalfPlane(HalfPlane { point: Vector::ZERO, normal: Vector::Y });
        let floor = SurfaceWall::still(floor, Species(0));
        let open = Enclosure::new(&discs(&[(0.0, 2.0)]), &[], &[floor], 0.1);
        assert_eq!(open.beyond(Vector::new(0.0, 3.0), Vector::new(1.0, 3.0)), None, "a floor has no lateral bounds");
    }
}
