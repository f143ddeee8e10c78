//! The pictures of a run, drawn and written by a thread of their own, in turn: steps do not wait for them.
//!
//! What is handed over is a [`Picture`], a copy of what is seen; as text and pixels it takes longer than some steps. At
//! most [`WAITING`] wait for the painter, then the run waits for him, so that memory stays bounded. A picture that could
//! not be written is told with one of the next, or at the end of the run, which waits for the last one.

use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::thread::JoinHandle;

use bevy_ecs::prelude::*;

use crate::outcome::{Failure, Outcome};
use crate::writers::png;
use crate::writers::svg::Picture;

/// How many pictures may wait.
pub const WAITING: usize = 4;

/// Pictures by number, in a directory.
#[derive(Resource, Debug)]
pub struct FrameWriter {
    directory: PathBuf,
    png: bool,
    taken: u32,
    painter: Option<Painter>,
}

/// The thread, and the way to it.
#[derive(Debug)]
struct Painter {
    pictures: SyncSender<(PathBuf, Picture)>,
    thread: JoinHandle<Result<(), Failure>>,
}

impl FrameWriter {
    /// An empty album, of PNGs too if wanted.
    #[must_use]
    pub fn new(directory: PathBuf, png: bool) -> Self {
        Self { directory, png, taken: 0, painter: None }
    }

    /// Adds a picture, the last one if the run has come to its end; what could not be written ends the run.
    pub fn add(&mut self, picture: Picture, outcome: &mut Outcome) {
        let added = self.hand_over(picture);
        let result = if outcome.end().is_some() { added.and_then(|()| self.close()) } else { added };
        if let Err(failure) = result {
            outcome.fail(failure);
        }
    }

    fn hand_over(&mut self, picture: Picture) -> Result<(), Failure> {
        let path = self.directory.join(format!("{:05}.svg", self.taken));
        self.taken += 1;
        let painter = match self.painter.take() {
            Some(painter) => painter,
            None => Painter::start(self.png).map_err(|error| failed(&path, &error))?,
        };
        // A painter who does not listen any more has failed.
        let is_taken = painter.pictures.send((path, picture)).is_ok();
        self.painter = Some(painter);
        if is_taken { Ok(()) } else { self.close() }
    }

    /// Waits until all is written.
    ///
    /// # Errors
    /// If one could not be.
    pub fn close(&mut self) -> Result<(), Failure> {
        let Some(Painter { pictures, thread }) = self.painter.take() else { return Ok(()) };
        drop(pictures);
        thread.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic))
    }
}

impl Drop for FrameWriter {
    /// A run that has failed elsewhere has said so.
    fn drop(&mut self) {
        if let Some(Painter { pictures, thread }) = self.painter.take() {
            drop(pictures);
            let _ = thread.join();
        }
    }
}

impl Painter {
    fn start(png: bool) -> std::io::Result<Self> {
        let (pictures, easel) = sync_channel(WAITING);
        let thread = std::thread::Builder::new().name("pictures".to_owned()).spawn(move || paint(&easel, png))?;
        Ok(Self { pictures, thread })
    }
}

fn paint(easel: &Receiver<(PathBuf, Picture)>, png: bool) -> Result<(), Failure> {
    easel.iter().try_for_each(|(path, picture)| {
        let svg = picture.to_svg();
        std::fs::write(&path, &svg).map_err(|error| failed(&path, &error))?;
        if png {
            let path = path.with_extension("png");
            let bytes = png::encode(&svg).map_err(|reason| failed(&path, &reason))?;
            std::fs::write(&path, bytes).map_err(|error| failed(&path, &error))?;
        }
        Ok(())
    })
}

fn failed(path: &Path, reason: &impl ToString) -> Failure {
    Failure::Output { path: path.display().to_string(), reason: reason.to_string() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::outcome::End;
    use crate::space::Vector;

    fn picture() -> Picture {
        Picture { high: Vector::ONE, width: 40.0, ..Picture::default() }
    }

    #[test]
    fn pictures_are_numbered_and_there_when_the_album_is_closed() {
        let directory = tempfile::tempdir().unwrap();
        let (mut frame_writer, mut outcome) = (FrameWriter::new(directory.path().to_owned(), true), Outcome::default());
        (0..10).for_each(|_| frame_writer.add(picture(), &mut outcome));
        frame_writer.close().unwrap();
        assert_eq!(std::fs::read_dir(directory.path()).unwrap().count(), 20);
        let last = std::fs::read_to_string(directory.path().join("00009.svg")).unwrap();
        assert_eq!((last, outcome.end()), (picture().to_svg(), None));
    }

    #[test]
    fn what_cannot_be_written_ends_the_run() {
        let nowhere = tempfile::tempdir().unwrap().path().join("nowhere");
        let (mut frame_writer, mut outcome) = (FrameWriter::new(nowhere.clone(), false), Outcome::default());
        frame_writer.add(picture(), &mut outcome);
        outcome.finish(End::Empty);
        frame_writer.add(picture(), &mut outcome);
        let Some(End::Failed(Failure::Output { path, .. })) = outcome.end() else { panic!("{outcome:?}") };
        assert_eq!(Path::new(path), nowhere.join("00000.svg"));
    }
}
