//! Pictures of a lattice gas: density as grey levels, from white (no particles) to black (13 particles per site).
//!
//! A picture consists of cells of several columns and rows of sites (`pictures.cell`). The grey level of a cell is its
//! mean number of particles per site divided by 13. The files are `frames/NNNNN.svg`, every `pictures.interval` steps
//! and at the end, with PNGs beside them if `pictures.png` is set.

use std::num::{NonZeroU16, NonZeroU32};
use std::path::PathBuf;

use bevy_app::{App, Plugin};
use bevy_ecs::prelude::*;
use serde::{Deserialize, Serialize};

use crate::lattice_silo::door::DoorState;
use crate::measure::{ObserveStage, due, observe_every};
use crate::writers::picture_writer::PictureWriter;
use crate::writers::run_path::RunPath;
use siloflow_dem::outcome::Outcome;
use siloflow_dem::space::Vector;
use siloflow_dem::step::{Clock, Step};
use siloflow_dem::values::Positive;
use siloflow_figures::colour::{self, Rgb};
use siloflow_figures::svg::{Legend, Picture};
use siloflow_lattice::gas::Gas;
use siloflow_lattice::sites::Sites;
use siloflow_lattice::velocities::in_bonds;

/// The scene's key `pictures`.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct Pictures {
    /// Steps between pictures. Default 100.
    pub interval: NonZeroU32,
    /// Width of a picture, px. Default 480.
    pub width: Positive,
    /// Numbers of columns and rows of sites in a cell. Default (2, 2).
    pub cell: (NonZeroU16, NonZeroU16),
    /// Whether PNGs are written beside the SVGs. Default `false`.
    pub png: bool,
}

/// Default numbers of columns and rows of sites in a cell: 2 and 2.
pub const CELL: (NonZeroU16, NonZeroU16) =
    (NonZeroU16::new(2).expect("positive"), NonZeroU16::new(2).expect("positive"));

impl Default for Pictures {
    fn default() -> Self {
        Self {
            interval: NonZeroU32::new(100).expect("positive"),
            width: Positive::try_from(480.0).expect("positive"),
            cell: CELL,
            png: false,
        }
    }
}

/// Returns the cells of a picture that have fluid sites, each of this many columns and rows of sites.
#[must_use]
pub fn densities(sites: &Sites, gas: &Gas, (columns, rows): (NonZeroU16, NonZeroU16)) -> Vec<DensityCell> {
    let columns = usize::from(columns.get());
    let rows = usize::from(rows.get());
    let high = sites.stride.div_ceil(rows);
    let mut sums = vec![(0u32, 0u32); sites.kinds.len().div_ceil(sites.stride).div_ceil(columns) * high];
    for s in sites.fluid() {
        let cell = &mut sums[s / sites.stride / columns * high + s % sites.stride / rows];
        *cell = (cell.0 + gas.states()[s].count_ones(), cell.1 + 1);
    }
    // Each site covers a rectangle of one pitch, with the site in its middle.
    let pitch = sites.spacing * Vector::new(in_bonds((1, 0)).0, 1.0);
    let corner = sites.position(0) - 0.5 * pitch;
    #[expect(clippy::cast_precision_loss, reason = "small numbers")]
    let at = |i: usize, j: usize| corner + pitch * Vector::new((i * columns) as f64, (j * rows) as f64);
    let filled = sums.into_iter().enumerate().filter(|(_, (_, fluid))| *fluid > 0);
    filled
        .map(|(n, (count, fluid))| {
            let i = n / high;
            let j = n % high;
            DensityCell { low: at(i, j), high: at(i + 1, j + 1), density: f64::from(count) / f64::from(fluid) }
        })
        .collect()
}

/// A cell of a picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DensityCell {
    /// Lower left corner, m.
    pub low: Vector,
    /// Upper right corner, m.
    pub high: Vector,
    /// Mean number of particles per fluid site.
    pub density: f64,
}

/// Returns the grey level of a density in particles per site: 0 is white, 13 is black.
#[must_use]
pub fn grey(density: f64) -> Rgb {
    colour::grey(density / 13.0)
}

/// Groups the cells by colour, as (colour, corners of the cells), in the form of [`Picture::cells`].
#[must_use]
pub fn shaded(cells: &[DensityCell]) -> Vec<(Rgb, Vec<(Vector, Vector)>)> {
    let mut by_grey: Vec<Vec<(Vector, Vector)>> = vec![Vec::new(); 256];
    for cell in cells {
        by_grey[usize::from(grey(cell.density)[0])].push((cell.low, cell.high));
    }
    (0..=u8::MAX).zip(by_grey).filter(|(_, cells)| !cells.is_empty()).map(|(g, cells)| ([g; 3], cells)).collect()
}

/// Settings of all pictures of a run.
#[derive(Resource, Clone)]
pub(crate) struct PictureSettings {
    pub pictures: Pictures,
    pub title: String,
    /// Lower left and upper right corner of the view, m.
    pub view: (Vector, Vector),
    /// The ends of the door, m.
    pub door: Option<(Vector, Vector)>,
}

fn write_picture(
    clock: Res<Clock>,
    (sites, gas, door): (Res<Sites>, Res<Gas>, Option<Res<DoorState>>),
    settings: Res<PictureSettings>,
    mut picture_writer: ResMut<PictureWriter>,
    mut outcome: ResMut<Outcome>,
) {
    let opened = door.as_ref().and_then(|door| door.steps_since(&clock));
    let since = opened.map_or_else(String::new, |steps| format!(", {steps} since the door opened"));
    let picture = Picture {
        low: settings.view.0,
        high: settings.view.1,
        width: settings.pictures.width.get(),
        header: vec![
            settings.title.clone(),
            format!("step {}{since}", clock.steps),
            format!("inside {}, out {} particles", gas.inside(), gas.out()),
        ],
        legend: Legend::Scale { from: 0.0, to: 13.0, title: "particles a site".to_owned(), map: colour::grey },
        cells: shaded(&densities(&sites, &gas, settings.pictures.cell)),
        lines: sites.lines().iter().map(|&(from, to)| (from, to, colour::WALL)).collect(),
        ..Picture::default()
    };
    let closed = settings.door.filter(|_| opened.is_none());
    let doors =
        settings.door.iter().map(|&(from, to)| (from, to, if closed.is_some() { colour::DOOR } else { [255; 3] }));
    let picture = Picture { lines: picture.lines.iter().copied().chain(doors).collect(), ..picture };
    picture_writer.add(move || picture, &mut outcome);
}

/// Plugin that writes the pictures.
pub(crate) struct PicturesPlugin {
    pub settings: PictureSettings,
    /// The directory of the pictures.
    pub directory: PathBuf,
}

impl Plugin for PicturesPlugin {
    fn build(&self, app: &mut App) {
        observe_every::<Pictures>(app, f64::from(self.settings.pictures.interval.get()));
        PictureWriter::persist(app);
        let writer = PictureWriter::new(self.directory.clone(), self.settings.pictures.png);
        let writer = writer.recorded_in(app.world().get_resource::<RunPath>().map(|run| &run.files));
        app.insert_resource(self.settings.clone())
            .insert_resource(writer)
            .add_systems(Step, write_picture.in_set(ObserveStage::Write).run_if(due::<Pictures>));
    }
}
