//! The frame writer: draws and writes the pictures of a run in order, on a separate drawing thread.
//!
//! The run sends to the drawing thread what makes a [`Picture`], and continues. Making, drawing and encoding a picture takes longer
//! than some steps. The queue holds at most [`MAX_WAITING_PICTURES`] pictures, so that memory is
//! bounded; if it is full, the run blocks. An error of the drawing thread is reported when a later picture is added, or
//! at the end of the run, which blocks until all pictures are written.

use std::path::{Path, PathBuf};

use bevy_app::App;
use bevy_ecs::prelude::*;

use crate::writers::background::Background;
use siloflow_dem::outcome::{Failure, Outcome};
use siloflow_dem::persist::PersistApp as _;
use siloflow_figures::png;
use siloflow_figures::svg::Picture;
use siloflow_files::own_files;
use siloflow_files::run_directory::Guard;
use siloflow_files::run_files::{Extent, RunFiles};
use siloflow_files::whole_file;

/// Largest number of queued pictures.
pub const MAX_WAITING_PICTURES: usize = 4;

/// Writes numbered pictures into a directory.
#[derive(Resource)]
pub struct PictureWriter {
    directory: PathBuf,
    guard: Option<Guard>,
    files: RunFiles,
    png: bool,
    /// Number of pictures so far.
    count: u32,
    /// The drawing thread; it starts with the first picture.
    drawing_thread: Option<Background<Drawing, Task>>,
}

/// Makes a picture.
type MakePicture = Box<dyn FnOnce() -> Picture + Send>;

/// How pictures are drawn, and where they are recorded.
struct Drawing {
    png: bool,
    guard: Option<Guard>,
    files: RunFiles,
}

/// A picture for the drawing thread.
struct Task {
    path: PathBuf,
    make: MakePicture,
}

impl PictureWriter {
    /// Returns a frame writer for `directory` that has written no picture; with `png` it also writes PNGs.
    #[must_use]
    pub fn new(directory: PathBuf, png: bool) -> Self {
        Self { directory, guard: None, files: RunFiles::default(), png, count: 0, drawing_thread: None }
    }

    /// Records the pictures among the files of the run, if there is a record.
    #[must_use]
    pub fn recorded_in(mut self, files: Option<&RunFiles>) -> Self {
        self.files = files.cloned().unwrap_or_default();
        self
    }

    /// Saves the number of pictures with each checkpoint. A restored run removes all later pictures.
    pub(crate) fn persist(app: &mut App) {
        app.persist_sound_part::<Self, _>(
            |writer| Ok(writer.count),
            |writer, count| {
                writer.count = count;
                writer.remove_later().map_err(|error| format!("could not remove later pictures: {error}"))
            },
        );
    }

    /// Removes pictures whose number is not below the count.
    fn remove_later(&self) -> std::io::Result<()> {
        for entry in own_files::entries(&self.directory)? {
            let path = entry?.path();
            let is_picture = path.extension().is_some_and(|ending| ending == "svg" || ending == "png");
            let number = path.file_stem().and_then(|stem| stem.to_str()?.parse::<u32>().ok());
            if is_picture && number.is_some_and(|number| number >= self.count) {
                whole_file::remove_if_there(&path)?;
            }
        }
        Ok(())
    }

    /// Queues a picture. If the run has ended, this is the last picture and the call blocks until all are written.
    ///
    /// The drawing thread calls `make`. A picture that cannot be written makes the run fail.
    pub fn add(&mut self, make: impl FnOnce() -> Picture + Send + 'static, outcome: &mut Outcome) {
        let added = self.send(Box::new(make));
        let result = if outcome.end().is_some() { added.and_then(|()| self.close()) } else { added };
        if let Err(failure) = result {
            outcome.fail(failure);
        }
    }

