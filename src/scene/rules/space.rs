//! Rules on the number of vector components, which must match the scene's space.

use crate::door::DoorMotion;
use crate::grains::region::Region;
use crate::grains::shaped::OrientationLaw;
use crate::scene::Scene;
use crate::scene::loaded::Loaded;
use siloflow_dem::space::Dimension;
use siloflow_dem::values::FiniteVector;
use siloflow_dem::walls::free::Freedom;
use siloflow_dem::walls::motion::Course;
use siloflow_text::fault::Fault;

/// Every vector must have as many components as the scene's space, and planar objects must not stand in solid space.
///
/// # Errors
/// The first vector or object that does not fit.
pub fn space(loaded: &Loaded) -> Result<(), Fault> {
    let scene = &loaded.scene;
    let wanted = scene.space.count();
    for (key, vector) in vectors(scene) {
        if vector.count() != wanted {
            let message = format!("`space` is {:?}: expected {wanted} numbers, got {}", scene.space, vector.count());
            return Err(loaded
                .fault("scene::dimension", &key, message)
                .help("vectors are (x, y) in the plane and (x, y, z) with `space: Solid`"));
        }
    }
    let on_paper = scene.pictures.iter().filter_map(|pictures| pictures.view).flat_map(|(low, high)| [low, high]);
    let in_the_plane = scene.bed.iter().filter(|_| scene.space == Dimension::Plane).flat_map(|bed| [bed.low, bed.high]);
    for (key, vector) in on_paper.map(|v| ("pictures.view", v)).chain(in_the_plane.map(|v| ("bed", v))) {
        if vector.count() != 2 {
            return Err(loaded
                .fault("scene::dimension", key, format!("expected 2 numbers, got {}", vector.count()))
                .help("a view has corners on paper: (x, y), of solid space (x, z)"));
        }
    }
    let is_solid = scene.space == Dimension::Solid;
    let disc = scene.feed.iter().position(|feed| matches!(feed.region, Region::Disc { .. }));
    let solid_wall = scene.walls.iter().position(|wall| wall.shape.needs_solid_space());
    let misplaced = [
        (is_solid && scene.silo.is_some(), "silo".to_owned(), "a silo file describes discs in the plane"),
        (
            is_solid && scene.bed.is_some(),
            "bed".to_owned(),
            "the bed is measured in the plane; `profiles` work in both",
        ),
        (
            is_solid && scene.flow.is_some(),
            "flow".to_owned(),
            "a field of flow has cells in the plane; `profiles` work in both",
        ),
        (
            !is_solid && disc.is_some(),
            format!("feed[{}].region", disc.unwrap_or(0)),
            "this disc is a region of solid space; in the plane a region is a `Box(low: ..., high: ...)`",
        ),
        (!is_solid && scene.periodic.z.is_some(), "periodic.z".to_owned(), "the plane has no z"),
        (
            !is_solid && solid_wall.is_some(),
            format!("walls[{}]", solid_wall.unwrap_or(0)),
            "panels, polygons, cylinders, cones and rings are walls of solid space",
        ),
    ];
    match misplaced.into_iter().find(|(wrong, ..)| *wrong) {
        Some((_, key, message)) => Err(loaded
            .fault("scene::dimension", &key, message)
            .help("remove it, or choose the other `space`: Plane or Solid")),
        None => Ok(()),
    }
}

/// The directions of shaped grains, with their keys.
fn orientations(scene: &Scene) -> Vec<(String, FiniteVector)> {
    let fills = scene.fill.iter().enumerate().map(|(index, fill)| (format!("fill[{index}]"), fill.orientation));
    let feeds = scene.feed.iter().enumerate().map(|(index, feed)| (format!("feed[{index}]"), feed.orientation));
    let spawner = scene.spawner.iter().map(|spawner| ("spawner".to_owned(), spawner.orientation));
    let direction = |(key, law): (String, Option<OrientationLaw>)| match law? {
        OrientationLaw::Along(direction) => Some((format!("{key}.orientation"), direction)),
        OrientationLaw::Random => None,
    };
    fills.chain(feeds).chain(spawner).filter_map(direction).collect()
}

