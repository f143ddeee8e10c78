//! Finds the checkpoint from which a run continues.

use std::path::{Path, PathBuf};

use crate::output::checkpoint::file::{self, Checkpoint, FORMAT, Header, Packed};
use crate::output::checkpoint::hash_of_program;
use crate::scene::extent::most_bytes_of_file;
use crate::scene::loaded::AnyScene;
use siloflow_files::run_directory::{checkpoints_directory, checkpoints_in, hash_of_input};
use siloflow_text::fault::Fault;

/// A checkpoint that fits its run, and its path.
#[derive(Debug)]
pub struct Found {
    path: PathBuf,
    packed: Packed,
}

impl Found {
    /// Facts about it.
    #[must_use]
    pub fn header(&self) -> &Header {
        &self.packed.header
    }

    /// The checkpoint, unread.
    pub(crate) fn into_packed(self) -> Packed {
        self.packed
    }

    /// Reads its state, as far as `scene` can need it.
    ///
    /// # Errors
    /// If it takes more, or is none.
    pub fn read(self, scene: &AnyScene) -> Result<Checkpoint, Fault> {
        let most = most_bytes_of_file(scene, self.packed.length);
        self.packed.unpack(most).map_err(|error| {
            Fault::new("checkpoint::refused", format!("{} is refused: {error}", self.path.display()))
                .help("no run of this scene has written it; start the run again with `siloflow run`")
        })
    }
}

/// Returns the latest checkpoint in the run directory `run` whose hash is right.
///
/// # Errors
/// * There is none, or none can be read.
/// * It belongs to another version, or the scene or a file that the scene names has changed since.
pub fn latest(run: &Path) -> Result<Found, Fault> {
    let fault = |message: String| Fault::new("checkpoint::none", message);
    let paths = checkpoints_in(&checkpoints_directory(run))
        .map_err(|error| fault(format!("could not read the checkpoints of {}: {error}", run.display())))?;
    let mut unreadable = Vec::new();
    for path in &paths {
        match file::open(path) {
            Ok(packed) => {
                refuse_foreign(run, path, &packed.header)?;
                for problem in &unreadable {
                    tracing::warn!("{problem}; an earlier checkpoint is used");
                }
                return Ok(Found { path: path.clone(), packed });
            }
            Err(error) => unreadable.push(format!("{} cannot be used: {error}", path.display())),
        }
    }
    if unreadable.is_empty() {
        return Err(fault(format!("{} holds no checkpoint", run.display())).help(
            "a run writes its first one after `checkpoint.every` minutes, at a signal, and at its end; start it again \
             with `siloflow run`",
        ));
    }
    Err(fault(unreadable.join("; ")).help("start the run again with `siloflow run`"))
}

/// Refuses a checkpoint whose state would mean something else here.
fn refuse_foreign(run: &Path, path: &Path, header: &Header) -> Result<(), Fault> {
    let refuse = |why: String| Fault::new("checkpoint::refused", format!("{} is refused: {why}", path.display()));
    let version = env!("CARGO_PKG_VERSION");
    if (header.format, header.version.as_str()) != (FORMAT, version) {
        let why = format!(
            "siloflow {} with format {} wrote it; this is siloflow {version} with format {FORMAT}",
            header.version, header.format
        );
        return Err(refuse(why).help("continue the run with the version that began it"));
    }
    let input = hash_of_input(run).map_err(|error| refuse(format!("the scene cannot be read: {error}")))?;
    if input != header.input {
        return Err(refuse("the scene or a file that it names has changed since".to_owned())
            .help("undo the change, or start a new run from it with `siloflow run SCENE --from DIR`"));
    }
    if !header.is_final && header.program != hash_of_program() {
        tracing::warn!("another build of siloflow {version} began this run: the last bits of results may differ");
    }
    Ok(())
}
