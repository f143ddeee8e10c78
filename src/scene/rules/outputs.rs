//! Rules on what a run writes: the size of pictures, and how often it writes rows and pictures.

use crate::scene::expected;
use crate::scene::loaded::Loaded;
use crate::scene::outputs::{Colour, Pictures};
use crate::writers::volume;
use siloflow_dem::space::Dimension;
use siloflow_dem::values::Positive;
use siloflow_dem::walls::config::shape::WallShape;
use siloflow_figures::png::{IS_AVAILABLE, MOST_PIXELS, MOST_SHAPES};
use siloflow_results::pictures::camera::Direction;
use siloflow_text::fault::Fault;

/// Most bins of all profiles, each counted for every species: their sums take about 100 B a bin.
const MOST_BINS: usize = 5_000_000;

/// A PNG must not have too many pixels, nor too many shapes.
pub(super) fn pictures(loaded: &Loaded) -> Result<(), Fault> {
    let Some(pictures) = &loaded.scene.pictures else { return Ok(()) };
    if !(50.0..=20_000.0).contains(&pictures.width.get()) {
        return Err(loaded
            .fault("scene::out_of_range", "pictures.width", "expected a width of 50 to 20000 px")
            .help("600 is a good width"));
    }
    colour(loaded, &pictures.colour)?;
    direction(loaded, pictures)?;
    if !pictures.png {
        return Ok(());
    }
    if !IS_AVAILABLE {
        return Err(loaded
            .fault("scene::no_png", "pictures.png", "this program was built without PNG")
            .help("write SVG only with `png: false`, or build with the feature `png`"));
    }
    let pixels = expected::pixels(loaded);
    // A view without a size has no number of pixels.
    if pixels.is_nan() || pixels > MOST_PIXELS {
        let message =
            format!("a picture would have {pixels:.2e} pixels, more than the limit of {MOST_PIXELS:e} for PNG");
        return Err(loaded
            .fault("scene::out_of_range", "pictures.width", message)
            .help("lower the width, give a `view`, or write SVG only with `png: false`"));
    }
    let shapes = expected::shapes(loaded);
    if shapes > MOST_SHAPES {
        let message = format!("a picture may have {shapes} discs, more than the limit of {MOST_SHAPES} for PNG");
        return Err(loaded
            .fault("scene::out_of_range", "pictures.png", message)
            .help("write SVG only with `png: false`"));
    }
    Ok(())
}

/// A column that colours grains must be one that frames have. Behaviours may register more, which their names show only in a run.
fn colour(loaded: &Loaded, colour: &Colour) -> Result<(), Fault> {
    let Colour::Column(name, low, high) = colour else { return Ok(()) };
    if low.get() >= high.get() {
        return Err(loaded
            .fault("scene::out_of_range", "pictures.colour", "the scale must begin below its end")
            .help("give both ends, for example `Column(\"radius\", 0.03, 0.04)`"));
    }
    if name == Colour::INCLINATION && loaded.shapes.is_empty() {
        return Err(loaded
            .fault("scene::no_such_column", "pictures.colour", "spheres and discs have no inclination")
            .help("give the grains a shape with `shapes`, or choose another column"));
    }
    if loaded.scene.behaviours.is_empty() && !Colour::COLUMNS.contains(&name.as_str()) {
        return Err(loaded
            .fault("scene::no_such_column", "pictures.colour", format!("grains have no column `{name}` of one number"))
            .help(format!("the columns are {}; behaviours may register others", Colour::COLUMNS.join(", "))));
    }
    Ok(())
}

/// Only solid space has directions.
fn direction(loaded: &Loaded, pictures: &Pictures) -> Result<(), Fault> {
    if !pictures.direction.is_valid() {
        return Err(loaded
            .fault("scene::out_of_range", "pictures.direction", "the vector has no direction")
            .help("give a vector with a length, for example `Towards(1.0, 2.0, -1.0)`"));
    }
    let key = match (pictures.direction, pictures.cut) {
        (Direction::Front, None) => return Ok(()),
        (Direction::Front, Some(_)) => "pictures.cut",
        _ => "pictures.direction",
    };
    if loaded.scene.space == Dimension::Plane {
        return Err(loaded
            .fault("scene::dimension", key, "a plane has no depth")
            .help("remove this key; it is for `space: Solid`"));
    }
    Ok(())
}

/// Frames that the scene asks for need a time between them.
pub(super) fn data_frames(loaded: &Loaded) -> Result<(), Fault> {
    let is_asked = loaded.source.value_of("data_frames").is_some() && loaded.scene.data_frames.is_some();
    if is_asked && loaded.data_frames().is_none() {
        return Err(loaded
            .fault("scene::missing_key", "data_frames", "a scene without pictures needs the time between frames")
            .help("give `interval`, in s, for example `data_frames: (interval: 0.1)`"));
    }
    let formats = loaded.scene.data_frames.iter().flat_map(|frames| frames.format.iter().enumerate());
    let mut all = formats.clone();
    if let Some((_, format)) =
        all.find(|(place, format)| formats.clone().any(|(other, same)| other < *place && same == *format))
    {
        let message = format!("`{format:?}` stands there twice");
        return Err(loaded
            .fault("scene::duplicate", "data_frames.format", message)
            .help("give each of Vtk, ExtXyz and LammpsDump at most once"));
    }
    Ok(())
}

