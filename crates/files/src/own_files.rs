//! Opens files inside siloflow's own directories: of runs, of sweeps, of results.
//!
//! Such a directory may come from somebody else, or have been changed. A file that siloflow reads or changes there has to be a regular
//! file, and a directory that it lists or fills a directory. Symbolic links are not followed, because they may lead anywhere; pipes and
//! devices are not opened for work, because they may wait for ever or have no end. Paths that a user names are another matter:
//! [`files`](siloflow_text::file) follows links in them.
//!
//! Only the last part of a path is examined. The directories before it are examined when a command begins
//! (`run_directory::refuse_odd`).
//!
//! Limit: where the system cannot refuse a link while it opens a file (not Unix), the file is examined just before.

use std::fs::{self, File, FileType, Metadata, OpenOptions, ReadDir};
use std::io::{self, ErrorKind, Read as _};
use std::path::{Path, PathBuf};

use siloflow_text::encoding::TextReader;
use siloflow_text::file::BoundedFile;

/// Opens a file to read.
///
/// # Errors
/// If it is not there, is no regular file, or cannot be read.
pub fn read(path: &Path) -> io::Result<File> {
    open(path, OpenOptions::new().read(true))
}

/// Opens a file to read at most `most` bytes.
///
/// # Errors
/// As [`read`]; also if the file is larger.
pub fn bounded(path: &Path, most: u64) -> io::Result<BoundedFile> {
    BoundedFile::of(read(path)?, most)
}

/// Reads a file of at most `most` bytes.
///
/// # Errors
/// As [`bounded`].
pub fn read_bytes(path: &Path, most: u64) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    bounded(path, most)?.read_to_end(&mut bytes)?;
    Ok(bytes)
}

/// Reads a file of at most `most` bytes as a text in one of the known [encodings](siloflow_text::encoding).
///
/// # Errors
/// As [`bounded`]; also if the text is in another encoding.
pub fn read_text(path: &Path, most: u64) -> io::Result<String> {
    let mut text = String::new();
    TextReader::new(bounded(path, most)?).read_to_string(&mut text)?;
    Ok(text)
}

/// Opens a file to change it. It is neither created nor cut.
///
/// # Errors
/// If it is not there, is no regular file, or cannot be written.
pub fn change(path: &Path) -> io::Result<File> {
    open(path, OpenOptions::new().read(true).write(true))
}

/// Opens a file to change it, and creates it if it is not there.
///
/// # Errors
/// If it is no regular file, or cannot be written.
pub fn create_or_change(path: &Path) -> io::Result<File> {
    open(path, OpenOptions::new().read(true).write(true).create(true).truncate(false))
}

/// Opens a file to add to its end, and creates it if it is not there.
///
/// # Errors
/// If it is no regular file, or cannot be written.
pub fn append(path: &Path) -> io::Result<File> {
    open(path, OpenOptions::new().create(true).append(true))
}

/// Returns the entries of a directory.
///
/// # Errors
/// If it is not there, is no directory, or cannot be read.
pub fn entries(directory: &Path) -> io::Result<ReadDir> {
    refuse(&fs::symlink_metadata(directory)?, Expected::Directory)?;
    fs::read_dir(directory)
}

/// Makes a directory, if it is not there.
///
/// # Errors
/// If something else has its name, or it cannot be made.
pub fn make_directory(path: &Path) -> io::Result<()> {
    match fs::create_dir(path) {
        Err(error) if error.kind() == ErrorKind::AlreadyExists => {
            refuse(&fs::symlink_metadata(path)?, Expected::Directory)
        }
        made => made,
    }
}

/// Whether there is a regular file, and no link to one.
#[must_use]
pub fn is_file(path: &Path) -> bool {
    fs::symlink_metadata(path).is_ok_and(|found| found.is_file())
}

/// Whether there is a directory, and no link to one.
#[must_use]
pub fn is_directory(path: &Path) -> bool {
    fs::symlink_metadata(path).is_ok_and(|found| found.is_dir())
}

/// Returns the kind of an entry of a directory, in words.
#[must_use]
pub fn in_words(kind: FileType) -> &'static str {
    if kind.is_symlink() {
        "a symbolic link"
    } else if kind.is_dir() {
        "a directory"
    } else if kind.is_file() {
        "a regular file"
    } else {
        "a device, a pipe or a socket"
    }
}

/// Device and number of a file, which together identify it.
#[cfg(unix)]
#[must_use]
pub fn file_number(file: &Metadata) -> (u64, u64) {
    use std::os::unix::fs::MetadataExt as _;
    (file.dev(), file.ino())
}

/// Elsewhere files are not identified: all have one number.
#[cfg(not(unix))]
#[must_use]
pub fn file_number(_: &Metadata) -> (u64, u64) {
    (0, 0)
}

