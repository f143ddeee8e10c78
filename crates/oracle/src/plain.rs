//! Forces of a contact under plain velocity Verlet: from the positions at the end and the velocities in the middle of a
//! step.
//!
//! * Assignment: k delta n - b v. Other laws: F_n = max(spring - c v_n, floor) with v_n = v.n.
//! * Sliding velocity v_t = v - v_n n - (l_i w_i + l_j w_j) x n. The lever is l = R, or R_i - delta R_j/(R_i + R_j) to
//!   the contact point. On a wall surface it is R - delta, and the wall's own lever is 0.
//! * Slider: S <- S + v dt, projected into the tangent plane; F = -k S - c v. Beyond mu |F_n| the force is cut and S =
//!   -(F + c v)/k. A dashpot has no S. Where k varies (Mindlin), a stiffening spring keeps its force, S <- S
//!   k_before/k; a softening spring keeps its displacement.
//! * Rolling resistance: the same slider with v_r = R* (w_i - w_j) x n. The torque is R* n x F_r on i and the opposite
//!   on j.
//! * Torques of friction: -l n x F_t on each.

use crate::law::{Normal, Reduced, Rolling, RollingKind, Terms};
use crate::vector::V;

/// Two particles in contact, seen from i. j may be a wall surface, which has no curvature.
#[derive(Clone, Copy, Debug)]
pub struct PairState {
    /// Unit vector from j to i.
    pub normal: V,
    /// Overlap, m; negative across a gap.
    pub overlap: f64,
    /// v_i - v_j, m/s.
    pub velocity: V,
    pub reduced: Reduced,
    pub radii: [f64; 2],
    pub spins: [V; 2],
}

/// Memory of a contact: the displacements of its two springs, m, and the tangential stiffness, N/m, if that varies.
#[derive(Clone, Copy, Debug, Default)]
pub struct Memory {
    pub spring: V,
    pub rolling: V,
    /// Twisting spring, along x of a plane with the normal y, m.
    pub twist: V,
    pub stiffness: f64,
}

/// Force on i (the opposite acts on j) and torques on i and j.
#[derive(Clone, Copy, Debug)]
pub struct Action {
    pub force: V,
    pub torques: [V; 2],
}

impl PairState {
    /// l_i and l_j, m.
    pub fn levers(&self, at_point: bool) -> [f64; 2] {
        let [i, j] = self.radii;
        match (at_point, j.is_infinite()) {
            (false, false) => [i, j],
            (false, true) => [i, 0.0],
            (true, true) => [i - self.overlap, 0.0],
            (true, false) => [i - self.overlap * j / (i + j), j - self.overlap * i / (i + j)],
        }
    }

    /// Returns v_t for a relative velocity and spins.
    pub fn sliding(&self, velocity: V, spins: [V; 2], levers: [f64; 2]) -> V {
        velocity.across(self.normal) - (spins[0] * levers[0] + spins[1] * levers[1]).cross(self.normal)
    }

    /// Returns v_r for spins.
    pub fn rolling(&self, spins: [V; 2]) -> V {
        (spins[0] - spins[1]).cross(self.normal) * self.reduced.radius
    }

    /// Returns R* (w_i - w_j).n for spins, as a vector along x.
    pub fn twisting(&self, spins: [V; 2]) -> V {
        V([(spins[0] - spins[1]).dot(self.normal) * self.reduced.radius, 0.0, 0.0])
    }

    /// Adds the torques of a twisting force along x, N.
    pub fn twist(&self, mut action: Action, force: V) -> Action {
        let couple = self.normal * (self.reduced.radius * force.0[0]);
        action.torques[0] += couple;
        action.torques[1] += -couple;
        action
    }

    /// Combines a normal force with all pulls (N), friction and rolling resistance into force and torques.
    pub fn act(&self, total: f64, friction: V, levers: [f64; 2], rolling: V) -> Action {
        let moment = self.normal.cross(friction);
        let couple = (self.normal * self.reduced.radius).cross(rolling);
        let torques = [moment * -levers[0] + couple, moment * -levers[1] - couple];
        Action { force: self.normal * total + friction, torques }
    }
}

/// The times of springs.
#[derive(Clone, Copy, Debug)]
pub struct Times {
    /// Time by which springs advance, s.
    pub dt: f64,
    /// Time by which they are stored ahead of the evaluation, s.
    pub lead: f64,
    /// Whether displacement that a stiffening spring gathers counts with the mean stiffness of the step.
    pub is_centred: bool,
}

/// Advances a slider by `dt` with the second velocity and returns its force, with the dashpot at the first. The spring is stored `lead` (s)
/// ahead of the evaluation.
fn slide(spring: &mut V, [k, c, cap]: [f64; 3], [velocity, gathered]: [V; 2], normal: V, [dt, lead]: [f64; 2]) -> V {
    let moved = (*spring + gathered * dt).across(normal);
    let stretched = moved - velocity * lead;
    let (force, is_beyond) = (stretched * -k - velocity * c).cut(cap);
    *spring = if is_beyond { (force + velocity * c) * (-1.0 / k) + velocity * lead } else { moved };
    force
}

