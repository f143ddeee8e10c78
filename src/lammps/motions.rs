//! Walls that move, in the words of LAMMPS: a region that moves by `move` and turns by `rotate`, with a variable of the time for each component.
//!
//! | siloflow | region |
//! |---|---|
//! | `motions` with `translate`: `Steady`, `Oscillate` | `move` |
//! | `motions` with `rotate`: `Steady`, `Oscillate` | `rotate` about the same axis, which moves with the shift |
//! | `velocity` of a `HalfPlane` | `move` along itself |
//! | `spin` of a `Cylinder`, `Cone`, `Annulus` | `rotate` about its own axis |
//! | door with `how: Move` | `move`; the variables follow the schedule, or are zero until the door opens |
//!
//! Limits: LAMMPS takes the velocity of a wall as its mean over the last step, and as zero in step 0. Tables are not written, and a region
//! has one rotation, which a slanted rectangle needs already.

use std::f64::consts::TAU;
use std::fmt::Write as _;

use crate::door::{DoorMotion, DoorOpens};
use crate::lammps::quantities::first_step;
use crate::lammps::{number, refused, vector};
use crate::scene::loaded::Loaded;
use siloflow_dem::space::Solid;
use siloflow_dem::values::{Finite, FiniteVector, NonNegative};
use siloflow_dem::walls::config::Wall;
use siloflow_dem::walls::config::geometry::OwnSpin;
use siloflow_dem::walls::config::shape::WallShape;
use siloflow_dem::walls::motion::{Course, Motion, Values};
use siloflow_text::fault::Fault;

/// The motion of a region.
#[derive(Debug, Default)]
pub(super) struct RegionMotion {
    /// Commands that precede the command of the region.
    pub variables: String,
    /// Words at the end of the command of the region; empty if it rests.
    pub words: String,
    /// Whether the region turns.
    pub turns: bool,
}

