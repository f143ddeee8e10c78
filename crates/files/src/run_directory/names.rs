//! Names in a run directory: of results, of copies of input, of checkpoints; and which files are siloflow's own, so that a later run
//! in the same place removes them.

use std::ffi::OsStr;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use crate::fnv::Fnv;
use crate::own_files;
use crate::run_directory::marker::MARKER;
use crate::whole_file::{PART, remove_if_there};

/// The scene, with all settings applied.
pub const SCENE: &str = "scene.ron";
/// Totals over time.
pub const SERIES: &str = "series.csv";
/// Directory of the pictures of a run.
pub const FRAMES: &str = "frames";
/// Frames of data.
pub const FRAME_DATA: &str = "frames.bin";
/// Directory of the frames for ParaView.
pub const VTK: &str = "vtk";
/// Pictures and a movie of `siloflow render`.
pub const PICTURES: &str = "pictures";
/// The movie of `siloflow render`.
pub const MOVIE: &str = "movie.png";
/// Figures of `siloflow plot`.
pub const PLOTS: &str = "plots";
/// Directory of the checkpoints.
pub const CHECKPOINTS: &str = "checkpoints";
const CHECKPOINT_ENDING: &str = "checkpoint";
/// Forces on walls.
pub const WALLS: &str = "walls.csv";
/// Forces on all walls of one name.
pub const WALL_GROUPS: &str = "wall_groups.csv";
/// Walls that forces move.
pub const FREE_WALLS: &str = "free_walls.csv";
/// Pressure and friction on walls by height.
pub const WALL_BANDS: &str = "wall_bands.csv";
/// Profiles along an axis.
pub const PROFILES: &str = "profiles.csv";
/// Centres of grains in sections of profiles.
pub const CENTRES: &str = "centres.csv";
/// Fields of density, velocity and stress.
pub const FIELDS: &str = "fields.csv";
/// Slopes of the free surface.
pub const SLOPES: &str = "slopes.csv";
/// The flow field.
pub const FLOW: &str = "flow.csv";
/// Lost grains.
pub const LOSSES: &str = "losses.csv";
/// The final grains.
pub const STATE: &str = "state.csv";
/// The summary.
pub const SUMMARY: &str = "summary.json";
/// The report.
pub const REPORT: &str = "report.html";
/// Hashes of all files of a run that is over.
pub const HASHES: &str = "hashes.txt";
/// Ending of what is left of a damaged file; `.damaged-2` and so on if there are several.
pub const DAMAGED: &str = "damaged";
/// Names of all files that a run writes at the top of its directory.
const OWN_FILES: [&str; 19] = [
    MOVIE,
    SERIES,
    FRAME_DATA,
    "frames.xyz",
    "frames.dump",
    WALLS,
    WALL_GROUPS,
    FREE_WALLS,
    WALL_BANDS,
    PROFILES,
    CENTRES,
    FIELDS,
    SLOPES,
    FLOW,
    LOSSES,
    STATE,
    SUMMARY,
    REPORT,
    HASHES,
];

/// Names of the files that hold the input of a run, without those of meshes and motions.
const INPUT_FILES: [&str; 4] = [SCENE, "input-silo.dat", "input-grains.csv", "input-contacts.csv"];
const MESH_START: &str = "input-wall-";
const TABLE_START: &str = "input-motion-";

/// Returns the name of the copy of the input file `from` that the scene key `key` names.
pub(super) fn copy_name(key: &str, from: &Path) -> String {
    let name = match key {
        "silo.file" => "input-silo.dat",
        "grains.contacts" => "input-contacts.csv",
        "grains.file" => "input-grains.csv",
        _ if key.starts_with("motions") => {
            // The table of a motion: `motions[3].rotate.by.file`.
            let number: String = key.chars().filter(char::is_ascii_digit).collect();
            let course = if key.contains("rotate") { "rotate" } else { "translate" };
            return format!("{TABLE_START}{number}-{course}.csv");
        }
        _ => {
            // The mesh of a wall: `walls[3].file`.
            let number: String = key.chars().filter(char::is_ascii_digit).collect();
            let ending = from.extension().unwrap_or_default().to_ascii_lowercase();
            return format!("{MESH_START}{number}.{}", ending.display());
        }
    };
    name.to_owned()
}

