//! The naive simulator: a loop over every pair and every wall in every step, one after the other.
//!
//! Velocity Verlet: v += h F/m, x += dt v, F from x(t+dt) and v(t+dt/2), v += h F/m. Spins are treated alike. a(0)
//! comes from x(0) and v(0). Euler schemes: v(t+dt) = v + dt F/m and x(t+dt) = x + dt v, with v of the end (symplectic)
//! or of the beginning (explicit).
//!
//! A grain beyond a periodic side is shifted by the length of the box. Two particles interact by the shortest
//! separation of their images. Moving walls keep their velocity. Grains enter, and grains that have fallen far enough
//! are removed. A grain of several spheres is a centre of mass and its spheres ([`Clump`]). The memory of a contact lasts as long as the contact
//! acts in every step.

use std::collections::BTreeMap;

use crate::centred::{Pushed, VelocityPrediction, centred, start};
use crate::clump::Clump;
use crate::law::{Reduced, Terms};
use crate::plain::{Action, Memory, PairState, Times, plain};
use crate::vector::V;
use crate::wall::Wall;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scheme {
    Verlet,
    Centred,
    SymplecticEuler,
    ExplicitEuler,
}

/// The part of a grain that a body is.
#[derive(Clone, Copy, Debug)]
pub enum Part {
    /// A grain of one sphere, or a wall grain.
    Whole,
    /// The centre of mass of the clump with this number.
    Centre(usize),
    /// A sphere of the clump whose centre has this number among the bodies, with its gains of velocity (m/s) and spin (rad/s) in half a step.
    Sphere { of: usize, gains: [V; 2] },
}

/// A grain or a part of it, or a wall grain if it is fixed.
#[derive(Clone, Copy, Debug)]
pub struct Body {
    pub part: Part,
    /// The place of a sphere from the centre of its clump, m.
    pub arm: V,
    pub position: V,
    pub velocity: V,
    pub spin: V,
    pub radius: f64,
    pub mass: f64,
    /// kg m^2. A sphere of a clump has the harmonic mean of the principal moments.
    pub inertia: f64,
    pub species: usize,
    pub is_fixed: bool,
    pub force: V,
    pub torque: V,
    /// Number of contacts at the last evaluation.
    pub contacts: usize,
    /// Whether it has had at most one contact since contacts were counted and it had none, or since the start.
    pub is_lone: bool,
    /// Whether it has been removed.
    pub is_gone: bool,
    /// Of a wall: the velocity that it gains from the middle of the step to its end, m/s.
    pub gained: V,
}

#[derive(Clone, Debug)]
pub struct Simulator {
    pub bodies: Vec<Body>,
    pub clumps: Vec<Clump>,
    pub walls: Vec<Wall>,
    /// Lower and upper ends.
    pub periodic: [Option<(f64, f64)>; 3],
    pub gravity: V,
    /// Grains with a height, along the axis `up`, below this value are removed at the end of a step, m.
    pub cull: f64,
    pub up: usize,
    /// Laws by the species of both particles.
    pub laws: Vec<Vec<Terms>>,
    pub scheme: Scheme,
    pub dt: f64,
    /// beta of the centred scheme for velocities and for spins.
    pub prediction: [f64; 2],
    /// Whether springs of the centred scheme advance with the velocities in the middle of the step.
    pub springs_exact: bool,
    /// Grains that enter later, each with its number of steps.
    pub releases: Vec<(u64, Body)>,
    pub steps: u64,
    /// Memories by the numbers of both particles; walls are numbered down from `usize::MAX`.
    pub memories: BTreeMap<[usize; 2], Memory>,
}

impl Body {
    fn inverse_mass(&self) -> f64 {
        if self.is_fixed { 0.0 } else { 1.0 / self.mass }
    }

    fn inverse_inertia(&self) -> f64 {
        if self.is_fixed { 0.0 } else { 1.0 / self.inertia }
    }

    pub fn is_sphere_of_clump(&self) -> bool {
        matches!(self.part, Part::Sphere { .. })
    }

    /// Whether contacts act on it: a centre of mass has none of its own.
    fn is_solid(&self) -> bool {
        !matches!(self.part, Part::Centre(_))
    }

    /// Advances velocity and spin by the loads in the time `kick`, s. Clumps turn by themselves.
    fn kick(&mut self, kick: f64) {
        if self.is_sphere_of_clump() {
            return;
        }
        self.velocity += self.force * (kick * self.inverse_mass());
        if self.is_solid() {
            self.spin += self.torque * (kick * self.inverse_inertia());
        }
    }

