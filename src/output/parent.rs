//! The parent of a run: the run from whose state it started.

use bevy_app::{App, Plugin};
use bevy_ecs::prelude::*;
use serde::{Deserialize, Serialize};

use siloflow_dem::persist::PersistApp as _;

/// The run from whose state this run started.
#[derive(Resource, Clone, Debug, PartialEq, Deserialize, Serialize)]
pub struct Parent {
    /// Its directory, absolute.
    pub run: String,
    /// Name of its scene.
    pub scene: String,
    /// Number of its completed steps.
    pub steps: u64,
    /// Its simulated time, s.
    pub time_s: f64,
    /// Hash of its grains, as 16 hexadecimal digits.
    pub state_hash: String,
}

impl Parent {
    /// Returns the parent in words, for the scene's text.
    #[must_use]
    pub fn note(&self) -> String {
        let Self { run, scene, steps, time_s, state_hash } = self;
        let run: String = run.chars().map(|c| if c.is_control() { '?' } else { c }).collect();
        format!(
            "The grains and contacts at the start are those of {run}: scene {scene}, step {steps}, t = {time_s} s, state \
             hash {state_hash}."
        )
    }
}

/// Records the parent of a run, for its summary.
pub struct ParentPlugin(pub Option<Parent>);

impl Plugin for ParentPlugin {
    fn build(&self, app: &mut App) {
        app.persist_sound::<Parent>();
        if let Some(parent) = &self.0 {
            app.insert_resource(parent.clone());
        }
    }
}
