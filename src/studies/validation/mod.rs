//! Validation: silos, flows and impacts held against figures that others have measured or derived.
//!
//! | part | file |
//! |---|---|
//! | the cases, one file each | [`cases`] |
//! | the finished runs of a case | [`runs`] |
//! | rows of a verdict: figure, published figure, rule | [`verdict`] |
//! | groups of runs by a number of theirs | [`groups`] |
//! | pages and tables | [`page`] |
//! | paths of grains between frames | [`tracks`] |
//! | avalanches of a silo that clogs | [`avalanches`] |
//!
//! A case is a set of scenes and sweep files, which the program carries. Its short form takes minutes on one core, its full form at most about an
//! hour. The runs are those of `siloflow sweep`, so an interrupted validation continues. A case then reads its run directories as any user
//! can, and returns rows and figures.

pub mod avalanches;
pub mod cases;
pub mod groups;
pub mod page;
pub mod runs;
pub mod tracks;
pub mod verdict;

use std::io;
use std::path::Path;

use crate::studies::validation::runs::Studies;
use crate::studies::validation::verdict::Judgement;
use siloflow_text::fault::Fault;

/// A validation case.
#[derive(Debug)]
pub struct Case {
    /// Name on the command line, and of its directory.
    pub name: &'static str,
    /// Title of its section.
    pub title: &'static str,
    /// Sources of the published figures.
    pub sources: &'static str,
    /// Scenes and sweep files: name and content.
    pub files: &'static [(&'static str, &'static str)],
    /// Sweep files of the short form.
    pub short: &'static [&'static str],
    /// Sweep files of the full form.
    pub full: &'static [&'static str],
    /// Judges the finished runs.
    pub judge: fn(&Studies) -> Result<Judgement, Fault>,
}

/// The form of a case.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Form {
    /// Minutes on one core.
    Short,
    /// The size of the publication, or as close as an hour of one core comes.
    Full,
}

impl Form {
    /// Name on the page.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Short => "short",
            Self::Full => "full",
        }
    }
}

impl Case {
    /// Returns the sweep files of a form.
    #[must_use]
    pub fn sweeps(&self, form: Form) -> &'static [&'static str] {
        match form {
            Form::Short => self.short,
            Form::Full => self.full,
        }
    }
}

/// Returns the fault of a file of a case that cannot be read.
fn unreadable(path: &Path, error: &io::Error) -> Fault {
    Fault::new("validate::unreadable", format!("could not read {}: {error}", path.display())).help("run the case again")
}

/// Adds a file of `scenes/validation` to the list of a case.
macro_rules! file {
    ($case:literal, $name:literal) => {
        ($name, include_str!(concat!("../../../../scenes/validation/", $case, "/", $name)))
    };
}
pub(crate) use file;
