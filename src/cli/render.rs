//! `siloflow render`: converts SVG snapshots to PNG.

use std::path::{Path, PathBuf};

use clap::Args;

use crate::cli::exit_status::Verdict;
use crate::cli::{refused, say};
use crate::fault::Fault;
use crate::writers::png;

/// Arguments of `render`.
#[derive(Args, Debug)]
pub(super) struct RenderArgs {
    /// SVG files, directories of them, or run directories.
    #[arg(required = true)]
    paths: Vec<PathBuf>,
    /// Write PNG. It is the only format, so this changes nothing.
    #[arg(long)]
    png: bool,
}

pub(super) fn render(args: &RenderArgs) -> Result<Verdict, Fault> {
    let pictures = args.paths.iter().map(|path| pictures(path)).collect::<Result<Vec<_>, _>>()?;
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
    let fault = |message: String| Fault::new("render::read", message).help("give SVG files, or run directories");
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
