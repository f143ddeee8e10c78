//! A scene as an input of LAMMPS: a script and a data file, for runs on many ranks over MPI.
//!
//! The reference is LAMMPS of 29 September 2021, the version of Debian; that of 22 July 2025 reads the same script. The files `laws` and `walls`
//! have the tables of counterparts, `stages` the course of a run, `outputs` the files that LAMMPS writes.
//!
//! Forces of step 0 are equal to round-off. A key without a counterpart is refused. A term that can be written but is not the same is
//! listed at the head of the script and in [`Export::differences`]. The scheme of LAMMPS is velocity Verlet whatever the scene says.

mod bodies;
mod grains;
mod laws;
mod motions;
mod outputs;
mod quantities;
mod releases;
mod stages;
mod walls;

use std::fmt::Write as _;

use crate::door::{DoorMotion, DoorOpens};
use crate::grains::file::GrainRow;
use crate::lammps::grains::Particles;
use crate::lammps::quantities::all_grains;
use crate::scene::TimeStep;
use crate::scene::loaded::Loaded;
use siloflow_dem::contact::config::Contact;
use siloflow_dem::integrate::Integrator;
use siloflow_dem::space::{Dimension, Solid};
use siloflow_text::fault::Fault;

/// Name of the script.
pub const SCRIPT: &str = "in.silo";
/// Name of the data file.
pub const DATA: &str = "grains.data";

/// Name of the file of bodies of several spheres.
pub const BODIES: &str = "bodies.data";

/// A scene as an input of LAMMPS.
#[derive(Debug)]
pub struct Export {
    /// Content of [`SCRIPT`].
    pub script: String,
    /// Content of [`DATA`].
    pub data: String,
    /// Content of [`BODIES`]; `None` if no grain has several spheres.
    pub bodies: Option<String>,
    /// Differences of the run in LAMMPS from that in siloflow, one sentence each.
    pub differences: Vec<String>,
    /// Number of grains, those to be released included.
    pub grains: usize,
}

/// Translates a scene.
///
/// # Errors
/// If the scene has a key without a counterpart. The fault names it.
pub fn export(loaded: &Loaded) -> Result<Export, Fault> {
    refuse_unmapped(loaded)?;
    let laws = laws::laws(loaded)?;
    let walls = walls::walls(loaded, &laws)?;
    let particles = Particles::of(loaded);
    let grains = all_grains(loaded).count();
    check_identifiers(loaded, particles.next_id() + grains - loaded.grains.len() - 1)?;
    let mut differences = differences(loaded, &laws, &walls);
    let course = stages::course(loaded, &walls, &particles)?;
    differences.extend(course.differences.iter().cloned());
    let mut script = head(loaded, &differences);
    script.push_str(&particles.setup(loaded));
    let _ = write!(script, "\n# Contact law.\n{}", laws.lines);
    let _ = write!(script, "\n# Walls.\n{}", walls.lines);
    script.push_str(&particles.motion(loaded));
    script.push_str(&outputs::step_zero(loaded, &particles));
    script.push_str(&outputs::series(loaded, &particles, &walls));
    script.push_str(&course.script);
    Ok(Export { script, data: particles.data(loaded), bodies: particles.bodies_file(), differences, grains })
}

/// A number with all its digits.
fn number(x: f64) -> String {
    format!("{x:?}")
}

/// Three numbers with all their digits.
fn vector(v: Solid) -> String {
    v.to_array().map(number).join(" ")
}

/// The fault of a key without a counterpart.
fn refused(loaded: &Loaded, key: &str, reason: &str) -> Fault {
    loaded.fault("lammps::unmapped", key, reason)
}

