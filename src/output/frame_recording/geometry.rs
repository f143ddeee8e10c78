//! Wall surfaces as points, lines and triangles (module `walls::drawing` of `siloflow_dem`), and the box of a scene.

use crate::scene::loaded::Loaded;
use siloflow_dem::space::{Dimension, Linear as _, Solid, Space};
use siloflow_dem::walls::config::shape::WallShape;
use siloflow_dem::walls::drawing::{Detail, Drawing};
use siloflow_dem::walls::surface_wall::SurfaceWall;
use siloflow_files::frames::WallGeometry;

/// Number of sectors of a surface of revolution.
pub const SECTORS: u32 = 48;

/// Returns each wall of a scene, from its surfaces. A wall that has been removed has no points.
///
/// This is the only place that turns walls into geometry; it uses the surfaces as they are at the moment.
#[must_use]
pub fn walls<V: Space>(all: &[SurfaceWall<V>], domain: [Solid; 2]) -> Vec<WallGeometry> {
    let detail = Detail { sectors: SECTORS, domain };
    let mut walls: Vec<WallGeometry> = Vec::new();
    for surface in all {
        let number = u32::try_from(surface.number + 1).unwrap_or(u32::MAX);
        if walls.last().is_none_or(|wall| wall.number != number) {
            let species = surface.species.0;
            let is_door = surface.door.is_some();
            walls.push(WallGeometry { number, species, is_door, ..WallGeometry::default() });
        }
        if let Some(wall) = walls.last_mut()
            && surface.is_present
        {
            add(wall, &surface.surface.shape().drawing(&detail));
        }
    }
    walls
}

/// Returns the walls that differ from the first ones. Both lists have the same numbers in the same order.
#[must_use]
pub(super) fn changed(first: &[WallGeometry], now: Vec<WallGeometry>) -> Vec<WallGeometry> {
    now.into_iter().zip(first).filter(|(now, first)| now != *first).map(|(now, _)| now).collect()
}

/// Adds points, lines and triangles to a wall.
fn add(wall: &mut WallGeometry, drawing: &Drawing) {
    let first = u32::try_from(wall.points.len()).unwrap_or(u32::MAX);
    wall.points.extend(drawing.points.iter().map(Solid::to_array));
    wall.lines.extend(drawing.lines.iter().map(|line| line.map(|index| first + index)));
    wall.triangles.extend(drawing.triangles.iter().map(|triangle| triangle.map(|index| first + index)));
}

