//! Independent reference solution: discs, contact laws and integration, implemented a second time for the plane.
//!
//! This module uses no contact, integration scheme or neighbour search of the simulator, so it cannot share their
//! errors. Symbols: overlap delta, normal n from j to i, v_n = v_ij.n, tangent t = z x n, slip velocity
//! v_s = v_ij.t - (R_i w_i + R_j w_j). The forces are
//!
//! * [`Law::Full`]: F = k delta n - b v_ij (the assignment's law);
//! * [`Law::Linear`], normal: F_n = k delta - c v_n with c = 2 zeta sqrt(k m_eff) for a restitution e. F_n is cut at 0
//!   unless attraction is allowed.
//! * [`Law::Linear`], friction: F_t = -k_t S - c_t v_s with S' = v_s while the contact sticks, F_t = +-mu |F_n| while
//!   it slips. During slip S follows the force, S = -(F_t + c_t v_s)/k_t. The contact sticks again when S' = v_s would
//!   reduce the force below the cap.
//! * Rolling resistance: the same with its own k, c and mu and the velocity v_r = R_eff (w_i - w_j). The torque on i is
//!   R_eff F_r.
//! * [`Law::Hertz`]: F_n = 4/3 E* sqrt(R_eff) delta^(3/2) - c v_n, cut at 0, with c = 2 z sqrt(S_n m_eff) and
//!   S_n = 2 E* sqrt(R_eff delta). Friction has k_t = 8 G* sqrt(R_eff delta), c_t = 2 z sqrt(k_t m_eff). While k_t grows, S
//!   also obeys S' = -S k_t'/k_t, so that the spring keeps its force.
//!
//! * [`Law::Adhesive`]: the same with a constant pull 2 pi w R_eff while the sides overlap, which does not count in the cap of
//!   friction and is not cut.
//!
//! A [`Clump`] is a rigid body of discs. The discs move as the body says: with the centre X, r = x - X and the spin w, x'' = X'' + w' z x r - w^2 r.
//!
//! A [`Piston`] is a floor that forces shift along its normal. Its place and rate are those of a disc of the system, so that it is integrated like one.
//!
//! Each contact is in a mode (`contact`) in which its force is smooth. [`path`] integrates with the classical
//! fourth-order Runge-Kutta scheme and ends a step where a mode ends. [`closed`] has the closed forms. `moduli` has the
//! coefficients of a contact.
//!
//! Limits: plane only; the lever arms of friction are the radii; floors and discs have one material. Two mode changes of one contact
//! within one step of the reference (a contact shorter than that) are missed.

pub mod closed;
mod contact;
mod moduli;
pub mod path;

use std::f64::consts::TAU;
use std::ops::Range;

use glam::DVec2;

/// Friction of [`Law::Linear`].
#[derive(Clone, Copy, Debug)]
pub struct Friction {
    /// Tangential stiffness k_t, N/m.
    pub k: f64,
    /// Tangential damping over normal damping, c_t/c.
    pub share: f64,
    /// Friction coefficient mu.
    pub mu: f64,
    /// Rolling resistance, if any.
    pub rolling: Option<Rolling>,
}

/// Rolling resistance of [`Law::Linear`].
#[derive(Clone, Copy, Debug)]
pub struct Rolling {
    /// Stiffness, N/m.
    pub k: f64,
    /// Damping, N s/m.
    pub b: f64,
    /// Friction coefficient.
    pub mu: f64,
}

/// The contact law.
#[derive(Clone, Copy, Debug)]
pub enum Law {
    /// F = k delta n - b v_ij.
    Full {
        /// Stiffness, N/m.
        k: f64,
        /// Damping, N s/m.
        b: f64,
    },
    /// A spring and a dashpot along the normal, and friction.
    Linear {
        /// Stiffness, N/m.
        k: f64,
        /// Restitution.
        e: f64,
        /// Whether the normal force may be attractive.
        attracts: bool,
        /// Friction along the tangent, if any.
        friction: Option<Friction>,
    },
    /// Elastic spheres with the damping and the friction of `siloflow::dem::contact::hertz`, without attraction.
    Hertz {
        /// Young's modulus, Pa.
        young: f64,
        /// Poisson's ratio.
        poisson: f64,
        /// Restitution.
        e: f64,
        /// Friction coefficient mu.
        mu: f64,
    },
    /// Elastic spheres with a constant pull, `siloflow::dem::contact::adhesion`.
    Adhesive {
        /// Young's modulus, Pa.
        young: f64,
        /// Poisson's ratio.
        poisson: f64,
        /// Restitution without the pull.
        e: f64,
        /// Friction coefficient mu.
        mu: f64,
        /// Work of adhesion w, J/m^2.
        work: f64,
    },
    /// Elastic spheres with adhesion beyond touch, `siloflow::dem::contact::jkr`, without damping and friction. Known by its closed
    /// form only: [`path`] does not integrate it.
    Jkr {
        /// Young's modulus, Pa.
        young: f64,
        /// Poisson's ratio.
        poisson: f64,
        /// Work of adhesion w, J/m^2.
        work: f64,
    },
}

/// A disc and its initial motion.
#[derive(Clone, Copy, Debug)]
pub struct Disc {
    /// Radius, m.
    pub radius: f64,
    /// Mass, kg.
    pub mass: f64,
    /// Initial position, m.
    pub x: DVec2,
    /// Initial velocity, m/s.
    pub v: DVec2,
}

/// A half-plane that discs touch: a floor, a side wall or a lid.
#[derive(Clone, Copy, Debug)]
pub struct Floor {
    /// A point on the surface, m; of a floor that vibrates, in the middle of its motion.
    pub point: DVec2,
    /// Unit normal towards the discs.
    pub normal: DVec2,
    /// Vibration, if any.
    pub vibration: Option<Vibration>,
    /// The forces that shift the floor, if any.
    pub piston: Option<Piston>,
}