    /// Returns the gains of velocity and spin in half a step of `dt`, by the loads of its beginning.
    fn gains(&self, dt: f64) -> [V; 2] {
        match self.part {
            Part::Sphere { gains, .. } => gains,
            _ => [self.force * (0.5 * dt * self.inverse_mass()), self.torque * (0.5 * dt * self.inverse_inertia())],
        }
    }
}

impl Simulator {
    /// Returns the shortest image of a separation.
    pub fn shortest(&self, mut separation: V) -> V {
        for (axis, side) in self.periodic.iter().enumerate() {
            if let Some((low, high)) = side {
                let images = [0.0, high - low, low - high].map(|shift| separation.0[axis] + shift);
                separation.0[axis] = images.into_iter().min_by(|a, b| a.abs().total_cmp(&b.abs())).unwrap();
            }
        }
        separation
    }

    /// Evaluates the forces of the start.
    pub fn start(&mut self) {
        self.release();
        for clump in &self.clumps {
            clump.place_spheres(&mut self.bodies);
            self.bodies[clump.centre].spin = clump.spin();
        }
        self.evaluate(0.0);
        let gravity = self.gravity;
        self.walls.iter_mut().for_each(|wall| wall.kick(gravity, 0.0));
        self.remove();
    }

    /// Adds grains that enter. Their first force is their weight, and they do not count as lone.
    fn release(&mut self) {
        for (_, body) in self.releases.iter().filter(|(when, _)| *when == self.steps) {
            self.bodies.push(Body { force: self.gravity * body.mass, is_lone: false, ..*body });
        }
    }

    /// Advances by one step.
    pub fn step(&mut self) {
        if self.steps > 0 {
            self.release();
        }
        self.steps += 1;
        let dt = self.dt;
        let periodic = self.periodic;
        let verlet = matches!(self.scheme, Scheme::Verlet | Scheme::Centred);
        let kick = if verlet { 0.5 * dt } else { dt };
        for body in &mut self.bodies {
            let before = body.velocity;
            body.kick(kick);
            body.position += if self.scheme == Scheme::ExplicitEuler { before } else { body.velocity } * dt;
            for (axis, side) in periodic.iter().enumerate() {
                let x = &mut body.position.0[axis];
                match *side {
                    Some((low, high)) if *x < low => *x += high - low,
                    Some((low, high)) if *x >= high => *x -= high - low,
                    _ => {}
                }
            }
        }
        let is_centred = self.scheme == Scheme::Centred;
        self.walls.iter_mut().for_each(|wall| wall.drift(dt, is_centred));
        let shares = (self.scheme == Scheme::Centred).then_some(self.prediction);
        for clump in &mut self.clumps {
            clump.momentum += self.bodies[clump.centre].torque * kick;
            clump.drift(&mut self.bodies, dt, shares);
        }
        self.evaluate(dt);
        let gravity = self.gravity;
        self.walls.iter_mut().for_each(|wall| wall.kick(gravity, dt));
        if verlet {
            self.bodies.iter_mut().for_each(|body| body.kick(kick));
            for clump in &mut self.clumps {
                clump.momentum += self.bodies[clump.centre].torque * kick;
                self.bodies[clump.centre].spin = clump.spin();
            }
        }
        self.remove();
    }

    /// Removes grains below the cull line in steps that are multiples of 32, the start included.
    fn remove(&mut self) {
        if !self.steps.is_multiple_of(32) {
            return;
        }
        for body in self.bodies.iter_mut().filter(|body| !body.is_fixed) {
            body.is_gone |= !body.is_sphere_of_clump() && body.position.0[self.up] < self.cull;
        }
        for clump in &self.clumps {
            for (number, _) in &clump.spheres {
                self.bodies[*number].is_gone = self.bodies[clump.centre].is_gone;
            }
        }
    }

