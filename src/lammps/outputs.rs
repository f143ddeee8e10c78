//! The files that LAMMPS writes: forces of step 0, `series.csv` in the columns of siloflow, forces on walls, frames, restarts. Numbers have
//! 17 digits, which read back to the same bits.

use std::fmt::Write as _;

use crate::lammps::grains::Particles;
use crate::lammps::number;
use crate::lammps::quantities::{steps, up};
use crate::lammps::walls::Walls;
use crate::scene::loaded::Loaded;
use siloflow_dem::spin::InertiaLaw;

/// Commands that write the forces of step 0 and end, if the variable `forces` is `yes`.
pub(super) fn step_zero(loaded: &Loaded, particles: &Particles) -> String {
    // The forces on a body are those on its spheres.
    let of_body = if particles.bodies.is_empty() { "" } else { "mol x y z " };
    let torques = if loaded.scene.contact.spins() || !particles.bodies.is_empty() { " tqx tqy tqz" } else { "" };
    format!(
        "\n# Forces of step 0, without weight, if they are asked for.\nvariable forces index no\n\
         if \"${{forces}} == yes\" then &\n  \"{}dump step_zero grains custom 1 forces.dump id {of_body}fx fy fz{torques}\" &\n  \
         \"dump_modify step_zero sort id format float %.17g\" &\n  \"run 0\" &\n  \"quit\"\n",
        if loaded.scene.gravity.padded() == siloflow_dem::space::Solid::ZERO { "" } else { "unfix weight\" &\n  \"" }
    )
}

/// Level below which grains are out, m: the middle of the lowest door, or the cull line.
fn outlet_level(loaded: &Loaded) -> Option<f64> {
    let up = up(loaded);
    let doors = loaded.outlets().into_iter().map(|[low, high]| 0.5 * (low[up] + high[up]));
    doors.reduce(f64::min).or(loaded.scene.cull.map(|cull| cull.below.get()))
}

/// Variables and fixes of the files.
pub(super) fn series(loaded: &Loaded, particles: &Particles, walls: &Walls) -> String {
    let dt = loaded.step();
    let every = steps(loaded.scene.series.interval.get(), dt);
    let count = loaded.grains.len();
    let gravity = loaded.scene.gravity.padded();
    let mut text = String::from("\n# Outputs.\n");
    let level = outlet_level(loaded).map_or_else(|| "INF".to_owned(), number);
    let above =
        if up(loaded) == 1 { format!("INF INF {level} INF INF INF") } else { format!("INF INF INF INF {level} INF") };
    let turning = if loaded.inertia() == InertiaLaw::Disc { "1.25" } else { "1.0" };
    let total: f64 = loaded.grains.iter().map(|grain| grain.mass).sum();
    let counted = particles.bodies.counted();
    let has_bodies = !particles.bodies.is_empty();
    let single = if has_bodies { "single" } else { "grains" };
    let of_bodies = if has_bodies {
        "compute moving_bodies bodies ke/rigid bodies\ncompute turning_bodies bodies erotate/rigid bodies\n"
    } else {
        ""
    };
    let [moving_bodies, turning_bodies] = if has_bodies { ["+c_moving_bodies", "+c_turning_bodies"] } else { ["", ""] };
    let _ = write!(
        text,
        "region above block {above}\n\
         variable inside equal count({counted},above)\n\
         variable released equal {count}\n\
         variable released_kg equal {}\n\
         variable out equal v_released-v_inside\n\
         variable culled equal v_released-count({counted})\n\
         variable mass_of atom mass\n\
         compute mass_inside {counted} reduce/region above sum v_mass_of\n\
         variable out_kg equal v_released_kg-c_mass_inside\n\
         compute moving {single} ke\n\
         compute turning {single} erotate/sphere\n\
         {of_bodies}\
         variable kinetic equal c_moving{moving_bodies}\n\
         variable rotational equal {turning}*c_turning{turning_bodies}\n\
         variable lift atom -mass*({}*x+{}*y+{}*z)\n\
         compute lifted {counted} reduce sum v_lift\n\
         variable speed_of atom sqrt(vx*vx+vy*vy+vz*vz)\n\
         compute fastest grains reduce max v_speed_of\n",
        number(total),
        number(gravity.x),
        number(gravity.y),
        number(gravity.z),
    );
    // A variable of LAMMPS that names another one takes 15 digits of it.
    let _ = write!(
        text,
        "fix series all print {every} \"$(time:%.17g),$(v_released:%.0f),$(v_inside:%.0f),$(v_out:%.0f),$(v_culled:%.0f),\
         $(v_out_kg:%.17g),$(c_moving{moving_bodies}:%.17g),$({turning}*c_turning{turning_bodies}:%.17g),$(c_lifted:%.17g),$(c_fastest:%.17g)\" &\n  \
         file series.csv screen no title \"time_s,released,inside,out,culled,out_kg,kinetic_j,rotational_j,potential_j,\
         largest_speed_m_per_s\"\n"
    );
    let _ = writeln!(text, "variable cpu_now equal cpu\nfix clock all ave/time {every} 1 {every} v_cpu_now");
    let is_door = |number: usize| {
        let fixes = walls.fixes.iter().find(|(own, _)| *own == number).map(|(_, fixes)| fixes);
        walls.doors.iter().any(|(_, door)| fixes.is_some_and(|fixes| fixes.iter().any(|fix| door.contains(fix))))
    };
    for (name, doors) in [("wall_forces", false), ("door_forces", true)] {
        let chosen: Vec<_> = walls.fixes.iter().filter(|(number, _)| is_door(*number) == doors).collect();
        text.push_str(&forces(name, every, &chosen));
    }
    let frames = loaded.even_frames().map(|interval| steps(interval, dt));
    if let Some(every) = frames {
        let spins = if loaded.scene.contact.spins() { " omegax omegay omegaz" } else { "" };
        let _ = writeln!(
            text,
            "dump frames all custom {every} frames.dump id type radius mass x y z vx vy vz fx fy fz{spins}\n\
             dump_modify frames sort id format float %.17g"
        );
    }
    let restarts = steps(loaded.scene.until.get() / 10.0, dt);
    let _ = writeln!(
        text,
        "restart {restarts} restart.1 restart.2\nthermo {every}\nthermo_style custom step time atoms v_inside v_out v_kinetic\n\
         thermo_modify lost ignore"
    );
    if particles.has_door() {
        text.push_str("# The door is the group door.\n");
    }
    text
}

/// A table of the forces on walls, N.
fn forces(name: &str, every: u64, walls: &[&(usize, Vec<String>)]) -> String {
    if walls.is_empty() {
        return String::new();
    }
    let mut text = String::new();
    let mut title = "time_s".to_owned();
    let mut row = "$(time:%.17g)".to_owned();
    for (number, fixes) in walls {
        for (column, axis) in [(2, "x"), (3, "y"), (4, "z")] {
            let sums = fixes.iter().map(|fix| {
                let _ = writeln!(text, "compute load_{fix}_{axis} all reduce sum f_{fix}[{column}]");
                format!("-c_load_{fix}_{axis}")
            });
            let sum: String = sums.collect();
            let _ = write!(title, ",wall_{number}_f{axis}_n");
            let _ = write!(row, ",$(0{sum}:%.17g)");
        }
    }
    let _ = writeln!(text, "fix {name} all print {every} \"{row}\" &\n  file {name}.csv screen no title \"{title}\"");
    text
}
