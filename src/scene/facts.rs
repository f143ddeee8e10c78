//! Facts of a scene for reports and comparisons.

use std::path::Path;

use crate::lattice_silo;
use crate::scene::check::automatic::{automatic, expected_error};
use crate::scene::check::{self, Estimates};
use crate::scene::extent::most_bytes;
use crate::scene::loaded::{AnyScene, Loaded};
use crate::scene::{TimeStep, load};
use siloflow_dem::walls::config::Wall;
use siloflow_results::scene_facts::{Disc, Outline, SceneFacts, StepEstimates};

/// Reads the facts of the scene at `path`, under the name of its run.
///
/// # Errors
/// Why the scene cannot be loaded.
pub fn read(path: &Path, name: &str) -> Result<SceneFacts, String> {
    load::named(path, name).map(|scene| of(&scene)).map_err(|fault| fault.to_string())
}

fn of(scene: &AnyScene) -> SceneFacts {
    let most_bytes = most_bytes(scene);
    match scene {
        AnyScene::Grains(loaded) => SceneFacts {
            title: loaded.scene.title.clone(),
            seed: loaded.scene.seed,
            is_lattice: false,
            most_bytes,
            // Discs have no number.
            wall_names: loaded
                .scene
                .walls
                .iter()
                .filter(|wall| wall.is_surface())
                .map(|wall| Wall::name(wall).map(str::to_owned))
                .collect(),
            step: step(loaded),
            warnings: check::warnings(loaded),
        },
        AnyScene::Lattice(loaded) => SceneFacts {
            title: loaded.scene.title.clone(),
            seed: loaded.scene.seed,
            is_lattice: true,
            most_bytes,
            warnings: lattice_silo::check::warnings(loaded),
            ..SceneFacts::default()
        },
    }
}

fn step(loaded: &Loaded) -> Option<StepEstimates> {
    let estimates = Estimates::of(loaded)?;
    Some(StepEstimates {
        dt: estimates.dt,
        contact_duration: estimates.contact_duration,
        pair_limit: estimates.pair_limit,
        bed_limit: estimates.bed_limit,
        expected_error: expected_error(&estimates),
        restitution: estimates.restitution,
        impact_speed: estimates.impact_speed,
        impact_overlap: estimates.impact_overlap,
        static_overlap: estimates.static_overlap,
        scheme: format!("{:?}", estimates.scheme),
        reason: match loaded.scene.step {
            TimeStep::Auto { error } => Some(automatic(&estimates, error.get()).reason),
            TimeStep::Fixed(_) => None,
        },
    })
}

/// Reads the outline of the scene at `path`. If the scene cannot be loaded, there is none.
#[must_use]
pub fn read_outline(path: &Path) -> Outline {
    match load::any(path, &[]) {
        Ok(AnyScene::Grains(loaded)) => Outline {
            discs: loaded.wall_discs().iter().map(|disc| Disc { centre: disc.centre, radius: disc.radius }).collect(),
            lines: Vec::new(),
        },
        Ok(AnyScene::Lattice(loaded)) => Outline { discs: Vec::new(), lines: loaded.sites.lines().to_vec() },
        Err(_) => Outline::default(),
    }
}
