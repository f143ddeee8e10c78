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

/// Returns the part of a view that has grains: the box around `grains`, m, with a margin. The walls there are in the view, longer ones are cut.
/// Walls that move are part of the story, so then nothing is cut.
#[must_use]
pub fn around(loaded: &Loaded, (low, high): (Vector, Vector), grains: (Vector, Vector)) -> (Vector, Vector) {
    if has_moving_walls(loaded) {
        return (low, high);
    }
    let largest = loaded.grain_radii().map_or(0.0, |(_, largest)| largest);
    let margin = Vector::splat(0.06 * (grains.1 - grains.0).max_element() + 2.0 * largest);
    let part = (low.max(grains.0 - margin), high.min(grains.1 + margin));
    if part.0.cmplt(part.1).all() { widened(part) } else { (low, high) }
}

fn has_moving_walls(loaded: &Loaded) -> bool {
    !loaded.scene.motions.is_empty() || !loaded.scene.free_walls.is_empty()
}

/// Returns a view that is at least half as wide as it is high, so that the header fits.
fn widened((low, high): (Vector, Vector)) -> (Vector, Vector) {
    let size = high - low;
    let more = Vector::new((0.25 * size.y - 0.5 * size.x).max(0.0), 0.0);
    (low - more, high + more)
}

/// Longest way of falling grains in a view, from the lowest place of walls and entering grains, over the height from there to the highest one.
const FALL: f64 = 0.5;

/// Returns the corners of a view (m) that contains the walls as high as grains can come, the initial grains, the spawner, and below them the cull line if it
/// is near.
fn full_view(loaded: &Loaded, camera: &Camera) -> (Vector, Vector) {
    let corners = match loaded.scene.space {
        Dimension::Plane => corners_in::<Plane>(loaded, camera),
        Dimension::Solid => corners_in::<Solid>(loaded, camera),
    };
    let low = corners.iter().copied().reduce(Vector::min).unwrap_or(Vector::ZERO);
    let high = corners.iter().copied().reduce(Vector::max).unwrap_or(Vector::ONE);
    let margin = Vector::splat(0.04 * (high - low).max_element().max(1e-6));
    let (low, high) = widened((low, high));
    (low - margin, high + margin)
}

/// The things that a view must show, gathered one by one.
struct Contents<'a> {
    camera: &'a Camera,
    /// Corners in the axes of the camera, m.
    corners: Vec<Vector>,
    /// Lowest and highest coordinates of centres and of corners of walls, m.
    ends: Option<[Solid; 2]>,
    /// Direction against gravity; zero without.
    up: Solid,
    /// Acceleration of gravity, m/s^2.
    gravity: f64,
    /// The greatest height of grains, m along `up`.
    top: Option<f64>,
}

impl<'a> Contents<'a> {
    fn new(loaded: &Loaded, camera: &'a Camera) -> Self {
        let gravity = loaded.scene.gravity.padded();
        let up = -gravity.normalize_or_zero();
        Self { camera, corners: Vec::new(), ends: None, up, gravity: gravity.length(), top: None }
    }

    fn ball(&mut self, centre: Solid, radius: f64) {
        let on_paper = self.camera.on_paper(centre);
        let reach = Vector::splat(radius);
        self.corners.extend([on_paper - reach, on_paper + reach]);
        self.ends = Some(self.ends.map_or([centre; 2], |[low, high]| [low.min(centre), high.max(centre)]));
    }

    /// Adds a grain that enters here with this velocity, m/s.
    fn grain(&mut self, centre: Solid, radius: f64, velocity: Solid) {
        self.ball(centre, radius);
        let speed = velocity.dot(self.up).max(0.0);
        let rise = if speed > 0.0 { 0.5 * speed * speed / self.gravity } else { 0.0 };
        let top = centre.dot(self.up) + radius + rise;
        self.top = Some(self.top.map_or(top, |before| before.max(top)));
    }

    /// Adds a corner of a wall, no higher than grains can come if they only fall.
    fn corner_of_wall(&mut self, corner: Solid) {
        let above = self.top.map_or(0.0, |top| (corner.dot(self.up) - top).max(0.0));
        self.ball(corner - self.up * above, 0.0);
    }
}

fn corners_in<V: Space>(loaded: &Loaded, camera: &Camera) -> Vec<Vector> {
    let scene = &loaded.scene;
    let mut contents = Contents::new(loaded, camera);
    loaded.grains.iter().for_each(|grain| contents.grain(grain.position, grain.reach(), grain.velocity));
    if let (Some(spawner), Some((_, largest))) = (&scene.spawner, loaded.grain_radii()) {
        contents.grain(spawner.point.padded(), largest, spawner.velocity.padded());
    }
    for feed in &scene.feed {
        let (low, high) = feed.region.bounds();
        let largest = feed.largest_reach();
        for corner in corners_of([low, high]) {
            contents.grain(corner, largest, feed.velocity.padded());
        }
    }
    if has_moving_walls(loaded) {
        // They may lift grains to any height.
        contents.top = None;
    }
    for disc in loaded.wall_discs().iter().chain(&loaded.silo.door) {
        contents.ball(disc.centre.spread(), disc.radius);
    }
    loaded.fixed.iter().for_each(|grain| contents.ball(grain.position, grain.radius));
    let bounds = |surface: &Surface<V>| surface.bounds().unwrap_or([surface.shape().reference(); 2]).map(V::spread);
    let surfaces = loaded.own_surfaces::<V>();
    surfaces
        .iter()
        .flat_map(|wall| corners_of(bounds(&wall.surface)))
        .for_each(|corner| contents.corner_of_wall(corner));
    if let (Some(cull), Some([low, high])) = (scene.cull, contents.ends) {
        let mut lowest = 0.5 * (low + high);
        let heights = [low, high].map(|end| end[V::COMPONENTS - 1]);
        lowest[V::COMPONENTS - 1] = cull.below.get().max(heights[0] - FALL * (heights[1] - heights[0]));
        contents.corners.push(camera.on_paper(lowest));
    }
    contents.corners
}

