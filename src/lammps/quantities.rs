//! Quantities of a scene that several parts of the script need.

use crate::grains::file::GrainRow;
use crate::scene::loaded::Loaded;
use siloflow_dem::space::{Dimension, Plane, Solid};

/// The axis of heights: the last one.
pub(super) fn up(loaded: &Loaded) -> usize {
    loaded.scene.space.count() - 1
}

/// Number of steps of a time, at least 1.
pub(super) fn steps(time: f64, dt: f64) -> u64 {
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a number of steps; saturates")]
    let steps = (time / dt).round().max(1.0) as u64;
    steps
}

/// Returns the first step that has reached a time (s), by the rule of [`Clock::has_reached`](siloflow_dem::step::Clock::has_reached).
pub(super) fn first_step(time: f64, dt: f64) -> f64 {
    (time / dt - 1e-3).ceil().max(0.0)
}

/// All grains of a scene: those of the start, then those of the spawner in the order of their release.
pub(super) fn all_grains(loaded: &Loaded) -> impl Iterator<Item = GrainRow> {
    loaded.grains.iter().copied().chain(released(loaded))
}

/// The grains of the spawner in the order of their release.
pub(super) fn released(loaded: &Loaded) -> Vec<GrainRow> {
    let (Some(spawner), Some(mass)) = (&loaded.scene.spawner, loaded.scene.mass) else { return Vec::new() };
    let seed = loaded.scene.seed;
    let first = loaded.first_free_id();
    match loaded.scene.space {
        Dimension::Plane => spawner.grains::<Plane>(mass, seed, first),
        Dimension::Solid => spawner.grains::<Solid>(mass, seed, first),
    }
}
