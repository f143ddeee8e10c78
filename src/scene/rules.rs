//! Rules across keys: what one number's range cannot say.

use crate::contact::Contact;
use crate::contact::config::{Friction, PairOfSpecies};
use crate::door::{DoorMotion, DoorOpens};
use crate::fault::Fault;
use crate::grains::spawner::RadiusLaw;
use crate::integrate::Integrator;
use crate::neighbours::Neighbours;
use crate::particle::GrainId;
use crate::scene::Scene;
use crate::scene::load::Loaded;
use crate::scene::values::FiniteVector;
use crate::space::{Dimension, Solid};
use crate::walls::surfaces::Wall;

/// Checks a scene whose files have been read.
///
/// # Errors
/// The first rule that it breaks, pointing at the key.
pub fn check(loaded: &Loaded) -> Result<(), Fault> {
    contacts(loaded)?;
    fill(loaded)?;
    walls(loaded)?;
    periodic(loaded)?;
    spawner(loaded)?;
    door_and_rest(loaded)?;
    cells(loaded)?;
    profiles(loaded)?;
    pictures_and_bed(loaded)
}

fn profiles(loaded: &Loaded) -> Result<(), Fault> {
    for (index, profile) in loaded.scene.profiles.iter().enumerate() {
        let key = |name: &str| format!("profiles[{index}].{name}");
        let (code, key, message) = if profile.axis.number() >= loaded.scene.space.count() {
            ("scene::dimension", key("axis"), "the plane has no z")
        } else if profile.low.get() >= profile.high.get() {
            ("scene::empty_box", key("high"), "the first bin must begin below the end of the last one")
        } else if !(1..=10_000).contains(&profile.bins) {
            ("scene::out_of_range", key("bins"), "expected 1 to 10000 bins")
        } else if profile.section.is_none() && loaded.periodic_section(profile).is_none() {
            ("scene::missing_key", key("section"), "a packing fraction needs to know the section of the bins")
        } else {
            continue;
        };
        return Err(loaded.fault(code, &key, message).help(
            "give the area at right angles to the axis, m^2 (in the plane its length, m), `low` and `high` in m",
        ));
    }
    Ok(())
}

/// Every vector has as many components as the scene's space, and nothing planar stands in solid space.
///
/// # Errors
/// If one has not.
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
    let panel = scene.walls.iter().position(|wall| matches!(wall, Wall::Panel { .. }));
    let misplaced = [
        (is_solid && scene.silo.is_some(), "silo".to_owned(), "a silo file describes discs in the plane"),
        (
            is_solid && scene.bed.is_some(),
            "bed".to_owned(),
            "the bed is measured in the plane; `profiles` work in both",
        ),
        (!is_solid && scene.periodic.z.is_some(), "periodic.z".to_owned(), "the plane has no z"),
        (
            !is_solid && panel.is_some(),
            format!("walls[{}]", panel.unwrap_or(0)),
            "a panel is a rectangle in solid space",
        ),
    ];
    match misplaced.into_iter().find(|(wrong, ..)| *wrong) {
        Some((_, key, message)) => Err(loaded
            .fault("scene::dimension", &key, message)
            .help("remove it, or choose the other `space`: Plane or Solid")),
        None => Ok(()),
    }
}

/// All vectors of a scene that count in its space, with their keys.
fn vectors(scene: &Scene) -> Vec<(String, FiniteVector)> {
    let mut all = vec![("gravity".to_owned(), scene.gravity)];
    let mut add = |key: String, vectors: &[(&str, Option<FiniteVector>)]| {
        let given = vectors.iter().filter_map(|&(name, vector)| Some((format!("{key}{name}"), vector?)));
        all.extend(given);
    };
    for (index, wall) in scene.walls.iter().enumerate() {
        let key = format!("walls[{index}].");
        match *wall {
            Wall::HalfPlane { point, normal, velocity, .. } => {
                add(key, &[("point", Some(point)), ("normal", Some(normal)), ("velocity", velocity)]);
            }
            Wall::Segment { from, to, .. } => add(key, &[("from", Some(from)), ("to", Some(to))]),
            Wall::Panel { corner, along, across, .. } => {
                add(key, &[("corner", Some(corner)), ("along", Some(along)), ("across", Some(across))]);
            }
            Wall::Disc { centre, .. } => add(key, &[("centre", Some(centre))]),
        }
    }
    if let Some(spawner) = &scene.spawner {
        let vectors =
            [("point", Some(spawner.point)), ("jitter", spawner.jitter), ("velocity", Some(spawner.velocity))];
        add("spawner.".to_owned(), &vectors);
    }
    for (index, fill) in scene.fill.iter().enumerate() {
        let corners = [("low", Some(fill.low)), ("high", Some(fill.high))];
        add(format!("fill[{index}]."), &corners);
        add(format!("fill[{index}]."), &[("velocity", fill.velocity), ("agitation", fill.agitation)]);
    }
    all
}