/// Refuses keys whose behaviour LAMMPS does not have, or that are not written yet.
fn refuse_unmapped(loaded: &Loaded) -> Result<(), Fault> {
    let scene = &loaded.scene;
    let refuse = |key: &str, reason: &str, help: &str| Err(refused(loaded, key, reason).help(help.to_owned()));
    let start =
        "run the filling in siloflow, then export with its grains: `--set \"grains=(file: \\\"state.csv\\\")\"`";
    if !scene.behaviours.is_empty() {
        return refuse("behaviours", "behaviours of other crates have no counterpart in LAMMPS", "export without them");
    }
    if !scene.feed.is_empty() {
        return refuse(
            "feed",
            "`fix pour` of LAMMPS derives its rate from its region, and keeps no order of sizes",
            start,
        );
    }
    let is_shaped = |grain: &GrainRow| grain.posture.is_some();
    if scene.space == Dimension::Plane && all_grains(loaded).any(|grain| is_shaped(&grain)) {
        return refuse("shapes", "shapes of the plane are not written", "export a scene in solid space, or with discs");
    }
    if matches!(scene.contact, Contact::Assignment { .. }) && all_grains(loaded).any(|grain| is_shaped(&grain)) {
        let reason = "in LAMMPS the drag of this law turns bodies, in siloflow it acts at the centres of spheres";
        return refuse("contact", reason, "export with a `Linear` law");
    }
    if quantities::released(loaded).iter().any(is_shaped) {
        return refuse("spawner.shape", "grains of several spheres that are released later are not written", start);
    }
    if scene.kick.is_some() {
        return refuse("kick", "kicks that restart the flow are not written", "export without it");
    }
    if all_grains(loaded).next().is_none() {
        return refuse("fill", "there are no grains", "give `grains`, `fill` or `spawner`");
    }
    if all_grains(loaded).any(|grain| grain.id.number() == 0) {
        let reason = "a grain has the id 0, and the identifiers of LAMMPS begin at 1";
        return refuse("grains.file", reason, "give it another id in the file of grains");
    }
    for (number, fill) in scene.fill.iter().enumerate() {
        if fill.fixed && (fill.velocity.is_some() || fill.agitation.is_some()) {
            let reason = "fixed grains that move are not written";
            return refuse(&format!("fill[{number}].velocity"), reason, "export fixed grains at rest");
        }
    }
    let controls = scene.door_controls();
    for (_, key, control) in &controls {
        if matches!(control.how, DoorMotion::Slide(_)) && control.opens != DoorOpens::Never {
            let reason = "discs of a door that slide are not written";
            return refuse(&format!("{key}.how"), reason, "export with a door that vanishes: `how: Remove`");
        }
    }
    let mut opening = controls.iter().filter(|(_, _, control)| control.opens != DoorOpens::Never);
    if let Some((_, _, first)) = opening.next()
        && let Some((_, key, _)) = opening.find(|(_, _, control)| control.opens != first.opens)
    {
        let reason = format!("doors that open at different times are not written: the first opens {:?}", first.opens);
        return refuse(&format!("{key}.opens"), &reason, "export with doors that open together");
    }
    Ok(())
}

/// Refuses identifiers that LAMMPS does not have. Fixed grains and those of the spawner follow the largest of the grains.
fn check_identifiers(loaded: &Loaded, last: usize) -> Result<(), Fault> {
    // The default build has identifiers of 4 bytes with a sign.
    const LARGEST: usize = 0x7fff_ffff;
    if last <= LARGEST {
        return Ok(());
    }
    let reason = format!("the last id would be {last}, and the largest identifier of LAMMPS is {LARGEST}");
    Err(refused(loaded, "grains.file", &reason).help("give the grains lower ids in the file of grains"))
}

