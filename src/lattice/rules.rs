//! The six parameters of the automaton, all probabilities, and what follows from them.

use bevy_ecs::prelude::*;
use serde::{Deserialize, Serialize};

use crate::lattice::draws::{Chance, Geometric};
use crate::values::{Positive, Share};

/// The keys of a scene's `method: LatticeGas(...)`.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Rules {
    /// Distance of nearest neighbours, m.
    pub spacing: Positive,
    /// Collision: n of the particles of a site stop with a probability of p^n or more.
    pub p: Share,
    /// Collision: l particles do not count in the momentum with a probability of q^l or more.
    pub q: Share,
    /// Wall friction.
    pub b: Share,
    /// Internal friction: the momentum becomes that of random, nearly horizontal directions.
    pub k: Share,
    /// Gravity: a collision gains one downward velocity.
    pub g: Share,
    /// Gravity of particles at rest: one moves down.
    pub h: Share,
    /// What rough walls do. Default `Stop`.
    #[serde(default)]
    pub walls: Walls,
}

/// What rough walls, those with b > 0, do.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
pub enum Walls {
    /// They stop each particle with probability b (the paper's second method).
    #[default]
    Stop,
    /// They reflect into random directions (the paper's first method), whatever b is.
    Scatter,
}

/// The rules, ready to be asked.
#[derive(Resource, Clone, Copy, Debug)]
pub struct Odds {
    /// Of the number of particles that stop.
    pub stop: Geometric,
    /// Whether collisions are elastic: p = 0.
    pub is_elastic: bool,
    /// Of the number that do not count in the momentum.
    pub forget: Geometric,
    /// b.
    pub rub: Chance,
    /// k.
    pub level: Chance,
    /// g.
    pub fall: Chance,
    /// h.
    pub trickle: Chance,
    /// Seed of all draws.
    pub seed: u64,
}

impl Odds {
    /// Those of some rules.
    #[must_use]
    pub fn new(rules: &Rules, seed: u64) -> Self {
        Self {
            stop: Geometric::new(rules.p.get()),
            is_elastic: rules.p.get() == 0.0,
            forget: Geometric::new(rules.q.get()),
            rub: Chance::of(rules.b.get()),
            level: Chance::of(rules.k.get()),
            fall: Chance::of(rules.g.get()),
            trickle: Chance::of(rules.h.get()),
            seed,
        }
    }
}
