//! The view of the pictures: lower left and upper right corner, m, in the axes of the [`Camera`].

use crate::scene::loaded::Loaded;
use crate::scene::outputs::Pictures;
use siloflow_dem::space::{Dimension, Linear as _, Plane, Solid, Space, Vector};
use siloflow_dem::walls::surface::Surface;
use siloflow_results::pictures::camera::Camera;

/// Returns the camera of a scene's pictures.
#[must_use]
pub fn camera(loaded: &Loaded, pictures: &Pictures) -> Camera {
    match loaded.scene.space {
        Dimension::Plane => Camera::PLANE,
        Dimension::Solid => Camera::towards(pictures.direction),
    }
}

/// Returns lower left and upper right corner (m) of the pictures: as the scene gives them, or around all of it.
#[must_use]
pub fn of(loaded: &Loaded, pictures: &Pictures) -> (Vector, Vector) {
    let camera = camera(loaded, pictures);
    let given = pictures.view.map(|(low, high)| (low.get(), high.get()));
    given.unwrap_or_else(|| full_view(loaded, &camera))
}

/// Returns the corners of a view (m) that contains all walls, the initial grains, the spawner and the cull line.
fn full_view(loaded: &Loaded, camera: &Camera) -> (Vector, Vector) {
    let corners = match loaded.scene.space {
        Dimension::Plane => corners_in::<Plane>(loaded, camera),
        Dimension::Solid => corners_in::<Solid>(loaded, camera),
    };
    let low = corners.iter().copied().reduce(Vector::min).unwrap_or(Vector::ZERO);
    let high = corners.iter().copied().reduce(Vector::max).unwrap_or(Vector::ONE);
    // The view is at least half as wide as it is high, so that the header fits.
    let size = high - low;
    let margin = Vector::splat(0.04 * size.max_element().max(1e-6));
    let widen = Vector::new((0.25 * size.y - 0.5 * size.x).max(0.0), 0.0);
    (low - margin - widen, high + margin + widen)
}

fn corners_in<V: Space>(loaded: &Loaded, camera: &Camera) -> Vec<Vector> {
    let mut corners: Vec<Vector> = Vec::new();
    let mut ends: Vec<Solid> = Vec::new();
    // A ball, and a box by opposite corners.
    let mut ball = |centre: Solid, radius: f64| {
        let on_paper = camera.on_paper(centre);
        let reach = Vector::splat(radius);
        corners.extend([on_paper - reach, on_paper + reach]);
        ends.push(centre);
    };
    for disc in loaded.wall_discs().iter().chain(&loaded.silo.door) {
        ball(disc.centre.spread(), disc.radius);
    }
    loaded.grains.iter().for_each(|grain| ball(grain.position, grain.reach()));
    loaded.fixed.iter().for_each(|grain| ball(grain.position, grain.radius));
    if let (Some(spawner), Some((_, largest))) = (&loaded.scene.spawner, loaded.grain_radii()) {
        ball(spawner.point.padded(), largest);
    }
    for feed in &loaded.scene.feed {
        let (low, high) = feed.region.bounds();
        let largest = feed.largest_reach();
        for corner in corners_of([low, high]) {
            ball(corner, largest);
        }
    }
    let bounds = |surface: &Surface<V>| surface.bounds().unwrap_or([surface.shape().reference(); 2]).map(V::spread);
    let surfaces = loaded.own_surfaces::<V>();
    surfaces.iter().flat_map(|wall| corners_of(bounds(&wall.surface))).for_each(|corner| ball(corner, 0.0));
    if let (Some(cull), Some(low), Some(high)) =
        (loaded.scene.cull, ends.iter().copied().reduce(Solid::min), ends.iter().copied().reduce(Solid::max))
    {
        let mut lowest = 0.5 * (low + high);
        lowest[V::COMPONENTS - 1] = cull.below.get();
        corners.push(camera.on_paper(lowest));
    }
    corners
}

/// Returns the corners of a box.
#[must_use]
pub fn corners_of([low, high]: [Solid; 2]) -> [Solid; 8] {
    std::array::from_fn(|place| {
        let pick = |axis: usize| if place >> axis & 1 == 0 { low[axis] } else { high[axis] };
        Solid::new(pick(0), pick(1), pick(2))
    })
}
