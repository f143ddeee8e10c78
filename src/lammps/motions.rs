//! Walls that move, in the words of LAMMPS: a region that moves by `move` and turns by `rotate`, with a variable of the time for each component.
//!
//! | siloflow | region |
//! |---|---|
//! | `motions` with `translate`: `Steady`, `Oscillate` | `move` |
//! | `motions` with `rotate`: `Steady`, `Oscillate` | `rotate` about the same axis, which moves with the shift |
//! | `velocity` of a `HalfPlane` | `move` along itself |
//! | `spin` of a `Cylinder`, `Cone`, `Annulus` | `rotate` about its own axis |
//! | door with `how: Move` | `move`, with variables that are zero until the door opens |
//!
//! Limits: LAMMPS takes the velocity of a wall as its mean over the last step, and as zero in step 0. Tables are not written, and a region
//! has one rotation, which a slanted rectangle needs already.

use std::f64::consts::TAU;
use std::fmt::Write as _;

use crate::door::{DoorMotion, DoorOpens};
use crate::fault::Fault;
use crate::lammps::{number, refused, vector};
use crate::scene::load::Loaded;
use crate::space::Solid;
use crate::values::{Finite, FiniteVector, NonNegative};
use crate::walls::config::Wall;
use crate::walls::motion::{Course, Motion, Values};

/// The motion of a region.
#[derive(Debug, Default)]
pub(super) struct RegionMotion {
    /// Commands before that of the region.
    pub variables: String,
    /// Words at the end of the command of the region; empty if it rests.
    pub words: String,
    pub turns: bool,
}

/// Translates the motion of a wall, which has this number among the regions.
///
/// # Errors
/// If the motion follows a table.
pub(super) fn motion(loaded: &Loaded, wall: &Wall, place: usize) -> Result<RegionMotion, Fault> {
    let mut region = RegionMotion::default();
    let always = "(step*dt)";
    match wall {
        Wall::HalfPlane { velocity: Some(velocity), .. } => {
            region.shift(place, velocity.padded().to_array().map(|rate| product(rate, always)));
        }
        Wall::Cylinder { spin: Some(spin), from, to, .. } | Wall::Cone { spin: Some(spin), from, to, .. } => {
            region.turn(place, &product(spin.get(), always), from.padded(), to.padded() - from.padded());
        }
        Wall::Annulus { spin: Some(spin), centre, normal, .. } => {
            region.turn(place, &product(spin.get(), always), centre.padded(), normal.padded());
        }
        _ => {}
    }
    if leaf(loaded, wall).is_some() {
        region.shift(place, [(); 3].map(|()| "0".to_owned()));
    }
    let motions = loaded.scene.motions.iter().enumerate();
    for (index, motion) in motions.filter(|(_, motion)| wall.name() == Some(&motion.walls)) {
        let tau = elapsed(motion);
        let table = |key: &str| {
            refused(loaded, &format!("motions[{index}].{key}"), "motions by a table are not written")
                .help("export with `Steady` or `Oscillate`")
        };
        if let Some(course) = &motion.translate {
            let [x, y, z] = formulas(course, &tau).ok_or_else(|| table("translate"))?;
            region.shift(place, [x, y, z]);
        }
        if let Some(turn) = &motion.rotate {
            let [angle, ..] = formulas(&turn.by, &tau).ok_or_else(|| table("rotate.by"))?;
            region.turn(place, &angle, turn.about.padded(), turn.axis.map_or(Solid::Z, FiniteVector::padded));
        }
    }
    Ok(region)
}

/// Returns the shift (m) from shut to open, and the speed (m/s), of a wall that is a door that moves.
pub(super) fn leaf(loaded: &Loaded, wall: &Wall) -> Option<(Solid, f64)> {
    let door = loaded.scene.door_of(wall)?;
    let controls = loaded.scene.door_controls();
    let (_, _, control) =
        controls.iter().find(|(number, _, control)| *number == door && control.opens != DoorOpens::Never)?;
    match control.how {
        DoorMotion::Move { by, speed } => Some((by.padded(), speed.get())),
        _ => None,
    }
}

