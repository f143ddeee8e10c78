//! Grains of the spawner: one `create_atoms` for each release, at the place and with the size that siloflow draws.
//!
//! A release waits as in [`crate::grains::spawner`], until its place is free: a region around the place must hold no centre. With one radius
//! this is the condition of siloflow; with several, the region is that of the largest. The place is tested several times in an interval.

use std::fmt::Write as _;

use crate::door::DoorOpens;
use crate::grains::file::GrainRow;
use crate::lammps::grains::Particles;
use crate::lammps::quantities::{released, steps};
use crate::lammps::{number, refused, vector};
use crate::scene::loaded::Loaded;
use siloflow_dem::space::{Dimension, Plane, Solid};
use siloflow_text::fault::Fault;

/// Tests of an occupied place in an interval.
const TESTS: u64 = 20;

/// Commands that release the grains of the spawner.
///
/// # Errors
/// If a door opens at a time, which may come before the last release, or places are next to a wall.
pub(super) fn releases(loaded: &Loaded, particles: &Particles) -> Result<String, Fault> {
    let Some(spawner) = loaded.scene.spawner.as_ref().filter(|spawner| spawner.count > 0) else {
        return Ok(String::new());
    };
    let controls = loaded.scene.door_controls();
    if let Some((_, key, _)) =
        controls.iter().find(|(_, _, control)| matches!(control.opens, DoorOpens::At(_) | DoorOpens::Schedule(_)))
    {
        return Err(refused(
            loaded,
            &format!("{key}.opens"),
            "a door that opens at given times is not written for a scene with a spawner",
        )
        .help("export with `opens: AtRest`"));
    }
    let grains = released(loaded);
    let is_clear = |grain: &GrainRow| match loaded.scene.space {
        Dimension::Plane => loaded
            .surfaces::<Plane>()
            .iter()
            .all(|wall| wall.surface.distance(grain.position.truncate()) >= grain.radius),
        Dimension::Solid => {
            loaded.surfaces::<Solid>().iter().all(|wall| wall.surface.distance(grain.position) >= grain.radius)
        }
    };
    if !grains.iter().all(is_clear) {
        return Err(
            refused(loaded, "spawner.point", "a place of release touches a wall").help("move it away from walls")
        );
    }
    let largest = loaded.fixed_radii().chain(grains.iter().map(|grain| grain.radius)).fold(0.0, f64::max);
    let largest = loaded.grains.iter().map(|grain| grain.radius).fold(largest, f64::max);
    let due = |number: u32| steps_from_zero(f64::from(number) * spawner.interval.get() / loaded.step());
    let tested = (due(1) / TESTS).max(1);
    let mut text = String::from("\n# Releases.\n");
    let mut count = loaded.grains.len();
    let mut mass = loaded.grains.iter().map(|grain| grain.mass).sum::<f64>();
    for (order, grain) in (0u32..).zip(&grains) {
        let id = particles.next_id() + order as usize;
        let place = vector(grain.position);
        (count, mass) = (count + 1, mass + grain.mass);
        let _ = write!(
            text,
            "region place sphere {place} {}\n\
             variable taken equal count(all,place)\n\
             label release_{order}\n\
             if \"${{taken}} > 0\" then \"run {tested} post no\" \"jump SELF release_{order}\"\n\
             region place delete\n\
             create_atoms {} single {place} units box\n\
             set atom {id} diameter {} mass {} vx {} vy {} vz {}\n\
             group grains id {id}\n\
             variable released equal {count}\n\
             variable released_kg equal {}\n",
            number(largest + grain.radius),
            grain.species.0 + 1,
            number(2.0 * grain.radius),
            number(grain.mass),
            number(grain.velocity.x),
            number(grain.velocity.y),
            number(grain.velocity.z),
            number(mass),
        );
        if order + 1 < spawner.count {
            let _ = writeln!(text, "run {} post no", (due(order + 1) - due(order)).max(1));
        }
    }
    Ok(text)
}

fn steps_from_zero(ratio: f64) -> u64 {
    if ratio > 0.0 { steps(ratio, 1.0) } else { 0 }
}
