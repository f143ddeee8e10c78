//! Formats that are written while a run goes on, by the thread that writes `frames.bin`.
//!
//! A text file grows as `frames.bin` does, and a directory of VTK files gets new files. Both are cut to the frames of a checkpoint
//! when a run is resumed.

use std::fs::{self, File};
use std::io::{self, Seek as _, SeekFrom, Write as _};
use std::path::Path;

use super::{dump, vtk, xyz};
use crate::output::frame_data::{Frame, Header};
use crate::own_files;
use crate::scene::outputs::Format;
use crate::writers::frame_writer::Guard;

/// The formats of a run.
pub struct LiveFormats {
    header: Header,
    formats: Vec<Live>,
    /// Checks that the run directory is still that of the run.
    guard: Option<Guard>,
}

#[derive(Debug)]
enum Live {
    Text {
        format: Format,
        file: File,
        /// Bytes of whole frames.
        length: u64,
    },
    Vtk(vtk::Directory),
}

/// State of each format in a checkpoint.
pub(crate) type SavedFormats = Vec<Vec<u64>>;

impl LiveFormats {
    /// Creates the files of these formats in a run directory, or opens them if the run is continued.
    ///
    /// # Errors
    /// If a file cannot be written, or a new one exists.
    pub fn open(formats: &[Format], header: Header, run: &Path, is_continued: bool) -> io::Result<Self> {
        let open = |&format: &Format| {
            let path = run.join(format.file_name());
            if format == Format::Vtk {
                if !is_continued {
                    fs::create_dir(&path)?;
                }
                return vtk::Directory::open(&path).map(Live::Vtk);
            }
            let mut file = if is_continued { own_files::change(&path)? } else { File::create_new(&path)? };
            let length = file.seek(SeekFrom::End(0))?;
            Ok(Live::Text { format, file, length })
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
            Live::Text { format, file, length } => {
                let text = if *format == Format::ExtXyz { xyz::text } else { dump::text }(&self.header, frame);
                let written = file.write_all(text.as_bytes());
                if written.is_ok() {
                    *length += text.len() as u64;
                } else {
                    // A part of the frame may have been written. The run reports the first error.
                    let _ = file.set_len(*length).and_then(|()| file.seek(SeekFrom::Start(*length)));
                }
                written.map_err(|error| (format.file_name(), error))
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
    pub(crate) fn saved(&self) -> io::Result<SavedFormats> {
        let saved = |live: &Live| match live {
            Live::Text { file, length, .. } => file.sync_data().map(|()| vec![*length]),
            Live::Vtk(directory) => Ok(directory.saved()),
        };
        self.formats.iter().map(saved).collect()
    }

    /// Removes all frames beyond those of [`LiveFormats::saved`].
    pub(crate) fn restore(&mut self, saved: &[Vec<u64>]) -> io::Result<()> {
        if saved.len() != self.formats.len() {
            return Err(io::Error::other("the checkpoint has other formats"));
        }
        self.formats.iter_mut().zip(saved).try_for_each(|(live, saved)| match live {
            Live::Text { file, length, .. } => {
                let before = saved.first().copied().unwrap_or(0);
                if before > *length {
                    return Err(io::Error::other("a file of frames is shorter than it was at the checkpoint"));
                }
                file.set_len(before)?;
                file.seek(SeekFrom::Start(before))?;
                *length = before;
                Ok(())
            }
            Live::Vtk(directory) => directory.restore(saved),
        })
    }
}
