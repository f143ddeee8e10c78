//! Converts SVG snapshots to PNGs beside them.

use std::path::{Path, PathBuf};

use crate::cli::exit_status::Verdict;
use crate::cli::{refused, say};
use crate::fault::Fault;
use crate::writers::png;

pub(super) fn render(paths: &[PathBuf]) -> Result<Verdict, Fault> {
    let pictures = paths.iter().map(|path| pictures(path)).collect::<Result<Vec<_>, _>>()?;
    let mut has_written = false;
    for svg in pictures.iter().flatten() {
        match png::render_file(svg) {
            Ok(png) => say(&format!("{}\n", png.display())),
            Err(fault) => return refused(fault, has_written),
        }
        has_written = true;
    }
    Ok(Verdict::Done)
}

/// The SVG files at a path, in order.
fn pictures(path: &Path) -> Result<Vec<PathBuf>, Fault> {
    if !path.is_dir() {
        return Ok(vec![path.to_owned()]);
    }
    let frames = path.join("frames");
    let directory = if frames.is_dir() { frames } else { path.to_owned() };
    let fault = |message: String| {
        Fault::new("render::read", message).help(
            "give SVG files, or run directories; with --at, --every or --movie pictures are drawn from frames.bin",
        )
    };
    let entries = std::fs::read_dir(&directory)
        .map_err(|error| fault(format!("could not read {}: {error}", directory.display())))?;
    let mut files: Vec<_> = entries.filter_map(|entry| Some(entry.ok()?.path())).collect();
    files.retain(|file| file.extension().is_some_and(|ending| ending == "svg"));
    files.sort();
    if files.is_empty() {
        return Err(fault(format!("there is no SVG file in {}", directory.display())));
    }
    Ok(files)
}
