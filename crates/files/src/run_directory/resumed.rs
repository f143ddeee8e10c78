//! The files of a run that is resumed: compared with the record in its checkpoint, and set aside if they are damaged.

use std::io;
use std::path::Path;

use super::RunDirectory;
use super::integrity::{Moment, problem};
use crate::disk;
use crate::run_directory::names::{DAMAGED, FRAMES, VTK};
use crate::run_files::{Damage, Manifest};
use siloflow_text::fault::Fault;

/// Largest number of damaged files that a message names.
const MOST_NAMED: usize = 10;

/// Most copies of one damaged file.
const MOST_COPIES: u32 = 1000;

impl RunDirectory {
    /// Continues the record of a checkpoint that was taken after `steps` steps. With `accepts_damage` damaged files are set aside:
    /// they get the ending `.damaged`, and the run begins new ones.
    ///
    /// # Errors
    /// If a file is missing or has changed, and `accepts_damage` is false; nothing is then changed. If a damaged file cannot be set
    /// aside.
    pub fn continue_from(&self, mut manifest: Manifest, steps: u64, accepts_damage: bool) -> Result<(), Fault> {
        let now = self.current();
        let mut damage = Vec::new();
        for file in &manifest.files {
            let what = problem(now, file, Moment::Checkpoint);
            damage.extend(what.map(|what| Damage { file: file.name.clone(), what, steps }));
        }
        if !damage.is_empty() && !accepts_damage {
            return Err(damaged(self.path(), &damage));
        }
        for Damage { file, what, .. } in &damage {
            set_aside(now, file).map_err(|error| {
                Fault::new("run::damaged", format!("{file} {what}, and could not be set aside: {error}"))
                    .help("move it out of the run directory")
            })?;
            tracing::warn!("{file} {what}; the run goes on without it");
        }
        manifest.files.retain(|file| damage.iter().all(|damage| damage.file != file.name));
        manifest.damage.extend(damage);
        self.files().continue_from(manifest);
        Ok(())
    }
}

fn damaged(run: &Path, damage: &[Damage]) -> Fault {
    let mut words: Vec<_> =
        damage.iter().take(MOST_NAMED).map(|Damage { file, what, .. }| format!("{file} {what}")).collect();
    if damage.len() > MOST_NAMED {
        words.push(format!("and {} more files", damage.len() - MOST_NAMED));
    }
    let run = run.display();
    let message = format!("files of {run} are not as the run left them: {}", words.join("; "));
    Fault::new("run::damaged", message).help(format!(
        "bring them back from a copy, or go on without them with `siloflow run --resume {run} --accept-damage`: what is left of \
         them is kept as NAME.{DAMAGED}, nothing in them is computed again, and the summary names them"
    ))
}

/// Gives what is left of a damaged file another name.
fn set_aside(run: &Path, name: &str) -> io::Result<()> {
    let path = run.join(name);
    let directory = Path::new(name).parent().unwrap_or(Path::new(""));
    if [FRAMES, VTK].into_iter().any(|own| directory == Path::new(own)) {
        match std::fs::symlink_metadata(run.join(directory)) {
            Ok(found) if !found.is_dir() => {
                return Err(io::Error::other(format!("{} is no directory", directory.display())));
            }
            Ok(_) => {}
            // The run will write more files there.
            Err(error) if error.kind() == io::ErrorKind::NotFound => disk::create_directory(&run.join(directory))?,
            Err(error) => return Err(error),
        }
    }
    if path.symlink_metadata().is_err() {
        return Ok(());
    }
    let ending = |number: u32| if number == 1 { DAMAGED.to_owned() } else { format!("{DAMAGED}-{number}") };
    let places = (1..=MOST_COPIES).map(|number| path.with_added_extension(ending(number)));
    let free = places.into_iter().find(|place| place.symlink_metadata().is_err());
    disk::rename(&path, &free.ok_or_else(|| io::Error::other("there are too many damaged files of this name"))?)
}