    fn send(&mut self, make: MakePicture) -> Result<(), Failure> {
        let path = self.directory.join(format!("{:05}.svg", self.count));
        self.count += 1;
        let mut drawing_thread = if let Some(drawing_thread) = self.drawing_thread.take() {
            drawing_thread
        } else {
            let drawing = Drawing { png: self.png, guard: self.guard.clone(), files: self.files.clone() };
            Background::start("pictures", MAX_WAITING_PICTURES, drawing, Drawing::draw)
                .map_err(|error| failed(&path, &error))?
        };
        let is_added = drawing_thread.add(Task { path, make });
        self.drawing_thread = Some(drawing_thread);
        if is_added { Ok(()) } else { self.close() }
    }

    /// Blocks until all pictures are written. Later pictures go to `directory`, to which the caller moves the present ones.
    /// `guard` is called before each of them.
    ///
    /// # Errors
    /// If a picture could not be written.
    pub fn continue_in(&mut self, directory: PathBuf, guard: Guard) -> Result<(), Failure> {
        self.directory = directory;
        self.guard = Some(guard);
        self.close()
    }

    /// Blocks until all pictures are written.
    ///
    /// # Errors
    /// If a picture could not be written.
    pub fn close(&mut self) -> Result<(), Failure> {
        self.drawing_thread.take().map_or(Ok(()), |drawing_thread| drawing_thread.close().1)
    }
}

impl Drop for PictureWriter {
    /// Blocks until all pictures are written. An error is ignored, because a run that drops the writer early has
    /// already reported its failure.
    fn drop(&mut self) {
        if let Some(drawing_thread) = self.drawing_thread.take() {
            drawing_thread.wait();
        }
    }
}

impl Drawing {
    /// Draws and writes a picture.
    fn draw(&mut self, task: Task) -> Result<(), Failure> {
        let Task { path, make } = task;
        self.guard.as_ref().map_or(Ok(()), |guard| guard()).map_err(|error| failed(&path, &error))?;
        let svg = make().to_svg();
        self.write(&path, svg.as_bytes())?;
        if self.png {
            let path = path.with_extension("png");
            let bytes = png::encode(&svg).map_err(|reason| failed(&path, &reason))?;
            self.write(&path, &bytes)?;
        }
        Ok(())
    }

    fn write(&self, path: &Path, bytes: &[u8]) -> Result<(), Failure> {
        whole_file::write(path, bytes).map_err(|error| failed(path, &error))?;
        self.files.file(name_in_run(path)).is_written(Extent::default().with(bytes));
        Ok(())
    }
}

/// Path of a picture in the run directory, which holds its directory.
fn name_in_run(path: &Path) -> String {
    let part = |path: &Path| path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    format!("{}/{}", path.parent().map_or_else(String::new, part), part(path))
}

fn failed(path: &Path, reason: &impl ToString) -> Failure {
    Failure::Output { path: path.display().to_string(), reason: reason.to_string() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use siloflow_dem::outcome::End;
    use siloflow_dem::space::Vector;

    fn picture() -> Picture {
        Picture { high: Vector::ONE, width: 40.0, ..Picture::default() }
    }

    #[test]
    fn pictures_are_numbered_and_complete_after_close() {
        let directory = tempfile::tempdir().unwrap();
        let mut picture_writer = PictureWriter::new(directory.path().to_owned(), true);
        let mut outcome = Outcome::default();
        (0..10).for_each(|_| picture_writer.add(picture, &mut outcome));
        picture_writer.close().unwrap();
        assert_eq!(std::fs::read_dir(directory.path()).unwrap().count(), 20);
        let last = std::fs::read_to_string(directory.path().join("00009.svg")).unwrap();
        assert_eq!((last, outcome.end()), (picture().to_svg(), None));
    }

    #[test]
    fn failed_write_ends_the_run() {
        let nowhere = tempfile::tempdir().unwrap().path().join("nowhere");
        let mut picture_writer = PictureWriter::new(nowhere.clone(), false);
        let mut outcome = Outcome::default();
        picture_writer.add(picture, &mut outcome);
        outcome.finish(End::Empty);
        picture_writer.add(picture, &mut outcome);
        let Some(End::Failed(Failure::Output { path, .. })) = outcome.end() else { panic!("{outcome:?}") };
        assert_eq!(Path::new(path), nowhere.join("00000.svg"));
    }
}
