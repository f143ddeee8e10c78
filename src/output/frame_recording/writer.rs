//! Writes the frames of a run in order, on a separate thread.
//!
//! The run sends each [`Frame`] to the thread and continues. Sorting bytes, compressing and writing take longer than some steps.
//! The queue holds at most [`MAX_WAITING_FRAMES`], so that memory is bounded; if it is full, the run blocks. An error is reported
//! when a later frame is added, or at the end of the run, which blocks until all frames are written.

use std::path::Path;
use std::sync::Arc;

use bevy_app::App;
use bevy_ecs::prelude::*;

use crate::output::frame_recording::live::{LiveFormats, SavedFormats};
use crate::writers::background::Background;
use siloflow_dem::outcome::{Failure, Outcome};
use siloflow_dem::persist::PersistApp as _;
use siloflow_files::frames::Frame;
use siloflow_files::frames::file::FrameFile;
use siloflow_files::run_directory::Guard;

/// Largest number of queued frames.
pub const MAX_WAITING_FRAMES: usize = 4;

/// Writes the frames of a run.
#[derive(Resource)]
pub struct FrameWriter {
    /// The files, while no thread writes to them.
    files: Option<Files>,
    /// The thread; it starts with the first frame.
    thread: Option<Background<Files, Arc<Frame>>>,
}

/// `frames.bin`, and the formats of other programs that the scene wants.
struct Files {
    frames: FrameFile,
    formats: LiveFormats,
}

impl FrameWriter {
    /// Returns a writer that adds to these files.
    #[must_use]
    pub fn new(frames: FrameFile, formats: LiveFormats) -> Self {
        Self { files: Some(Files { frames, formats }), thread: None }
    }

    /// Saves the lengths of the files with each checkpoint. A restored run removes all later frames.
    pub(crate) fn persist(app: &mut App) {
        app.persist_sound_part::<Self, (u64, SavedFormats)>(
            |writer| {
                let files = writer.files.as_ref().ok_or("frames are still being written")?;
                Ok((files.frames.file.length(), files.formats.saved()))
            },
            |writer, (length, formats)| {
                let Some(files) = &mut writer.files else { return Ok(()) };
                files.frames.file.restore(length)?;
                files.formats.restore(&formats)
            },
        );
    }

    /// Blocks until all frames are written. Later ones go to the run directory `run`, to which the caller moves the present files.
    ///
    /// # Errors
    /// If a frame could not be written.
    pub fn continue_in(&mut self, run: &Path, guard: Guard) -> Result<(), Failure> {
        self.close()?;
        if let Some(files) = &mut self.files {
            files.formats.continue_in(run, guard);
        }
        Ok(())
    }

    /// Queues a frame. If the run has ended, this is the last frame and the call blocks until all are written.
    ///
    /// A frame that cannot be written makes the run fail.
    pub fn add(&mut self, frame: Arc<Frame>, outcome: &mut Outcome) {
        let added = self.send(frame);
        let result = if outcome.end().is_some() { added.and_then(|()| self.close()) } else { added };
        if let Err(failure) = result {
            outcome.fail(failure);
        }
    }

    fn send(&mut self, frame: Arc<Frame>) -> Result<(), Failure> {
        if let Some(files) = self.files.take() {
            let name = files.frames.file.name().to_owned();
            let thread = Background::start("frames", MAX_WAITING_FRAMES, files, Files::add);
            self.thread = Some(thread.map_err(|error| failed(name, &error))?);
        }
        let is_added = self.thread.as_mut().is_none_or(|thread| thread.add(frame));
        if is_added { Ok(()) } else { self.close() }
    }

    /// Blocks until all frames are written.
    ///
    /// # Errors
    /// If a frame could not be written.
    pub fn close(&mut self) -> Result<(), Failure> {
        let Some(thread) = self.thread.take() else { return Ok(()) };
        let (files, result) = thread.close();
        self.files = Some(files);
        result
    }
}

impl Drop for FrameWriter {
    /// Blocks until all frames are written. An error is ignored, because a run that drops the writer early has already reported
    /// its failure.
    fn drop(&mut self) {
        if let Some(thread) = self.thread.take() {
            thread.wait();
        }
    }
}

impl Files {
    fn add(&mut self, frame: Arc<Frame>) -> Result<(), Failure> {
        self.frames.add(&frame).map_err(|error| failed(self.frames.file.name().to_owned(), &error))?;
        self.formats.add(&frame).map_err(|(name, error)| failed(name.to_owned(), &error))
    }
}

fn failed(path: String, reason: &impl ToString) -> Failure {
    Failure::Output { path, reason: reason.to_string() }
}

#[cfg(all(test, target_os = "linux"))]
mod tests {
    use super::*;
    use siloflow_dem::outcome::End;
    use siloflow_files::frames::Header;
    use siloflow_files::growing::{Growing, OutputPlace};

    #[test]
    fn a_full_disk_ends_the_run() {
        let full = std::fs::File::options().write(true).open("/dev/full").unwrap();
        let file = FrameFile { file: Growing::of(full, "frames.bin") };
        let formats = LiveFormats::open(&[], Header::default(), &OutputPlace::default()).unwrap();
        let mut writer = FrameWriter::new(file, formats);
        let mut outcome = Outcome::default();
        writer.add(Arc::default(), &mut outcome);
        outcome.finish(End::Empty);
        writer.add(Arc::default(), &mut outcome);
        let Some(End::Failed(Failure::Output { path, reason })) = outcome.end() else { panic!("{outcome:?}") };
        assert!(path == "frames.bin" && reason.contains("space"), "{reason}");
        assert_eq!(writer.files.as_ref().map(|files| files.frames.file.length()), Some(0));
    }
}
