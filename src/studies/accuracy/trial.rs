//! One trial: a case with one step and one scheme, run as a scene in the simulator's own app.

use std::f64::consts::TAU;
use std::fmt::Write as _;
use std::num::NonZeroUsize;
use std::path::Path;

use bevy_ecs::prelude::*;
use glam::DVec2;

use super::Scheme;
use super::case::{Answer, Case};
use super::reference::{Clump, Floor, Law, Piston, Rolling, State, System, Vibration};
use crate::behaviour::Registry;
use crate::grains::file::GrainRow;
use crate::grains::shaped::Posture;
use crate::scene::load;
use crate::scene::loaded::Loaded;
use crate::scene::rules;
use crate::simulation::Simulation;
use siloflow_dem::bodies::{Orientation, Shape};
use siloflow_dem::outcome::End;
use siloflow_dem::particle::{Grain, GrainId, Position, Species, Velocity};
use siloflow_dem::space::{Plane, Rotor, Solid};
use siloflow_dem::spin::Spin;
use siloflow_dem::walls::free::FreeState;
use siloflow_dem::walls::surfaces::Surfaces;
use siloflow_text::fault::Fault;

/// Builds the scene that holds these copies: its text and its grains. `dt` is the step and `until` the end, both in s.
///
/// # Errors
/// If a check of the scene refuses it.
pub fn scene(name: &str, answers: &[Answer], scheme: &Scheme, dt: f64, until: f64) -> Result<Loaded, Fault> {
    let Some(first) = answers.first() else { return Err(Fault::new("accuracy::empty", "the case has no system")) };
    let width = spacing(answers);
    let text = scene_text(&first.system, &floors(answers, width), scheme, dt, until);
    let mut loaded = load::from_text(&format!("{name}.ron"), name, Path::new(""), text, &[])?;
    let mut number = 0;
    for (copy, answer) in answers.iter().enumerate() {
        let is_grain = |i: usize| !is_member(&answer.system, i) && !answer.system.is_floor(i);
        for (i, disc) in answer.system.discs.iter().enumerate().filter(|&(i, _)| is_grain(i)) {
            number += 1;
            let id =
                GrainId::grain(number).ok_or_else(|| Fault::new("accuracy::size", "the case has too many grains"))?;
            let position = (answer.start.x[i] + offset(width, copy)).extend(0.0);
            let velocity = answer.start.v[i].extend(0.0);
            let spin = Solid::Z * answer.start.w[i];
            let clump = answer.system.clumps.iter().find(|clump| clump.centre == i);
            let facts = loaded.shapes.facts.first();
            let posture = clump.zip(facts).map(|(clump, facts)| Posture {
                shape: Shape(0),
                rotor: Rotor::<Plane>::to_quaternion(axis(clump, &answer.start)),
                reach: facts.reach,
            });
            let radius = posture.and(facts).map_or(disc.radius, |facts| facts.equivalent_radius);
            let row = GrainRow { id, radius, mass: disc.mass, position, velocity, spin, posture, species: Species(0) };
            loaded.grains.push(row);
        }
    }
    // Checked again because loading checked a scene without grains.
    rules::check(&loaded)?;
    Ok(loaded)
}

/// Runs all copies with the step `dt` (s) and returns the error of each copy; infinite if its run did not reach the
/// end.
///
/// # Errors
/// If a check of the scene refuses it.
pub fn errors(case: &Case, answers: &[Answer], scheme: &Scheme, dt: f64) -> Result<Vec<f64>, Fault> {
    // Copies of one system share a scene; different systems have a scene each.
    let size = case.phases() as usize;
    let mut errors = Vec::with_capacity(answers.len());
    for answers in answers.chunks(size) {
        let loaded = scene(case.name, answers, scheme, dt, 2.0 * case.end + 10.0 * dt)?;
        let mut simulation = Simulation::new(&loaded, &Registry::default(), NonZeroUsize::MIN)?;
        if let Some(End::Failed(_)) = simulation.run_steps(case.steps(dt)) {
            errors.extend(answers.iter().map(|_| f64::INFINITY));
            continue;
        }
        let states = states(&mut simulation, answers);
        errors
            .extend(answers.iter().zip(&states).map(|(answer, state)| case.error(&answer.system, state, &answer.end)));
    }
    Ok(errors)
}

/// Returns the distance between neighbouring copies along x (m), large enough that copies never touch.
fn spacing(answers: &[Answer]) -> f64 {
    let Some(first) = answers.first() else { return 0.0 };
    let ends = |state: &State| {
        let x = |i: usize| (state.x[i].x - first.system.discs[i].radius, state.x[i].x + first.system.discs[i].radius);
        (0..state.x.len()).map(x).fold((f64::INFINITY, f64::NEG_INFINITY), |a, b| (a.0.min(b.0), a.1.max(b.1)))
    };
    let before = ends(&first.start);
    let after = ends(&first.end);
    // Three times the width of a copy's exact motion, because an inaccurate scheme may throw grains farther.
    3.0 * (before.1.max(after.1) - before.0.min(after.0))
}

