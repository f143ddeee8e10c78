//! Loading: the scene's text with `--set` applied, its files read, its rules checked.

use std::fs;
use std::path::Path;

use crate::fault::Fault;
use crate::grains::file::{self, GrainRow};
use crate::neighbours::Neighbours;
use crate::scene::places::{self, Places};
use crate::scene::values::Positive;
use crate::scene::{Scene, parse, rules};
use crate::walls::silo_file::{self, Disc, SiloGeometry};
use crate::walls::surfaces::{Surface, Wall};

/// A scene that is ready to run.
#[derive(Debug)]
pub struct Loaded {
    /// What the file says, with `--set` applied.
    pub scene: Scene,
    /// The scene's name: that of its file, without ending.
    pub name: String,
    /// The silo's discs.
    pub silo: SiloGeometry,
    /// The grains of the start.
    pub grains: Vec<GrainRow>,
    /// The files that the scene names: key and content, to be kept with the run.
    pub files: Vec<(&'static str, String)>,
    /// The text as resolved.
    pub text: String,
    path: String,
    places: Places,
}

/// Loads the scene at `path`, each of `settings` (key path, value as RON) applied to its text first.
///
/// # Errors
/// If a file cannot be read, is not what it should be, or a rule is broken.
pub fn load(path: &Path, settings: &[(String, String)]) -> Result<Loaded, Fault> {
    let text = read(path, "scene::unreadable", "give the path of a scene, a RON file such as scenes/silo1.ron")?;
    let directory = path.parent().unwrap_or(Path::new("")).to_owned();
    let name = path.file_stem().map_or_else(|| "scene".to_owned(), |stem| stem.to_string_lossy().into_owned());
    from_text(&path.display().to_string(), &name, &directory, text, settings)
}

/// The same for a scene's text; `directory` is where the files that it names are looked for.
///
/// # Errors
/// As [`load`].
pub fn from_text(
    path: &str,
    name: &str,
    directory: &Path,
    mut text: String,
    settings: &[(String, String)],
) -> Result<Loaded, Fault> {
    // What the file itself has wrong is told before what a setting has.
    if !settings.is_empty() {
        parse::parse::<Scene>(path, &text)?;
    }
    for (key, value) in settings {
        text = places::set(&text, key, value)?;
    }
    let scene: Scene = parse::parse(path, &text)?;
    let places = Places::scan(&text);
    let mut loaded = Loaded {
        scene,
        name: name.to_owned(),
        silo: SiloGeometry::default(),
        grains: Vec::new(),
        files: Vec::new(),
        text,
        path: path.to_owned(),
        places,
    };
    if let Some(silo) = loaded.scene.silo.clone() {
        let (shown, text) = loaded.read_named(directory, &silo.file, "silo.file")?;
        loaded.silo = silo_file::parse(&shown, &text, silo.unit)?;
        loaded.files.push(("silo.file", text));
    }
    if let Some(grains) = loaded.scene.grains.clone() {
        let (shown, text) = loaded.read_named(directory, &grains.file, "grains.file")?;
        loaded.grains = file::parse(&shown, &text)?;
        loaded.files.push(("grains.file", text));
    }
    rules::check(&loaded)?;
    Ok(loaded)
}

fn read(path: &Path, code: &'static str, help: &str) -> Result<String, Fault> {
    fs::read_to_string(path)
        .map_err(|error| Fault::new(code, format!("could not read {}: {error}", path.display())).help(help))
}

impl Loaded {
    /// A fault that points at the value of `key`, or at its nearest parent in the text.
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

    /// The scene's file in messages, and its text.
    #[must_use]
    pub fn source(&self) -> (&str, &str) {
        (&self.path, &self.text)
    }

    /// Where the value of `key` starts in the text.
    #[must_use]
    pub fn offset_of(&self, key: &str) -> Option<usize> {
        self.places.get(key).map(|place| place.value.start)
    }

    fn read_named(&self, directory: &Path, file: &Path, key: &str) -> Result<(String, String), Fault> {
        let path = directory.join(file);
        let text = fs::read_to_string(&path).map_err(|error| {
            self.fault("scene::unreadable_file", key, format!("could not read {}: {error}", path.display()))
                .help("the path counts from the directory of the scene file")
        })?;
        Ok((path.display().to_string(), text))
    }

    /// All fixed discs but the door: the silo's wall, then the scene's discs.
    #[must_use]
    pub fn wall_discs(&self) -> Vec<Disc> {
        let own = self.scene.walls.iter().filter_map(|wall| match wall {
            Wall::Disc { centre, radius } => Some(Disc { centre: centre.get(), radius: radius.get() }),
            _ => None,
        });
        self.silo.wall.iter().copied().chain(own).collect()
    }

    /// The flat walls.
    #[must_use]
    pub fn surfaces(&self) -> Vec<Surface> {
        self.scene.walls.iter().filter_map(Wall::surface).collect()
    }

    /// Smallest and largest radius of all grains, of the start and to come, m; `None` without grains.
    #[must_use]
    pub fn grain_radii(&self) -> Option<(f64, f64)> {
        let start = self.grains.iter().map(|grain| (grain.radius, grain.radius));
        let to_come = self.scene.spawner.iter().filter(|s| s.count > 0).map(|spawner| spawner.radius.range());
        start.chain(to_come).reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)))
    }

    /// The largest distance at which two particles touch, at least one of them a grain, m.
    #[must_use]
    pub fn contact_range(&self) -> f64 {
        let largest_fixed = self.wall_discs().iter().chain(&self.silo.door).map(|disc| disc.radius).fold(0.0, f64::max);
        self.grain_radii().map_or(0.0, |(_, largest)| largest + largest.max(largest_fixed))
    }

    /// Ids from here on are free for grains to come.
    #[must_use]
    pub fn first_free_id(&self) -> u32 {
        self.grains.iter().map(|grain| grain.id.number()).max().map_or(1, |largest| largest.saturating_add(1))
    }

    /// The neighbour search: the scene's, or a Verlet list with a skin of the smallest radius.
    #[must_use]
    pub fn neighbours(&self) -> Neighbours {
        self.scene.neighbours.unwrap_or_else(|| {
            let skin = self.grain_radii().and_then(|(smallest, _)| Positive::try_from(smallest).ok());
            skin.map_or(Neighbours::AllPairs, |skin| Neighbours::VerletList { skin })
        })
    }
}
