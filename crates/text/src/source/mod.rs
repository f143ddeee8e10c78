//! The text of a scene: its origin, the byte range of each key, its parameters, and the files that it names.

mod expression;
pub mod keys;
pub mod parameters;
pub mod parse;
pub mod places;
mod reference;

use std::io;
use std::path::{Path, PathBuf};

use ron::error::SpannedError;
use serde::de::DeserializeOwned;

use crate::encoding::MARK;
use crate::fault::{Fault, Warning};
use crate::file;
use crate::source::parameters::Resolved;
use crate::source::parse::Texts;
use crate::source::places::{Place, Places};

/// A scene's text, with `--set` applied.
#[derive(Debug)]
pub struct Source {
    /// The scene's name: its file name without extension.
    pub name: String,
    /// The text with all settings applied.
    pub text: String,
    /// Files that the scene names, as key and path. A run keeps copies of them.
    pub files: Vec<(String, PathBuf)>,
    /// Texts that stand for named files, by key.
    pub texts: Vec<(&'static str, String)>,
    /// The page of reference that has the keys' values and units, for the help of errors; empty if there is none.
    pub reference: &'static str,
    path: String,
    directory: PathBuf,
    places: Places,
    /// The text that is parsed, if the scene has parameters.
    resolved: Option<Resolved>,
}

impl Source {
    /// Reads the file at `path`.
    ///
    /// # Errors
    /// If it cannot be read, is not a regular file, or is too large.
    pub fn read(path: &Path) -> Result<Self, Fault> {
        let text = file::read_text(path, file::SCENE_BYTES).map_err(|error| {
            Fault::new("scene::unreadable", format!("could not read {}: {error}", path.display()))
                .help(file::remedy(&error, "give the path of a scene, a RON file such as scenes/silo1.ron"))
        })?;
        let directory = path.parent().unwrap_or(Path::new(""));
        let name = path.file_stem().map_or_else(|| "scene".to_owned(), |stem| stem.to_string_lossy().into_owned());
        Ok(Self::new(&path.display().to_string(), &name, directory, text))
    }

    /// Takes a text. Messages show `path`; relative file names in the text start from `directory`.
    #[must_use]
    pub fn new(path: &str, name: &str, directory: &Path, mut text: String) -> Self {
        // Files are read without a byte order mark; a text may come from elsewhere.
        if text.starts_with(MARK) {
            text.remove(0);
        }
        let places = Places::scan(&text);
        Self {
            name: name.to_owned(),
            text,
            files: Vec::new(),
            texts: Vec::new(),
            reference: "",
            path: path.to_owned(),
            directory: directory.to_owned(),
            places,
            resolved: None,
        }
    }

    /// Applies settings (key path, value as RON) to the text, evaluates its expressions and parses it.
    ///
    /// # Errors
    /// If the text, an expression or a setting is wrong.
    pub fn parse<T: DeserializeOwned>(&mut self, settings: &[(String, String)]) -> Result<T, Fault> {
        // Errors of the file itself are reported before errors of settings.
        if !settings.is_empty() {
            self.parse_text::<T>()?;
        }
        self.apply(settings)?;
        self.parse_text()
    }

    /// Applies settings (key path, value as RON) to the text.
    ///
    /// # Errors
    /// If a setting is wrong.
    pub fn apply(&mut self, settings: &[(String, String)]) -> Result<(), Fault> {
        for (key, value) in settings {
            parameters::check_setting(&self.places, key)?;
            self.text = places::set(&self.text, key, value)?;
        }
        self.places = Places::scan(&self.text);
        Ok(())
    }

    fn parse_text<T: DeserializeOwned>(&mut self) -> Result<T, Fault> {
        self.resolved = parameters::resolve(&self.path, &self.text, &self.places)?;
        parse::parse_texts(self.texts())
    }

    fn texts(&self) -> Texts<'_> {
        Texts { name: &self.path, written: &self.text, resolved: self.resolved.as_ref(), reference: self.reference }
    }

    /// The fault for an error of a parser that was given the value of `key`, its expressions evaluated.
    #[must_use]
    pub fn explain(&self, key: &str, error: &SpannedError) -> Fault {
        let written = self.places.get(key).map_or(0, |place| place.value.start);
        let parsed = self.resolved.as_ref().map_or(written, |resolved| resolved.parsed(written));
        parse::explain(self.texts(), error, parsed)
    }

    /// The names of the parameters that are numbers, with their values, in the order of the scene.
    #[must_use]
    pub fn numeric_parameters(&self) -> Vec<(String, f64)> {
        let entries = self.places.get(parameters::KEY).into_iter().flat_map(|section| self.places.entries(section));
        entries.filter_map(|(name, place)| Some((name.to_owned(), self.text_of(place).parse().ok()?))).collect()
    }

    /// A warning for each parameter that no expression uses.
    #[must_use]
    pub fn unused_parameters(&self) -> Vec<Warning> {
        let unused = self.resolved.iter().flat_map(|resolved| &resolved.unused);
        unused
            .map(|name| Warning {
                code: "check::unused_parameter",
                message: format!("no expression uses the parameter `{name}`"),
                help: format!("write it as \"= {name}\" where it is needed, or remove it"),
            })
            .collect()
    }

    /// A fault that points at the value of `key`, or at its nearest parent that stands in the text.
    #[must_use]
    pub fn fault(&self, code: &'static str, key: &str, message: impl Into<String>) -> Fault {
        let fault = Fault::new(code, message).key(key);
        match self.places.nearest(key) {
            Some(place) => {
                let first_line = self.text[place.value.clone()].find('\n').unwrap_or(place.value.len());
                fault.at(&self.path, &self.text, place.value.start..place.value.start + first_line)
            }
            None => fault.at(&self.path, &self.text, 0..self.text.find('\n').unwrap_or(self.text.len())),
        }
    }

    /// Path of the scene's file, as shown in messages.
    #[must_use]
    pub fn path(&self) -> &str {
        &self.path
    }

    /// The text of the value of `key`.
    #[must_use]
    pub fn value_of(&self, key: &str) -> Option<&str> {
        self.places.get(key).map(|place| self.text_of(place))
    }

    /// The text of a value.
    fn text_of(&self, place: &Place) -> &str {
        self.text[place.value.clone()].trim()
    }

    /// Records a file that `key` names, and returns its path.
    pub fn name_file(&mut self, key: &str, file: &Path) -> PathBuf {
        let path = self.path_of(file);
        self.files.push((key.to_owned(), path.clone()));
        path
    }

    /// Returns the path of a file that the text names.
    #[must_use]
    pub fn path_of(&self, file: &Path) -> PathBuf {
        self.directory.join(file)
    }

    /// Returns the text that stands for the file that `key` names, if there is one.
    #[must_use]
    pub fn text_for(&self, key: &str) -> Option<&str> {
        self.texts.iter().find(|(of, _)| *of == key).map(|(_, text)| &**text)
    }

    /// The fault for a named file that cannot be read.
    #[must_use]
    pub fn unreadable(&self, key: &str, path: &Path, error: &io::Error) -> Fault {
        self.fault("scene::unreadable_file", key, format!("could not read {}: {error}", path.display()))
            .help(file::remedy(error, "the path counts from the directory of the scene file"))
    }
}
