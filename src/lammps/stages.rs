//! The course of a run: filling, rest, the opening of the door, the discharge and its end.
//!
//! Rest has the conditions of [`crate::rest`], and the end those of [`crate::ending`] and [`crate::ending::stop`]. siloflow tests them in every
//! step; the script tests them several times in each interval that they must hold (`fix halt`), which the head of the script states.

use std::fmt::Write as _;

use crate::door::DoorOpens;
use crate::ending::stop::conditions::StopCondition;
use crate::lammps::grains::Particles;
use crate::lammps::quantities::{all_grains, first_step, steps};
use crate::lammps::releases;
use crate::lammps::walls::Walls;
use crate::lammps::{number, refused};
use crate::rest::Rest;
use crate::scene::loaded::Loaded;
use siloflow_text::fault::Fault;

/// Tests in each interval that a condition must hold.
const TESTS: f64 = 20.0;

/// Adds the wall-clock time of the run before it, s, up to its last row of the series. `cpu` cannot be read between runs.
const CLOCK: &str = "variable wall_s equal $(v_wall_s+f_clock)\n";

/// The part of the script that runs.
pub(super) struct Course {
    pub script: String,
    pub differences: Vec<String>,
}

/// Writes the course of a run.
///
/// # Errors
/// If a condition has no counterpart.
pub(super) fn course(loaded: &Loaded, walls: &Walls, particles: &Particles) -> Result<Course, Fault> {
    let scene = &loaded.scene;
    let dt = loaded.step();
    let last = steps(scene.until.get(), dt);
    let mut script = String::from(
        "\n# Course of the run.\nvariable wall_s equal 0\nvariable rest_time equal -1\nvariable open_time equal -1\n",
    );
    let mut differences = Vec::new();
    script.push_str(&releases::releases(loaded, particles)?);
    let stop = scene.stop_conditions();
    let opens = scene.door_controls().into_iter().map(|(_, _, control)| control.opens);
    let opens = opens.into_iter().find(|opens| *opens != DoorOpens::Never);
    if stop.contains(&StopCondition::AtRest) && matches!(opens, Some(DoorOpens::At(_) | DoorOpens::Schedule(_))) {
        let key = if scene.stop.contains(&StopCondition::AtRest) { "stop" } else { "rest.stop" };
        let reason = "a run that stops at rest, with a door that opens at given times, is not written";
        return Err(refused(loaded, key, reason).help("export with a door that opens at rest, or without the stop"));
    }
    let waits = opens == Some(DoorOpens::AtRest) || stop.contains(&StopCondition::AtRest);
    if let (true, Some(rest)) = (waits, scene.rest) {
        let every = rest_test(loaded, &rest, &mut script);
        differences.push(format!("rest is tested every {every} steps; siloflow tests it in every step"));
        let _ = writeln!(script, "run {last} upto\n{CLOCK}unfix at_rest\nunfix loud");
        let _ =
            writeln!(script, "if \"$(step) >= {last}\" then \"jump SELF end\"\nvariable rest_time equal $(time:%.17g)");
        if stop.contains(&StopCondition::AtRest) {
            script.push_str("jump SELF end\n");
        }
    }
    if let Some(opens) = &opens {
        let at = match opens {
            DoorOpens::At(time) => Some(time),
            DoorOpens::Schedule(times) => times.first().map(|(open, _)| open),
            DoorOpens::AtRest | DoorOpens::Never => None,
        };
        if let Some(time) = at {
            let opening = first_step(time.get(), dt);
            let _ = writeln!(
                script,
                "if \"{opening} >= {last}\" then \"run {last} upto\" \"jump SELF end\"\nrun {opening} upto\n{CLOCK}"
            );
        }
        script.push_str(&open(loaded, walls));
    }
    discharge(loaded, &stop, opens.is_some(), &mut script, &mut differences);
    let _ = writeln!(script, "run {last} upto\n{CLOCK}label end");
    script.push_str(SUMMARY);
    Ok(Course { script, differences })
}

