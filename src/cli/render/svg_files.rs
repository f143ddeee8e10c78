//! Converts SVG snapshots to PNGs beside them.

use std::path::{Path, PathBuf};

use crate::cli::exit_status::ExitStatus;
use crate::cli::{refused, say};
use siloflow_figures::png;
use siloflow_files::run_directory::{Depth, is_run, refuse_odd};
use siloflow_files::whole_file;
use siloflow_text::fault::Fault;
use siloflow_text::file;

pub(super) fn render(paths: &[PathBuf]) -> Result<ExitStatus, Fault> {
    let pictures = paths.iter().map(|path| pictures(path)).collect::<Result<Vec<_>, _>>()?;
    let mut has_written = false;
    for svg in pictures.iter().flatten() {
        match render_file(svg) {
            Ok(png) => say(&format!("{}\n", png.display())),
            Err(fault) => return refused(fault, has_written),
        }
        has_written = true;
    }
    Ok(ExitStatus::Done)
}

/// Renders an SVG file to a PNG beside it and returns its path.
///
/// # Errors
/// If the file cannot be read, is not SVG, is beyond the limits, or the PNG cannot be written.
fn render_file(path: &Path) -> Result<PathBuf, Fault> {
    let path_text = path.display();
    let svg = file::read_text(path, file::RESULT_BYTES).map_err(|error| {
        Fault::new("render::read", format!("could not read {path_text}: {error}"))
            .help(file::remedy(&error, "give SVG files, or run directories"))
    })?;
    let drawn = png::encode_within(svg, png::LONGEST_DRAWING).map_err(|error| {
        Fault::new("render::svg", format!("could not draw {path_text}: {error}"))
            .help("is it an SVG picture of siloflow?")
    })?;
    let target = path.with_extension("png");
    whole_file::write(&target, &drawn).map_err(|error| {
        Fault::new("render::write", format!("could not write {}: {error}", target.display()))
            .help("check free disk space and write permission")
    })?;
    Ok(target)
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