/// Nothing is written more often than the run makes steps, and not too much within the first steps of a run.
pub(super) fn volume(loaded: &Loaded) -> Result<(), Fault> {
    let Some(dt) = expected::known_step(loaded) else { return Ok(()) };
    for (key, interval) in intervals(loaded) {
        // Rounding, and a step that was lowered a little, are no errors.
        if interval < 0.5 * dt {
            let message =
                format!("{interval:e} s is shorter than the step of {dt:e} s, and nothing happens between two steps");
            return Err(loaded
                .fault("scene::out_of_range", &key, message)
                .help("give at least the step, for one row, picture or frame in each step"));
        }
    }
    let mut outputs = expected::outputs(loaded, dt);
    // A default interval that does not fit a long step is no error of the scene.
    outputs.retain(|output| output.key != "pictures.interval" || loaded.source.value_of(&output.key).is_some());
    if let Some((key, message)) = volume::excess(&outputs, loaded.scene.until.get() / dt) {
        return Err(loaded.fault("scene::too_much_output", key, message).help("give a longer time"));
    }
    Ok(())
}

/// The intervals (s) that stand in the scene, with their keys.
fn intervals(loaded: &Loaded) -> Vec<(String, f64)> {
    let scene = &loaded.scene;
    let mut all = vec![("series.interval".to_owned(), scene.series.interval)];
    all.extend(scene.pictures.iter().map(|pictures| ("pictures.interval".to_owned(), pictures.interval)));
    let frames = scene.data_frames.iter().filter_map(|frames| frames.interval);
    all.extend(frames.map(|interval| ("data_frames.interval".to_owned(), interval)));
    all.extend(scene.flow.iter().map(|flow| ("flow.sample".to_owned(), flow.sample)));
    let profiles = scene.profiles.iter().enumerate();
    all.extend(profiles.map(|(index, profile)| (format!("profiles[{index}].sample"), profile.sample)));
    let fields = scene.fields.iter().enumerate();
    all.extend(fields.map(|(index, field)| (format!("fields[{index}].sample"), field.sample)));
    all.retain(|(key, _)| loaded.source.value_of(key).is_some());
    all.into_iter().map(|(key, interval): (String, Positive)| (key, interval.get())).collect()
}

/// All bins are kept in memory.
pub(super) fn bins(loaded: &Loaded) -> Result<(), Fault> {
    let species = loaded.largest_species().saturating_add(2);
    let mut total: usize = 0;
    for (index, profile) in loaded.scene.profiles.iter().enumerate() {
        total = total.saturating_add(species.saturating_mul(usize::from(profile.bins)));
        if total > MOST_BINS {
            let message = format!(
                "with these bins all profiles have {total} bins of all species, more than the limit of {MOST_BINS}"
            );
            return Err(loaded
                .fault("scene::out_of_range", &format!("profiles[{index}].bins"), message)
                .help("give fewer bins or profiles"));
        }
    }
    Ok(())
}

/// Bands need walls with ends, and bins.
pub(super) fn wall_bands(loaded: &Loaded) -> Result<(), Fault> {
    for (index, bands) in loaded.scene.wall_bands.iter().enumerate() {
        let mut walls = loaded.scene.walls.iter().filter(|wall| wall.name() == Some(&bands.walls));
        if walls.clone().next().is_none() {
            return Err(loaded
                .fault(
                    "scene::no_such_wall",
                    &format!("wall_bands[{index}].walls"),
                    format!("no wall has the name {:?}", bands.walls),
                )
                .help(loaded.help_for_wall(&bands.walls)));
        }
        let (code, key, message, help) = if walls.any(|wall| matches!(wall.shape, WallShape::HalfPlane { .. })) {
            let message = format!("a half-plane named {:?} has no ends, so its area is not known", bands.walls);
            ("scene::no_ends", "walls", message, "use a segment, in solid space a panel")
        } else if bands.low.get() >= bands.high.get() {
            (
                "scene::empty_box",
                "high",
                "the first bin must begin below the end of the last one".to_owned(),
                "give heights in m",
            )
        } else if !(1..=10_000).contains(&bands.bins) {
            (
                "scene::out_of_range",
                "bins",
                "expected 1 to 10000 bins".to_owned(),
                "bins divide the height from `low` to `high`",
            )
        } else {
            continue;
        };
        return Err(loaded.fault(code, &format!("wall_bands[{index}].{key}"), message).help(help));
    }
    Ok(())
}