/// Returns the corners of a box.
#[must_use]
pub fn corners_of([low, high]: [Solid; 2]) -> [Solid; 8] {
    std::array::from_fn(|place| {
        let pick = |axis: usize| if place >> axis & 1 == 0 { low[axis] } else { high[axis] };
        Solid::new(pick(0), pick(1), pick(2))
    })
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::scene::load;

    const FILL: &str = "fill: [(low: (0.0, 0.0), high: (1.0, 2.0), spacing: 0.2, radius: Fixed(0.05))]";

    /// Returns a silo of 1 m by 10 m with the given keys.
    fn silo(keys: &str) -> Loaded {
        let side = |x: f64| format!("Segment(from: ({x:?}, 0.0), to: ({x:?}, 10.0))");
        let text = format!(
            "(title: \"silo\", gravity: (0.0, -10.0), walls: [{}, {}, Segment(from: (0.2, 3.0), to: (0.8, 3.0), name: \"paddle\")], contact: Linear(k: 1.0e5, damping: Restitution(0.5)), \
             mass: Disc(1000.0), step: Fixed(1.0e-3), until: 1.0, {keys})",
            side(0.0),
            side(1.0)
        );
        load::from_text("silo.ron", "silo", Path::new(""), text, &[]).unwrap()
    }

    /// Returns the top of the view, m.
    fn top(keys: &str) -> f64 {
        of(&silo(keys), &Pictures::default()).1.y
    }

    #[test]
    fn walls_end_where_grains_can_come() {
        // The margin is 0.04 of the height.
        assert!((1.9..=2.0 * 1.04).contains(&top(FILL)), "{}", top(FILL));
        // A grain rises by v^2/(2 g) = 5 m.
        let thrown = |velocity: &str| {
            format!(
                "{FILL}, spawner: (point: (0.5, 2.5), velocity: {velocity}, interval: 1.0, count: 1, radius: Fixed(0.05))"
            )
        };
        assert!((2.55..2.7).contains(&top(&thrown("(0.0, -10.0)"))));
        // Both have the same margin: 0.04 of the height.
        let rise = top(&thrown("(0.0, 10.0)")) - top(&thrown("(0.0, 0.0)"));
        assert!((rise - 5.0 * 1.04).abs() < 1e-9, "{rise}");
        // Without grains, or where walls may lift them, all of the walls are in the view.
        for keys in
            ["", &format!("{FILL}, motions: [(walls: \"paddle\", rotate: (about: (0.5, 3.0), by: Steady(1.0)))]")]
        {
            assert!((10.0..10.5).contains(&top(keys)), "{keys}");
        }
    }

    #[test]
    fn the_space_below_a_silo_ends_at_the_cull_line_or_at_half_of_its_height() {
        // The silo is as high as its grains, 2 m, and the margin 0.04 of all.
        for (cull, height) in [(-0.5, 2.4), (-1.0, 2.9), (-30.0, 2.9)] {
            let (low, high) = of(&silo(&format!("{FILL}, cull: (below: {cull:?})")), &Pictures::default());
            let found = high.y - low.y;
            assert!((height..=1.08 * (height + 0.1)).contains(&found), "{cull}: {found}");
        }
    }

    #[test]
    fn a_view_around_grains_has_nothing_but_their_surroundings() {
        let loaded = silo(FILL);
        let view = (Vector::new(-1.0, -1.0), Vector::new(9.0, 9.0));
        // 0.06 of 2 m and two radii of 0.05 m.
        let margin = 0.22;
        let found = around(&loaded, view, (Vector::new(1.0, -5.0), Vector::new(3.0, -3.0)));
        assert_eq!(found, view, "no grain is in the view");
        let (low, high) = around(&loaded, view, (Vector::new(1.0, 2.0), Vector::new(3.0, 3.0)));
        assert!((low - Vector::new(1.0 - margin, 2.0 - margin)).length() < 1e-12, "{low}");
        assert!((high - Vector::new(3.0 + margin, 3.0 + margin)).length() < 1e-12, "{high}");
        // Half as wide as high, at least.
        let (low, high) = around(&loaded, view, (Vector::new(4.0, -3.0), Vector::new(4.0, 4.0)));
        assert!((high.x - low.x - 0.5 * (high.y - low.y)).abs() < 1e-12, "{low} {high}");
        assert!((low.y + 1.0).abs() < 1e-12, "{low}");
    }
}
