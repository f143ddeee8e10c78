//! A sweep: one scene, run with many values of its keys and with several seeds. The results are a table and figures.
//!
//! | part | file |
//! |---|---|
//! | the sweep file and its rules | [`plan`] |
//! | points: the product of all axes, or a Latin hypercube | [`design`] |
//! | the figures of a run | [`figures`](crate::studies::figures) |
//! | the sweep directory and the state of each run in it | [`directory`] |
//! | means and standard errors over the seeds | [`table`] |
//! | fits through the means | [`statistics::fit`](siloflow_figures::statistics::fit) |
//! | pictures of the means | [`picture`] |
//! | scripts that make a job array of a sweep | [`script`] |
//!
//! Each run is a process of its own on one thread, with a run directory of its own. A run depends on its point and its seed alone, and
//! all tables list runs in the order of the sweep file. So the tables do not depend on the order of the runs, on the machine that made
//! them, or on interruptions.

pub mod design;
pub mod directory;
pub mod picture;
pub mod plan;
pub mod script;
pub mod table;

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use crate::behaviour::Registry;
use crate::lattice_silo;
use crate::scene::check;
use crate::scene::load;
use crate::scene::loaded::AnyScene;
use crate::simulation::Simulation;
use crate::studies::figures::figure::Figure;
use crate::studies::sweep::design::Point;
use crate::studies::sweep::plan::SweepPlan;
use siloflow_text::fault::{Fault, Warning};
use siloflow_text::source::Source;

/// A sweep file that has been read, with its points.
#[derive(Debug)]
pub struct Sweep {
    /// Name: that of the sweep file without its ending.
    pub name: String,
    /// The text of the sweep file.
    pub text: String,
    /// The content of the sweep file.
    pub plan: SweepPlan,
    /// The path of the scene.
    pub scene: PathBuf,
    /// Keys of the scene that differ between points.
    pub keys: Vec<String>,
    /// All points.
    pub points: Vec<Point>,
    /// Name of the copy of the sweep file in the directory.
    pub copy: &'static str,
    /// The text of the scene.
    scene_text: String,
}

/// One run of a sweep.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Task {
    /// Index of the point.
    pub point: usize,
    /// Seed of the run.
    pub seed: u64,
}

impl Sweep {
    /// Reads a sweep file and makes its points. The scene is read, but not checked: [`Sweep::check`].
    ///
    /// # Errors
    /// If a file cannot be read, or the sweep file breaks a rule.
    pub fn read(path: &Path) -> Result<Self, Fault> {
        let mut source = plan::read_source(path)?;
        let text = source.text.clone();
        let plan = SweepPlan::parse(&mut source)?;
        let scene = path.parent().unwrap_or(Path::new("")).join(&plan.scene);
        let scene_text = Source::read(&scene)
            .map_err(|fault| {
                source
                    .fault("sweep::scene", "scene", fault.to_string())
                    .help("give the path of a scene, relative to the directory of the sweep file")
            })?
            .text;
        let points = design::points(&plan);
        let keys = plan.keys().map(str::to_owned).collect();
        let name = source.name.clone();
        let sweep = Self { name, text, plan, scene, keys, points, copy: "sweep.ron", scene_text };
        sweep.check_figures(&source)?;
        Ok(sweep)
    }

    /// Makes the sweep of a study that chooses points and seeds of its runs itself. `text` tells the study of a directory from others, and
    /// `copy` is the name of the file that keeps it there.
    ///
    /// # Errors
    /// If the scene cannot be read.
    pub fn of_points(
        name: String,
        scene: &Path,
        text: String,
        copy: &'static str,
        keys: Vec<String>,
        points: Vec<Point>,
    ) -> Result<Self, Fault> {
        let scene_text = Source::read(scene)?.text;
        let plan = SweepPlan::without_axes(scene);
        Ok(Self { name, text, plan, scene: scene.to_owned(), keys, points, copy, scene_text })
    }

    /// Checks that a run of the scene can have the figures.
    fn check_figures(&self, source: &Source) -> Result<(), Fault> {
        let scene = self.base();
        let is_lattice = scene.value_of("method").is_some_and(|method| method.starts_with("LatticeGas"));
        for (number, figure) in self.plan.figures.iter().enumerate() {
            if let Err(fault) = Figure::parse(figure, is_lattice) {
                let help = fault.remedy().unwrap_or_default().to_owned();
                return Err(source.fault("sweep::figure", &format!("figures[{number}]"), fault.to_string()).help(help));
            }
        }
        Ok(())
    }

    /// The scene without the settings of a point.
    fn base(&self) -> Source {
        let directory = self.scene.parent().unwrap_or(Path::new(""));
        let name = self.scene.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        Source::new(&self.scene.display().to_string(), &name, directory, self.scene_text.clone())
    }

    /// Returns all runs, in the order of the points and then of the seeds.
    #[must_use]
    pub fn tasks(&self) -> Vec<Task> {
        let seeds = self.plan.seeds.list();
        (0..self.points.len()).flat_map(|point| seeds.iter().map(move |&seed| Task { point, seed })).collect()
    }

    /// Returns the settings of a run: those of the sweep file, of its point, and its seed.
    #[must_use]
    pub fn settings(&self, task: Task) -> Vec<(String, String)> {
        let common = self.plan.set.iter().map(|(key, value)| (key.clone(), value.trim().get_ron().to_owned()));
        let own = self.keys.iter().cloned().zip(self.points[task.point].values.iter().cloned());
        common.chain(own).chain([("seed".to_owned(), task.seed.to_string())]).collect()
    }

    /// Returns the name of a run's directory, for example `0003-2` for seed 2 of the third point.
    #[must_use]
    pub fn run_name(&self, task: Task) -> String {
        format!("{:04}-{}", task.point + 1, task.seed)
    }

    /// Returns a run in words: its name, the values of its point and its seed.
    #[must_use]
    pub fn in_words(&self, task: Task) -> String {
        let mut words = format!("{} (", self.run_name(task));
        // Writing to a string cannot fail.
        for (key, value) in self.keys.iter().zip(&self.points[task.point].values) {
            let _ = write!(words, "{key} = {value}, ");
        }
        let _ = write!(words, "seed {})", task.seed);
        words
    }

    /// Loads the scene of a run, finds all errors of its input, and returns its warnings.
    ///
    /// # Errors
    /// If the scene is refused with the settings of the run.
    pub fn check(&self, task: Task, registry: &Registry) -> Result<Vec<Warning>, Fault> {
        match load::any(&self.scene, &self.settings(task))? {
            AnyScene::Grains(loaded) => Simulation::check(&loaded, registry).map(|()| check::warnings(&loaded)),
            AnyScene::Lattice(loaded) => Simulation::of_lattice(&loaded, registry, std::num::NonZeroUsize::MIN)
                .map(|_| lattice_silo::check::warnings(&loaded)),
        }
    }

    /// Returns the text of the scene with the settings of a run.
    fn expected(&self, task: Task) -> Result<Source, Fault> {
        let mut source = self.base();
        source.apply(&self.settings(task))?;
        Ok(source)
    }
}
