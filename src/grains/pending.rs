//! Grains that are still to be released.

use bevy_ecs::prelude::*;
use serde::{Deserialize, Serialize};

/// Number of grains still to be released by any source. The rest detector and the end of a run depend on it.
#[derive(Resource, Default, Debug, Deserialize, Serialize)]
pub struct Pending(pub u32);

/// Returns the number of grains that the spawner of a world still has to release.
#[derive(Resource)]
pub(super) struct LeftOfSpawner(pub(super) fn(&World) -> u32);
