//! The scene key `checkpoint`, and the figures of checkpoints in the summary.

use std::num::NonZeroU8;

use bevy_ecs::prelude::*;
use serde::{Deserialize, Serialize};

use crate::values::NonNegative;

/// The scene key `checkpoint`.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct CheckpointConfig {
    /// Wall-clock time between checkpoints, minutes. Default 10.
    pub every: NonNegative,
    /// Number of checkpoints that are kept. Default 2.
    pub keep: NonZeroU8,
}

impl Default for CheckpointConfig {
    fn default() -> Self {
        let every = NonNegative::try_from(10.0).expect("not negative");
        Self { every, keep: NonZeroU8::new(2).expect("not zero") }
    }
}

/// The default of the scene key.
#[must_use]
pub fn default_checkpoint() -> Option<CheckpointConfig> {
    Some(CheckpointConfig::default())
}

/// Number and size of the checkpoints of a run, for the summary.
#[derive(Resource, Clone, Copy, Debug, Default, Serialize)]
pub struct CheckpointFigures {
    /// Number of checkpoints that this process wrote during the run, without the final one.
    pub written: u32,
    /// Wall-clock time that they took, s.
    pub wall_s: f64,
    /// Size of the last one, bytes.
    pub last_bytes: u64,
}
