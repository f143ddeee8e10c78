//! The view of the pictures: lower left and upper right corner, m. Solid space is seen along y, so that its view is in x and z.

use crate::scene::load::Loaded;
use crate::scene::outputs::Pictures;
use crate::space::{Dimension, Plane, Solid, Space, Vector};
use crate::walls::shapes::Shape as _;
use crate::walls::surfaces::Surface;

/// Returns lower left and upper right corner (m) of the pictures: as the scene gives them, or around all of it.
#[must_use]
pub fn of(loaded: &Loaded, pictures: &Pictures) -> (Vector, Vector) {
    pictures.view.map_or_else(|| full_view(loaded), |(low, high)| (low.get(), high.get()))
}

/// Returns the corners of a view (m) that contains all walls, the initial grains, the spawner and the cull line.
fn full_view(loaded: &Loaded) -> (Vector, Vector) {
    match loaded.scene.space {
        Dimension::Plane => full_view_in::<Plane>(loaded),
        Dimension::Solid => full_view_in::<Solid>(loaded),
    }
}

fn full_view_in<V: Space>(loaded: &Loaded) -> (Vector, Vector) {
    let disc = |centre: Vector, radius: f64| [centre - Vector::splat(radius), centre + Vector::splat(radius)];
    let paper = |x: Solid| V::narrow(x).on_paper();
    let mut corners: Vec<Vector> = Vec::new();
    corners.extend(loaded.wall_discs().iter().chain(&loaded.silo.door).flat_map(|d| disc(d.centre, d.radius)));
    corners.extend(loaded.grains.iter().flat_map(|g| disc(paper(g.position), g.radius)));
    corners.extend(loaded.fixed.iter().flat_map(|g| disc(paper(g.position), g.radius)));
    if let (Some(spawner), Some((_, largest))) = (&loaded.scene.spawner, loaded.grain_radii()) {
        corners.extend(disc(spawner.point.get::<V>().on_paper(), largest));
    }
    for feed in &loaded.scene.feed {
        let ((low, high), (_, largest)) = (feed.region.bounds(), feed.radius.range());
        corners.extend([low, high].into_iter().flat_map(|corner| disc(paper(corner), largest)));
    }
    let surfaces = loaded.surfaces::<V>();
    let ends = |surface: &Surface<V>| surface.bounds().unwrap_or([surface.reference(); 2]);
    corners.extend(surfaces.iter().flat_map(|wall| ends(&wall.surface)).map(Space::on_paper));
    if let (Some(cull), Some(any)) = (loaded.scene.cull, corners.first().copied()) {
        corners.push(Vector::new(any.x, cull.below.get()));
    }
    let low = corners.iter().copied().reduce(Vector::min).unwrap_or(Vector::ZERO);
    let high = corners.iter().copied().reduce(Vector::max).unwrap_or(Vector::ONE);
    // The view is at least half as wide as it is high, so that the header fits.
    let size = high - low;
    let margin = Vector::splat(0.04 * size.max_element().max(1e-6));
    let widen = Vector::new((0.25 * size.y - 0.5 * size.x).max(0.0), 0.0);
    (low - margin - widen, high + margin + widen)
}
