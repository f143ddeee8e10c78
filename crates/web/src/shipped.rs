//! Scenes that come with the program.

use std::fs;
use std::path::Path;

use serde::Serialize;
use siloflow::scene::shipped::{SCENES, Shipped};
use siloflow::text::fault::Fault;

/// The directory of scenes.
const SCENE: &str = "/scene";

#[derive(Serialize)]
pub struct Entry {
    name: &'static str,
    line: &'static str,
}

/// Lists the scenes.
pub fn list() -> Vec<Entry> {
    SCENES.iter().map(|scene| Entry { name: scene.name, line: scene.line }).collect()
}

/// Writes a scene and the file that it names, and returns the text of the scene.
pub fn copy(name: &str) -> Result<String, Fault> {
    let scene = Shipped::named(name).ok_or_else(|| Fault::new("page::scene", format!("there is no scene `{name}`")))?;
    let files = scene.copy(name);
    for (file, content) in &files {
        fs::write(Path::new(SCENE).join(file), content)
            .map_err(|error| Fault::new("page::scene", format!("could not write {file}: {error}")))?;
    }
    Ok(files.into_iter().next().map(|(_, text)| text).unwrap_or_default())
}