    /// Evaluates all forces and torques and advances memories by `dt`, which is 0 before the first step.
    fn evaluate(&mut self, dt: f64) {
        let former = self.bodies.clone();
        for body in &mut self.bodies {
            let weight = if body.is_sphere_of_clump() { V::default() } else { self.gravity * body.mass };
            (body.force, body.torque, body.contacts) = (weight, V::default(), 0);
        }
        self.walls.iter_mut().for_each(|wall| (wall.load, wall.moment) = (V::default(), V::default()));
        let mut remembered = std::mem::take(&mut self.memories);
        let all: Vec<usize> = (0..former.len()).filter(|&i| !former[i].is_gone && former[i].is_solid()).collect();
        for (rank, &i) in all.iter().enumerate() {
            for &j in &all[rank + 1..] {
                let separation = self.shortest(former[i].position - former[j].position);
                let distance = separation.length();
                let reach = former[i].radius + former[j].radius;
                let both_fixed = former[i].is_fixed && former[j].is_fixed;
                if !both_fixed && !are_of_one_clump(&former[i], &former[j]) && distance < 1.5 * reach {
                    let towards = (reach - distance, separation * (1.0 / distance));
                    self.meet([&former[i], &former[j]], [i, j], towards, &mut remembered, dt);
                }
            }
            for (number, wall) in self.walls.clone().iter().enumerate() {
                let foot = wall.foot(former[i].position);
                let flat = Body {
                    position: foot.place,
                    velocity: foot.velocity,
                    gained: foot.gained,
                    radius: f64::INFINITY,
                    species: wall.species,
                    ..FLAT
                };
                if !former[i].is_fixed {
                    let towards = (former[i].radius - foot.distance, foot.normal);
                    self.meet([&former[i], &flat], [i, usize::MAX - number], towards, &mut remembered, dt);
                }
            }
        }
        for clump in &self.clumps {
            clump.gather(&mut self.bodies);
        }
        if self.steps.is_multiple_of(8) {
            let starts = self.steps == 0;
            for body in &mut self.bodies {
                body.is_lone = body.contacts == 0 || body.contacts == 1 && (body.is_lone || starts);
            }
        }
    }

    /// Evaluates the contact of two particles with the given overlap and normal.
    fn meet(
        &mut self,
        [a, b]: [&Body; 2],
        pair: [usize; 2],
        (overlap, normal): (f64, V),
        remembered: &mut BTreeMap<[usize; 2], Memory>,
        dt: f64,
    ) {
        let inverse_masses = [a.inverse_mass(), b.inverse_mass()];
        let radius = if b.radius.is_infinite() { a.radius } else { a.radius * b.radius / (a.radius + b.radius) };
        let pair_state = PairState {
            normal,
            overlap,
            velocity: a.velocity - b.velocity,
            reduced: Reduced { mass: 1.0 / (inverse_masses[0] + inverse_masses[1]), radius },
            radii: [a.radius, b.radius],
            spins: [a.spin, b.spin],
        };
        let terms = self.laws[a.species][b.species];
        let mut memory = remembered.remove(&pair).unwrap_or_default();
        let action = if self.scheme == Scheme::Centred {
            self.meet_centred(&terms, &pair_state, [a, b], &mut memory, dt)
        } else {
            let range = if memory.stiffness > 0.0 { terms.range(pair_state.reduced) } else { 0.0 };
            (overlap + range > 0.0)
                .then(|| plain(&terms, [&pair_state; 2], &mut memory, Times { dt, lead: 0.0, is_centred: false }))
        };
        let Some(action) = action else { return };
        self.memories.insert(pair, memory);
        for (side, number) in pair.into_iter().enumerate() {
            if let Some(wall) = self.walls.get_mut(usize::MAX - number) {
                wall.load += -action.force;
                wall.moment += b.position.cross(-action.force);
            } else if let Some(body) = self.bodies.get_mut(number) {
                body.force += if side == 0 { action.force } else { -action.force };
                body.torque += action.torques[side];
                body.contacts += 1;
            }
        }
    }
}

