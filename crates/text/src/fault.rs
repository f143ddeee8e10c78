//! A fault in the input: its message, its place and a remedy. Messages show text of the input only as
//! [`text`](crate::safe) makes it safe.

mod excerpt;

use std::fmt;
use std::ops::Range;

use miette::{Diagnostic, LabeledSpan, SourceCode};

use crate::fault::excerpt::Excerpt;
use crate::safe::{LONGEST_QUOTATION, cut, message};

/// An error of the input: a stable code, a message, a help line and, if known, the place in a file.
#[derive(Clone, Debug)]
pub struct Fault(Box<Inner>);

#[derive(Clone, Debug)]
struct Inner {
    code: &'static str,
    message: String,
    help: Option<String>,
    key: Option<String>,
    place: Option<Excerpt>,
}

impl Fault {
    /// A fault with the stable `code` (`area::name`).
    #[must_use]
    pub fn new(code: &'static str, text: impl Into<String>) -> Self {
        Self(Box::new(Inner { code, message: message(&text.into()), help: None, key: None, place: None }))
    }

    /// Adds the help line.
    #[must_use]
    pub fn help(mut self, help: impl Into<String>) -> Self {
        self.0.help = Some(message(&help.into()));
        self
    }

    /// Names the scene key that is at fault.
    #[must_use]
    pub fn key(mut self, key: impl Into<String>) -> Self {
        self.0.key = Some(message(&cut(&key.into(), LONGEST_QUOTATION)));
        self
    }

    /// Points at a byte range of `text`, the content of the file `name`.
    #[must_use]
    pub fn at(mut self, name: &str, text: &str, range: Range<usize>) -> Self {
        self.0.place = Some(Excerpt::new(name, text, range));
        self
    }

    /// The stable code.
    #[must_use]
    pub fn code(&self) -> &'static str {
        self.0.code
    }

    /// The scene key that is at fault, if known.
    #[must_use]
    pub fn scene_key(&self) -> Option<&str> {
        self.0.key.as_deref()
    }

    /// The help line.
    #[must_use]
    pub fn remedy(&self) -> Option<&str> {
        self.0.help.as_deref()
    }

    /// The file of the place, as messages show it.
    #[must_use]
    pub fn file(&self) -> Option<&str> {
        self.0.place.as_ref().map(Excerpt::name)
    }

    /// The number of characters that the fault points at, in one line.
    #[must_use]
    pub fn width(&self) -> Option<usize> {
        self.0.place.as_ref().map(Excerpt::width)
    }

    /// Line and column of the place, both counted from 1.
    #[must_use]
    pub fn line_and_column(&self) -> Option<(usize, usize)> {
        self.0.place.as_ref().map(|place| (place.line + 1, place.column + 1))
    }
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(key) = self.scene_key() {
            write!(f, "{key}: ")?;
        }
        f.write_str(&self.0.message)
    }
}

impl std::error::Error for Fault {}

impl Diagnostic for Fault {
    fn code<'a>(&'a self) -> Option<Box<dyn fmt::Display + 'a>> {
        Some(Box::new(self.0.code))
    }

    fn help<'a>(&'a self) -> Option<Box<dyn fmt::Display + 'a>> {
        self.remedy().map(|help| Box::new(help) as Box<dyn fmt::Display>)
    }

    fn source_code(&self) -> Option<&dyn SourceCode> {
        self.0.place.as_ref().map(|place| place as &dyn SourceCode)
    }

    fn labels(&self) -> Option<Box<dyn Iterator<Item = LabeledSpan> + '_>> {
        let place = self.0.place.as_ref()?;
        let label = LabeledSpan::new_with_span(Some("here".to_owned()), place.place.clone());
        Some(Box::new(std::iter::once(label)))
    }
}

/// A warning about an input that can be run.
#[derive(Clone, Debug, PartialEq)]
pub struct Warning {
    /// A stable code, `check::name`.
    pub code: &'static str,
    /// The expected trouble.
    pub message: String,
    /// The remedy.
    pub help: String,
}

impl fmt::Display for Warning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}; {}", self.code, message(&self.message), message(&self.help))
    }
}
