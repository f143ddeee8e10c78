//! Writes the frames of a run in order, on a separate thread.
//!
//! The run sends each [`Frame`] to the thread and continues. Sorting bytes, compressing and writing take longer than some steps.
//! The queue holds at most [`MAX_WAITING_FRAMES`], so that memory is bounded; if it is full, the run blocks. An error is reported
//! when a later frame is added, or at the end of the run, which blocks until all frames are written.

use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::thread::JoinHandle;

use bevy_app::App;
use bevy_ecs::prelude::*;

use super::Frame;
use super::file::FrameFile;
use crate::outcome::{Failure, Outcome};
use crate::persist::PersistApp as _;

/// Largest number of queued frames.
pub const MAX_WAITING_FRAMES: usize = 4;

/// Writes the frames of a run.
#[derive(Resource)]
pub struct FrameDataWriter {
    /// The file, while no thread writes to it.
    file: Option<FrameFile>,
    /// The thread; it starts with the first frame.
    thread: Option<WriterThread>,
}

#[derive(Debug)]
struct WriterThread {
    queue: SyncSender<Frame>,
    thread: JoinHandle<(FrameFile, Result<(), Failure>)>,
}

impl FrameDataWriter {
    /// Returns a writer that adds to a file.
    #[must_use]
    pub fn new(file: FrameFile) -> Self {
        Self { file: Some(file), thread: None }
    }

    /// Saves the length of the file with each checkpoint. A restored run removes all later frames.
    pub(crate) fn persist(app: &mut App) {
        app.persist_part::<Self, _>(
            |writer| writer.file.as_ref().ok_or("frames are still being written")?.saved(),
            |writer, length| writer.file.as_mut().map_or(Ok(()), |file| file.restore(length)),
        );
    }

    /// Queues a frame. If the run has ended, this is the last frame and the call blocks until all are written.
    ///
    /// A frame that cannot be written makes the run fail.
    pub fn add(&mut self, frame: Frame, outcome: &mut Outcome) {
        let added = self.send(frame);
        let result = if outcome.end().is_some() { added.and_then(|()| self.close()) } else { added };
        if let Err(failure) = result {
            outcome.fail(failure);
        }
    }

    fn send(&mut self, frame: Frame) -> Result<(), Failure> {
        if let Some(file) = self.file.take() {
            self.thread = Some(WriterThread::start(file)?);
        }
        // Sending fails only if the thread has ended with an error, which `close` returns.
        let is_sent = self.thread.as_ref().is_none_or(|thread| thread.queue.send(frame).is_ok());
        if is_sent { Ok(()) } else { self.close() }
    }

    /// Blocks until all frames are written.
    ///
    /// # Errors
    /// If a frame could not be written.
    pub fn close(&mut self) -> Result<(), Failure> {
        let Some(WriterThread { queue, thread }) = self.thread.take() else { return Ok(()) };
        drop(queue);
        let (file, result) = thread.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic));
        self.file = Some(file);
        result
    }
}

impl Drop for FrameDataWriter {
    /// Blocks until all frames are written. An error is ignored, because a run that drops the writer early has already reported
    /// its failure.
    fn drop(&mut self) {
        if let Some(WriterThread { queue, thread }) = self.thread.take() {
            drop(queue);
            let _ = thread.join();
        }
    }
}

impl WriterThread {
    fn start(file: FrameFile) -> Result<Self, Failure> {
        let (queue, frames) = sync_channel(MAX_WAITING_FRAMES);
        let name = file.name.clone();
        let thread = std::thread::Builder::new().name("frames".to_owned()).spawn(move || write_all(file, &frames));
        let thread = thread.map_err(|error| failed(name, &error))?;
        Ok(Self { queue, thread })
    }
}

/// Writes frames until the queue is closed.
fn write_all(mut file: FrameFile, frames: &Receiver<Frame>) -> (FrameFile, Result<(), Failure>) {
    let written = frames.iter().try_for_each(|frame| file.add(&frame));
    let result = written.map_err(|error| failed(file.name.clone(), &error));
    (file, result)
}

fn failed(path: String, reason: &impl ToString) -> Failure {
    Failure::Output { path, reason: reason.to_string() }
}

#[cfg(all(test, target_os = "linux"))]
mod tests {
    use super::*;
    use crate::outcome::End;

    #[test]
    fn a_full_disk_ends_the_run() {
        let full = std::fs::File::options().write(true).open("/dev/full").unwrap();
        let file = FrameFile { name: "frames.bin".to_owned(), file: full, length: 0 };
        let (mut writer, mut outcome) = (FrameDataWriter::new(file), Outcome::default());
        writer.add(Frame::default(), &mut outcome);
        outcome.finish(End::Empty);
        writer.add(Frame::default(), &mut outcome);
        let Some(End::Failed(Failure::Output { path, reason })) = outcome.end() else { panic!("{outcome:?}") };
        assert!(path == "frames.bin" && reason.contains("space"), "{reason}");
        assert_eq!(writer.file.as_ref().map(|file| file.length), Some(0));
    }
}