/// A floor that gravity, a load, a spring and the discs on it shift along its normal.
#[derive(Clone, Copy, Debug)]
pub struct Piston {
    /// The disc that stands for the floor: its mass, its place on the surface, its velocity. This disc has no radius and touches nothing.
    pub disc: usize,
    /// Load along the normal, N.
    pub load: f64,
    /// Stiffness of a spring, N/m, that is relaxed where the disc is at the `point` of the floor.
    pub spring: f64,
}

/// A motion A sin(2 pi f t).
#[derive(Clone, Copy, Debug)]
pub struct Vibration {
    /// Amplitude A, m.
    pub amplitude: DVec2,
    /// Frequency f, Hz.
    pub frequency: f64,
}

impl Floor {
    /// Returns the floor through a point (m), at rest.
    #[must_use]
    pub fn still(point: DVec2, normal: DVec2) -> Self {
        Self { point, normal, vibration: None, piston: None }
    }

    /// Whether it moves.
    #[must_use]
    pub fn moves(&self) -> bool {
        self.vibration.is_some() || self.piston.is_some()
    }

    /// Returns shift (m) and velocity (m/s) at a time (s) by its vibration.
    #[must_use]
    pub fn motion(&self, time: f64) -> [DVec2; 2] {
        let Some(Vibration { amplitude, frequency }) = self.vibration else { return [DVec2::ZERO; 2] };
        let pulse = TAU * frequency;
        let (sine, cosine) = (pulse * time).sin_cos();
        [amplitude * sine, amplitude * (pulse * cosine)]
    }
}

/// A rigid body of discs. The disc with the number `centre` is its centre of mass, without contacts; those of `members` touch. All have the mass of the
/// body.
#[derive(Clone, Debug)]
pub struct Clump {
    /// The centre of mass.
    pub centre: usize,
    /// The discs.
    pub members: Range<usize>,
    /// Moment of inertia about the centre, kg m^2.
    pub inertia: f64,
    /// Initial spin, rad/s. The initial velocities of all its discs are that of the centre.
    pub spin: f64,
}

/// Discs, floors, gravity and a contact law. Discs that are no part of a clump start without spin.
#[derive(Clone, Debug)]
pub struct System {
    /// Acceleration of gravity, m/s^2.
    pub gravity: DVec2,
    /// Law of all contacts.
    pub law: Law,
    /// The moving discs.
    pub discs: Vec<Disc>,
    /// The half-planes.
    pub floors: Vec<Floor>,
    /// The discs that form rigid bodies.
    pub clumps: Vec<Clump>,
}

/// Moment of inertia of a disc over m R^2.
pub const INERTIA: f64 = 0.5;

/// Positions, velocities and spins of all discs.
#[derive(Clone, Debug, PartialEq)]
pub struct State {
    /// Positions, m.
    pub x: Vec<DVec2>,
    /// Velocities, m/s.
    pub v: Vec<DVec2>,
    /// Spins, rad/s.
    pub w: Vec<f64>,
}

impl System {
    /// Whether two discs can touch: neither is a centre, and they are not of one clump.
    #[must_use]
    pub fn can_touch(&self, i: usize, j: usize) -> bool {
        let are_one = |clump: &Clump| clump.members.contains(&i) && clump.members.contains(&j);
        self.touches(i) && self.touches(j) && !self.clumps.iter().any(are_one)
    }

    /// Whether a disc touches others: it is no centre of a clump, and no floor.
    #[must_use]
    pub fn touches(&self, i: usize) -> bool {
        !self.clumps.iter().any(|clump| clump.centre == i) && !self.is_floor(i)
    }

    /// Whether a disc stands for a floor.
    #[must_use]
    pub fn is_floor(&self, i: usize) -> bool {
        self.floors.iter().any(|floor| floor.piston.is_some_and(|piston| piston.disc == i))
    }

    /// Returns the state at time 0.
    #[must_use]
    pub fn start(&self) -> State {
        let mut state = State {
            x: self.discs.iter().map(|disc| disc.x).collect(),
            v: self.discs.iter().map(|disc| disc.v).collect(),
            w: vec![0.0; self.discs.len()],
        };
        for clump in &self.clumps {
            state.w[clump.centre] = clump.spin;
            for i in clump.members.clone() {
                state.v[i] += (state.x[i] - state.x[clump.centre]).perp() * clump.spin;
                state.w[i] = clump.spin;
            }
        }
        state
    }

    /// Returns the sum of kinetic, gravitational and elastic energy, J, with all floors at their `point`. Elastic energy counts linear normal springs only.
    #[must_use]
    pub fn energy(&self, state: &State) -> f64 {
        let k = match self.law {
            Law::Full { k, .. } | Law::Linear { k, .. } => k,
            Law::Hertz { .. } | Law::Adhesive { .. } | Law::Jkr { .. } => 0.0,
        };
        let mut energy = 0.0;
        for (i, disc) in self.discs.iter().enumerate() {
            let turning = INERTIA * disc.radius * disc.radius * state.w[i] * state.w[i];
            energy +=
                0.5 * disc.mass * (state.v[i].length_squared() + turning) - disc.mass * self.gravity.dot(state.x[i]);
            let overlaps = self.floors.iter().map(|floor| disc.radius - (state.x[i] - floor.point).dot(floor.normal));
            let others = self.discs.iter().enumerate().skip(i + 1);
            let overlaps =
                overlaps.chain(others.map(|(j, other)| disc.radius + other.radius - state.x[i].distance(state.x[j])));
            energy += overlaps.map(|overlap| 0.5 * k * overlap.max(0.0).powi(2)).sum::<f64>();
        }
        energy
    }
}
