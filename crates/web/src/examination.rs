//! Is a scene right, and small enough for a page?
//!
//! A page refuses scenes that would freeze its tab: steps that take longer than the time between two pictures, and outputs that do not fit
//! beside the run into the memory of a tab, which keeps all files.

use std::fs;
use std::path::Path;

use serde::Serialize;
use siloflow::behaviour::Registry;
use siloflow::cli::check;
use siloflow::dem::budget::Budget;
use siloflow::scene::load;
use siloflow::scene::loaded::AnyScene;
use siloflow::text::fault::Fault;
use siloflow::text::source::places;

/// Most spheres, discs or sites: a step of so many takes about a quarter of a second.
const MOST_BODIES: usize = 200_000;

/// Most sites of a lattice gas, whose updates take a tenth of that time.
const MOST_SITES: usize = 2_000_000;

/// Most bytes of outputs.
const MOST_BYTES: f64 = 1.0e9;

/// A fault of a scene.
#[derive(Serialize)]
pub struct Trouble {
    code: &'static str,
    message: String,
    help: Option<String>,
    file: Option<String>,
    line: Option<usize>,
    column: Option<usize>,
    width: Option<usize>,
}

impl Trouble {
    pub fn of(fault: &Fault) -> Self {
        let place = fault.line_and_column();
        Self {
            code: fault.code(),
            message: fault.to_string(),
            help: fault.remedy().map(str::to_owned),
            file: fault.file().map(str::to_owned),
            line: place.map(|(line, _)| line),
            column: place.map(|(_, column)| column),
            width: fault.width(),
        }
    }
}

#[derive(Serialize)]
struct Warning {
    code: &'static str,
    message: String,
    help: String,
}

#[derive(Serialize)]
struct Parameter {
    name: String,
    value: f64,
}

/// The findings in a scene that can be run.
#[derive(Serialize)]
pub struct Examination {
    title: String,
    estimates: String,
    warnings: Vec<Warning>,
    parameters: Vec<Parameter>,
    is_lattice: bool,
    is_solid: bool,
    /// Latest end, s or steps.
    until: f64,
}

/// Examines the scene at a path.
pub fn examine(path: &str) -> Result<Examination, Fault> {
    let scene = load::any(Path::new(path), &[])?;
    let found = check::examine(&scene, &Registry::default(), &Budget::usual())?;
    refuse_large(&scene, &found)?;
    let warnings = found.warnings.into_iter();
    let parameters = scene.source().numeric_parameters().into_iter();
    Ok(Examination {
        title: title(&scene).to_owned(),
        estimates: found.estimates,
        warnings: warnings.map(|of| Warning { code: of.code, message: of.message, help: of.help }).collect(),
        parameters: parameters.map(|(name, value)| Parameter { name, value }).collect(),
        is_lattice: matches!(scene, AnyScene::Lattice(_)),
        is_solid: matches!(&scene, AnyScene::Grains(loaded) if loaded.scene.space.count() == 3),
        until: until(&scene),
    })
}

/// Refuses a scene that is too large for a page.
pub fn refuse_large(scene: &AnyScene, found: &check::Findings) -> Result<(), Fault> {
    let most = if matches!(scene, AnyScene::Lattice(_)) { MOST_SITES } else { MOST_BODIES };
    let help = "make it smaller, or run it with the program on your machine: `siloflow run`";
    if found.bodies > most {
        let message =
            format!("{} grains and walls, or sites, would freeze this page; the limit is {most}", found.bodies);
        return Err(Fault::new("page::too_large", message).help(help));
    }
    if found.bytes > MOST_BYTES {
        let message = format!(
            "the run would write about {:.1} GB, which this page keeps in memory; the limit is {:.1} GB",
            found.bytes / 1e9,
            MOST_BYTES / 1e9
        );
        return Err(Fault::new("page::too_much_output", message).help("write less often, or run it on your machine"));
    }
    Ok(())
}

fn title(scene: &AnyScene) -> &str {
    match scene {
        AnyScene::Grains(loaded) => &loaded.scene.title,
        AnyScene::Lattice(loaded) => &loaded.scene.title,
    }
}

#[expect(clippy::cast_precision_loss, reason = "a number of steps")]
fn until(scene: &AnyScene) -> f64 {
    match scene {
        AnyScene::Grains(loaded) => loaded.scene.until.get(),
        AnyScene::Lattice(loaded) => loaded.scene.until as f64,
    }
}

/// Sets a parameter: path, name and value are the lines of `request`. Returns the text of the scene.
pub fn set(request: &str) -> Result<String, Fault> {
    let mut lines = request.lines();
    let mut next = || lines.next().ok_or_else(|| Fault::new("page::request", "the request has too few lines"));
    let path = next()?;
    let name = next()?;
    let value = next()?;
    let text = fs::read_to_string(path).map_err(|error| Fault::new("page::request", error.to_string()))?;
    places::set(&text, &format!("parameters.{name}"), value)
}