impl Simulator {
    /// Returns the action of a contact under the centred scheme.
    fn meet_centred(
        &self,
        terms: &Terms,
        pair_state: &PairState,
        both: [&Body; 2],
        memory: &mut Memory,
        dt: f64,
    ) -> Option<Action> {
        let half = 0.5 * self.dt;
        let [beta, beta_of_spins] = self.prediction;
        let lead = if self.springs_exact { 0.0 } else { half };
        let gains = if dt == 0.0 { VelocityPrediction::default() } else { self.ahead(both, pair_state, dt) };
        let predicted = PairState {
            velocity: pair_state.velocity + gains.velocity * beta - both[1].gained * (1.0 - beta),
            spins: [0, 1].map(|side| pair_state.spins[side] + gains.spins[side] * beta_of_spins),
            ..*pair_state
        };
        let even = if terms.reaches() {
            16.0
        } else if terms.law.is_hertz() {
            8.0
        } else {
            3.0
        };
        let closing = -predicted.velocity.dot(predicted.normal);
        let nearest = even * half * closing.abs();
        let range = if memory.stiffness > 0.0 { terms.range(pair_state.reduced) } else { 0.0 };
        let overlap = pair_state.overlap + range;
        let mut is_even = overlap >= nearest;
        if terms.law.friction.is_some() {
            // Near a change of the sign of the normal force the cap of friction is zero.
            let spring = terms.spring(predicted.reduced, predicted.overlap);
            let drag = terms.drag(predicted.reduced, predicted.overlap);
            let total = (spring + drag * closing).max(terms.floor());
            is_even &= total.min(spring) * overlap >= spring * nearest;
        }
        if terms.reaches() && overlap <= 0.0 {
            is_even = false;
        }
        if dt == 0.0 && is_even {
            // At the start springs are empty, and stored ahead.
            Some(plain(terms, [pair_state; 2], memory, Times { dt: lead, lead, is_centred: true }))
        } else if dt == 0.0 {
            start(terms, pair_state, memory, [half, lead])
        } else if is_even && !both[0].is_lone && !both[1].is_lone {
            let gathering = if self.springs_exact { pair_state } else { &predicted };
            Some(plain(terms, [&predicted, gathering], memory, Times { dt, lead, is_centred: true }))
        } else {
            let is_far = overlap + 1.25 * half * predicted.velocity.dot(predicted.normal).abs() < 0.0;
            if is_far { None } else { centred(terms, pair_state, &gains, memory, [dt, lead]) }
        }
    }
}

/// A wall surface as a body that forces do not move.
pub const FLAT: Body = Body {
    part: Part::Whole,
    arm: V([0.0; 3]),
    position: V([0.0; 3]),
    velocity: V([0.0; 3]),
    spin: V([0.0; 3]),
    radius: f64::INFINITY,
    mass: 0.0,
    inertia: 0.0,
    species: 0,
    is_fixed: true,
    force: V([0.0; 3]),
    torque: V([0.0; 3]),
    contacts: 0,
    is_lone: false,
    is_gone: false,
    gained: V([0.0; 3]),
};

/// Whether two bodies are spheres of one clump.
fn are_of_one_clump(a: &Body, b: &Body) -> bool {
    matches!((a.part, b.part), (Part::Sphere { of, .. }, Part::Sphere { of: other, .. }) if of == other)
}

impl Simulator {
    /// Returns the predicted velocity change over half a step of both particles, from their previous loads.
    fn ahead(&self, both: [&Body; 2], pair_state: &PairState, dt: f64) -> VelocityPrediction {
        let normal = pair_state.normal;
        let gains = both.map(|body| body.gains(dt));
        let mobility = |body: &Body| match body.part {
            Part::Sphere { of, .. } => self.clump_at(of).mobility(body.mass, body.arm, normal),
            _ => body.inverse_mass(),
        };
        VelocityPrediction {
            velocity: gains[0][0] - gains[1][0] - both[1].gained,
            spins: gains.map(|[_, spin]| spin),
            inverse_masses: both.map(mobility),
            inverse_inertias: both.map(Body::inverse_inertia),
            lone: both.map(|body| body.is_lone),
            pushed: self.pushed(both, pair_state),
        }
    }

    /// Returns what momenta at the contact change beside what they change at spheres.
    fn pushed(&self, both: [&Body; 2], pair_state: &PairState) -> Pushed {
        let normal = pair_state.normal;
        let mut pushed = Pushed::default();
        let sliding = pair_state.sliding(pair_state.velocity, pair_state.spins, pair_state.levers(false));
        let along = sliding * (1.0 / sliding.length());
        for (side, (body, towards)) in both.into_iter().zip([-normal, normal]).enumerate() {
            let Part::Sphere { of, .. } = body.part else { continue };
            let clump = self.clump_at(of);
            let arm = body.arm + towards * body.radius;
            // The momentum on this body is -towards.
            let spin = clump.turning(arm.cross(-towards));
            let velocity = spin.cross(body.arm);
            pushed.velocities[side] = if side == 0 { velocity } else { -velocity };
            pushed.spins[side] = spin;
            if sliding.length() > 0.0 {
                let of_sphere =
                    clump.mobility(body.mass, body.arm, normal) + body.radius.powi(2) * body.inverse_inertia();
                pushed.mobilities[side] = clump.mobility(body.mass, arm, along) - of_sphere;
            }
        }
        pushed
    }

    fn clump_at(&self, centre: usize) -> &Clump {
        match self.bodies[centre].part {
            Part::Centre(clump) => &self.clumps[clump],
            _ => panic!("body {centre} is the centre of a clump"),
        }
    }
}
