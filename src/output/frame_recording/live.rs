//! Formats that are written while a run goes on, by the thread that writes `frames.bin`.
//!
//! A text file grows as `frames.bin` does, and a directory of VTK files gets new files. Both are cut to the frames of a checkpoint
//! when a run is resumed.

use std::io;
use std::path::Path;

use siloflow_dem::persist::Problem;
use siloflow_files::disk;
use siloflow_files::frames::{Frame, Header};
use siloflow_files::growing::Growing;
use siloflow_files::growing::OutputPlace;
use siloflow_files::own_files;
use siloflow_files::run_directory::Guard;
use siloflow_results::export::Format;
use siloflow_results::export::{dump, vtk, xyz};

/// The formats of a run.
pub struct LiveFormats {
    header: Header,
    formats: Vec<Live>,
    /// Checks that the run directory is still that of the run.
    guard: Option<Guard>,
}

#[derive(Debug)]
enum Live {
    Text { format: Format, file: Growing },
    Vtk(Box<vtk::Directory>),
}

/// State of each format in a checkpoint.
pub(crate) type SavedFormats = Vec<Vec<u64>>;

impl LiveFormats {
    /// Creates the files of these formats in the run directory that holds `frames`, the place of `frames.bin`, or opens them if the
    /// run is continued.
    ///
    /// # Errors
    /// If a file cannot be written, or a new one exists.
    pub fn open(formats: &[Format], header: Header, frames: &OutputPlace) -> io::Result<Self> {
        let open = |&format: &Format| {
            let name = format.file_name();
            let path = frames.path.with_file_name(name);
            if format == Format::Vtk {
                if !(frames.is_continued && own_files::is_directory(&path)) {
                    disk::create_directory(&path)?;
                }
                return vtk::Directory::open(&path, &frames.files).map(|directory| Live::Vtk(Box::new(directory)));
            }
            let file = Growing::at(&path, frames.files.file(name), b"", frames.is_continued)?;
            Ok(Live::Text { format, file })
        };
        let formats = formats.iter().map(open).collect::<io::Result<_>>()?;
        Ok(Self { header, formats, guard: None })
    }

    /// Adds a frame to every format.
    ///
    /// # Errors
    /// The name of the file, and why it could not be written. A text file then ends with the frame before.
    pub fn add(&mut self, frame: &Frame) -> Result<(), (&'static str, io::Error)> {
        self.formats.iter_mut().try_for_each(|live| match live {
            Live::Text { format, file } => {
                let text = if *format == Format::ExtXyz { xyz::text } else { dump::text }(&self.header, frame);
                file.append(text.as_bytes()).map_err(|error| (format.file_name(), error))
            }
            Live::Vtk(directory) => {
                let is_there = self.guard.as_ref().map_or(Ok(()), |guard| guard());
                let added = is_there.and_then(|()| directory.add(&self.header, frame));
                added.map_err(|error| (Format::Vtk.file_name(), error))
            }
        })
    }

    /// Continues in a run directory to which the caller moves the present files. `guard` is called before a file is created.
    pub fn continue_in(&mut self, run: &Path, guard: Guard) {
        self.guard = Some(guard);
        for live in &mut self.formats {
            if let Live::Vtk(directory) = live {
                directory.path = run.join(Format::Vtk.file_name());
            }
        }
    }

    /// Returns the extent of each format.
    pub(crate) fn saved(&self) -> SavedFormats {
        let saved = |live: &Live| match live {
            Live::Text { file, .. } => vec![file.length()],
            Live::Vtk(directory) => directory.saved(),
        };
        self.formats.iter().map(saved).collect()
    }

    /// Removes all frames beyond those of [`LiveFormats::saved`].
    pub(crate) fn restore(&mut self, saved: &[Vec<u64>]) -> Result<(), Problem> {
        if saved.len() != self.formats.len() {
            return Err("the checkpoint has other formats".to_owned());
        }
        self.formats.iter_mut().zip(saved).try_for_each(|(live, saved)| match live {
            Live::Text { file, .. } => file.restore(saved.first().copied().unwrap_or(0)),
            Live::Vtk(directory) => {
                directory.restore(saved).map_err(|error| format!("could not remove later frames: {error}"))
            }
        })
    }
}
