//! Converts SVG snapshots to PNGs beside them.

use std::path::{Path, PathBuf};

use crate::cli::exit_status::ExitStatus;
use crate::cli::{refused, say};
use crate::output::run_directory::{Depth, is_run, refuse_odd};
use crate::writers::png;
use siloflow_text::fault::Fault;

pub(super) fn render(paths: &[PathBuf]) -> Result<ExitStatus, Fault> {
    let pictures = paths.iter().map(|path| pictures(path)).collect::<Result<Vec<_>, _>>()?;
    let mut has_written = false;
    for svg in pictures.iter().flatten() {
        match png::render_file(svg) {
            Ok(png) => say(&format!("{}\n", png.display())),
            Err(fault) => return refused(fault, has_written),
        }
        has_written = true;
    }
    Ok(ExitStatus::Done)
}

/// The SVG files at a path, in order.
fn pictures(path: &Path) -> Result<Vec<PathBuf>, Fault> {
    if !path.is_dir() {
        return Ok(vec![path.to_owned()]);
    }
    let frames = path.join("frames");
    if is_run(path) {
        refuse_odd(path, Depth::Top)?;
    }
    let directory = if frames.is_dir() { frames } else { path.to_owned() };
    let fault = |message: String| {
        Fault::new("render::read", message).help(
            "give SVG files, or run directories; with --at, --every or --movie pictures are drawn from frames.bin",
        )
    };
    let entries = std::fs::read_dir(&directory)
        .map_err(|error| fault(format!("could not read {}: {error}", directory.display())))?;
    let entries = entries.filter_map(Result::ok);
    // A link beside pictures may lead anywhere. A file that the user names may be one.
    let own = entries.filter(|entry| entry.file_type().is_ok_and(|kind| kind.is_file()));
    let mut files: Vec<_> = own.map(|entry| entry.path()).collect();
    files.retain(|file| file.extension().is_some_and(|ending| ending == "svg"));
    files.sort();
    if files.is_empty() {
        return Err(fault(format!("there is no SVG file in {}", directory.display())));
    }
    Ok(files)
}