/// Whether a file of this name at the top of a run directory holds input.
pub(super) fn is_input(name: &str) -> bool {
    let is_numbered = |rest: &str, endings: &[&str]| {
        let number = endings.iter().find_map(|ending| rest.strip_suffix(ending));
        number.is_some_and(|number| !number.is_empty() && number.bytes().all(|byte| byte.is_ascii_digit()))
    };
    INPUT_FILES.contains(&name)
        || name.strip_prefix(MESH_START).is_some_and(|rest| is_numbered(rest, &[".stl", ".obj"]))
        || name.strip_prefix(TABLE_START).is_some_and(|rest| is_numbered(rest, &["-translate.csv", "-rotate.csv"]))
}

/// Returns the path of the scene in a run directory.
#[must_use]
pub fn scene_of(run: &Path) -> PathBuf {
    run.join(SCENE)
}

/// Whether a directory looks like one of a run: it has a scene, or what only a run makes.
#[must_use]
pub fn is_run(directory: &Path) -> bool {
    [SCENE, SERIES, MARKER].iter().any(|name| directory.join(name).symlink_metadata().is_ok())
}

/// Returns the path of the summary in a run directory.
#[must_use]
pub fn summary_of(run: &Path) -> PathBuf {
    run.join(SUMMARY)
}

/// Returns the hash of the scene in a run directory and of the copies of the files that it names.
///
/// # Errors
/// If a file cannot be read.
pub fn hash_of_input(run: &Path) -> io::Result<u64> {
    let mut names = Vec::new();
    for entry in fs::read_dir(run)? {
        names.extend(entry?.file_name().into_string().ok().filter(|name| is_input(name)));
    }
    names.sort_unstable();
    let mut hash = Fnv::default();
    for name in names {
        hash.update(name.as_bytes());
        let failed = |error| with_name(&name, &error);
        hash.update_from(own_files::read(&run.join(&name)).map_err(failed)?).map_err(failed)?;
    }
    Ok(hash.value())
}

fn with_name(name: &str, error: &io::Error) -> io::Error {
    io::Error::new(error.kind(), format!("{name}: {error}"))
}

/// Returns the path of the frames of data in a run directory.
#[must_use]
pub fn frame_data_of(run: &Path) -> PathBuf {
    run.join(FRAME_DATA)
}

/// Returns the path of the report in a run directory.
#[must_use]
pub fn report_of(run: &Path) -> PathBuf {
    run.join(REPORT)
}

/// Returns the names, without ending, of siloflow's CSV files in a run directory, and their paths.
#[must_use]
pub fn tables_of(run: &Path) -> Vec<(&'static str, PathBuf)> {
    let names = OWN_FILES.iter().filter_map(|name| Some((name.strip_suffix(".csv")?, run.join(name))));
    names.filter(|(_, path)| own_files::is_file(path)).collect()
}

/// Returns the directory of the checkpoints in a run directory.
#[must_use]
pub fn checkpoints_directory(run: &Path) -> PathBuf {
    run.join(CHECKPOINTS)
}

/// Returns the name of the checkpoint after a number of steps. Names sort in the order of steps.
#[must_use]
pub fn checkpoint_name(steps: u64) -> String {
    format!("{steps:016}.{CHECKPOINT_ENDING}")
}

/// Whether a checkpoint may have this name.
pub(super) fn is_checkpoint(name: &Path) -> bool {
    let number = name.file_stem().unwrap_or_default().as_encoded_bytes();
    name.extension().is_some_and(|ending| ending == CHECKPOINT_ENDING)
        && number.len() >= 16
        && number.iter().all(u8::is_ascii_digit)
}

