//! Directories with a marker: a file that tells siloflow's own directories from others.
//!
//! Two processes may use one directory at the same time. The marker is therefore written before any other content, and content is
//! looked for before the marker. In this order no process takes the content of the other for foreign content.

use std::ffi::OsString;
use std::io::{self, ErrorKind};
use std::path::Path;

use crate::own_files;

/// Returns an entry of a directory that has content and none of the files `markers`; `None` also if there is no directory.
///
/// # Errors
/// If the directory cannot be read.
pub fn foreign_entry(directory: &Path, markers: &[&str]) -> io::Result<Option<OsString>> {
    let entry = match directory.read_dir() {
        Err(error) if error.kind() == ErrorKind::NotFound => None,
        entries => entries?.next().transpose()?.map(|entry| entry.file_name()),
    };
    let is_marked = markers.iter().any(|marker| own_files::is_file(&directory.join(marker)));
    Ok(entry.filter(|_| !is_marked))
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;

    #[test]
    fn content_without_a_marker_is_foreign() {
        let here = tempfile::tempdir().unwrap();
        let foreign = |name: &str| foreign_entry(&here.path().join(name), &["mark", "plan"]).unwrap();
        assert_eq!((foreign(""), foreign("missing")), (None, None));
        fs::write(here.path().join("text"), "").unwrap();
        assert_eq!(foreign(""), Some("text".into()));
        fs::write(here.path().join("plan"), "").unwrap();
        assert_eq!(foreign(""), None);
        assert!(foreign_entry(&here.path().join("text"), &[]).is_err());
    }
}
