//! Figures of runs as SVG, for `siloflow plot` and the report: curves over time, walls, profiles and fields.
//!
//! A figure of one run shows its quantities together. A figure of several runs has a panel for each quantity, with a curve for each
//! run. Times of rest and of the opening of the door are marked.
//!
//! | figure | from | content |
//! |---|---|---|
//! | `discharge` | `series.csv` | grains and mass that are out, with the mean rate; the rate over time |
//! | `grains` | `series.csv` | released, inside, out and lost |
//! | `energy` | `series.csv` | energies; flows of energy; error of the balance |
//! | `contacts` | `series.csv` | contacts per grain; largest overlap |
//! | `speed` | `series.csv` | largest speed; of the lattice gas mean velocity, centre of mass and share at rest |
//! | `walls` | `walls.csv`, `wall_groups.csv` | forces on walls |
//! | `free_walls` | `free_walls.csv` | places of walls that forces move, and the force of the grains |
//! | `slopes` | `slopes.csv` | angles of the free surface |
//! | `bands` | `wall_bands.csv` | pressure and friction on walls by height, at rest with Janssen's law, and in flow |
//! | `profiles` | `profiles.csv` | packing fraction, velocity and temperature in bins |
//! | `fields` | `fields.csv`, `flow.csv` | solid fraction, speed and temperature as maps |
//!
//! Any other column of `series.csv` has a figure of its name.
//!
//! The colours of an SVG are attributes, and its elements have classes, which [`STYLE`] gives the colours of a page. Panels over
//! time have the attributes of [`Panel::clock`](siloflow_figures::diagram::Panel::clock), so that a page can draw a cursor.

mod bands;
mod by_height;
mod by_name;
mod discharge;
mod maps;
mod over_time;
pub mod rate;

use crate::run_results::RunResults;
use siloflow_figures::diagram::{Look, Panel, sheet};
use siloflow_text::fault::Fault;

/// A figure of one or several runs.
#[derive(Clone, Debug)]
pub struct Figure {
    /// Name, for example `discharge`.
    pub name: String,
    /// Title, for example `Discharge`.
    pub title: String,
    /// Its panels.
    pub panels: Vec<Panel>,
}

impl Figure {
    /// Returns the figure as SVG.
    #[must_use]
    pub fn svg(&self, look: &Look) -> String {
        look.sheet(&self.panels, PER_ROW)
    }

    /// Returns each panel as a drawing of its own, for a page that arranges them.
    pub fn drawings(&self) -> impl Iterator<Item = String> {
        self.panels.iter().map(|panel| sheet(std::slice::from_ref(panel), 1))
    }
}

/// A style sheet for figures in a page that defines the variables `--paper`, `--ink` and `--line`.
pub const STYLE: &str = "\
.plot svg { max-width: 100%; height: auto }
.plot .paper { fill: var(--paper) }
.plot .ink { fill: var(--ink) }
.plot .grid { stroke: var(--line) }
.plot .frame, .plot .k0 { stroke: var(--ink) }
.plot circle.k0 { fill: var(--ink) }
";

type Draw = fn(&[&RunResults]) -> Result<Vec<Panel>, Fault>;

/// All figures that have their own code: name, title and drawing.
const FIGURES: [(&str, &str, Draw); 11] = [
    ("discharge", "Discharge", |runs| Ok(discharge::panels(runs))),
    ("grains", "Grains", |runs| Ok(over_time::of_groups(runs, &over_time::GRAINS))),
    ("energy", "Energy", |runs| Ok(over_time::of_groups(runs, &over_time::ENERGY))),
    ("contacts", "Contacts", |runs| Ok(over_time::of_groups(runs, &over_time::CONTACTS))),
    ("speed", "Speed", |runs| Ok(over_time::of_groups(runs, &over_time::SPEED))),
    ("walls", "Forces on walls", over_time::walls),
    ("free_walls", "Walls that forces move", by_name::free_walls),
    ("bands", "Walls by height", bands::panels),
    ("slopes", "Slopes", by_name::slopes),
    ("profiles", "Profiles", by_height::profiles),
    ("fields", "Fields", maps::panels),
];

/// Most panels beside each other.
const PER_ROW: usize = 2;

/// Names of the figures that have their own code.
pub fn names() -> impl Iterator<Item = &'static str> + Clone {
    FIGURES.iter().map(|figure| figure.0)
}

/// Returns all figures that runs have data for, in the order of the table above, and then those of columns that behaviours
/// add to `series.csv`.
///
/// # Errors
/// If a file cannot be read.
pub fn figures(runs: &[&RunResults]) -> Result<Vec<Figure>, Fault> {
    let own = FIGURES.iter().map(|&(name, title, draw)| Ok(figure(name, title, draw(runs)?)));
    let others = over_time::other_columns(runs).into_iter().map(|name| named(runs, &name));
    own.chain(others).filter_map(Result::transpose).collect()
}

/// Returns the figure of this name; `None` if no run has data for it.
///
/// # Errors
/// If a file cannot be read.
pub fn named(runs: &[&RunResults], name: &str) -> Result<Option<Figure>, Fault> {
    match FIGURES.iter().find(|figure| figure.0 == name) {
        Some(&(name, title, draw)) => Ok(figure(name, title, draw(runs)?)),
        None => Ok(figure(name, name, over_time::column(runs, name))),
    }
}

fn figure(name: &str, title: &str, panels: Vec<Panel>) -> Option<Figure> {
    (!panels.is_empty()).then(|| Figure { name: name.to_owned(), title: title.to_owned(), panels })
}