/// Returns the checkpoints in a directory, the latest first. Links and other files are left out.
///
/// # Errors
/// If the directory cannot be read; a missing one is empty.
pub fn checkpoints_in(directory: &Path) -> io::Result<Vec<PathBuf>> {
    let entries = match own_files::entries(directory) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(Vec::new()),
        entries => entries?,
    };
    let mut paths = Vec::new();
    for entry in entries {
        let entry = entry?;
        if entry.file_type()?.is_file() && is_checkpoint(Path::new(&entry.file_name())) {
            paths.push(entry.path());
        }
    }
    paths.sort_unstable_by(|a, b| b.cmp(a));
    Ok(paths)
}

/// Removes checkpoints that a killed process has left incomplete.
///
/// # Errors
/// If the directory cannot be read, or a file cannot be removed.
pub fn remove_incomplete_checkpoints(directory: &Path) -> io::Result<()> {
    for entry in own_files::entries(directory)? {
        let path = entry?.path();
        let is_part = path.extension().is_some_and(|ending| ending == PART);
        if is_part && is_checkpoint(Path::new(path.file_stem().unwrap_or_default())) {
            remove_if_there(&path)?;
        }
    }
    Ok(())
}

/// Whether siloflow writes a file of this name in the directory `vtk`.
fn is_vtk(name: &Path) -> bool {
    let name = name.to_str().unwrap_or_default();
    let (kind, rest) = name.split_once(['-', '.']).unwrap_or_default();
    let number = rest.strip_suffix(".vtp").unwrap_or_default();
    let is_frame = number.len() >= 5 && number.bytes().all(|byte| byte.is_ascii_digit());
    ["grains", "contacts", "walls"].contains(&kind) && (is_frame || rest == "pvd")
}

/// Whether a file of this name in `plots` is a figure: named after a column, as SVG or PNG.
fn is_plot(name: &Path) -> bool {
    let name = name.to_str().unwrap_or_default();
    let stem = name.strip_suffix(".svg").or(name.strip_suffix(".png")).unwrap_or_default();
    !stem.is_empty() && stem.bytes().all(|byte| byte.is_ascii_lowercase() || byte.is_ascii_digit() || byte == b'_')
}

/// Whether a file of this name in `pictures` is a picture of a time: `t_01.50.png`.
fn is_picture(name: &Path) -> bool {
    let time = name.to_str().and_then(|name| name.strip_prefix("t_")?.strip_suffix(".png")).unwrap_or_default();
    !time.is_empty() && time.bytes().all(|byte| byte.is_ascii_digit() || byte == b'.')
}

/// Returns the directory of pictures that are drawn after a run.
#[must_use]
pub fn pictures_of(run: &Path) -> PathBuf {
    run.join(PICTURES)
}

/// Returns the path of a run's movie.
#[must_use]
pub fn movie_of(run: &Path) -> PathBuf {
    run.join(MOVIE)
}

/// Whether `path` is a picture file, or a directory with pictures of times and nothing else.
#[must_use]
pub fn is_drawn(path: &Path) -> bool {
    let Ok(entries) = fs::read_dir(path) else {
        let is_picture = path.extension().is_some_and(|ending| ["png", "svg", "apng"].iter().any(|own| ending == *own));
        return is_picture && !path.is_dir();
    };
    let mut entries = entries;
    // A process that was killed may leave the marker in a whole directory.
    entries
        .all(|entry| entry.is_ok_and(|entry| is_picture(Path::new(&entry.file_name())) || entry.file_name() == MARKER))
}

/// Directories of results whose files have names of one pattern.
const DIRECTORIES: [(&str, fn(&Path) -> bool); 6] = [
    (CHECKPOINTS, is_checkpoint),
    (VTK, is_vtk),
    (PLOTS, is_plot),
    (PICTURES, is_picture),
    ("csv", |name| is_exported_table(name, "csv")),
    ("parquet", |name| is_exported_table(name, "parquet")),
];

