//! Loads a scene: applies `--set` to its text, parses it, reads its files and checks its rules.

mod contacts;
mod fill;
mod growth;
mod shapes;
pub mod start_state;

use std::path::Path;
use std::sync::Arc;

use crate::grains::file::{self, Kind};
use crate::grains::shaped::Shapes;
use crate::lattice_silo::loaded::LoadedLattice;
use crate::scene::check::automatic;
use crate::scene::check::quantities::Estimates;
use crate::scene::loaded::{AnyScene, Loaded};
use crate::scene::{KEYS, Method, Scene, TimeStep, rules};
use siloflow_dem::bodies::config::ShapeConfig;
use siloflow_dem::contact::history::remembered::{self, RememberedContacts};
use siloflow_dem::walls::config::shape::WallShape;
use siloflow_dem::walls::mesh;
use siloflow_dem::walls::motion::Table;
use siloflow_dem::walls::motion::table::Curve;
use siloflow_dem::walls::silo_file::{self, SiloGeometry};
use siloflow_text::fault::Fault;
use siloflow_text::file::{self as input, GRAIN_BYTES, MESH_BYTES, SILO_BYTES, TABLE_BYTES};
use siloflow_text::source::Source;

/// Loads the scene at `path`, each of `settings` (key path, value as RON) applied to its text first.
///
/// # Errors
/// If a file cannot be read or has wrong content, or if the scene breaks a rule.
pub fn any(path: &Path, settings: &[(String, String)]) -> Result<AnyScene, Fault> {
    any_from(Source::read(path)?, settings)
}

/// The key that names a file of contacts.
const CONTACTS: &str = "grains.contacts";

fn any_from(source: Source, settings: &[(String, String)]) -> Result<AnyScene, Fault> {
    if source.value_of("scene").is_some() && source.value_of("figures").is_some() {
        return Err(source
            .fault("scene::is_a_sweep", "scene", "this is a sweep file, not a scene")
            .help("run it with `siloflow sweep`, or give the scene that it names"));
    }
    if source.value_of("method").is_some_and(|method| method.starts_with("LatticeGas")) {
        return LoadedLattice::new(source, settings).map(Box::new).map(AnyScene::Lattice);
    }
    from_source(source, settings).map(Box::new).map(AnyScene::Grains)
}

/// Loads the scene at `path` under another name than that of its file.
///
/// # Errors
/// Like [`any`].
pub fn named(path: &Path, name: &str) -> Result<AnyScene, Fault> {
    let mut source = Source::read(path)?;
    name.clone_into(&mut source.name);
    any_from(source, &[])
}

/// Loads a scene of grains.
///
/// # Errors
/// Like [`any`]; also if the scene has another method.
pub fn load(path: &Path, settings: &[(String, String)]) -> Result<Loaded, Fault> {
    from_source(Source::read(path)?, settings)
}

/// Reads the files of the scene's meshes: walls and shapes.
fn read_meshes(loaded: &mut Loaded) -> Result<(), Fault> {
    let Loaded { scene, source, .. } = loaded;
    let walls = scene.walls.iter_mut().enumerate().filter_map(|(index, wall)| match &mut wall.shape {
        WallShape::Mesh { file, unit, triangles } => Some((format!("walls[{index}].file"), &*file, *unit, triangles)),
        _ => None,
    });
    let shapes = scene.shapes.iter_mut().filter_map(|(name, shape)| match shape {
        ShapeConfig::Mesh { file, unit, triangles, .. } => {
            Some((format!("shapes.{name}.file"), &*file, *unit, triangles))
        }
        _ => None,
    });
    for (key, file, unit, triangles) in walls.chain(shapes) {
        let path = source.name_file(&key, file);
        let bytes = input::read_bytes(&path, MESH_BYTES).map_err(|error| source.unreadable(&key, &path, &error))?;
        let read = mesh::read(&path, &bytes, unit).map_err(|message| {
            let message = format!("{}: {message}", path.display());
            source.fault("scene::mesh", &key, message).help("give a mesh of triangles with an area, each once")
        })?;
        *triangles = read.into();
    }
    Ok(())
}

/// Reads the tables of the scene's motions.
fn read_tables(loaded: &mut Loaded) -> Result<(), Fault> {
    let components = loaded.scene.space.count();
    for (index, motion) in loaded.scene.motions.iter_mut().enumerate() {
        for Table { key, file, curve, values } in motion.tables(components) {
            let key = format!("motions[{index}].{key}");
            let path = loaded.source.name_file(&key, file);
            let text =
                input::read_text(&path, TABLE_BYTES).map_err(|error| loaded.source.unreadable(&key, &path, &error))?;
            let read = Curve::parse(&text, values).map_err(|message| {
                let message = format!("{}: {message}", path.display());
                loaded.source.fault("scene::table", &key, message).help(
                    "give a CSV file: a header that begins with `time_s`, then rows of a time (s) and the components of the \
                     shift (m) or the angle (rad), with ascending times",
                )
            })?;
            *curve = Arc::new(read);
        }
    }
    Ok(())
}

