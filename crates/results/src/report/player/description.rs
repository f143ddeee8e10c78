//! Facts about a run in JSON, for the script of the player.

use serde::Serialize;

use super::links::TOP_FORCE;
use super::plan::Plan;
use super::scale::TOP;
use crate::pictures::bonds::WEAKEST;
use siloflow_figures::colour::{self, Rgb};
use siloflow_files::frames::Header;
use siloflow_files::frames::scale::Palette;

/// The description of a run that the script needs besides the numbers.
#[derive(Serialize)]
pub(super) struct Description<'a> {
    title: &'a str,
    scene: &'a str,
    dimension: u8,
    /// Name and colour of each species.
    species: Vec<(&'a str, String)>,
    /// Colours of wall grains and walls of the plane, and of doors.
    wall_colours: [String; 2],
    /// Colours of walls of solid space, and of doors.
    surface_colours: [String; 2],
    /// Colours of the levels: of magnitudes, and of differences from a middle.
    palettes: [String; 2],
    periodic: [Option<(f64, f64)>; 3],
    domain: [[f64; 3]; 2],
    /// Corner and step of the grid, m.
    low: [f64; 3],
    high: [f64; 3],
    step: f64,
    particles: usize,
    frames: usize,
    frames_of_run: usize,
    changes_radius: bool,
    quantities: Vec<Quantity<'a>>,
    top: f64,
    forces: Range,
    top_force: f64,
    has_contacts: bool,
    /// For each wall whether it is a door.
    doors: Vec<bool>,
}

#[derive(Serialize)]
struct Quantity<'a> {
    name: &'a str,
    label: String,
    unit: &'a str,
    /// Which of the palettes.
    palette: u8,
    is_whole: bool,
    /// Whether every particle keeps its number.
    is_kept: bool,
    /// Whether levels are in proportion to the root of the distance from the lowest number.
    is_root: bool,
    #[serde(flatten)]
    range: Range,
}

/// The numbers of the lowest and highest level, and the smallest and largest number.
#[derive(Serialize)]
struct Range {
    low: f64,
    high: f64,
    smallest: f64,
    largest: f64,
}

impl<'a> Description<'a> {
    /// Describes a run of which so many frames are packed.
    pub fn of(header: &'a Header, plan: &'a Plan, frames: usize) -> Self {
        let column = |name: &str| header.columns.iter().find(|column| column.name == name);
        let is_difference =
            |name| column(name).and_then(|column| column.scale).is_some_and(|scale| scale.palette == Palette::BlueRed);
        let quantities = plan.quantities().map(|(facts, scale)| Quantity {
            name: &facts.name,
            label: column(&facts.name).map_or_else(|| facts.name.replace('_', " "), |column| column.label.clone()),
            palette: is_difference(&facts.name).into(),
            unit: &facts.unit,
            is_whole: facts.is_whole,
            is_kept: facts.fixed.is_some(),
            is_root: scale.is_root,
            range: Range { low: scale.low, high: scale.high, smallest: facts.spread.low, largest: facts.spread.high },
        });
        let forces = &plan.facts.forces;
        let palette = |colour: fn(f64) -> Rgb| (0..=254).map(|level| hex(colour(f64::from(level) / TOP))).collect();
        Self {
            title: &header.title,
            scene: &header.scene,
            dimension: header.dimension,
            species: header.species.iter().map(|(name, colour)| (&**name, colour::hex(*colour))).collect(),
            wall_colours: [colour::WALL, colour::DOOR].map(colour::hex),
            surface_colours: [colour::SURFACE, colour::DOOR].map(colour::hex),
            palettes: [palette(colour::viridis), palette(blue_red)],
            periodic: header.periodic,
            domain: header.domain,
            low: plan.grid.low,
            high: plan.grid.high,
            step: plan.grid.step,
            particles: plan.facts.particles.len(),
            frames,
            frames_of_run: plan.facts.frames,
            changes_radius: plan.facts.changes_radius,
            quantities: quantities.collect(),
            top: TOP,
            forces: Range {
                low: WEAKEST * plan.forces.high,
                high: plan.forces.high,
                smallest: forces.low,
                largest: forces.high,
            },
            top_force: TOP_FORCE,
            has_contacts: plan.facts.contacts > 0,
            doors: header.walls.iter().map(|wall| wall.is_door).collect(),
        }
    }
}

fn hex(colour: Rgb) -> String {
    colour::hex(colour).split_off(1)
}

/// Ends of the palette for differences (Brewer and Harrower, RdBu), distinguishable with colour blindness; white is between them.
const ENDS: [Rgb; 2] = [[0x21, 0x66, 0xac], [0xb2, 0x18, 0x2b]];

/// Returns the colour of a number from 0 (blue) over 0.5 (white) to 1 (red).
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "between two bytes")]
fn blue_red(share: f64) -> Rgb {
    let distance = (2.0 * share - 1.0).abs().min(1.0);
    ENDS[usize::from(share > 0.5)].map(|end| (255.0 + distance * (f64::from(end) - 255.0)).round() as u8)
}
