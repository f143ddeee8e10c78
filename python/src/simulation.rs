//! A simulation that Python steps.

use std::marker::PhantomData;
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use pyo3::exceptions::{PyOSError, PyRuntimeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use siloflow::behaviour::Registry;
use siloflow::dem::outcome::End;
use siloflow::dem::space::{Dimension, Plane, Solid};
use siloflow::dem::step::Clock;
use siloflow::ledger::Ledger;
use siloflow::measure::totals;
use siloflow::output::summary::{Cost, Summary};
use siloflow::output::{pictures, state_hash};
use siloflow::prelude::App;
use siloflow::scene::load;
use siloflow::scene::loaded::Loaded;
use siloflow::simulation::Simulation as Engine;
use siloflow::simulation::assign::Assigned;
use siloflow::simulation::push::PushPlugin;
use siloflow::text::fault::Fault;

use crate::columns::{self, read};
use crate::{Column, SceneError};

/// Time between two looks at signals, s: between a quarter of it and twice of it.
const SLICE: Duration = Duration::from_millis(50);

/// A simulation of a scene with grains.
#[pyclass]
pub struct Simulation {
    engine: Engine,
    loaded: Loaded,
    end: Option<End>,
}

/// Calls `$run` with `V` as the space of the scene.
macro_rules! in_its_space {
    ($this:expr, $space:ident => $run:expr) => {
        match $this.loaded.scene.space {
            Dimension::Plane => {
                type $space = Plane;
                $run
            }
            Dimension::Solid => {
                type $space = Solid;
                $run
            }
        }
    };
}

#[pymethods]
impl Simulation {
    /// Loads the scene at `path`, or `text` in its directory, and builds its simulation; at the state of a file if one is named.
    #[new]
    #[pyo3(signature = (path, text, settings, threads, state))]
    fn new(
        py: Python<'_>,
        path: PathBuf,
        text: Option<String>,
        settings: Vec<(String, String)>,
        threads: NonZeroUsize,
        state: Option<PathBuf>,
    ) -> PyResult<Self> {
        py.detach(|| Self::build(&path, text, &settings, threads, state.as_deref()))
            .map_err(|fault| refusal(&path, &fault))
    }

    /// Does this many steps, or fewer if the run ends.
    fn advance(&mut self, py: Python<'_>, steps: u64) -> PyResult<()> {
        let target = self.clock().steps.saturating_add(steps);
        self.run_to(py, target)
    }

    /// Steps until the clock shows a time, s, or the run ends.
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a time before zero does no step")]
    fn advance_to(&mut self, py: Python<'_>, time: f64) -> PyResult<()> {
        // A time counts as reached within a thousandth of a step, as in the engine.
        let steps = (time / self.clock().dt - 1e-3).ceil();
        self.run_to(py, steps as u64)
    }

    /// The number of completed steps at which the clock shows a time, s.
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a time before zero does no step")]
    fn steps_at(&self, time: f64) -> u64 {
        (time / self.clock().dt - 1e-3).ceil() as u64
    }

    /// Why the run has ended, as `status` in `summary.json`; `None` while it goes on.
    fn status(&self) -> Option<&'static str> {
        self.end.as_ref().map(End::word)
    }

    /// The reason of a failure.
    fn failure(&self) -> Option<String> {
        match &self.end {
            Some(End::Failed(failure)) => Some(failure.to_string()),
            _ => None,
        }
    }

    /// Simulated time, s.
    fn time(&self) -> f64 {
        self.clock().time()
    }

    /// Number of completed steps.
    fn steps(&self) -> u64 {
        self.clock().steps
    }

    /// The time step, s.
    fn dt(&self) -> f64 {
        self.clock().dt
    }

    /// Number of components of a vector.
    fn dimension(&self) -> usize {
        self.loaded.scene.space.count()
    }

    /// The scene with all settings.
    fn scene(&self) -> &str {
        &self.loaded.source.text
    }

    /// Grains that were released, are inside, are out, and are lost.
    fn counts(&self) -> [u32; 4] {
        let ledger = self.engine.world().resource::<Ledger>();
        [ledger.released, ledger.inside(), ledger.out(), ledger.lost()]
    }

    /// Totals over the grains, SI, as JSON.
    fn totals(&self) -> PyResult<String> {
        as_json(&totals::of_world(self.engine.world()))
    }

    /// The content of `summary.json` at this moment.
    fn figures(&mut self) -> PyResult<String> {
        let end = self.end.clone().unwrap_or(End::Interrupted);
        as_json(&Summary::of_grains(self.engine.world_mut(), &self.loaded, &end, Cost::default(), None))
    }

    /// Hash of the state of the grains, as in `summary.json`.
    fn state_hash(&mut self) -> String {
        format!("{:016x}", state_hash::of_world(self.engine.world_mut()))
    }

    /// Names of the columns of grains in this scene.
    fn column_names(&self) -> Vec<&'static str> {
        let world = self.engine.world();
        let has = |name: &&str| in_its_space!(self, V => columns::has_column::<V>(world.resource(), name));
        columns::GRAINS.into_iter().filter(has).collect()
    }

    /// A column of the grains that are present, in the order of their ids, SI.
    fn column<'py>(&self, py: Python<'py>, name: &str) -> PyResult<Column<'py>> {
        in_its_space!(self, V => columns::of_grains::<V>(py, self.engine.world(), name))
    }

    /// Columns of the contacts, SI.
    fn contacts<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        in_its_space!(self, V => columns::of_contacts::<V>(py, self.engine.world()))
    }

    /// Columns of the wall surfaces, SI.
    fn walls<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        in_its_space!(self, V => columns::of_walls::<V>(py, self.engine.world(), &self.loaded))
    }

    /// One sample of an entry of the scene's `fields`, SI.
    fn field<'py>(&self, py: Python<'py>, which: usize) -> PyResult<Bound<'py, PyDict>> {
        in_its_space!(self, V => columns::of_field::<V>(py, self.engine.world(), &self.loaded, which))
    }

    /// Gives all grains other numbers, in the order of their ids: `position`, `velocity` or `spin` as bytes of doubles.
    fn assign(&mut self, name: &str, bytes: &[u8]) -> PyResult<()> {
        let done = in_its_space!(self, V => match name {
            "position" => self.engine.assign::<V>(Assigned::Positions(&read(bytes))),
            "velocity" => self.engine.assign::<V>(Assigned::Velocities(&read(bytes))),
            _ => self.engine.assign::<V>(Assigned::Spins(&read(bytes))),
        });
        done.map_err(PyValueError::new_err)
    }

    /// Adds forces (N, as bytes of doubles) to all grains, in the order of their ids, until `stop_pushing`.
    fn push(&mut self, bytes: &[u8]) -> PyResult<()> {
        let done = in_its_space!(self, V => {
            let ids = self.engine.grain_ids::<V>();
            self.engine.push::<V>(ids.into_iter().zip(read(bytes)))
        });
        done.map_err(PyValueError::new_err)
    }

    /// Takes all forces of `push` back.
    fn stop_pushing(&mut self) {
        in_its_space!(self, V => self.engine.stop_pushing::<V>());
    }

    /// The grains as they are, as SVG.
    fn picture(&mut self) -> PyResult<String> {
        let drawn = in_its_space!(self, V => pictures::of_world::<V>(&self.loaded, self.engine.world_mut()));
        drawn.map(|picture| picture.to_svg()).map_err(|fault| SceneError::new_err(fault.to_string()))
    }

    /// Writes the whole state into a file.
    fn save(&mut self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        let Self { engine, loaded, .. } = self;
        py.detach(|| engine.save_to(&path, &loaded.source.name))
            .map_err(|error| PyOSError::new_err(format!("could not write {}: {error}", path.display())))
    }
}

