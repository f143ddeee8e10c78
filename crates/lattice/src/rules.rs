//! The six parameters of the automaton, all of them probabilities, and the distributions for drawing from them.

use bevy_ecs::prelude::*;
use serde::{Deserialize, Serialize};

use crate::draws::{Chance, Geometric};
use siloflow_dem::values::{Positive, Share};

/// The keys of a scene's `method: LatticeGas(...)`.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Rules {
    /// Distance between nearest neighbours, m.
    pub spacing: Positive,
    /// Stopping in collisions: at least n particles of a site stop with probability p^n.
    pub p: Share,
    /// Momentum loss in collisions: at least l particles are left out of the momentum with probability q^l.
    pub q: Share,
    /// Wall friction: probability that a mover stops when a rough wall blocks it.
    pub b: Share,
    /// Internal friction: probability that the momentum of a collision is replaced by the sum of random, nearly
    /// horizontal directions.
    pub k: Share,
    /// Gravity: probability that one downward velocity is added to the momentum of a collision or of a lone mover.
    pub g: Share,
    /// Gravity of particles at rest: probability that a particle at rest tries to move down.
    pub h: Share,
    /// Effect of rough walls. Default `Stop`.
    #[serde(default)]
    pub walls: Walls,
}

/// Effect of walls if b > 0 (rough walls).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
pub enum Walls {
    /// Walls stop each mover that they block with probability b (the paper's second method).
    #[default]
    Stop,
    /// Walls reflect movers into random directions (the paper's first method). Any b > 0 has this effect.
    Scatter,
}

/// The distributions that the automaton draws from.
#[derive(Resource, Clone, Copy, Debug)]
pub struct Odds {
    /// Number of particles that stop in a collision (p).
    pub stop: Geometric,
    /// Whether p = 0.
    pub is_elastic: bool,
    /// Number of particles that are left out of the momentum of a collision (q).
    pub forget: Geometric,
    /// Wall friction (b).
    pub stop_at_wall: Chance,
    /// Internal friction (k).
    pub level: Chance,
    /// Gravity of movers (g).
    pub fall: Chance,
    /// Gravity of particles at rest (h).
    pub trickle: Chance,
    /// Seed of all random numbers.
    pub seed: u64,
}

impl Odds {
    /// Creates the distributions for these parameters.
    #[must_use]
    pub fn new(rules: &Rules, seed: u64) -> Self {
        Self {
            stop: Geometric::new(rules.p.get()),
            is_elastic: rules.p.get() == 0.0,
            forget: Geometric::new(rules.q.get()),
            stop_at_wall: Chance::of(rules.b.get()),
            level: Chance::of(rules.k.get()),
            fall: Chance::of(rules.g.get()),
            trickle: Chance::of(rules.h.get()),
            seed,
        }
    }
}
