//! The other side of every comparison: grains, law and integration written out anew, in plain vectors of the plane.
//!
//! Nothing here uses the product's contacts, schemes or searches, so an error of theirs cannot hide here. The forces
//! are, with overlap delta, normal n from j to i, v_n = v_ij.n and slip
//! v_s = v_ij.t - (R_i w_i + R_j w_j), t = z x n,
//!
//! * [`Law::Full`]: F = k delta n - b v_ij (the assignment's);
//! * [`Law::Linear`]: F_n = k delta - c v_n with c = 2 zeta sqrt(k m_eff) for a restitution e, cut at 0 unless
//!   attraction is allowed; friction F_t = -k_t S - c_t v_s with S' = v_s while it sticks, +-mu |F_n| while it slips. S
//!   then follows the force, S = -(F_t + c_t v_s)/k_t, and friction sticks again when S' = v_s would pull it below the cap.
//!
//! Each contact is in one of these modes (`contact`), in which its force is smooth; [`path`] integrates by the classical Runge
//! and Kutta scheme of fourth order and ends a step where a mode ends. [`closed`] has the closed forms.
//!
//! Limits: the plane; arms of friction are the radii; no rolling resistance; two switches of one contact within one step
//! of the reference (a graze shorter than that) go unseen.

pub mod closed;
mod contact;
pub mod path;

use glam::DVec2;

/// Friction of [`Law::Linear`].
#[derive(Clone, Copy, Debug)]
pub struct Friction {
    /// k_t, N/m.
    pub k: f64,
    /// c_t/c.
    pub share: f64,
    /// mu.
    pub mu: f64,
}

/// The contact law.
#[derive(Clone, Copy, Debug)]
pub enum Law {
    /// k delta n - b v_ij.
    Full {
        /// N/m.
        k: f64,
        /// N s/m.
        b: f64,
    },
    /// A spring and a dashpot along the normal, and friction.
    Linear {
        /// N/m.
        k: f64,
        /// Restitution.
        e: f64,
        /// Whether the normal force may pull.
        attracts: bool,
        /// In the tangent.
        friction: Option<Friction>,
    },
}

/// A disc.
#[derive(Clone, Copy, Debug)]
pub struct Disc {
    /// m.
    pub radius: f64,
    /// kg.
    pub mass: f64,
    /// Where it starts, m.
    pub x: DVec2,
    /// How it starts, m/s.
    pub v: DVec2,
}

/// A half-plane that grains stand on.
#[derive(Clone, Copy, Debug)]
pub struct Floor {
    /// A point of it, m.
    pub point: DVec2,
    /// Towards the grains, of length 1.
    pub normal: DVec2,
}

/// Discs, floors, weight and a law. Discs start without spin.
#[derive(Clone, Debug)]
pub struct System {
    /// m/s^2.
    pub gravity: DVec2,
    /// Between all.
    pub law: Law,
    /// What moves.
    pub discs: Vec<Disc>,
    /// What does not.
    pub floors: Vec<Floor>,
}

/// Moment of inertia over m R^2: of discs.
pub const INERTIA: f64 = 0.5;

/// How the discs lie and move.
#[derive(Clone, Debug, PartialEq)]
pub struct State {
    /// m.
    pub x: Vec<DVec2>,
    /// m/s.
    pub v: Vec<DVec2>,
    /// rad/s.
    pub w: Vec<f64>,
}

impl System {
    /// The state at time 0.
    #[must_use]
    pub fn start(&self) -> State {
        State {
            x: self.discs.iter().map(|disc| disc.x).collect(),
            v: self.discs.iter().map(|disc| disc.v).collect(),
            w: vec![0.0; self.discs.len()],
        }
    }

    /// Kinetic, gravitational and (of normal springs) elastic energy, J.
    #[must_use]
    pub fn energy(&self, state: &State) -> f64 {
        let (Law::Full { k, .. } | Law::Linear { k, .. }) = self.law;
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
