//! Estimates of the memory, rows, pictures and disk space of a scene, before any of it is allocated or written.
//!
//! | figure | estimate |
//! |---|---|
//! | memory | [`BYTES_PER_GRAIN`] for each grain at the start, the most that was measured (docs/developers/speed-notebook.md) |
//! | rows, pictures | the number of intervals in a number of steps, at most one for each step |
//! | time | [`Work`] |
//! | disk | the length of such rows and shapes, times their number |

mod frame_times;
mod work;

pub use self::work::Work;

use crate::grains::feed::Feed;
use crate::grains::file::GrainRow;
use crate::grains::shaped::{Shaped, SizeRange, size_ranges};
use crate::grains::sizes::RadiusLaw;
use crate::measure::fields::Layout;
use crate::scene::TimeStep;
use crate::scene::check::quantities::Estimates;
use crate::scene::loaded::Loaded;
use crate::scene::outputs::DataFrames;
use crate::scene::view;
use crate::writers::volume::Output;
use siloflow_dem::particle::GrainId;
use siloflow_dem::values::Positive;
use siloflow_figures::svg;
use siloflow_results::export::Format;

/// Memory of a grain, B.
pub const BYTES_PER_GRAIN: f64 = 1000.0;

/// Length of a row of `series.csv`, of `walls.csv`, and of `centres.csv` or `profiles.csv`, B.
const ROW_BYTES: [f64; 3] = [250.0, 80.0, 150.0];

/// Length of a disc in an SVG picture, and of a picture without discs, B.
const PICTURE_BYTES: [f64; 2] = [65.0, 2000.0];

/// Length of a PNG over its number of pixels, B.
const PNG_BYTES: f64 = 0.1;

/// Bytes of a grain and of its contacts in a frame of data, in the plane and in solid space, B; and of a frame without grains.
const FRAME_BYTES: [[f64; 2]; 2] = [[45.0, 40.0], [85.0, 90.0]];
const FRAME_HEAD_BYTES: f64 = 500.0;

/// Bytes of a grain and its contacts in VTK files, and of a grain in a text, B.
const FORMAT_BYTES: [f64; 2] = [500.0, 400.0];

/// Number of lines above a picture.
fn header_lines(loaded: &Loaded) -> usize {
    // Title, time, accounting, and the scale of bonds; or the sizes of a mixture.
    loaded.largest_species().saturating_add(1).max(4)
}

/// Returns the number of pixels of a picture.
#[must_use]
pub fn pixels(loaded: &Loaded) -> f64 {
    loaded
        .scene
        .pictures
        .as_ref()
        .map_or(0.0, |pictures| svg::pixels(pictures.width.get(), view::of(loaded, pictures), header_lines(loaded)))
}

/// Returns the number of discs of a late picture: wall grains, grains of the start, and grains to be released. A grain with a shape has
/// several.
#[must_use]
pub fn shapes(loaded: &Loaded) -> usize {
    let walls = loaded.silo.wall.len() + loaded.silo.door.len() + loaded.fixed.len() + loaded.scene.walls.len();
    walls + grain_shapes(loaded)
}

/// Returns the number of discs or spheres of all grains, those of the start and those to be released.
#[must_use]
pub fn grain_shapes(loaded: &Loaded) -> usize {
    let count = |radius: &RadiusLaw, shaped: Option<&Shaped>| {
        size_ranges(radius, shaped).iter().map(SizeRange::count).max().unwrap_or(1)
    };
    let of_spawner = loaded.scene.spawner.as_ref();
    let released =
        of_spawner.map_or(0, |spawner| spawner.count as usize * count(&spawner.radius, spawner.shaped.as_ref()));
    let fed: usize =
        loaded.scene.feed.iter().map(|feed| fed(loaded, feed) * count(&feed.radius, feed.shaped.as_ref())).sum();
    let of_grain = |grain: &GrainRow| {
        grain.posture.and_then(|posture| loaded.shapes.facts_of(posture.shape)).map_or(1, |facts| facts.count)
    };
    let start: usize = loaded.grains.iter().map(of_grain).sum();
    start + released + fed
}

/// Returns the number of grains that a feed will release up to `until`.
fn fed(loaded: &Loaded, feed: &Feed) -> usize {
    let Some(mass) = loaded.scene.mass else { return 0 };
    let by_then = feed.grains_per_second(mass) * loaded.scene.until.get();
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped")]
    let count =
        feed.count(mass).map_or(by_then, |count| count.min(by_then)).clamp(0.0, f64::from(GrainId::MAX_GRAIN)) as usize;
    count
}

