//! The run directory as a resource, for behaviours that write files of their own.

use std::path::{Path, PathBuf};

use bevy_ecs::prelude::*;

use siloflow_files::growing::OutputPlace;
use siloflow_files::run_directory::RunDirectory;
use siloflow_files::run_files::RunFiles;

/// The run directory of a run of the command line. A simulation that a program builds by itself has none.
///
/// A behaviour declares its files with [`run_file`](crate::measure::outputs::OutputApp::run_file), so that a later run in the
/// same place removes them together with siloflow's own. Files of other names are kept, because they may belong to somebody else.
///
/// ```
/// use siloflow::prelude::*;
///
/// fn write_hottest(run: Option<Res<RunPath>>, mut outcome: ResMut<Outcome>) {
///     let Some(run) = run else { return };
///     // Complete or absent, also if the disk is full.
///     let written = siloflow::files::whole_file::write(&run.file("hottest.txt"), b"412 K\n");
///     if let Err(error) = written {
///         outcome.fail(Failure::Output { path: "hottest.txt".to_owned(), reason: error.to_string() });
///     }
/// }
///
/// # fn build(app: &mut App) {
/// app.run_file("hottest.txt");
/// # }
/// ```
///
/// The path changes once, after step zero: ask for it each time. An open file stays valid. A run that is resumed finds the file as
/// the interrupted run left it, which may be later than the checkpoint: [`Rows`](crate::writers::rows::Rows) has `saved` and
/// `restore` for files that grow, and [`RunPath::rows`] is their place. A checkpoint and the summary bring all declared files to the
/// disk before they get their names.
#[derive(Resource, Clone, Debug)]
pub struct RunPath {
    pub(crate) now: PathBuf,
    /// Whether an interrupted run is continued, so that its files exist.
    pub is_resumed: bool,
    pub(crate) files: RunFiles,
}

impl RunPath {
    /// The resource for behaviours that write into this directory as it is now.
    #[must_use]
    pub fn of(directory: &RunDirectory) -> Self {
        Self {
            now: directory.current().to_owned(),
            is_resumed: directory.is_continued(),
            files: directory.files().clone(),
        }
    }

    /// The directory, as it is now.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.now
    }

    /// The place of a file of [`Rows`](crate::writers::rows::Rows) in the directory. Its rows are hashed as they are written, so that a
    /// resume and `siloflow verify` find out if they have changed.
    #[must_use]
    pub fn rows(&self, name: &str) -> OutputPlace {
        OutputPlace { path: self.file(name), is_continued: self.is_resumed, files: self.files.clone() }
    }

    /// The path of a file in the directory.
    #[must_use]
    pub fn file(&self, name: &str) -> PathBuf {
        self.now.join(name)
    }
}