/// All vectors of a scene that must match its space, with their keys.
fn vectors(scene: &Scene) -> Vec<(String, FiniteVector)> {
    let of_walls = scene.walls.iter().enumerate().flat_map(|(index, wall)| {
        wall.shape.vectors().into_iter().map(move |(name, vector)| (format!("walls[{index}].{name}"), vector))
    });
    let mut all: Vec<_> = std::iter::once(("gravity".to_owned(), scene.gravity)).chain(of_walls).collect();
    let mut add = |key: String, vectors: &[(&str, Option<FiniteVector>)]| {
        let given = vectors.iter().filter_map(|&(name, vector)| Some((format!("{key}{name}"), vector?)));
        all.extend(given);
    };
    if let Some(spawner) = &scene.spawner {
        let vectors =
            [("point", Some(spawner.point)), ("jitter", spawner.jitter), ("velocity", Some(spawner.velocity))];
        add("spawner.".to_owned(), &vectors);
    }
    for (index, feed) in scene.feed.iter().enumerate() {
        let key = format!("feed[{index}].");
        match feed.region {
            Region::Box { low, high } => {
                add(format!("{key}region."), &[("low", Some(low)), ("high", Some(high))]);
            }
            Region::Disc { centre, .. } => add(format!("{key}region."), &[("centre", Some(centre))]),
        }
        add(key, &[("velocity", Some(feed.velocity)), ("agitation", feed.agitation)]);
    }
    if let Some(zones) = scene.outflow.and_then(|outflow| outflow.mass_flow) {
        add("outflow.mass_flow.".to_owned(), &[("axis", Some(zones.axis))]);
    }
    if let Some(kick) = scene.kick {
        add("kick.".to_owned(), &[("acceleration", Some(kick.acceleration))]);
    }
    for (index, motion) in scene.motions.iter().enumerate() {
        let key = format!("motions[{index}].");
        match motion.translate {
            Some(Course::Steady(velocity)) => add(key.clone(), &[("translate", Some(velocity))]),
            Some(Course::Oscillate { amplitude, .. }) => add(key.clone(), &[("translate.amplitude", Some(amplitude))]),
            Some(Course::Table { .. }) | None => {}
        }
        // The rules on motions tell that the plane has no other axis.
        let about = motion.rotate.as_ref().map(|turn| turn.about);
        let axis = motion.rotate.as_ref().and_then(|turn| turn.axis).filter(|_| scene.space == Dimension::Solid);
        add(key, &[("rotate.about", about), ("rotate.axis", axis)]);
    }
    for (index, free) in scene.free_walls.iter().enumerate() {
        let key = format!("free_walls[{index}].");
        let (direction, point, axis) = match &free.moves {
            Freedom::Along(direction) => (Some(*direction), None, None),
            Freedom::About { point, axis } => (None, Some(*point), axis.filter(|_| scene.space == Dimension::Solid)),
        };
        add(key, &[("moves", direction), ("moves.point", point), ("moves.axis", axis), ("centre", free.centre)]);
    }
    for (_, key, control) in scene.door_controls() {
        if let DoorMotion::Move { by, .. } = control.how {
            add(key, &[(".how.by", Some(by))]);
        }
    }
    for (name, shape) in &scene.shapes {
        for (key, vector) in shape.vectors() {
            add(format!("shapes.{name}"), &[(&key, Some(vector))]);
        }
    }
    for (key, direction) in orientations(scene) {
        add(key, &[("", Some(direction))]);
    }
    for (index, fill) in scene.fill.iter().enumerate() {
        let corners = [("low", Some(fill.low)), ("high", Some(fill.high))];
        add(format!("fill[{index}]."), &corners);
        add(format!("fill[{index}]."), &[("velocity", fill.velocity), ("agitation", fill.agitation)]);
    }
    all
}