/// Returns the time step, s, if it is known: an automatic step without grains is not.
#[must_use]
pub fn known_step(loaded: &Loaded) -> Option<f64> {
    match loaded.scene.step {
        TimeStep::Fixed(dt) => Some(dt.get()),
        TimeStep::Auto { .. } => Estimates::of(loaded).map(|estimates| estimates.dt),
    }
}

/// Returns the outputs of a scene with this step (s).
#[must_use]
#[expect(clippy::cast_precision_loss, reason = "numbers of walls, species and bins")]
pub fn outputs(loaded: &Loaded, dt: f64) -> Vec<Output> {
    let scene = &loaded.scene;
    let species = loaded.largest_species() as f64 + 1.0;
    let flat = scene.walls.iter().filter(|wall| wall.is_surface()).count() as f64;
    let centres = if scene.profiles.is_empty() { 0.0 } else { species };
    let slopes = scene.slopes.len() as f64;
    let mut outputs = vec![Output {
        key: "series.interval".to_owned(),
        interval: scene.series.interval.get() / dt,
        rows: 1.0 + flat + centres + slopes,
        pictures: 0.0,
        bytes: ROW_BYTES[0] + flat * ROW_BYTES[1] + (centres + slopes) * ROW_BYTES[2],
    }];
    for (index, profile) in scene.profiles.iter().enumerate() {
        let rows = f64::from(profile.bins) * (species + 1.0);
        outputs.push(Output {
            key: format!("profiles[{index}].average"),
            interval: profile.average.map_or(f64::INFINITY, Positive::get) / dt,
            rows,
            pictures: 0.0,
            bytes: rows * ROW_BYTES[2],
        });
    }
    for (index, field) in scene.fields.iter().enumerate() {
        let layout = Layout { components: scene.space.count(), species: loaded.field_species() };
        let rows = field.grid.cells() as f64;
        outputs.push(Output {
            key: format!("fields[{index}].average"),
            interval: field.average.map_or(f64::INFINITY, Positive::get) / dt,
            rows,
            pictures: 0.0,
            // Two numbers of up to 25 letters for each mean, and the places.
            bytes: rows * (80.0 + 50.0 * layout.means() as f64),
        });
    }
    for (index, bands) in scene.wall_bands.iter().enumerate() {
        outputs.push(Output {
            key: format!("wall_bands[{index}].average"),
            interval: bands.average.map_or(f64::INFINITY, Positive::get) / dt,
            rows: f64::from(bands.bins),
            pictures: 0.0,
            bytes: f64::from(bands.bins) * ROW_BYTES[2],
        });
    }
    if let Some(pictures) = &scene.pictures {
        let interval = pictures.interval.get();
        let discs = mean_shapes(loaded);
        let png = if pictures.png { PNG_BYTES * pixels(loaded) } else { 0.0 };
        outputs.push(Output {
            key: "pictures.interval".to_owned(),
            interval: interval / dt,
            rows: 0.0,
            pictures: 1.0,
            bytes: PICTURE_BYTES[1] + discs * PICTURE_BYTES[0] + png,
        });
    }
    outputs.extend(frame_data(loaded, dt));
    outputs
}

/// Returns the number of discs of a picture in the middle of the run: with half of the grains that will be released.
#[expect(clippy::cast_precision_loss, reason = "a number of discs")]
fn mean_shapes(loaded: &Loaded) -> f64 {
    let released = loaded.scene.spawner.as_ref().map_or(0.0, |spawner| 0.5 * f64::from(spawner.count));
    (shapes(loaded) as f64 - released).max(0.0)
}

/// Returns the expected bytes of a frame.
fn frame_bytes(loaded: &Loaded, frames: &DataFrames) -> f64 {
    let [grain, contacts] = FRAME_BYTES[loaded.scene.space.count() - 2];
    let each = grain + if frames.contacts { contacts } else { 0.0 };
    let bytes_of = |format: &Format| match format {
        Format::Vtk => FORMAT_BYTES[0],
        Format::ExtXyz | Format::LammpsDump => FORMAT_BYTES[1],
    };
    let each = each + frames.format.iter().map(bytes_of).sum::<f64>();
    FRAME_HEAD_BYTES + mean_shapes(loaded) * each
}

/// Returns the frames of data of a scene with this step (s).
fn frame_data(loaded: &Loaded, dt: f64) -> Option<Output> {
    let (frames, times) = loaded.data_frames()?;
    let key = if frames.interval.is_some() { "data_frames.interval" } else { "pictures.interval" };
    let bytes = frame_bytes(loaded, frames);
    let interval = times.mean_interval(loaded.scene.until.get());
    Some(Output { key: key.to_owned(), interval: interval / dt, rows: 0.0, pictures: 0.0, bytes })
}