#[expect(clippy::cast_precision_loss, reason = "a small number")]
fn offset(width: f64, copy: usize) -> DVec2 {
    DVec2::new(width * copy as f64, 0.0)
}

/// Whether a disc is one of a clump, and so no grain of its own.
fn is_member(system: &System, disc: usize) -> bool {
    system.clumps.iter().any(|clump| clump.members.contains(&disc))
}

/// Returns the direction from the first to the last disc of a clump.
fn axis(clump: &Clump, state: &State) -> DVec2 {
    (state.x[clump.members.end - 1] - state.x[clump.members.start]).normalize_or(DVec2::X)
}

/// Returns the state of each copy in the coordinates of its system.
fn states(simulation: &mut Simulation, answers: &[Answer]) -> Vec<State> {
    let width = spacing(answers);
    let world = simulation.world_mut();
    let mut query =
        world.query_filtered::<(&GrainId, &Position, &Velocity, Option<&Spin>, Option<&Orientation>), With<Grain>>();
    let grain = |(id, x, v, w, rotor): (&GrainId, &Position, &Velocity, Option<&Spin>, Option<&Orientation>)| {
        (*id, x.0, v.0, w.map_or(0.0, |w| w.0), rotor.map_or(DVec2::X, |rotor| rotor.0))
    };
    let mut rows: Vec<_> = query.iter(world).map(grain).collect();
    rows.sort_unstable_by_key(|row| row.0);
    let mut rows = rows.into_iter();
    let mut pistons = free_states(world).into_iter();
    let state_of_copy = |copy: usize| {
        let Answer { system, start, .. } = &answers[copy];
        let mut state = State { x: Vec::new(), v: Vec::new(), w: Vec::new() };
        let mut rotor = DVec2::X;
        for i in 0..system.discs.len() {
            if let Some(floor) = system.floors.iter().find(|floor| floor.piston.is_some_and(|it| it.disc == i)) {
                let moved = pistons.next().unwrap_or_default();
                state.x.push(start.x[i] + floor.normal * moved.coordinate);
                state.v.push(floor.normal * moved.rate);
                state.w.push(0.0);
            } else if let Some(clump) = system.clumps.iter().find(|clump| clump.members.contains(&i)) {
                // The arm at the start, turned.
                let back = DVec2::new(axis(clump, start).x, -axis(clump, start).y);
                let arm = rotor.rotate(back.rotate(start.x[i] - start.x[clump.centre]));
                let spin = state.w[clump.centre];
                state.x.push(state.x[clump.centre] + arm);
                state.v.push(state.v[clump.centre] + arm.perp() * spin);
                state.w.push(spin);
            } else if let Some(row) = rows.next() {
                state.x.push(row.1 - offset(width, copy));
                state.v.push(row.2);
                state.w.push(row.3);
                rotor = row.4;
            }
        }
        state
    };
    (0..answers.len()).map(state_of_copy).collect()
}

/// Returns the states of the free walls, in the order of the scene.
fn free_states(world: &World) -> Vec<FreeState> {
    world
        .get_resource::<Surfaces<Plane>>()
        .into_iter()
        .flat_map(|walls| walls.free().map(|(_, state)| *state))
        .collect()
}

/// Returns the key `shapes` of a system with clumps, which all have the shape of the first.
fn shapes(system: &System) -> String {
    let Some(clump) = system.clumps.first() else { return String::new() };
    let start = system.start();
    let back = DVec2::new(axis(clump, &start).x, -axis(clump, &start).y);
    let disc = |i: usize| {
        let at = back.rotate(start.x[i] - start.x[clump.centre]);
        format!("(at: {}, radius: {:?})", vector(at), system.discs[i].radius)
    };
    format!("shapes: {{\"clump\": Discs([{}])}}, ", clump.members.clone().map(disc).collect::<Vec<_>>().join(", "))
}

fn vector(v: DVec2) -> String {
    format!("({:?}, {:?})", v.x, v.y)
}

