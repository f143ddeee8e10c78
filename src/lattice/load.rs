//! A scene of the lattice gas, loaded and checked.

use std::path::Path;

use crate::fault::Fault;
use crate::lattice::door::DoorOpens;
use crate::lattice::outline::Polygon;
use crate::lattice::rules::Rules;
use crate::lattice::scene::LatticeScene;
use crate::lattice::sites::Sites;
use crate::scene::Method;
use crate::scene::source::Source;
use crate::scene::values::FiniteVector;
use crate::space::{Plane, Vector};

/// Sites of the largest lattice.
const MOST_SITES: usize = 100_000_000;

/// A scene of the lattice gas that is ready to run.
#[derive(Debug)]
pub struct LoadedLattice {
    /// What the file says, with `--set` applied.
    pub scene: LatticeScene,
    /// Its text.
    pub source: Source,
    /// The rules.
    pub rules: Rules,
}

impl LoadedLattice {
    /// Loads the scene at `path`, each of `settings` (key path, value as RON) applied to its text first.
    ///
    /// # Errors
    /// If the file cannot be read, is not what it should be, or a rule is broken.
    pub fn read(path: &Path, settings: &[(String, String)]) -> Result<Self, Fault> {
        Self::new(Source::read(path)?, settings)
    }

    /// The same for a text.
    ///
    /// # Errors
    /// As [`LoadedLattice::read`].
    pub fn new(mut source: Source, settings: &[(String, String)]) -> Result<Self, Fault> {
        let scene: LatticeScene = source.parse(settings)?;
        let Method::LatticeGas(rules) = scene.method else {
            return Err(source
                .fault("scene::method", "method", "this is not a scene of the lattice gas")
                .help("write `method: LatticeGas(...)`"));
        };
        let loaded = Self { scene, source, rules };
        loaded.check_outline()?;
        loaded.check_door()?;
        loaded.check_particles()?;
        Ok(loaded)
    }

    /// A fault that points at the value of `key`.
    fn fault(&self, code: &'static str, key: &str, message: impl Into<String>, help: &str) -> Fault {
        self.source.fault(code, key, message).help(help)
    }

    /// The silo.
    #[must_use]
    pub fn outline(&self) -> Polygon {
        polygon(&self.scene.outline)
    }

    /// The sites of the silo, its door closed.
    #[must_use]
    pub fn sites(&self) -> Sites {
        let inserts: Vec<_> = self.scene.inserts.iter().map(|corners| polygon(corners)).collect();
        let door = self.scene.door.map(|door| (door.from.get::<Plane>(), door.to.get::<Plane>()));
        Sites::new(&self.outline(), &inserts, door, self.rules.spacing.get())
    }

    fn check_outline(&self) -> Result<(), Fault> {
        let named = self.scene.inserts.iter().enumerate().map(|(n, corners)| (format!("inserts[{n}]"), corners));
        for (key, corners) in std::iter::once(("outline".to_owned(), &self.scene.outline)).chain(named) {
            let is_planar = corners.iter().all(|corner| corner.count() == 2);
            if !is_planar || corners.len() < 3 || polygon(corners).area() == 0.0 {
                let message = "expected a polygon of at least three corners (x, y) that encloses an area";
                return Err(self.fault("scene::degenerate_wall", &key, message, "give the corners in turn, in m"));
            }
        }
        let (columns, rows) = Sites::extent(&self.outline(), self.rules.spacing.get());
        if columns.saturating_mul(rows) > MOST_SITES {
            let message = format!("{columns} columns of {rows} sites are more than {MOST_SITES} sites");
            return Err(self.fault("scene::out_of_range", "method.spacing", message, "give a larger spacing, in m"));
        }
        if self.sites().runs.is_empty() {
            let message = "no site of the lattice is inside the outline";
            return Err(self.fault(
                "scene::empty_box",
                "outline",
                message,
                "give a smaller `spacing` or a larger outline",
            ));
        }
        Ok(())
    }

    fn check_door(&self) -> Result<(), Fault> {
        let scene = &self.scene;
        let Some(door) = scene.door else {
            if scene.discharge.is_some() {
                let message = "a run ends so many steps after the door has opened, but there is no door";
                return Err(self.fault("scene::no_door", "discharge", message, "add `door`, or remove `discharge`"));
            }
            return Ok(());
        };
        let is_planar = door.from.count() == 2 && door.to.count() == 2;
        if !is_planar || door.from == door.to {
            let message = "the door goes from one place (x, y) to another";
            return Err(self.fault("scene::degenerate_wall", "door", message, "give two different places, in m"));
        }
        if self.sites().doorway.is_empty() {
            let message = "there is no site to go out by: the door is not on the outline";
            return Err(self.fault(
                "scene::no_door",
                "door",
                message,
                "give two places on one edge of the outline, in m",
            ));
        }
        if door.opens == DoorOpens::AtRest && scene.rest.is_none() {
            let message = "the door opens at rest, but nothing detects rest";
            return Err(self.fault("scene::missing_key", "rest", message, "add `rest: (hold: 800)`, in steps"));
        }
        Ok(())
    }

    fn check_particles(&self) -> Result<(), Fault> {
        let scene = &self.scene;
        for (n, thrown) in scene.particles.iter().enumerate() {
            if thrown.velocity > 12 {
                let (key, message) =
                    (format!("particles[{n}].velocity"), "expected a direction from 0 (at rest) to 12");
                return Err(self.fault("scene::out_of_range", &key, message, "1 is up, 4 is down, 7 obliquely up"));
            }
            let is_inside = thrown.at.count() == 2 && self.outline().holds(thrown.at.get::<Plane>(), 0.0);
            if !is_inside {
                let message = "the particle is not inside the outline";
                return Err(self.fault("scene::outside", &format!("particles[{n}].at"), message, "give (x, y) in m"));
            }
        }
        let full = 13.0;
        let wanted = [("fill", scene.fill.map(|f| f.per_site)), ("pour", scene.pour.map(|p| p.per_site))];
        for (key, per_site) in wanted {
            if per_site.is_some_and(|per_site| per_site.get() > full) {
                let message = "a site holds at most 13 particles";
                return Err(self.fault("scene::out_of_range", &format!("{key}.per_site"), message, "6 is usual"));
            }
        }
        if scene.fill.is_none() && scene.pour.is_none() && scene.particles.is_empty() {
            let message = "nothing enters: there are no particles";
            return Err(self.fault(
                "scene::missing_key",
                "fill",
                message,
                "add `fill: (per_site: 6.0)`, `pour` or `particles`",
            ));
        }
        Ok(())
    }
}

fn polygon(corners: &[FiniteVector]) -> Polygon {
    Polygon(corners.iter().map(|corner| Vector::new(corner.padded().x, corner.padded().y)).collect())
}