/// Laws of pairs have the terms of the usual one, and what a law needs is there.
fn contacts(loaded: &Loaded) -> Result<(), Fault> {
    let scene = &loaded.scene;
    for (index, pair) in scene.pairs.iter().enumerate() {
        let is_same = |other: &PairOfSpecies| {
            let (a, b) = other.species;
            pair.species == (a, b) || pair.species == (b, a)
        };
        if scene.pairs[..index].iter().any(is_same) {
            return Err(loaded
                .fault("scene::pair_twice", &format!("pairs[{index}].species"), "this pair stands here twice")
                .help("(0, 1) and (1, 0) are the same pair; remove one"));
        }
        if pair.contact.kind() != scene.contact.kind() {
            let message = format!("this is {}, but `contact` is {}", pair.contact.kind(), scene.contact.kind());
            return Err(loaded
                .fault("scene::kind_of_law", &format!("pairs[{index}].contact"), message)
                .help("all pairs have the same kind of law with other numbers; friction may be 0"));
        }
    }
    let of_pairs =
        (0..).zip(&scene.pairs).map(|(index, pair): (usize, _)| (format!("pairs[{index}].contact"), pair.contact));
    for (key, law) in of_pairs.chain([("contact".to_owned(), scene.contact)]) {
        let rolls_without_sticking = match law {
            Contact::Linear { tangential, rolling: Some(_), .. } => {
                !matches!(tangential, Some(Friction::Spring { .. }))
            }
            Contact::Hertz { tangential: None, rolling: Some(_), .. } => true,
            _ => false,
        };
        if rolls_without_sticking {
            return Err(loaded
                .fault("scene::rolling_alone", &format!("{key}.rolling"), "rolling resistance needs friction with memory")
                .help("add `tangential: Spring(k: ..., damping: ..., friction: ...)`, with Hertz `Mindlin(friction: ...)`"));
        }
    }
    if matches!(scene.contact, Contact::Hertz { .. }) && scene.materials.is_empty() {
        return Err(loaded
            .fault("scene::missing_key", "materials", "Hertz's law needs to know the elastic materials")
            .help("add for example `materials: [(young: 1.0e9, poisson: 0.2)]`, in Pa, one for each species"));
    }
    if scene.contact.spins() && scene.integrator == Integrator::ExplicitEuler {
        return Err(loaded
            .fault("scene::integrator", "integrator", "explicit Euler does not turn grains")
            .help("use `Verlet`, or leave `tangential` out of the contact law"));
    }
    if scene.materials.len() > 1 && loaded.largest_species() >= scene.materials.len() {
        let message =
            format!("there are {} materials, but species go up to {}", scene.materials.len(), loaded.largest_species());
        return Err(loaded
            .fault("scene::missing_material", "materials", message)
            .help("give one material for all, or one for each species from 0 on"));
    }
    if scene.inertia.is_some() && !scene.contact.spins() {
        return Err(loaded
            .fault("scene::no_spin", "inertia", "without a tangential force grains do not spin")
            .help("remove `inertia`, or add `tangential` to the contact law"));
    }
    Ok(())
}

fn fill(loaded: &Loaded) -> Result<(), Fault> {
    let scene = &loaded.scene;
    let mut wanted: usize = 0;
    for (index, fill) in scene.fill.iter().enumerate() {
        let key = |name: &str| format!("fill[{index}].{name}");
        if !is_box(fill.low, fill.high) {
            return Err(loaded
                .fault("scene::empty_box", &key("low"), "the lower corner must be below the upper one along every axis")
                .help("corners are in m"));
        }
        let Some(length) = fill.size(scene.space) else {
            return Err(loaded
                .fault("scene::out_of_range", &key("spacing"), "more than 1e7 grains would fit")
                .help("is the spacing, in m, right? A `count` bounds the number"));
        };
        if length < fill.count.unwrap_or(1) {
            let message = format!("{} grains are wanted, but {length} fit", fill.count.unwrap_or(1));
            return Err(loaded
                .fault("scene::out_of_range", &key("high"), message)
                .help("raise the box, or lower the spacing"));
        }
        if !fill.fixed && scene.mass.is_none() {
            return Err(loaded
                .fault("scene::missing_key", "mass", "`fill` needs to know how heavy its grains are")
                .help("add for example `mass: Sphere(2500.0)`, m = rho 4/3 pi R^3 in kg/m^3"));
        }
        radii(loaded, &key("radius"), &fill.radius, fill.species)?;
        wanted += if fill.fixed { 0 } else { length as usize };
        if wanted > loaded.grains.len() {
            return Err(loaded
                .fault("scene::out_of_range", &key("count"), "there are not enough ids left for these grains")
                .help("ids go up to 2147483647: give the grains of the file lower ones"));
        }
    }
    Ok(())
}

