//! The ids of grains that enter during a run by feeds or requests of behaviours.

use bevy_ecs::prelude::*;
use serde::{Deserialize, Serialize};

use siloflow_dem::particle::GrainId;

/// The lowest id that no grain has, no grain had, and the spawner does not need.
#[derive(Resource, Debug, Deserialize, Serialize)]
pub struct FreeId(pub u32);

impl FreeId {
    /// Returns a new id; `None` if all are used.
    pub fn take(&mut self) -> Option<GrainId> {
        let id = GrainId::grain(self.0)?;
        self.0 += 1;
        Some(id)
    }
}
