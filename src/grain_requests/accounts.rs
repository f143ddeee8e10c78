//! Accounts of requests, by reason: numbers of grains, mass, momentum and energy.

use std::collections::BTreeMap;

use bevy_ecs::prelude::*;
use serde::{Deserialize, Serialize};

use siloflow_dem::space::{Dimension, Plane, Solid, Space};

/// The account of one reason: mass, momentum and energy of the grains that came less those of the grains that went.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[serde(bound = "")]
pub(super) struct Account<V: Space> {
    /// Grains that came.
    pub(super) made: u32,
    /// Grains that went.
    pub(super) removed: u32,
    /// Grains that changed their size, also by a merger.
    pub(super) resized: u32,
    /// Requests that were not carried out, because another one or the outlet had taken the grain.
    pub(super) dropped: u32,
    /// Mass, kg.
    pub(super) mass: f64,
    /// Momentum, kg m/s.
    pub(super) momentum: V,
    /// Energy, J.
    pub(super) energy: f64,
    /// The part of the energy that is elastic, J.
    pub(super) elastic: f64,
}

impl<V: Space> Default for Account<V> {
    fn default() -> Self {
        Self { made: 0, removed: 0, resized: 0, dropped: 0, mass: 0.0, momentum: V::ZERO, energy: 0.0, elastic: 0.0 }
    }
}

/// The accounts, by reason.
#[derive(Resource, Debug, Deserialize, Serialize)]
#[serde(bound = "")]
pub(super) struct Accounts<V: Space>(BTreeMap<String, Account<V>>);

impl<V: Space> Default for Accounts<V> {
    fn default() -> Self {
        Self(BTreeMap::new())
    }
}

impl<V: Space> Accounts<V> {
    /// The account of a reason.
    pub(super) fn of(&mut self, reason: &str) -> &mut Account<V> {
        self.0.entry(reason.to_owned()).or_default()
    }
}

/// Figures of one reason, for the summary. Arrivals count as positive, departures as negative.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ReasonFigures {
    /// Grains that requests have made.
    pub made: u32,
    /// Grains that requests have removed.
    pub removed: u32,
    /// Grains whose radius or mass requests have changed.
    pub resized: u32,
    /// Requests that were not carried out, because the grain was gone.
    pub dropped: u32,
    /// Mass, kg.
    pub mass_kg: f64,
    /// Momentum, kg m/s.
    pub momentum_kg_m_per_s: Vec<f64>,
    /// Energy, J.
    pub energy_j: f64,
    /// The part of the energy that is elastic, J.
    pub elastic_j: f64,
}

/// Figures of requests, by reason.
pub type RequestFigures = BTreeMap<String, ReasonFigures>;

/// The figures of all requests of a run; empty without any.
#[must_use]
pub fn figures(world: &World) -> RequestFigures {
    fn of<V: Space>(world: &World) -> RequestFigures {
        let accounts = world.get_resource::<Accounts<V>>();
        let figures = |account: &Account<V>| ReasonFigures {
            made: account.made,
            removed: account.removed,
            resized: account.resized,
            dropped: account.dropped,
            mass_kg: account.mass,
            momentum_kg_m_per_s: account.momentum.components(),
            energy_j: account.energy,
            elastic_j: account.elastic,
        };
        accounts.into_iter().flat_map(|all| &all.0).map(|(reason, one)| (reason.clone(), figures(one))).collect()
    }
    match Dimension::of_world(world) {
        Dimension::Plane => of::<Plane>(world),
        Dimension::Solid => of::<Solid>(world),
    }
}
