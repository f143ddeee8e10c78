//! `siloflow new`: writes a scene to begin with. `siloflow scenes`: lists the scenes that come with the program.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use clap::Args;

use crate::cli::exit_status::ExitStatus;
use crate::cli::say;
use crate::scene::shipped::{self, SCENES, Shipped};
use siloflow_files::whole_file;
use siloflow_text::fault::Fault;
use siloflow_text::suggestion::did_you_mean;

/// Arguments of `new`.
#[derive(Args, Debug)]
#[command(after_help = "\
  siloflow new bin                      # writes bin.ron: a commented silo in the plane
  siloflow run bin.ron --report
  siloflow new tower --from round-silo  # a copy of a shipped scene, see `siloflow scenes`")]
pub(super) struct NewArgs {
    /// The scene file to write, with or without its ending .ron. It must not exist.
    name: PathBuf,
    /// Copy a shipped scene, with the file that it names, instead of the commented silo.
    #[arg(long, value_name = "SCENE")]
    from: Option<String>,
}

pub(super) fn new(args: &NewArgs) -> Result<ExitStatus, Fault> {
    let (directory, stem) = place(&args.name)?;
    let files = match &args.from {
        None => vec![shipped::template(&format!("{stem}.ron"))],
        Some(name) => shipped_scene(name)?.copy(&stem),
    };
    let paths: Vec<_> = files.iter().map(|file| directory.join(&file.0)).collect();
    if let Some(existing) = paths.iter().find(|path| path.symlink_metadata().is_ok()) {
        return Err(Fault::new("new::exists", format!("{} exists", existing.display())).help("choose another name"));
    }
    // The scene comes last, so that it never stands without its file.
    for (path, (_, content)) in paths.iter().zip(&files).rev() {
        if let Err(error) = whole_file::write(path, content.as_bytes()) {
            for written in &paths {
                let _ = whole_file::remove_if_there(written);
            }
            return Err(Fault::new("new::write", format!("could not write {}: {error}", path.display()))
                .help("does its directory exist, and may you write there?"));
        }
    }
    let scene = paths[0].display();
    say(&format!("wrote {scene}\nnext:  siloflow check {scene}\n       siloflow run {scene} --report\n"));
    Ok(ExitStatus::Done)
}

/// Returns the directory of a new scene, and its name without the ending.
fn place(path: &Path) -> Result<(PathBuf, String), Fault> {
    let fault = |why: &str| {
        Fault::new("new::name", format!("`{}` is no name of a scene: {why}", path.display()))
            .help("give a name such as my-silo")
    };
    let name = path.file_name().ok_or_else(|| fault("it has no last part"))?;
    let name = name.to_str().ok_or_else(|| fault("it is not UTF-8"))?;
    let stem = name.strip_suffix(".ron").unwrap_or(name);
    if stem.is_empty() || stem.starts_with('-') || stem.contains(char::is_control) {
        return Err(fault("a name begins with a letter or digit"));
    }
    Ok((path.parent().unwrap_or(Path::new("")).to_owned(), stem.to_owned()))
}

fn shipped_scene(name: &str) -> Result<&'static Shipped, Fault> {
    let name = name.strip_suffix(".ron").unwrap_or(name);
    Shipped::named(name).ok_or_else(|| {
        let names: Vec<_> = SCENES.iter().map(|scene| scene.name).collect();
        Fault::new("new::unknown_scene", format!("there is no shipped scene `{name}`"))
            .help(did_you_mean("scenes", name, &names))
    })
}

pub(super) fn scenes() -> ExitStatus {
    let mut text = String::new();
    for scene in &SCENES {
        // Writing to a string cannot fail.
        let _ = writeln!(text, "{:<19} {}", scene.name, scene.line);
    }
    say(&format!(
        "{text}\nsiloflow new my-silo --from silo1  copies a scene. In a clone of the repository they are in scenes/.\n"
    ));
    ExitStatus::Done
}