/// Returns the action of a contact and advances its memory, with the velocities of `gathering`.
pub fn plain(
    terms: &Terms,
    [pair_state, gathering]: [&PairState; 2],
    memory: &mut Memory,
    Times { dt, lead, is_centred }: Times,
) -> Action {
    let PairState { normal, overlap, velocity, reduced, spins, .. } = *pair_state;
    let spring = terms.spring(reduced, overlap);
    if let Normal::Assignment { b, .. } = terms.law.normal {
        return Action { force: normal * spring - velocity * b, torques: [V::default(); 2] };
    }
    let drag = terms.drag(reduced, overlap);
    let total = (spring - drag * velocity.dot(normal)).max(terms.floor());
    let levers = pair_state.levers(terms.law.at_point);
    let mut friction = V::default();
    let mut stiffnesses = [0.0; 2];
    if let Some([stiffness, damping, mu]) = terms.tangential(reduced, overlap, drag) {
        let sliding = pair_state.sliding(velocity, spins, levers);
        let gathered = pair_state.sliding(gathering.velocity, gathering.spins, levers);
        let mut time = dt;
        stiffnesses = [if terms.stiffness_varies() { memory.stiffness } else { stiffness }, stiffness];
        if terms.stiffness_varies() {
            if is_centred {
                time *= mean_of(terms, memory.stiffness, stiffness);
            }
            // Only the stretch at the evaluation follows the stiffness, not the part that the spring is ahead.
            memory.spring = memory.spring - sliding * lead;
            adapt(memory, stiffness);
            memory.spring += sliding * lead;
        }
        friction = if terms.has_spring() {
            let numbers = [stiffness, damping, mu * total.abs()];
            slide(&mut memory.spring, numbers, [sliding, gathered], normal, [time, lead])
        } else {
            (sliding * -damping).cut(mu * total.abs()).0
        };
    }
    let mut rolling = V::default();
    if let Some(Rolling { mu, kind, .. }) = terms.law.rolling {
        let velocity = pair_state.rolling(spins);
        let [k, c] = terms.rolling(reduced, stiffnesses[1], dt);
        let before = terms.rolling(reduced, stiffnesses[0], dt)[0];
        let cap = mu * total.abs();
        if kind == RollingKind::Torque {
            // At rest, and in an evaluation without a step, the drag has no bound.
            let force = if dt > 0.0 { velocity * -c } else { velocity * -1e200 };
            let size = force.length();
            rolling = if size > cap { velocity.unit() * -cap } else { force };
        } else {
            let ahead = velocity * lead;
            let time = if is_centred { dt * mean_of(terms, before, k) } else { dt };
            let velocities = [velocity, pair_state.rolling(gathering.spins)];
            let mut stretch = memory.rolling - ahead;
            if k > before {
                stretch = stretch * (before / k);
            }
            memory.rolling = stretch + ahead;
            rolling = slide(&mut memory.rolling, [k, c, cap], velocities, normal, [time, lead]);
        }
    }
    let action = pair_state.act(total - terms.pull(reduced, overlap, 1.0), friction, levers, rolling);
    let Some(Rolling { k, damping, mu, .. }) = terms.law.twisting else { return action };
    let numbers = [k, damping.drag(reduced.mass, 0.0), mu * total.abs()];
    let velocities = [spins, gathering.spins].map(|spins| pair_state.twisting(spins));
    let force = slide(&mut memory.twist, numbers, velocities, UP, [dt, lead]);
    pair_state.twist(action, force)
}

/// The normal of the plane in which a twisting spring lies along x.
pub const UP: V = V([0.0, 1.0, 0.0]);

/// Adapts a spring to a changed stiffness, N/m.
pub fn adapt(memory: &mut Memory, stiffness: f64) {
    if stiffness > memory.stiffness {
        memory.spring = memory.spring * (memory.stiffness / stiffness);
    }
    memory.stiffness = stiffness;
}

/// Like `mean_stiffness`; a contact that jumps to its stiffness has it in the whole first step.
pub fn mean_of(terms: &Terms, before: f64, now: f64) -> f64 {
    if terms.reaches() && before == 0.0 { 1.0 } else { mean_stiffness(before, now) }
}

/// Returns the mean stiffness of a step over the stiffness at its end. The overlap grows linearly, the stiffness with its
/// root.
fn mean_stiffness(before: f64, now: f64) -> f64 {
    if before >= now {
        return 1.0;
    }
    let part = before / now;
    (2.0 / 3.0) * (1.0 + part + part * part) / (1.0 + part)
}