/// Commands that open a door that moves, whose region has this number, from the present step on.
pub(super) fn open_leaf(place: usize, (by, speed): (Solid, f64)) -> String {
    let way = by.length();
    let (whole, since) = (number(way / speed), "(step-$(step))*dt");
    let mut text =
        format!("variable leaf_{place} equal (({since})*(({since})<{whole})+{whole}*(({since})>={whole}))\n");
    for (axis, rate) in ["x", "y", "z"].into_iter().zip((by * (speed / way)).to_array()) {
        let _ = writeln!(text, "variable move_{axis}_{place} equal {}", product(rate, &format!("v_leaf_{place}")));
    }
    text
}

/// Returns places of the corners of walls that move, at times all through the run, m.
pub(super) fn places(loaded: &Loaded) -> impl Iterator<Item = Solid> {
    let scene = &loaded.scene;
    let leaves = scene.walls.iter().filter_map(move |wall| {
        let ((by, _), [low, high]) = (leaf(loaded, wall)?, wall.bounds()?);
        Some([low + by, high + by])
    });
    let motions = scene.motions.iter().flat_map(move |motion| {
        let walls = scene.walls.iter().filter(|wall| wall.name() == Some(&motion.walls));
        let corners = walls.filter_map(Wall::bounds).flat_map(|[low, high]| {
            (0..8u8).map(move |corner| {
                let side = |axis: usize| if corner >> axis & 1 == 0 { low[axis] } else { high[axis] };
                Solid::new(side(0), side(1), side(2))
            })
        });
        corners.flat_map(move |corner| {
            let times = (0..=100u8).map(|part| 0.01 * f64::from(part) * scene.until.get());
            times.map(move |time| motion.at::<Solid>(time).pose.point(corner))
        })
    });
    leaves.flatten().chain(motions)
}

impl RegionMotion {
    fn shift(&mut self, place: usize, formulas: [String; 3]) {
        self.words.push_str(" move");
        for (axis, formula) in ["x", "y", "z"].into_iter().zip(formulas) {
            let _ = writeln!(self.variables, "variable move_{axis}_{place} equal {formula}");
            let _ = write!(self.words, " v_move_{axis}_{place}");
        }
    }

    fn turn(&mut self, place: usize, formula: &str, about: Solid, axis: Solid) {
        self.turns = true;
        // LAMMPS multiplies the angular velocity by the length of the axis.
        let axis = axis.normalize();
        let _ = writeln!(self.variables, "variable angle_{place} equal {formula}");
        let _ = write!(self.words, " rotate v_angle_{place} {} {}", vector(about), vector(axis));
    }
}

/// The time since the beginning of a motion, up to its end, as a formula of LAMMPS, s.
fn elapsed(motion: &Motion) -> String {
    let from = motion.from.map_or(0.0, NonNegative::get);
    let (begin, time) = (number(from), "step*dt");
    match motion.until.map(NonNegative::get) {
        None if from == 0.0 => format!("({time})"),
        None => format!("(({time}-{begin})*({time}>{begin}))"),
        Some(until) => {
            let (end, length) = (number(until), number((until - from).max(0.0)));
            format!("(({time}-{begin})*(({time}>{begin})&&({time}<{end}))+{length}*({time}>={end}))")
        }
    }
}

fn product(factor: f64, formula: &str) -> String {
    if factor == 0.0 { "0".to_owned() } else { format!("{}*{formula}", number(factor)) }
}

/// The components of a course after the time `tau`; `None` for a table.
fn formulas<T: Values>(course: &Course<T>, tau: &str) -> Option<[String; 3]> {
    match course {
        Course::Steady(rate) => Some(rate.padded_values().to_array().map(|rate| product(rate, tau))),
        Course::Oscillate { amplitude, frequency, phase } => {
            let phase = phase.map_or(0.0, Finite::get);
            let [pulse, start, phase] = [TAU * frequency.get(), phase.sin(), phase].map(number);
            let sine = format!("(sin({pulse}*{tau}+{phase})-{start})");
            Some(amplitude.padded_values().to_array().map(|size| product(size, &sine)))
        }
        Course::Table { .. } => None,
    }
}