/// Returns the absolute path of a file or directory that is there, without symbolic links. WebAssembly follows none: there the path is only made absolute.
///
/// # Errors
/// If there is nothing at `path`.
pub fn resolved(path: &Path) -> io::Result<PathBuf> {
    if !cfg!(target_family = "wasm") {
        return fs::canonicalize(path);
    }
    fs::symlink_metadata(path)?;
    std::path::absolute(path)
}

/// The kind of file that has to be at a path.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Expected {
    File,
    Directory,
}

fn refuse(found: &Metadata, expected: Expected) -> io::Result<()> {
    let (is_expected, name) = match expected {
        Expected::File => (found.is_file(), "a regular file"),
        Expected::Directory => (found.is_dir(), "a directory"),
    };
    if is_expected {
        return Ok(());
    }
    Err(io::Error::other(format!("it is not {name}, but {}", in_words(found.file_type()))))
}

fn open(path: &Path, options: &mut OpenOptions) -> io::Result<File> {
    // Before opening, because that alone can act on a device. A file that is not there may be created.
    match fs::symlink_metadata(path) {
        Err(error) if error.kind() != ErrorKind::NotFound => return Err(error),
        found => found.map_or(Ok(()), |found| refuse(&found, Expected::File))?,
    }
    // Another file may have taken its place since.
    let file = without_following(options).open(path)?;
    refuse(&file.metadata()?, Expected::File)?;
    Ok(file)
}

/// Opening fails at a link, and does not wait for the other end of a pipe. Neither changes anything for a regular file.
#[cfg(unix)]
fn without_following(options: &mut OpenOptions) -> &mut OpenOptions {
    use std::os::unix::fs::OpenOptionsExt as _;

    use rustix::fs::OFlags;
    let flags = OFlags::NOFOLLOW | OFlags::NONBLOCK;
    options.custom_flags(flags.bits().cast_signed())
}

#[cfg(not(unix))]
fn without_following(options: &mut OpenOptions) -> &mut OpenOptions {
    options
}

#[cfg(test)]
#[cfg(unix)]
mod tests {
    use std::io::Write as _;
    use std::os::unix::fs::symlink;

    use super::*;

    type Open = fn(&Path) -> io::Result<File>;

    const WAYS: [(&str, Open); 4] =
        [("read", read), ("change", change), ("create or change", create_or_change), ("append", append)];

    fn pipe(path: &Path) {
        assert!(std::process::Command::new("mkfifo").arg(path).status().unwrap().success());
    }

    #[test]
    fn links_pipes_devices_and_directories_are_refused_at_once() {
        let here = tempfile::tempdir().unwrap();
        let at = |name: &str| here.path().join(name);
        fs::write(at("precious"), "years").unwrap();
        symlink("precious", at("link")).unwrap();
        symlink("nowhere", at("dangling")).unwrap();
        pipe(&at("pipe"));
        fs::create_dir(at("directory")).unwrap();
        let cases: [(PathBuf, &str); 5] = [
            (at("link"), "a symbolic link"),
            (at("dangling"), "a symbolic link"),
            (at("pipe"), "a device, a pipe or a socket"),
            (PathBuf::from("/dev/zero"), "a device, a pipe or a socket"),
            (at("directory"), "a directory"),
        ];
        for (path, kind) in cases {
            for (way, open) in WAYS {
                let message = open(&path).unwrap_err().to_string();
                assert!(message.contains("not a regular file") && message.ends_with(kind), "{way} {kind}: {message}");
            }
            // The system refuses a link that took the place of a file after the file was examined.
            if kind == "a symbolic link" {
                assert!(without_following(OpenOptions::new().read(true)).open(&path).is_err());
            }
        }
        assert_eq!(fs::read(at("precious")).unwrap(), b"years");
        assert!(!at("nowhere").exists());
    }

    #[test]
    fn regular_files_are_opened_and_created_as_said() {
        let here = tempfile::tempdir().unwrap();
        let path = here.path().join("file");
        assert!([read(&path), change(&path)].iter().all(Result::is_err) && !path.exists());
        create_or_change(&path).unwrap().write_all(b"abc").unwrap();
        change(&path).unwrap().write_all(b"A").unwrap();
        append(&path).unwrap().write_all(b"d").unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"Abcd");
        assert!(is_file(&path) && !is_directory(&path));
    }

    #[test]
    fn linked_directories_are_neither_listed_nor_filled() {
        let here = tempfile::tempdir().unwrap();
        let at = |name: &str| here.path().join(name);
        make_directory(&at("frames")).unwrap();
        make_directory(&at("frames")).unwrap();
        fs::write(at("frames/00000.svg"), "").unwrap();
        symlink("frames", at("link")).unwrap();
        assert_eq!(entries(&at("frames")).unwrap().count(), 1);
        assert!(is_directory(&at("frames")) && !is_directory(&at("link")));
        for refused in [entries(&at("link")).map(drop), make_directory(&at("link"))] {
            assert!(refused.unwrap_err().to_string().contains("not a directory, but a symbolic link"));
        }
        assert_eq!(entries(&at("nowhere")).unwrap_err().kind(), ErrorKind::NotFound);
    }
}
