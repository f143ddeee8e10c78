//! Facts of a scene that pages and pictures show, as plain values. The app makes them from a scene file; nothing here knows scenes.

use std::path::Path;

use glam::DVec2;

use siloflow_text::fault::Warning;

/// Reads the facts of the scene at a path, under the name of its run. An error says why the scene cannot be loaded.
pub type ReadFacts<'a> = &'a dyn Fn(&Path, &str) -> Result<SceneFacts, String>;

/// Reads the outline of the scene at a path; it is empty if the scene cannot be loaded.
pub type ReadOutline<'a> = &'a dyn Fn(&Path) -> Outline;

/// Facts of a scene.
#[derive(Clone, Debug, Default)]
pub struct SceneFacts {
    /// Title; empty if the scene has none.
    pub title: String,
    /// Seed of the random numbers.
    pub seed: u64,
    /// Whether the scene is one of the lattice gas.
    pub is_lattice: bool,
    /// Most bytes of a frame of the scene.
    pub most_bytes: u64,
    /// Names of the wall surfaces, in the order of their numbers.
    pub wall_names: Vec<Option<String>>,
    /// Estimates of the step; `None` if they do not apply.
    pub step: Option<StepEstimates>,
    /// Warnings of the checks before a run.
    pub warnings: Vec<Warning>,
}

/// Estimates of the step and its error. Times are in s, speeds in m/s.
#[derive(Clone, Debug)]
pub struct StepEstimates {
    /// The step.
    pub dt: f64,
    /// Duration of the shortest contact.
    pub contact_duration: f64,
    /// Largest stable step of one contact.
    pub pair_limit: f64,
    /// Largest stable step in a dense bed.
    pub bed_limit: f64,
    /// Expected rms error of the speed after an impact, over that speed; `None` if it is not known.
    pub expected_error: Option<f64>,
    /// Restitution of an impact.
    pub restitution: f64,
    /// Speed of the fastest impact.
    pub impact_speed: f64,
    /// Overlap expected from that impact, over the radius.
    pub impact_overlap: f64,
    /// Overlap expected from the weight of the bed, over the radius.
    pub static_overlap: f64,
    /// Integration scheme.
    pub scheme: String,
    /// Why the program has chosen this step; `None` if the scene gives it.
    pub reason: Option<String>,
}

/// The outline of a silo in a plane, m.
#[derive(Clone, Debug, Default)]
pub struct Outline {
    /// Wall grains.
    pub discs: Vec<Disc>,
    /// Edges, by their ends.
    pub lines: Vec<(DVec2, DVec2)>,
}

/// A disc, m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Disc {
    /// Centre.
    pub centre: DVec2,
    /// Radius.
    pub radius: f64,
}