/// A grain must not touch another one, nor itself, twice.
fn periodic(loaded: &Loaded) -> Result<(), Fault> {
    for (name, side) in ["x", "y", "z"].into_iter().zip(loaded.scene.periodic.axes()) {
        let Some((low, high)) = side else { continue };
        let needed = 2.0 * loaded.contact_range();
        let length = high - low;
        if !(length.is_finite() && length > needed) {
            let message = format!(
                "the box is {length} m long, but grains touch at up to {} m: one could touch another twice",
                0.5 * needed
            );
            return Err(loaded
                .fault("scene::box_too_small", &format!("periodic.{name}"), message)
                .help(format!("give (low, high) in m, more than {needed} m apart")));
        }
    }
    Ok(())
}

fn walls(loaded: &Loaded) -> Result<(), Fault> {
    for (index, wall) in loaded.scene.walls.iter().enumerate() {
        let (key, message) = match wall {
            Wall::HalfPlane { normal, .. } if has_no_direction(normal.padded()) => {
                ("normal", "the normal has no direction")
            }
            Wall::HalfPlane { normal, velocity: Some(velocity), .. }
                if is_oblique(velocity.padded(), normal.padded()) =>
            {
                ("velocity", "a half-plane moves along itself only: its velocity must be at right angles to its normal")
            }
            Wall::Segment { from, to, .. } if has_no_direction(to.padded() - from.padded()) => {
                ("to", "the segment has no length")
            }
            Wall::Panel { along, .. } if has_no_direction(along.padded()) => ("along", "the panel has no length"),
            Wall::Panel { across, .. } if has_no_direction(across.padded()) => ("across", "the panel has no width"),
            Wall::Panel { along, across, .. } if is_oblique(along.padded(), across.padded()) => {
                ("across", "the edges of a panel must be at right angles to each other")
            }
            _ => continue,
        };
        return Err(loaded
            .fault("scene::degenerate_wall", &format!("walls[{index}].{key}"), message)
            .help("give two different points, a normal with a direction, edges and belts at right angles"));
    }
    Ok(())
}

/// Whether a vector is zero, or so short or long that its square is no number.
fn has_no_direction(v: Solid) -> bool {
    !v.length_squared().is_normal()
}

/// Whether two vectors are farther from right angles than rounded numbers make them.
fn is_oblique(a: Solid, b: Solid) -> bool {
    a.dot(b).abs() > 1e-9 * a.length() * b.length()
}

fn spawner(loaded: &Loaded) -> Result<(), Fault> {
    let Some(spawner) = &loaded.scene.spawner else { return Ok(()) };
    if loaded.scene.mass.is_none() {
        return Err(loaded
            .fault("scene::missing_key", "mass", "the spawner needs to know how heavy its grains are")
            .help("add for example `mass: ArealSquare(100.0)`, m = rho R^2 in kg/m^2"));
    }
    radii(loaded, "spawner.radius", &spawner.radius, 0)?;
    let room = (GrainId::MAX_GRAIN + 1).saturating_sub(loaded.first_free_id());
    if spawner.count > room {
        let message = format!("{} grains are more than there are ids left, {room}", spawner.count);
        return Err(loaded.fault("scene::out_of_range", "spawner.count", message).help("release fewer grains"));
    }
    Ok(())
}

fn door_and_rest(loaded: &Loaded) -> Result<(), Fault> {
    let Scene { door, rest, gravity, .. } = &loaded.scene;
    let panel = loaded.scene.walls.iter().any(|wall| matches!(wall, Wall::Panel { door: true, .. }));
    if door.is_some() && loaded.silo.door.is_empty() && !panel {
        return Err(loaded
            .fault("scene::no_door", "door", "there is no door to open: no silo file announces door grains")
            .help(
                "remove `door`, or give a silo file whose first line has a second count above 0, or in solid space a \
                 wall `Panel(..., door: true)`",
            ));
    }
    if panel && matches!(door.map(|door| door.how), Some(DoorMotion::Slide(_))) {
        return Err(loaded
            .fault("scene::no_slide", "door.how", "a panel cannot slide")
            .help("write `how: Remove`, or leave the key out"));
    }
    if door.is_some_and(|door| door.opens == DoorOpens::AtRest) && rest.is_none() {
        return Err(loaded
            .fault("scene::missing_key", "rest", "the door opens at rest, but nothing detects rest")
            .help("add `rest: (speed: 2.0e-3, energy: 1.0e-6, hold: 0.1)`"));
    }
    if rest.is_some() && gravity.padded() == Solid::ZERO {
        return Err(loaded
            .fault("scene::no_gravity", "rest", "rest is measured in units of sqrt(g R) and m g R, but gravity is zero")
            .help("remove `rest`, or give `gravity`"));
    }
    Ok(())
}