/// Returns the keys of the floors. All copies share the floors at rest. Every copy has a piece of its own of a floor that moves, because
/// the copies begin at different phases. `width` is the distance of the copies, m.
fn floors(answers: &[Answer], width: f64) -> String {
    let mut keys = FloorKeys::default();
    let Some(first) = answers.first() else { return String::new() };
    for Floor { point, normal, .. } in first.system.floors.iter().filter(|floor| !floor.moves()) {
        // Writing to a string cannot fail.
        let _ = write!(keys.walls, "HalfPlane(point: {}, normal: {}), ", vector(*point), vector(*normal));
    }
    for (copy, answer) in answers.iter().enumerate() {
        for (number, floor) in answer.system.floors.iter().enumerate() {
            keys.add(floor, answer, &format!("{copy} {number}"), offset(width, copy), width);
        }
    }
    let FloorKeys { walls, motions, free } = keys;
    let free = if free.is_empty() { free } else { format!(", free_walls: [{free}]") };
    format!("walls: [{walls}], motions: [{motions}]{free}")
}

/// Entries of the keys of floors.
#[derive(Default)]
struct FloorKeys {
    walls: String,
    motions: String,
    free: String,
}

impl FloorKeys {
    /// Adds the piece of a floor that moves, shifted by `offset` (m) and of this width (m).
    fn add(&mut self, floor: &Floor, answer: &Answer, name: &str, offset: DVec2, width: f64) {
        let mut piece = |middle: DVec2| {
            let [from, to] = [-0.5, 0.5].map(|share| vector(middle + offset + floor.normal.perp() * share * width));
            // Writing to a string cannot fail.
            let _ = write!(self.walls, "Segment(from: {from}, to: {to}, name: \"{name}\"), ");
        };
        if let Some(Vibration { amplitude, frequency }) = floor.vibration {
            piece(floor.point + floor.motion(answer.began)[0]);
            let amplitude = vector(amplitude);
            let phase = TAU * frequency * answer.began;
            // As above.
            let _ = write!(
                self.motions,
                "(walls: \"{name}\", translate: Oscillate(amplitude: {amplitude}, frequency: {frequency:?}, phase: {phase:?})), "
            );
        }
        if let Some(Piston { disc, load, spring }) = floor.piston {
            let shift = (answer.start.x[disc] - floor.point).dot(floor.normal);
            piece(floor.point + floor.normal * shift);
            let [along, rest] = [vector(floor.normal), format!("{:?}", -shift)];
            let mass = answer.system.discs[disc].mass;
            let rate = answer.start.v[disc].dot(floor.normal);
            let spring =
                if spring > 0.0 { format!("spring: (stiffness: {spring:?}, rest: {rest}), ") } else { String::new() };
            // As above.
            let _ = write!(
                self.free,
                "(walls: \"{name}\", moves: Along({along}), mass: {mass:?}, load: {load:?}, {spring}rate: {rate:?}, stops: (-1.0, 1.0)), "
            );
        }
    }
}

/// Returns the scene's text, without grains. `floors` has the keys of the floors.
fn scene_text(system: &System, floors: &str, scheme: &Scheme, dt: f64, until: f64) -> String {
    let contact = match system.law {
        Law::Full { k, b } => format!("Assignment(k: {k:?}, b: {b:?})"),
        Law::Linear { k, e, attracts, friction } => {
            let attraction = if attracts { "Allowed" } else { "Forbidden" };
            let friction = friction.map_or_else(String::new, |f| {
                let k = f.k;
                let share = f.share;
                let mu = f.mu;
                let rolling = f.rolling.map_or_else(String::new, |Rolling { k, b, mu }| {
                    format!(", rolling: (k: {k:?}, damping: B({b:?}), friction: {mu:?})")
                });
                format!(", tangential: Spring(k: {k:?}, damping: OfNormal({share:?}), friction: {mu:?}){rolling}")
            });
            format!("Linear(k: {k:?}, damping: Restitution({e:?}), attraction: {attraction}{friction})")
        }
        Law::Hertz { young, poisson, e, mu } => format!(
            "Hertz(restitution: {e:?}, tangential: Mindlin(friction: {mu:?})), \
             materials: [(young: {young:?}, poisson: {poisson:?})]"
        ),
        Law::Jkr { young, poisson, work } => format!(
            "Hertz(restitution: 1.0, tangential: Mindlin(friction: 0.0), adhesion: Jkr({work:?})), \
             materials: [(young: {young:?}, poisson: {poisson:?})]"
        ),
        Law::Adhesive { young, poisson, e, mu, work } => format!(
            "Hertz(restitution: {e:?}, tangential: Mindlin(friction: {mu:?}), adhesion: Dmt({work:?})), \
             materials: [(young: {young:?}, poisson: {poisson:?})]"
        ),
    };
    format!(
        "(gravity: {}, contact: {contact}, {}{floors}, integrator: {}, step: Fixed({dt:?}), until: {until:?}, \
         pictures: None)",
        vector(system.gravity),
        shapes(system),
        scheme.name()
    )
}
