//! Rules across keys: what one number's range cannot say.

use crate::door::DoorOpens;
use crate::fault::Fault;
use crate::grains::spawner::RadiusLaw;
use crate::neighbours::Neighbours;
use crate::particle::GrainId;
use crate::scene::Scene;
use crate::scene::load::Loaded;
use crate::space::Vector;
use crate::walls::surfaces::Wall;

/// Checks a scene whose files have been read.
///
/// # Errors
/// The first rule that it breaks, pointing at the key.
pub fn check(loaded: &Loaded) -> Result<(), Fault> {
    walls(loaded)?;
    spawner(loaded)?;
    door_and_rest(loaded)?;
    cells(loaded)?;
    pictures_and_bed(loaded)
}

fn walls(loaded: &Loaded) -> Result<(), Fault> {
    for (index, wall) in loaded.scene.walls.iter().enumerate() {
        let (key, message) = match wall {
            Wall::HalfPlane { normal, .. } if normal.get() == Vector::ZERO => ("normal", "the normal has no direction"),
            Wall::Segment { from, to } if from == to => ("to", "the segment has no length"),
            _ => continue,
        };
        return Err(loaded
            .fault("scene::degenerate_wall", &format!("walls[{index}].{key}"), message)
            .help("give two different points, or a normal other than (0, 0)"));
    }
    Ok(())
}

fn spawner(loaded: &Loaded) -> Result<(), Fault> {
    let Some(spawner) = &loaded.scene.spawner else { return Ok(()) };
    if loaded.scene.mass.is_none() {
        return Err(loaded
            .fault("scene::missing_key", "mass", "the spawner needs to know how heavy its grains are")
            .help("add for example `mass: ArealSquare(100.0)`, m = rho R^2 in kg/m^2"));
    }
    match &spawner.radius {
        RadiusLaw::Mixture(sizes) => {
            let sum: f64 = sizes.iter().map(|(_, share)| share.get()).sum();
            if (sum - 1.0).abs() > 1e-9 {
                let message = format!("the shares of the mixture sum to {sum}, not to 1");
                return Err(loaded
                    .fault("scene::shares", "spawner.radius", message)
                    .help("write (radius in m, share) for each size"));
            }
        }
        RadiusLaw::Uniform(low, high) if low > high => {
            let message = format!("the smaller radius comes first, got {} and {}", low.get(), high.get());
            return Err(loaded.fault("scene::out_of_range", "spawner.radius", message).help("exchange the two"));
        }
        _ => {}
    }
    let room = (GrainId::MAX_GRAIN + 1).saturating_sub(loaded.first_free_id());
    if spawner.count > room {
        let message = format!("{} grains are more than there are ids left, {room}", spawner.count);
        return Err(loaded.fault("scene::out_of_range", "spawner.count", message).help("release fewer grains"));
    }
    Ok(())
}

fn door_and_rest(loaded: &Loaded) -> Result<(), Fault> {
    let Scene { door, rest, gravity, .. } = &loaded.scene;
    if door.is_some() && loaded.silo.door.is_empty() {
        return Err(loaded
            .fault("scene::no_door", "door", "there is no door to open: no silo file announces door grains")
            .help("remove `door`, or give a silo file whose first line has a second count above 0"));
    }
    if door.is_some_and(|door| door.opens == DoorOpens::AtRest) && rest.is_none() {
        return Err(loaded
            .fault("scene::missing_key", "rest", "the door opens at rest, but nothing detects rest")
            .help("add `rest: (speed: 2.0e-3, energy: 1.0e-6, hold: 0.1)`"));
    }
    if rest.is_some() && gravity.get() == Vector::ZERO {
        return Err(loaded
            .fault("scene::no_gravity", "rest", "rest is measured in units of sqrt(g R) and m g R, but gravity is zero")
            .help("remove `rest`, or give `gravity`"));
    }
    Ok(())
}

/// A grain looks into its own cell and the eight around it; two centres that are farther apart than a side L can be
/// two cells apart. So L must be at least the largest distance of centres in contact.
fn cells(loaded: &Loaded) -> Result<(), Fault> {
    let Some(Neighbours::Cells { size }) = loaded.scene.neighbours else { return Ok(()) };
    let needed = loaded.contact_range();
    if size.get() < needed {
        let message = format!(
            "cells of {} m are too small: particles touch at up to {needed} m, and a grain looks only one cell far, \
             so contacts would be missed",
            size.get()
        );
        return Err(loaded
            .fault("scene::cells_too_small", "neighbours.size", message)
            .help(format!("give at least {needed} m, the sum of the two largest radii that can meet")));
    }
    Ok(())
}

fn pictures_and_bed(loaded: &Loaded) -> Result<(), Fault> {
    let scene = &loaded.scene;
    let view = scene.pictures.as_ref().and_then(|pictures| pictures.view);
    let bed = scene.bed.map(|bed| (bed.low, bed.high));
    for (key, corners) in [("pictures.view", view), ("bed", bed)] {
        if let Some((low, high)) = corners
            && !low.get().cmplt(high.get()).all()
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
