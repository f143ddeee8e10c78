//! Limits of a lattice-gas scene, checked before anything of that size is allocated or written.

use crate::lattice_silo::loaded::{LoadedLattice, polygon};
use crate::lattice_silo::scene::LatticeScene;
use crate::writers::memory::available_memory;
use crate::writers::volume::{self, Output};
use siloflow_figures::png::MOST_PIXELS;
use siloflow_figures::svg;
use siloflow_lattice::rules::Rules;
use siloflow_lattice::sites::Sites;
use siloflow_text::fault::Fault;
use siloflow_text::source::Source;

/// Largest number of stored sites, about 3 GB.
const MOST_SITES: usize = 200_000_000;

/// Memory of a stored site, B.
const BYTES_PER_SITE: usize = 16;

/// Most corners of the outline and of all inserts. Each pair of edges is compared.
const MOST_CORNERS: usize = 5_000;

/// Most comparisons of a site with an edge or with a single particle.
const MOST_COMPARISONS: u64 = 10_000_000_000;

/// Number of lines above a picture.
const HEADER_LINES: usize = 3;

/// Checks the number of corners, before any edges are compared.
pub(super) fn corners(scene: &LatticeScene, source: &Source) -> Result<(), Fault> {
    let lists = std::iter::once(&scene.outline).chain(&scene.inserts);
    let total: usize = lists.map(Vec::len).sum();
    if total <= MOST_CORNERS {
        return Ok(());
    }
    let key = if scene.outline.len() > MOST_CORNERS / 2 { "outline" } else { "inserts" };
    let message = format!("{total} corners of outline and inserts are more than the limit of {MOST_CORNERS}");
    Err(source.fault("scene::out_of_range", key, message).help("describe the silo by fewer corners"))
}

/// Checks the number of sites, before the sites are created.
pub(super) fn sites(scene: &LatticeScene, rules: &Rules, source: &Source) -> Result<(), Fault> {
    let (columns, rows) = Sites::extent(&polygon(&scene.outline), rules.spacing.get());
    let stored = Sites::stored(columns, rows);
    let corners = scene.outline.len() + scene.inserts.iter().map(Vec::len).sum::<usize>();
    let fault =
        |message: String, help: &str| Err(source.fault("scene::out_of_range", "method.spacing", message).help(help));
    if stored > MOST_SITES {
        let message = format!("{columns} columns of {rows} sites, with a margin, are more than {MOST_SITES} sites");
        return fault(message, "give a larger spacing, in m");
    }
    let available = available_memory().unwrap_or(u64::MAX);
    if (stored * BYTES_PER_SITE) as u64 > available {
        let message = format!(
            "{stored} sites need about {} MB of memory, and {} MB are available",
            stored * BYTES_PER_SITE / 1_000_000,
            available / 1_000_000
        );
        return fault(message, "give a larger spacing, in m");
    }
    if (stored as u64).saturating_mul(corners.max(scene.particles.len()) as u64) > MOST_COMPARISONS {
        let message = format!(
            "{stored} sites with {corners} corners and {} particles would take minutes to prepare",
            scene.particles.len()
        );
        return fault(message, "give a larger spacing, fewer corners or fewer `particles`");
    }
    Ok(())
}

/// Returns the outputs of a scene.
#[expect(clippy::cast_precision_loss, reason = "a number of sites")]
pub(crate) fn outputs(loaded: &LoadedLattice) -> Vec<Output> {
    let scene = &loaded.scene;
    let interval = f64::from(scene.series.interval.get());
    let mut outputs =
        vec![Output { key: "series.interval".to_owned(), interval, rows: 1.0, pictures: 0.0, bytes: 120.0 }];
    if let Some(pictures) = &scene.pictures {
        let cell = f64::from(pictures.cell.0.get()) * f64::from(pictures.cell.1.get());
        let pixels = svg::pixels(pictures.width.get(), loaded.view(), HEADER_LINES);
        outputs.push(Output {
            key: "pictures.interval".to_owned(),
            interval: f64::from(pictures.interval.get()),
            rows: 0.0,
            pictures: 1.0,
            // A rectangle takes about 35 B.
            bytes: 2000.0
                + loaded.sites.fluid_count() as f64 / cell * 35.0
                + if pictures.png { 0.1 * pixels } else { 0.0 },
        });
    }
    outputs
}

/// Checks the size and the number of pictures.
pub(super) fn check(loaded: &LoadedLattice) -> Result<(), Fault> {
    if let Some(pictures) = &loaded.scene.pictures {
        let width = pictures.width.get();
        let fault = |message: String, help| Err(loaded.fault("scene::out_of_range", "pictures.width", message, help));
        if !(50.0..=20_000.0).contains(&width) {
            return fault("expected a width of 50 to 20000 px".to_owned(), "480 is a good width");
        }
        let pixels = svg::pixels(width, loaded.view(), HEADER_LINES);
        if pictures.png && pixels > MOST_PIXELS {
            let message =
                format!("a picture would have {pixels:.2e} pixels, more than the limit of {MOST_PIXELS:e} for PNG");
            return fault(message, "lower the width, or write SVG only with `png: false`");
        }
    }
    #[expect(clippy::cast_precision_loss, reason = "a number of steps")]
    let until = loaded.scene.until as f64;
    if let Some((key, message)) = volume::excess(&outputs(loaded), until) {
        return Err(loaded.fault("scene::too_much_output", key, message, "give a larger number of steps"));
    }
    Ok(())
}