/// Directories that are filled as `NAME.part` before they get their names.
const FILLED_AS_PART: [&str; 4] = [VTK, PICTURES, "csv", "parquet"];

/// The start of names of directories in which `siloflow plot` prepares its figures, before they become [`PLOTS`].
const PLOTS_STAGE: &str = ".plots.siloflow-";

/// Returns which files siloflow makes in its directory `directory` at the top of a run directory, complete or not; `None` if it makes no
/// such directory. `frames` is another matter.
pub(super) fn content_of(directory: &str) -> Option<fn(&Path) -> bool> {
    let of_part = directory.strip_suffix(PART).and_then(|name| name.strip_suffix('.'));
    let complete = match of_part.filter(|name| FILLED_AS_PART.contains(name)) {
        Some(complete) => complete,
        None if directory.starts_with(PLOTS_STAGE) => PLOTS,
        None => directory,
    };
    DIRECTORIES.iter().find_map(|(own, is_file)| (*own == complete).then_some(*is_file))
}

/// Whether siloflow makes a directory of this name, and no file, at the top of a run directory.
pub(super) fn is_directory(name: &Path) -> bool {
    name == Path::new(FRAMES) || name.to_str().is_some_and(|name| content_of(name).is_some())
}

/// Returns a name without the ending of temporary or damaged files.
pub(super) fn completed(name: &Path) -> &Path {
    if name.extension().is_some_and(is_added) { Path::new(name.file_stem().unwrap_or_default()) } else { name }
}

/// Whether `siloflow export` writes a table of this name, with this ending.
fn is_exported_table(name: &Path, ending: &str) -> bool {
    let stem = name.file_stem().and_then(|stem| stem.to_str()).unwrap_or_default();
    let is_of_frames = ["grains", "contacts", "wall_contacts"].contains(&stem);
    let is_of_run = ending == "parquet" && OWN_FILES.iter().any(|own| own.strip_suffix(".csv") == Some(stem));
    name.extension().is_some_and(|found| found == ending) && (is_of_frames || is_of_run)
}

/// Whether siloflow adds this ending to names of its own: to incomplete and to damaged files.
fn is_added(ending: &OsStr) -> bool {
    let number = ending.to_str().and_then(|ending| ending.strip_prefix(DAMAGED)?.strip_prefix('-'));
    ending == PART || ending == DAMAGED || number.is_some_and(|number| number.parse::<u32>().is_ok())
}

/// Whether siloflow writes a file or directory of this path in a run directory.
pub(super) fn is_own(path: &Path) -> bool {
    let mut parts = path.components().map(|part| Path::new(part.as_os_str()));
    match (parts.next(), parts.next(), parts.next()) {
        (Some(top), None, _) => {
            let is_file = |name: &str| OWN_FILES.contains(&name) || is_input(name);
            is_directory(top) || completed(top).to_str().is_some_and(is_file)
        }
        (Some(top), Some(inside), None) if top == Path::new(FRAMES) => is_frame(completed(inside)),
        (Some(top), Some(inside), None) => {
            let is_file = top.to_str().and_then(content_of);
            // A process that was killed may leave the marker in a directory that it filled.
            is_file.is_some_and(|is_file| is_file(completed(inside)) || inside == Path::new(MARKER))
        }
        _ => false,
    }
}

/// Whether a file of this name in `frames` is a picture of a run.
fn is_frame(name: &Path) -> bool {
    let number = name.file_stem().unwrap_or_default().as_encoded_bytes();
    let is_picture = name.extension().is_some_and(|ending| ending == "svg" || ending == "png");
    is_picture && number.len() >= 5 && number.iter().all(u8::is_ascii_digit)
}

/// Whether a behaviour may not have a file of this name at the top of a run directory.
#[must_use]
pub fn is_reserved(name: &str) -> bool {
    is_own(Path::new(name)) || name.ends_with(&format!(".{PART}"))
}
