//! A simulation that Python steps.

use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};

use bevy_ecs::prelude::*;
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use siloflow::behaviour::Registry;
use siloflow::dem::outcome::End;
use siloflow::dem::particle::{Grain, GrainId, Mass, Position, Radius, Species, Velocity};
use siloflow::dem::space::{Dimension, Plane, Solid, Space};
use siloflow::dem::step::Clock;
use siloflow::ledger::Ledger;
use siloflow::measure::totals;
use siloflow::scene::load;
use siloflow::scene::loaded::Loaded;
use siloflow::simulation::Simulation as Engine;
use siloflow::text::fault::Fault;

use crate::{SceneError, set_column};

/// A simulation of a scene with grains. It stays in the thread that made it.
#[pyclass(unsendable)]
pub struct Simulation {
    engine: Engine,
    loaded: Loaded,
    end: Option<End>,
}

#[pymethods]
impl Simulation {
    #[new]
    fn new(scene: PathBuf, settings: Vec<(String, String)>, threads: NonZeroUsize) -> PyResult<Self> {
        let refused = |fault: Fault| refusal(&scene, &fault);
        let loaded = load::load(&scene, &settings).map_err(refused)?;
        let engine = Engine::new(&loaded, &Registry::default(), threads).map_err(refused)?;
        let mut this = Self { engine, loaded, end: None };
        // Step zero places the grains of the start and evaluates their forces.
        this.end = this.engine.step();
        Ok(this)
    }

    /// Does this many steps, or fewer if the run ends.
    fn advance(&mut self, steps: u64) {
        let target = self.clock().steps.saturating_add(steps);
        self.end = self.engine.run_steps(target);
    }

    /// Steps until the clock shows a time, s, or the run ends.
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a time before zero does no step")]
    fn advance_to(&mut self, time: f64) {
        // A time counts as reached within a thousandth of a step, as in the engine.
        let steps = (time / self.clock().dt - 1e-3).ceil();
        self.end = self.engine.run_steps(steps as u64);
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

    /// Grains that were released, are inside, are out, and are lost.
    fn counts(&self) -> [u32; 4] {
        let ledger = self.engine.world().resource::<Ledger>();
        [ledger.released, ledger.inside(), ledger.out(), ledger.lost()]
    }

    /// Totals over the grains, SI, as JSON.
    fn totals(&self) -> PyResult<String> {
        let totals = totals::of_world(self.engine.world());
        serde_json::to_string(&totals).map_err(|error| PyRuntimeError::new_err(error.to_string()))
    }

    /// Columns of the grains inside, in the order of their ids, SI.
    fn grains<'py>(&mut self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        match self.loaded.scene.space {
            Dimension::Plane => columns::<Plane>(py, self.engine.world_mut()),
            Dimension::Solid => columns::<Solid>(py, self.engine.world_mut()),
        }
    }
}

impl Simulation {
    fn clock(&self) -> &Clock {
        self.engine.world().resource::<Clock>()
    }
}

/// The components of a grain that Python sees.
type Row<V> =
    (&'static GrainId, &'static Species, &'static Radius, &'static Mass, &'static Position<V>, &'static Velocity<V>);

fn columns<'py, V: Space>(py: Python<'py>, world: &mut World) -> PyResult<Bound<'py, PyDict>> {
    let mut rows: Vec<_> = world.query_filtered::<Row<V>, With<Grain>>().iter(world).collect();
    rows.sort_unstable_by_key(|row| row.0.number());
    let components = |x: V| (0..V::COUNT).map(move |axis| x.component(axis));
    let positions: Vec<_> = rows.iter().flat_map(|row| components(row.4.0)).collect();
    let velocities: Vec<_> = rows.iter().flat_map(|row| components(row.5.0)).collect();
    let columns = PyDict::new(py);
    let number = |x: f64| x.to_le_bytes();
    let ids: Vec<_> = rows.iter().map(|row| row.0.number()).collect();
    set_column(&columns, "id", "<u4", 1, &ids, |x| x.to_le_bytes())?;
    let species: Vec<_> = rows.iter().map(|row| row.1.0).collect();
    set_column(&columns, "species", "|u1", 1, &species, |x| [x])?;
    let radii: Vec<_> = rows.iter().map(|row| row.2.0).collect();
    set_column(&columns, "radius", "<f8", 1, &radii, number)?;
    let masses: Vec<_> = rows.iter().map(|row| row.3.0).collect();
    set_column(&columns, "mass", "<f8", 1, &masses, number)?;
    let axes = u8::try_from(V::COUNT)?;
    set_column(&columns, "position", "<f8", axes, &positions, number)?;
    set_column(&columns, "velocity", "<f8", axes, &velocities, number)?;
    Ok(columns)
}

/// A fault with its place in the scene and its remedy.
fn refusal(scene: &Path, fault: &Fault) -> PyErr {
    let place = fault.line_and_column().map_or(String::new(), |(line, column)| format!(":{line}:{column}"));
    let help = fault.remedy().map_or(String::new(), |help| format!("\n  help: {help}"));
    SceneError::new_err(format!("{}{place}: {fault}{help}", scene.display()))
}