impl Simulation {
    fn build(
        path: &Path,
        text: Option<String>,
        settings: &[(String, String)],
        threads: NonZeroUsize,
        state: Option<&Path>,
    ) -> Result<Self, Fault> {
        let loaded = match text {
            Some(text) => {
                let name = path.file_stem().map_or("scene".into(), |stem| stem.to_string_lossy());
                let directory = path.parent().unwrap_or(Path::new(""));
                load::from_text(&path.to_string_lossy(), &name, directory, text, settings)?
            }
            None => load::load(path, settings)?,
        };
        let dimension = loaded.scene.space;
        let push = move |app: &mut App| {
            match dimension {
                Dimension::Plane => app.add_plugins(PushPlugin::<Plane>(PhantomData)),
                Dimension::Solid => app.add_plugins(PushPlugin::<Solid>(PhantomData)),
            };
        };
        let registry = Registry::default();
        let mut engine = match state {
            Some(state) => Engine::continued(&loaded, &registry, threads, state, push)?,
            None => Engine::with_plugins(&loaded, &registry, threads, push)?,
        };
        // Step zero places the grains of the start and evaluates their forces.
        let end = if state.is_none() { engine.step() } else { None };
        Ok(Self { engine, loaded, end })
    }

    /// Steps in slices of about [`SLICE`] without Python's lock, and sees to signals in between.
    fn run_to(&mut self, py: Python<'_>, target: u64) -> PyResult<()> {
        let mut steps = 1;
        while self.end.is_none() && self.clock().steps < target {
            let next = target.min(self.clock().steps.saturating_add(steps));
            let start = Instant::now();
            let engine = &mut self.engine;
            self.end = py.detach(|| engine.run_steps(next));
            let took = start.elapsed();
            if took < SLICE / 2 {
                steps = steps.saturating_mul(2);
            } else if took > SLICE * 2 {
                steps = (steps / 2).max(1);
            }
            py.check_signals()?;
        }
        Ok(())
    }

    fn clock(&self) -> &Clock {
        self.engine.world().resource::<Clock>()
    }
}

fn as_json(value: &impl serde::Serialize) -> PyResult<String> {
    serde_json::to_string(value).map_err(|error| PyRuntimeError::new_err(error.to_string()))
}

/// A fault with its place in the scene and its remedy.
fn refusal(scene: &Path, fault: &Fault) -> PyErr {
    let place = fault.line_and_column().map_or(String::new(), |(line, column)| format!(":{line}:{column}"));
    let help = fault.remedy().map_or(String::new(), |help| format!("\n  help: {help}"));
    SceneError::new_err(format!("{}{place}: {fault}{help}", scene.display()))
}

/// A simulation may pass from thread to thread; two that use it at once get an exception.
const fn is_shared<T: Send + Sync>() {}
const _: () = is_shared::<Simulation>();