/// Loads a scene of grains from its text. Relative file names start from `directory`.
///
/// # Errors
/// Like [`load`].
pub fn from_text(
    path: &str,
    name: &str,
    directory: &Path,
    text: String,
    settings: &[(String, String)],
) -> Result<Loaded, Fault> {
    from_source(Source::new(path, name, directory, text), settings)
}

fn from_source(source: Source, settings: &[(String, String)]) -> Result<Loaded, Fault> {
    let mut loaded = read_all(source, settings)?;
    if let [(row, stray), ..] = &loaded.find_partners()[..] {
        let path =
            loaded.source.files.iter().find(|(key, _)| key == CONTACTS).map(|(_, path)| path.display().to_string());
        let message = format!("{}, row {row}: {}", path.unwrap_or_default(), stray.reason);
        return Err(loaded.fault("scene::contacts", CONTACTS, message).help(
            "a row needs a grain of the scene, and a grain, wall grain or wall that it touches; remove the row, or let \
             `siloflow run SCENE --from DIR` leave out the contacts with walls that are gone",
        ));
    }
    loaded.choose_scheme();
    Ok(loaded)
}

/// Loads a scene from its text, without finding the partners of its contacts.
fn read_all(mut source: Source, settings: &[(String, String)]) -> Result<Loaded, Fault> {
    source.reference = KEYS;
    let scene: Scene = source.parse(settings)?;
    if scene.method != Method::Grains {
        return Err(source
            .fault("scene::method", "method", "this is not a scene of grains")
            .help("a scene's method is part of its file, not of a setting"));
    }
    let mut loaded = Loaded {
        scene,
        source,
        silo: SiloGeometry::default(),
        grains: Vec::new(),
        contacts_at_start: RememberedContacts::default(),
        fixed: Vec::new(),
        walls_of_fills: Vec::new(),
        notes: Vec::new(),
        shapes: Shapes::default(),
    };
    // Vectors have a checked number of components before any other code reads them.
    rules::space(&loaded)?;
    read_meshes(&mut loaded)?;
    loaded.resolve_shapes()?;
    loaded.grow()?;
    if let Some(silo) = loaded.scene.silo.clone() {
        let path = loaded.source.name_file("silo.file", &silo.file);
        let text = input::read_text(&path, SILO_BYTES)
            .map_err(|error| loaded.source.unreadable("silo.file", &path, &error))?;
        loaded.silo = silo_file::parse(&path.display().to_string(), &text, silo.unit)?;
    }
    if let Some(grains) = loaded.scene.grains.clone() {
        let path = loaded.source.name_file("grains.file", &grains.file);
        let kind = Kind { dimension: loaded.scene.space, spins: loaded.grains_spin(), shapes: &loaded.shapes.facts };
        let name = path.display().to_string();
        loaded.grains = match loaded.source.text_for("grains.file") {
            Some(text) => file::parse(&name, text, kind)?,
            None => file::read(&name, &path, kind)
                .map_err(|error| loaded.source.unreadable("grains.file", &path, &error))??,
        };
        if let Some(contacts) = grains.contacts {
            loaded.contacts_at_start = read_contacts(&mut loaded.source, &contacts)?;
        }
    }
    read_tables(&mut loaded)?;
    // Before any grain is created.
    rules::fill(&loaded)?;
    loaded.fill()?;
    rules::check(&loaded)?;
    Ok(loaded)
}

/// Reads the file that the key `grains.contacts` names.
fn read_contacts(source: &mut Source, file: &Path) -> Result<RememberedContacts, Fault> {
    let key = CONTACTS;
    let path = source.name_file(key, file);
    let rows = match source.text_for(key) {
        Some(text) => remembered::read(text.as_bytes()),
        None => remembered::read(
            input::open_text(&path, GRAIN_BYTES).map_err(|error| source.unreadable(key, &path, &error))?,
        ),
    };
    rows.map_err(|problem| {
        source
            .fault("scene::contacts", key, format!("{} is no file of contacts: {problem}", path.display()))
            .help("`siloflow run SCENE --from DIR` writes such files")
    })
}

impl Loaded {
    /// Chooses the scheme of a scene with an automatic step that names no scheme.
    fn choose_scheme(&mut self) {
        if let TimeStep::Auto { error } = self.scene.step
            && self.source.value_of("integrator").is_none()
            && self.grain_radii().is_some()
        {
            self.scene.integrator = automatic::cheaper(|scheme| Estimates::with(self, scheme), error.get());
        }
    }
}