/// Translates the motion of a wall, which has this number among the regions.
///
/// # Errors
/// If the motion follows a table.
pub(super) fn motion(loaded: &Loaded, wall: &Wall, place: usize) -> Result<RegionMotion, Fault> {
    let mut region = RegionMotion::default();
    let always = "(step*dt)";
    if let Some(velocity) = wall.shape.own_velocity() {
        region.shift(place, velocity.padded().to_array().map(|rate| product(rate, always)));
    }
    if let Some(OwnSpin { rate, about, axis }) = wall.shape.own_spin() {
        region.turn(place, &product(rate, always), about, axis);
    }
    if let Some(leaf) = Leaf::of(loaded, wall) {
        let way = leaf.scheduled_way(loaded.step());
        region.shift(place, leaf.velocity().to_array().map(|rate| product(rate, way.as_deref().unwrap_or("0"))));
    }
    if let Some(place) = loaded.scene.free_walls.iter().position(|free| wall.name() == Some(&free.walls)) {
        return Err(refused(loaded, &format!("free_walls[{place}]"), "walls that forces move are not written"));
    }
    let of_wall = loaded.scene.motions.iter().filter(|motion| wall.name() == Some(&motion.walls)).count();
    if of_wall > 1 || of_wall == 1 && wall.shape.moves_in_place() {
        return Err(refused(loaded, "motions", "walls that move in two ways are not written"));
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

/// A wall of a door that moves.
#[derive(Clone, Debug)]
pub(super) struct Leaf {
    /// Shift from shut to open, m.
    by: Solid,
    /// Speed, m/s.
    speed: f64,
    opens: DoorOpens,
}

impl Leaf {
    /// Returns a wall as a leaf; `None` if it is not part of a door that moves.
    pub(super) fn of(loaded: &Loaded, wall: &Wall) -> Option<Self> {
        let door = loaded.scene.door_of(wall)?;
        let (.., control) = loaded.scene.door_controls().into_iter().find(|(number, ..)| *number == door)?;
        let DoorMotion::Move { by, speed } = control.how else { return None };
        Some(Self { by: by.padded(), speed: speed.get(), opens: control.opens })
    }

    fn velocity(&self) -> Solid {
        self.by * (self.speed / self.by.length())
    }

    /// Returns the time of the whole way, s.
    fn whole(&self) -> f64 {
        self.by.length() / self.speed
    }

    /// Returns the way from the shut place in units of the speed, s, as a formula of the time; `None` without a schedule. A leaf that is told to turn
    /// round on its way does so.
    fn scheduled_way(&self, dt: f64) -> Option<String> {
        let DoorOpens::Schedule(times) = &self.opens else { return None };
        let turns = times.iter().flat_map(|(open, shut)| [*open, *shut]).map(|time| first_step(time.get(), dt) * dt);
        let turns: Vec<_> = turns.chain([f64::INFINITY]).collect();
        let mut way = 0.0;
        let mut terms = Vec::new();
        for (number, turn) in turns.windows(2).enumerate() {
            let opens = number % 2 == 0;
            let lasts = (turn[1] - turn[0]).min(if opens { self.whole() - way } else { way });
            way += if opens { lasts } else { -lasts };
            terms.push(format!("{}{}", if opens { "+" } else { "-" }, ramp("step*dt", turn[0], turn[0] + lasts)));
        }
        Some(format!("(0{})", terms.concat()))
    }

    /// Returns commands that open the leaf, whose region has this number, from the present step on; none with a schedule.
    pub(super) fn open(&self, place: usize) -> String {
        if matches!(self.opens, DoorOpens::Schedule(_) | DoorOpens::Never) {
            return String::new();
        }
        let way = ramp("(step-$(step))*dt", 0.0, self.whole());
        shift_variables(place, &self.velocity().to_array().map(|rate| product(rate, &way)))
    }
}

/// Returns boxes that the walls that move do not leave, lower and upper corner, m. Half-planes have none.
pub(super) fn ways(loaded: &Loaded) -> impl Iterator<Item = [Solid; 2]> {
    let scene = &loaded.scene;
    let leaves = scene.walls.iter().filter_map(move |wall| {
        let leaf = Leaf::of(loaded, wall)?;
        let [low, high] = wall.bounds()?;
        Some([low + leaf.by, high + leaf.by])
    });
    let motions = scene.motions.iter().flat_map(move |motion| {
        let shift = largest_shift(loaded, motion);
        let walls = scene.walls.iter().filter(|wall| wall.name() == Some(&motion.walls));
        walls.filter_map(Wall::bounds).map(move |[low, high]| {
            let [low, high] = motion.rotate.as_ref().map_or([low, high], |turn| {
                let about = turn.about.padded();
                let reach = Solid::splat((low - about).abs().max((high - about).abs()).length());
                [about - reach, about + reach]
            });
            [low - shift, high + shift]
        })
    });
    leaves.chain(motions)
}

/// Returns the largest shift of a half-plane, m, in each direction.
pub(super) fn shift_of_half_planes(loaded: &Loaded) -> Solid {
    let planes = || loaded.scene.walls.iter().filter(|wall| matches!(wall.shape, WallShape::HalfPlane { .. }));
    let motions = loaded.scene.motions.iter();
    let motions = motions.filter(|motion| planes().any(|wall| wall.name() == Some(&motion.walls)));
    let leaves = planes().filter_map(|wall| Leaf::of(loaded, wall)).map(|leaf| leaf.by.abs());
    motions.map(|motion| largest_shift(loaded, motion)).chain(leaves).fold(Solid::ZERO, Solid::max)
}

/// Returns a bound of the shift of a motion, m, in each direction.
fn largest_shift(loaded: &Loaded, motion: &Motion) -> Solid {
    let until = motion.until.map_or(f64::INFINITY, NonNegative::get).min(loaded.scene.until.get());
    let lasts = (until - motion.from.map_or(0.0, NonNegative::get)).max(0.0);
    match &motion.translate {
        Some(Course::Steady(rate)) => rate.padded().abs() * lasts,
        Some(Course::Oscillate { amplitude, .. }) => 2.0 * amplitude.padded().abs(),
        // A table is refused.
        Some(Course::Table { .. }) | None => Solid::ZERO,
    }
}

impl RegionMotion {
    fn shift(&mut self, place: usize, formulas: [String; 3]) {
        self.variables.push_str(&shift_variables(place, &formulas));
        let _ = write!(self.words, " move v_move_x_{place} v_move_y_{place} v_move_z_{place}");
    }

    fn turn(&mut self, place: usize, formula: &str, about: Solid, axis: Solid) {
        self.turns = true;
        // LAMMPS multiplies the angular velocity by the length of the axis.
        let axis = axis.normalize();
        let _ = writeln!(self.variables, "variable angle_{place} equal {formula}");
        let _ = write!(self.words, " rotate v_angle_{place} {} {}", vector(about), vector(axis));
    }
}

/// Commands that define the components of the shift of a region.
fn shift_variables(place: usize, [x, y, z]: &[String; 3]) -> String {
    format!("variable move_x_{place} equal {x}\nvariable move_y_{place} equal {y}\nvariable move_z_{place} equal {z}\n")
}

/// The time since the beginning of a motion, up to its end, as a formula of LAMMPS, s.
fn elapsed(motion: &Motion) -> String {
    let from = motion.from.map_or(0.0, NonNegative::get);
    match motion.until.map(NonNegative::get) {
        None if from == 0.0 => "(step*dt)".to_owned(),
        until => ramp("step*dt", from, until.unwrap_or(f64::INFINITY).max(from)),
    }
}

/// The time since `from` (s), up to `until` (s), as a formula, s. `time` is the formula of the time.
fn ramp(time: &str, from: f64, until: f64) -> String {
    let begin = number(from);
    if until == f64::INFINITY {
        return format!("(({time}-{begin})*({time}>{begin}))");
    }
    let end = number(until);
    let length = number(until - from);
    format!("(({time}-{begin})*(({time}>{begin})&&({time}<{end}))+{length}*({time}>={end}))")
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