/// Shares sum to one, and ranges have a smaller end.
fn radii(loaded: &Loaded, key: &str, law: &RadiusLaw, first_species: u8) -> Result<(), Fault> {
    if let RadiusLaw::Mixture(sizes) = law
        && sizes.len() + usize::from(first_species) > 256
    {
        return Err(loaded
            .fault("scene::out_of_range", key, format!("{} sizes are more than there are species, 256", sizes.len()))
            .help("use `Uniform(smallest, largest)` for many sizes"));
    }
    let (smallest, largest) = law.range();
    let masses = loaded.scene.mass.map(|mass| [mass.of(smallest), mass.of(largest)]);
    if masses.is_some_and(|masses| !masses.into_iter().all(f64::is_normal)) {
        return Err(loaded
            .fault("scene::out_of_range", key, "grains of this size have no mass that a double can hold")
            .help("radii are in m"));
    }
    match law {
        RadiusLaw::Mixture(sizes) => {
            let sum: f64 = sizes.iter().map(|(_, share)| share.get()).sum();
            if (sum - 1.0).abs() > 1e-9 {
                let message = format!("the shares of the mixture sum to {sum}, not to 1");
                return Err(loaded
                    .fault("scene::shares", key, message)
                    .help("write (radius in m, share) for each size"));
            }
        }
        RadiusLaw::Uniform(low, high) if low > high => {
            let message = format!("the smaller radius comes first, got {} and {}", low.get(), high.get());
            return Err(loaded.fault("scene::out_of_range", key, message).help("exchange the two"));
        }
        _ => {}
    }
    Ok(())
}

/// A grain looks into its own cell and the eight around it; two centres that are farther apart than a side L can be
/// two cells apart. So L must be at least the largest distance of centres in contact.
fn cells(loaded: &Loaded) -> Result<(), Fault> {
    let largest = loaded.grain_radii().map_or(0.0, |(_, largest)| largest);
    let (key, size) = match loaded.scene.neighbours {
        Some(Neighbours::Cells { size }) => ("neighbours.size", size.get()),
        Some(Neighbours::CellsOfRange { rng }) => ("neighbours.rng", rng.get() * largest),
        _ => return Ok(()),
    };
    let needed = loaded.contact_range();
    if size < needed {
        let message = format!(
            "cells of {size} m are too small: particles touch at up to {needed} m, and a grain looks only one cell far, \
             so contacts would be missed"
        );
        return Err(loaded
            .fault("scene::cells_too_small", key, message)
            .help(format!("give at least {needed} m, the sum of the two largest radii that can meet")));
    }
    Ok(())
}

/// Whether the first corner is below the second along every axis.
fn is_box(low: FiniteVector, high: FiniteVector) -> bool {
    (0..low.count()).all(|axis| low.padded()[axis] < high.padded()[axis])
}

fn pictures_and_bed(loaded: &Loaded) -> Result<(), Fault> {
    let scene = &loaded.scene;
    let view = scene.pictures.as_ref().and_then(|pictures| pictures.view);
    let bed = scene.bed.map(|bed| (bed.low, bed.high));
    for (key, corners) in [("pictures.view", view), ("bed", bed)] {
        if let Some((low, high)) = corners
            && !is_box(low, high)
        {
            return Err(loaded
                .fault("scene::empty_box", key, "the lower left corner must be below and left of the upper right one")
                .help("corners are (x, y) in m"));
        }
    }
    if scene.bed.is_some() && scene.rest.is_none() {
        return Err(loaded
            .fault("scene::missing_key", "rest", "the bed is measured at rest, but nothing detects rest")
            .help("add `rest: (speed: 2.0e-3, energy: 1.0e-6, hold: 0.1)`, or remove `bed`"));
    }
    if let Some(pictures) = &scene.pictures
        && !(50.0..=20_000.0).contains(&pictures.width.get())
    {
        return Err(loaded
            .fault("scene::out_of_range", "pictures.width", "expected a width of 50 to 20000 px")
            .help("600 is a good width"));
    }
    Ok(())
}