/// Commands that test for rest; returns the steps between tests.
fn rest_test(loaded: &Loaded, rest: &Rest, script: &mut String) -> u64 {
    let dt = loaded.step();
    let g = loaded.scene.gravity.padded().length();
    let every = steps(rest.hold.get() / TESTS, dt);
    let window = steps(rest.hold.get(), dt).div_ceil(every) + 1;
    let scale: f64 = all_grains(loaded).map(|grain| grain.mass * g * grain.radius).sum();
    let _ = write!(
        script,
        "compute radius_of grains property/atom radius\n\
         variable froude_of atom (vx*vx+vy*vy+vz*vz)/({}*c_radius_of)\n\
         compute froude grains reduce max v_froude_of\n\
         variable loud equal (c_froude>{})||((v_kinetic+v_rotational)>{})\n\
         fix loud all ave/time {every} 1 {every} v_loud ave window {window}\n\
         variable rest_from equal $(step)+{}\n\
         variable at_rest equal (f_loud<{})&&(step>=v_rest_from)\n\
         fix at_rest all halt {every} v_at_rest > 0.5 error continue\n",
        number(g),
        number(rest.speed.get().powi(2)),
        number(rest.energy.get() * scale),
        every * (window - 1),
        number(0.5 / f64::from(u32::try_from(window).unwrap_or(u32::MAX))),
    );
    every
}

/// Commands that open the door.
fn open(loaded: &Loaded, walls: &Walls) -> String {
    let mut text = String::from("\n# The door opens.\n");
    if !walls.doors.is_empty() {
        text.push_str("unfix door_forces\n");
    }
    let opens = |number: u16| {
        let controls = loaded.scene.door_controls();
        controls.iter().any(|(door, _, control)| *door == number && control.opens != DoorOpens::Never)
    };
    for fix in walls.doors.iter().filter(|(number, _)| opens(*number)).flat_map(|(_, fixes)| fixes) {
        for axis in ["x", "y", "z"] {
            let _ = writeln!(text, "uncompute load_{fix}_{axis}");
        }
        let _ = writeln!(text, "unfix {fix}");
    }
    for (place, leaf) in &walls.leaves {
        text.push_str(&leaf.open(*place));
    }
    if !loaded.silo.door.is_empty() && opens(0) {
        text.push_str("delete_atoms group door compress no\n");
    }
    text.push_str("variable open_time equal $(time:%.17g)\n");
    text
}

/// Commands that end the discharge.
fn discharge(loaded: &Loaded, stop: &[StopCondition], opens: bool, script: &mut String, differences: &mut Vec<String>) {
    let dt = loaded.step();
    let every = steps(loaded.scene.series.interval.get() / TESTS, dt);
    if loaded.has_outlet() || loaded.scene.cull.is_some() {
        let _ = writeln!(script, "fix empty all halt {every} v_inside < 0.5 error continue");
        differences.push(format!("the end is tested every {every} steps; siloflow tests it in every step"));
    }
    for (number, condition) in stop.iter().enumerate() {
        match *condition {
            StopCondition::Out(count) => {
                let _ = writeln!(
                    script,
                    "fix stop_{number} all halt {every} v_out > {}.5 error continue",
                    i64::from(count) - 1
                );
            }
            StopCondition::EndOfFlow { still } | StopCondition::Clogged { still } if opens => {
                let every = steps(still.get() / TESTS, dt);
                let window = steps(still.get(), dt).div_ceil(every) + 1;
                let inside = if matches!(condition, StopCondition::Clogged { .. }) { "&&(v_inside>0.5)" } else { "" };
                let _ = write!(
                    script,
                    "variable begin_{number} equal $(step)\n\
                     fix mean_{number} all ave/time {every} 1 {every} v_inside ave window {window}\n\
                     variable still_{number} equal ((f_mean_{number}-v_inside)<1e-6)&&(step>=(v_begin_{number}+{})){inside}\n\
                     fix stop_{number} all halt {every} v_still_{number} > 0.5 error continue\n",
                    every * window
                );
            }
            _ => {}
        }
    }
}

/// Commands that write the figures of the run in the words of `summary.json`.
const SUMMARY: &str = "\n# Figures of the run: null is a time that never came.\n\
     variable rest string $(v_rest_time:%.17g)\nvariable opened string $(v_open_time:%.17g)\n\
     if \"${rest_time} < 0\" then \"variable rest delete\" \"variable rest string null\"\n\
     if \"${open_time} < 0\" then \"variable opened delete\" \"variable opened string null\"\n\
     run 0 post no\n\
     print '{\"program\": \"LAMMPS\", \"rest_time_s\": ${rest}, \"door_open_time_s\": ${opened}, \"end_time_s\": $(time:%.17g), \
     \"grains\": {\"released\": $(v_released:%.0f), \"inside\": $(v_inside:%.0f), \"out\": $(v_out:%.0f)}, \
     \"performance\": {\"wall_s\": $(v_wall_s:%.3f)}}' file summary.json\n\
     write_data final.data nocoeff\n";