/// Returns the differences of the run in LAMMPS from that in siloflow.
fn differences(loaded: &Loaded, laws: &laws::Laws, walls: &walls::Walls) -> Vec<String> {
    let scene = &loaded.scene;
    let mut list = Vec::new();
    let mut say = |says: bool, sentence: &str| {
        if says {
            list.push(sentence.to_owned());
        }
    };
    say(
        scene.integrator != Integrator::Verlet,
        "LAMMPS integrates with velocity Verlet; the scene asks for another scheme, so use a smaller step for the same error",
    );
    say(
        matches!(scene.step, TimeStep::Auto { .. }),
        "the time step is the automatic one of the scene's scheme, and LAMMPS keeps it fixed",
    );
    say(
        laws.shortens_arm,
        "`pair granular` lets friction between grains turn them with the arm R - delta/2; siloflow and the walls of LAMMPS take R",
    );
    say(
        !loaded.contacts_at_start.rows.is_empty(),
        "springs of contacts at the start (grains.contacts) are lost: a data file of LAMMPS has no contact history",
    );
    say(
        laws.has_springs,
        "in step 0, springs are empty, and LAMMPS gives a contact that slides no friction there; siloflow gives it the cap",
    );
    say(
        laws.has_springs && laws.shortens_arm,
        "where the plane of a contact turns, `granular` keeps the length of the spring; siloflow keeps its part in the new plane",
    );
    say(
        laws.has_springs && !laws.shortens_arm && walls.may_turn,
        "where the plane of a contact turns on an edge or a curved wall, LAMMPS keeps the length of the spring; siloflow keeps its part in \
         the new plane",
    );
    say(
        walls.may_meet,
        "where an edge of a wall continues in another wall, LAMMPS counts both contacts and siloflow one",
    );
    say(
        loaded.have_walls_images(),
        "LAMMPS does not repeat walls beyond periodic sides, so that grains pass through what siloflow puts there",
    );
    say(
        walls::have_another_radius(loaded),
        "on a cone LAMMPS takes the contact radius of a cylinder, and on the outer side of a cylinder that of a plane; siloflow takes that of the wall",
    );
    say(
        !(scene.motions.is_empty() && walls.leaves.is_empty())
            || scene.walls.iter().any(|wall| wall.shape.moves_in_place()),
        "LAMMPS takes the velocity of a wall that moves as its mean over the last step, and as zero in step 0",
    );
    say(
        scene.opens_a_door() || scene.spawner.is_some(),
        "LAMMPS begins a new run at rest, at the opening and at each release, and computes the forces of that step once more, with the velocities of its end",
    );
    say(walls.has_planes, "LAMMPS does not push back a grain whose centre is behind a plane; siloflow does");
    say(
        loaded.has_outlet(),
        "grains count as out below the level of the door; siloflow counts crossings of the orifice, and losses apart",
    );
    say(
        loaded.scene.spawner.is_some(),
        "a release waits while a centre is nearer to its place than the sum of the radii, with the largest radius for every grain",
    );
    let has_bodies = loaded.grains.iter().any(|grain| grain.posture.is_some());
    say(
        has_bodies,
        "a grain of several spheres is counted, and its height taken, at the sphere nearest to its centre; rest and largest speed are those of spheres",
    );
    say(has_bodies, "grains that have left fall on, in a box that grows with them: none is removed");
    say(!has_bodies, "grains that leave the box of the data file are removed and count as out");
    list
}

/// The comment at the head of the script.
fn head(loaded: &Loaded, differences: &[String]) -> String {
    let mut text = format!(
        "# {} in LAMMPS, written by siloflow {}.\n\
         # mpirun -np 2 lmp -in {SCRIPT}       fills, waits for rest, opens the door, discharges\n\
         # lmp -in {SCRIPT} -var forces yes    only writes forces.dump, the forces of step 0, for a comparison\n\
         # It writes series.csv and summary.json (siloflow plot reads them), wall_forces.csv, frames.dump (OVITO reads it),\n\
         # restart.1 and restart.2 (with contact springs) and final.data (without them).\n\
         # LAMMPS 29 Sep 2021 (Debian) is the reference; 22 Jul 2025 reads this script too. SI units.\n",
        siloflow_text::safe::for_terminal(&loaded.source.name).lines().next().unwrap_or_default(),
        env!("CARGO_PKG_VERSION")
    );
    if !differences.is_empty() {
        text.push_str("# Not the same as in siloflow:\n");
        for sentence in differences {
            let _ = writeln!(text, "# - {sentence}.");
        }
    }
    text
}
