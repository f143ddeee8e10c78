//! Whether the second kick of the last step is still to be applied ([`deferred_kick`](super::deferred_kick)).

use bevy_ecs::prelude::*;

/// State of the second kick of the last step.
#[derive(Resource, Default)]
pub(crate) struct PendingKick {
    /// Whether the drift applies a pending kick.
    pub(crate) may_be_deferred: bool,
    /// Whether the second kick of the last complete step is still to be applied.
    pub(crate) is_pending: bool,
}