/// Returns the lowest and the highest corner of the periodic box, of the walls, and of the places where grains start, m.
#[must_use]
pub fn domain(loaded: &Loaded) -> [Solid; 2] {
    let scene = &loaded.scene;
    let mut corners: Vec<Solid> = Vec::new();
    let mut add = |centre: Solid, radius: f64| corners.extend([centre - radius, centre + radius]);
    for disc in loaded.silo.wall.iter().chain(&loaded.silo.door) {
        add(disc.centre.spread(), disc.radius);
    }
    for wall in &scene.walls {
        match &wall.shape {
            WallShape::Disc { centre, radius } => add(centre.padded(), radius.get()),
            WallShape::HalfPlane { point, .. } => add(point.padded(), 0.0),
            _ => wall.bounds().into_iter().flatten().for_each(|corner| add(corner, 0.0)),
        }
    }
    loaded.grains.iter().for_each(|grain| add(grain.position, grain.reach()));
    loaded.fixed.iter().for_each(|grain| add(grain.position, grain.radius));
    let largest = loaded.grain_radii().map_or(0.0, |(_, largest)| largest);
    scene.spawner.iter().for_each(|spawner| add(spawner.point.padded(), largest));
    for feed in &scene.feed {
        let (low, high) = feed.region.bounds();
        add(low, feed.largest_reach());
        add(high, feed.largest_reach());
    }
    let mut ends = [
        corners.iter().copied().reduce(Solid::min).unwrap_or(Solid::ZERO),
        corners.iter().copied().reduce(Solid::max).unwrap_or(Solid::ZERO),
    ];
    for (axis, side) in scene.periodic.axes().into_iter().enumerate() {
        if let Some((low, high)) = side {
            (ends[0][axis], ends[1][axis]) = (low, high);
        }
    }
    if scene.space == Dimension::Plane {
        (ends[0].z, ends[1].z) = (0.0, 0.0);
    }
    ends
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;
    use siloflow_dem::particle::Species;
    use siloflow_dem::space::Plane;
    use siloflow_dem::walls::shapes::ball::Ball;
    use siloflow_dem::walls::shapes::half_plane::HalfPlane;
    use siloflow_dem::walls::shapes::panel::Panel;
    use siloflow_dem::walls::shapes::prism::Prism;
    use siloflow_dem::walls::shapes::revolved::Revolved;
    use siloflow_dem::walls::shapes::spherical_zone::SphericalZone;
    use siloflow_dem::walls::shapes::trimmed::Trimmed;
    use siloflow_dem::walls::shapes::whole::Whole;
    use siloflow_dem::walls::surface::Surface;

    const BOX: [Solid; 2] = [Solid::ZERO, Solid::new(3.0, 4.0, 12.0)];

    fn area(wall: &WallGeometry) -> f64 {
        let corner = |place: u32| Solid::from_array(wall.points[place as usize]);
        let triangles = wall.triangles.iter().map(|triangle| triangle.map(corner));
        triangles.map(|[a, b, c]| 0.5 * (b - a).cross(c - a).length()).sum()
    }

    fn one<V: Space>(surface: Surface<V>) -> WallGeometry {
        walls(&[SurfaceWall::still(surface, Species(0))], BOX).remove(0)
    }

    #[test]
    fn surfaces_keep_their_areas() {
        let panel = Panel { corner: Solid::X, along: Solid::new(0.0, 2.0, 0.0), across: Solid::new(0.0, 0.0, 3.0) };
        assert!((area(&one(Surface::Panel(panel))) - 6.0).abs() < 1e-12);
        // Sectors: the side of a polygon of n corners is 2 r sin(pi/n); a cylinder of it has n flat sides.
        let n = f64::from(SECTORS);
        let half = TAU / 2.0 / f64::from(SECTORS);
        let cylinder = one(Surface::Revolved(Revolved::between(Solid::ZERO, Solid::Z * 2.0, [0.5, 0.5])));
        assert!((area(&cylinder) - 2.0 * n * 2.0 * 0.5 * half.sin()).abs() < 1e-12);
        let plate = one(Surface::Revolved(Revolved::ring(Solid::ZERO, Solid::Y, [0.0, 2.0])));
        assert!((area(&plate) - 0.5 * n * 4.0 * (2.0 * half).sin()).abs() < 1e-12);
        assert_eq!(plate.triangles.len(), SECTORS as usize);
        // A sphere of flat pieces has the area of the sphere but for terms of the square of the angle of a piece.
        let sphere = one(Surface::SphericalZone(SphericalZone::new(Solid::ONE, Solid::X, 2.0, [-2.0, 2.0])));
        let share = area(&sphere) / (4.0 * 0.5 * TAU * 4.0);
        assert!(share < 1.0 && share > 1.0 - (2.0 * half).powi(2), "{share}");
        assert_eq!(sphere.triangles.len(), (SECTORS * (SECTORS - 2)) as usize);
        let ball = one(Surface::Ball(Ball { centre: Solid::ONE, radius: 2.0 }));
        assert!((area(&ball) / area(&sphere) - 1.0).abs() < 1e-12);
        let disc = one(Surface::Ball(Ball { centre: Plane::ONE, radius: 2.0 }));
        let corner = |place: u32| Solid::from_array(disc.points[place as usize]);
        let round: f64 = disc.lines.iter().map(|line| corner(line[0]).distance(corner(line[1]))).sum();
        assert!((round - n * 2.0 * 2.0 * half.sin()).abs() < 1e-12 && disc.lines.len() == SECTORS as usize, "{round}");
        // A slope of 45 degrees with a round hole of radius 0.7 m, seen from above, as a polygon. Every edge but the borders and the rim
        // belongs to two triangles.
        let slope = Panel { corner: Solid::ZERO, along: Solid::new(3.0, 0.0, 3.0), across: Solid::Y * 4.0 };
        let prism = Prism::circle(Solid::new(1.5, 2.0, 0.0), Solid::Z, 0.7);
        let hole = one(Surface::Trimmed(Box::new(Trimmed::with_hole(Whole::Panel(slope), prism))));
        let cut = 0.5 * n * 0.49 * (2.0 * half).sin() * 2f64.sqrt();
        assert!((area(&hole) - (12.0 * 2f64.sqrt() - cut)).abs() < 1e-12);
        let on_rim = |n: f64| {
            Solid::new(0.7 * (2.0 * half * n).cos(), 0.7 * (2.0 * half * n).sin(), 0.7 * (2.0 * half * n).cos())
        };
        let rim: f64 = (0..SECTORS).map(|n| on_rim(f64::from(n)).distance(on_rim(f64::from(n + 1)))).sum();
        let borders = 2.0 * (3.0 * 2f64.sqrt() + 4.0);
        assert!((open_edges(&hole) - borders - rim).abs() < 1e-6, "{} {borders} {rim}", open_edges(&hole));
        // The diagonal of the box is 13 m.
        let ground = one(Surface::HalfPlane(HalfPlane { point: Solid::ZERO, normal: Solid::Z }));
        assert!((area(&ground) - 13.0 * 13.0).abs() < 1e-9 && ground.points.iter().all(|point| point[2].abs() < 1e-12));
    }

    /// Sum of the lengths of the edges that belong to one triangle alone. Corners are the same if they agree within a nanometre.
    fn open_edges(wall: &WallGeometry) -> f64 {
        let corner = |place: u32| Solid::from_array(wall.points[place as usize]);
        let edges: Vec<_> = wall
            .triangles
            .iter()
            .flat_map(|[a, b, c]| [[a, b], [b, c], [c, a]])
            .map(|ends| ends.map(|end| corner(*end)))
            .collect();
        let are_near = |a: Solid, b: Solid| a.distance(b) < 1e-9;
        let are_same = |[a, b]: [Solid; 2], [c, d]: [Solid; 2]| {
            (are_near(a, c) && are_near(b, d)) || (are_near(a, d) && are_near(b, c))
        };
        let alone = edges.iter().filter(|edge| edges.iter().filter(|other| are_same(**edge, **other)).count() == 1);
        alone.map(|[from, to]| from.distance(*to)).sum()
    }

    #[test]
    fn only_walls_that_change_are_listed() {
        let surface = |x: f64| Surface::HalfPlane(HalfPlane { point: Plane::new(x, 0.0), normal: Plane::X });
        let wall = |number, x| SurfaceWall { number, ..SurfaceWall::still(surface(x), Species(0)) };
        let first = walls(&[wall(0, 0.0), wall(1, 1.0), wall(2, 2.0)], BOX);
        let gone = SurfaceWall { is_present: false, ..wall(1, 1.0) };
        let now = changed(&first, walls(&[wall(0, 0.0), gone, wall(2, 2.5)], BOX));
        assert_eq!(now.iter().map(|wall| (wall.number, wall.points.len())).collect::<Vec<_>>(), [(2, 0), (3, 2)]);
        assert!(changed(&first, first.clone()).is_empty());
    }
}
