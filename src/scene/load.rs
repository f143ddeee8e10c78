//! Loads a scene: applies `--set` to its text, parses it, reads its files and checks its rules.

use std::path::Path;
use std::sync::Arc;

use crate::contact::config::Contact;
use crate::contact::history::remembered::{self, Remembered};
use crate::contact::selection::Contacts;
use crate::door::DoorMotion;
use crate::fault::Fault;
use crate::grains::file::{self, GrainRow, Kind};
use crate::grains::fill::{Fill, FixedGrain, MOST_TRIES, Placement};
use crate::grains::occupied::Occupied;
use crate::grains::spawner::RadiusLaw;
use crate::integrate::Integrator;
use crate::lattice::load::LoadedLattice;
use crate::measure::fields::{Field, FieldSampler, Grid};
use crate::measure::profile::Profile;
use crate::measure::wall_bands::BandSampler;
use crate::neighbours::Neighbours;
use crate::periodic::Periodic;
use crate::scene::check::{Estimates, automatic};
use crate::scene::{Method, Scene, TimeStep, rules};
use crate::source::{Source, files};
use crate::space::{Dimension, Plane, Solid, Space};
use crate::spin::InertiaLaw;
use crate::values::Positive;
use crate::walls::config::Wall;
use crate::walls::mesh;
use crate::walls::motion::table::Curve;
use crate::walls::moving::{Drive, LeafState, Mover};
use crate::walls::silo_file::{self, Disc, SiloGeometry};
use crate::walls::surfaces::{SurfaceWall, Surfaces};

/// A scene of grains that is ready to run.
#[derive(Debug)]
pub struct Loaded {
    /// The parsed scene, with `--set` applied.
    pub scene: Scene,
    /// The scene's text.
    pub source: Source,
    /// The discs of the silo file.
    pub silo: SiloGeometry,
    /// The grains at the start.
    pub grains: Vec<GrainRow>,
    /// Memories of contacts at the start.
    pub contacts_at_start: Vec<Remembered>,
    /// Wall grains of `fill`.
    pub fixed: Vec<FixedGrain>,
}

/// A scene of either method that is ready to run.
#[derive(Debug)]
pub enum AnyScene {
    /// Discrete elements.
    Grains(Box<Loaded>),
    /// The lattice gas.
    Lattice(Box<LoadedLattice>),
}

impl AnyScene {
    /// The scene's text.
    #[must_use]
    pub fn source(&self) -> &Source {
        match self {
            Self::Grains(loaded) => &loaded.source,
            Self::Lattice(loaded) => &loaded.source,
        }
    }
}

/// Loads the scene at `path`, each of `settings` (key path, value as RON) applied to its text first.
///
/// # Errors
/// If a file cannot be read or has wrong content, or if the scene breaks a rule.
pub fn any(path: &Path, settings: &[(String, String)]) -> Result<AnyScene, Fault> {
    any_from(Source::read(path)?, settings)
}

/// Loads a scene of grains that starts with the grains and contacts of another run, given as the texts of files. They replace
/// the scene's own grains at the start; fixed grains of `fill` stay. `note` is a comment for the scene's text.
///
/// # Errors
/// Like [`load`].
pub fn started_from(
    path: &Path,
    settings: &[(String, String)],
    grains: String,
    contacts: String,
    note: &str,
) -> Result<Box<Loaded>, Fault> {
    let AnyScene::Grains(loaded) = any(path, settings)? else {
        return Err(Fault::new("scene::method", "a run of the lattice gas cannot start from grains")
            .help("give a scene of grains"));
    };
    // Random numbers of a fill depend on its number, so that fills without grains hold the places of the others.
    let count = loaded.scene.fill.iter().rposition(|fill| fill.fixed).map_or(0, |last| last + 1);
    let keep = |fill: &Fill| if fill.fixed { fill.clone() } else { Fill { count: Some(0), ..fill.clone() } };
    let fixed: Vec<_> = loaded.scene.fill[..count].iter().map(keep).collect();
    let fill = ron::to_string(&fixed).map_err(|error| Fault::new("scene::fill", error.to_string()))?;
    let mut more = settings.to_vec();
    let files = "(file: \"grains.csv\", contacts: \"contacts.csv\")";
    more.push(("grains".to_owned(), files.to_owned()));
    if !loaded.scene.fill.is_empty() {
        more.push(("fill".to_owned(), fill));
    }
    let mut source = Source::read(path)?;
    source.texts = vec![("grains.file", grains), ("grains.contacts", contacts)];
    let mut started = from_source(source, &more)?;
    started.source.text.insert_str(0, &format!("// {note}\n"));
    Ok(Box::new(started))
}

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

/// Reads the files of the scene's meshes.
fn read_meshes(loaded: &mut Loaded) -> Result<(), Fault> {
    for (index, wall) in loaded.scene.walls.iter_mut().enumerate() {
        let Wall::Mesh { file, unit, triangles, .. } = wall else { continue };
        let key = format!("walls[{index}].file");
        let path = loaded.source.name_file(&key, file);
        let bytes = files::read_bytes(&path, files::MESH_BYTES)
            .map_err(|error| loaded.source.unreadable(&key, &path, &error))?;
        let read = mesh::read(&path, bytes, *unit).map_err(|message| {
            let message = format!("{}: {message}", path.display());
            loaded.source.fault("scene::mesh", &key, message).help("give a mesh of triangles with an area, each once")
        })?;
        *triangles = read.into();
    }
    Ok(())
}

/// Reads the tables of the scene's motions.
fn read_tables(loaded: &mut Loaded) -> Result<(), Fault> {
    let components = loaded.scene.space.count();
    for (index, motion) in loaded.scene.motions.iter_mut().enumerate() {
        for (key, file, curve, count) in motion.tables(components) {
            let key = format!("motions[{index}].{key}");
            let path = loaded.source.name_file(&key, file);
            let text = files::read_text(&path, files::TABLE_BYTES)
                .map_err(|error| loaded.source.unreadable(&key, &path, &error))?;
            let read = Curve::parse(&text, count).map_err(|message| {
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

fn from_source(mut source: Source, settings: &[(String, String)]) -> Result<Loaded, Fault> {
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
        contacts_at_start: Vec::new(),
        fixed: Vec::new(),
    };
    // Vectors have a checked number of components before any other code reads them.
    rules::space(&loaded)?;
    if let Some(silo) = loaded.scene.silo.clone() {
        let path = loaded.source.name_file("silo.file", &silo.file);
        let text = files::read_text(&path, files::SILO_BYTES)
            .map_err(|error| loaded.source.unreadable("silo.file", &path, &error))?;
        loaded.silo = silo_file::parse(&path.display().to_string(), &text, silo.unit)?;
    }
    if let Some(grains) = loaded.scene.grains.clone() {
        let path = loaded.source.name_file("grains.file", &grains.file);
        let kind = Kind { dimension: loaded.scene.space, spins: loaded.scene.contact.spins() };
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
    read_meshes(&mut loaded)?;
    read_tables(&mut loaded)?;
    // Before any grain is created.
    rules::fill(&loaded)?;
    loaded.fill()?;
    rules::check(&loaded)?;
    loaded.choose_scheme();
    Ok(loaded)
}

/// Reads the file that the key `grains.contacts` names.
fn read_contacts(source: &mut Source, file: &Path) -> Result<Vec<Remembered>, Fault> {
    let key = "grains.contacts";
    let path = source.name_file(key, file);
    let rows = match source.text_for(key) {
        Some(text) => remembered::read(text.as_bytes()),
        None => remembered::read(
            files::BoundedFile::open(&path, files::GRAIN_BYTES)
                .map_err(|error| source.unreadable(key, &path, &error))?,
        ),
    };
    rows.map_err(|problem| {
        source
            .fault("scene::contacts", key, format!("{} is no file of contacts: {problem}", path.display()))
            .help("`siloflow run SCENE --from DIR` writes such files")
    })
}

impl Loaded {
    /// A fault that points at the value of `key`, or at its nearest parent that stands in the text.
    #[must_use]
    pub fn fault(&self, code: &'static str, key: &str, message: impl Into<String>) -> Fault {
        self.source.fault(code, key, message)
    }

    /// Chooses the scheme of a scene with an automatic step that names no scheme.
    fn choose_scheme(&mut self) {
        if let TimeStep::Auto { error } = self.scene.step
            && self.source.value_of("integrator").is_none()
            && self.grain_radii().is_some()
        {
            self.scene.integrator = automatic::cheaper(|scheme| Estimates::with(self, scheme), error.get());
        }
    }

    /// Creates the grains of `fill`.
    fn fill(&mut self) -> Result<(), Fault> {
        let Scene { space, mass, seed, .. } = self.scene;
        let fills = std::mem::take(&mut self.scene.fill);
        for (number, fill) in fills.iter().enumerate() {
            let first_id = self.first_free_id();
            let rows = match (fill.place, space) {
                (Placement::Lattice, _) => fill.grains(space, mass, seed, number, first_id),
                (Placement::Random, Dimension::Plane) => self.random_fill::<Plane>(fill, number)?,
                (Placement::Random, Dimension::Solid) => self.random_fill::<Solid>(fill, number)?,
            };
            if fill.fixed {
                self.fixed.extend(rows.into_iter().map(|row| FixedGrain {
                    position: row.position,
                    radius: row.radius,
                    velocity: row.velocity,
                    species: row.species,
                }));
            } else {
                self.grains.extend(rows);
            }
        }
        self.scene.fill = fills;
        Ok(())
    }

    /// Creates the grains of a random fill: free of all grains and walls so far.
    fn random_fill<V: Space>(&self, fill: &Fill, number: usize) -> Result<Vec<GrainRow>, Fault> {
        let Scene { space, mass, seed, periodic, .. } = &self.scene;
        let (_, largest) = fill.radius.range();
        let mut occupied = Occupied::new(largest, periodic);
        self.grains.iter().for_each(|grain| occupied.add(grain.position, grain.radius));
        self.fixed.iter().for_each(|grain| occupied.add(grain.position, grain.radius));
        self.silo
            .wall
            .iter()
            .chain(&self.silo.door)
            .for_each(|disc| occupied.add(disc.centre.extend(0.0), disc.radius));
        for wall in &self.scene.walls {
            if let Some((centre, radius, _)) = wall.wall_grain() {
                occupied.add(centre.padded(), radius);
            }
        }
        let walls = self.surfaces::<V>();
        // Walls have no images, so a place beyond a periodic side counts as the one that it enters at.
        let periodic_box = Periodic::<V>::new(periodic);
        let is_clear = |x: Solid, radius: f64| {
            let x = periodic_box.map_or(V::narrow(x), |periodic| periodic.wrapped(V::narrow(x)));
            walls.iter().all(|wall| wall.surface.distance(x) >= radius)
        };
        let first_id = self.first_free_id();
        let rows = fill.random_grains(*space, *mass, (*seed, number), first_id, &mut occupied, is_clear);
        let wanted = fill.count.unwrap_or(0) as usize;
        if rows.len() == wanted {
            return Ok(rows);
        }
        let message = format!(
            "{wanted} random grains are wanted, and {} found a place: the next one found none in {MOST_TRIES} tries",
            rows.len()
        );
        Err(self.fault("scene::no_room", &format!("fill[{number}].count"), message).help(
            "lower the count or raise the box; equal grains at random fill at most 0.54 of an area, 0.38 of a volume",
        ))
    }

    /// The contact laws of the scene, for all species that it names.
    #[must_use]
    pub fn contacts(&self) -> Contacts<'_> {
        let Scene { contact, pairs, materials, .. } = &self.scene;
        let species = if pairs.is_empty() && materials.len() <= 1 { 1 } else { self.largest_species() + 1 };
        Contacts { usual: *contact, pairs, materials, species, only: None }
    }

    /// The law of moments of inertia: the scene's, or the default of its space.
    #[must_use]
    pub fn inertia(&self) -> InertiaLaw {
        self.scene.inertia.unwrap_or(InertiaLaw::usual(self.scene.space))
    }

    /// Whether contact forces are centred: the scheme is `Centred`, and at least one contact has drag or friction.
    #[must_use]
    pub fn is_centred(&self) -> bool {
        self.scene.integrator == Integrator::Centred && !self.is_elastic()
    }

    /// Whether no contact has drag or friction.
    #[must_use]
    pub fn is_elastic(&self) -> bool {
        let mut laws = std::iter::once(&self.scene.contact).chain(self.scene.pairs.iter().map(|pair| &pair.contact));
        laws.all(Contact::is_elastic)
    }

    /// The time step, s. Without grains an automatic step is `until`.
    #[must_use]
    pub fn step(&self) -> f64 {
        match self.scene.step {
            TimeStep::Fixed(dt) => dt.get(),
            TimeStep::Auto { .. } => Estimates::of(self).map_or(self.scene.until.get(), |estimates| estimates.dt),
        }
    }

    /// The profiles, each with the area of its cross-section (m^2; in the plane its length, m): from the scene, or from the
    /// periodic box.
    #[must_use]
    pub fn profiles(&self) -> Vec<(Profile, f64)> {
        let with_section = |profile: &Profile| profile.section.map(Positive::get).or(self.periodic_section(profile));
        self.scene.profiles.iter().filter_map(|profile| Some((*profile, with_section(profile)?))).collect()
    }

    /// The cross-section of the periodic box at right angles to a profile, if the box bounds every other axis.
    #[must_use]
    pub fn periodic_section(&self, profile: &Profile) -> Option<f64> {
        let axes = 0..self.scene.space.count();
        let sides = axes.filter(|&axis| axis != profile.axis.number()).map(|axis| self.scene.periodic.axes()[axis]);
        sides.map(|side| side.map(|(low, high)| high - low)).product()
    }

    /// The samplers of the scene's fields.
    #[must_use]
    pub fn fields<V: Space>(&self) -> Vec<FieldSampler<V>> {
        let sampler = |field: &Field| {
            let grid = Grid::new(&field.grid, field.kernel, self.scene.periodic.y);
            FieldSampler::new(*field, grid, self.field_species())
        };
        self.scene.fields.iter().map(sampler).collect()
    }

    /// Number of species whose shares fields measure: none if there is only one.
    #[must_use]
    pub fn field_species(&self) -> usize {
        let largest = self.largest_species();
        if largest > 0 { largest + 1 } else { 0 }
    }

    /// The largest species of all grains and walls.
    #[must_use]
    pub fn largest_species(&self) -> usize {
        let sizes = |law: &RadiusLaw| match law {
            RadiusLaw::Mixture(sizes) => sizes.len().saturating_sub(1),
            _ => 0,
        };
        let spawner = self.scene.spawner.iter().map(|spawner| sizes(&spawner.radius));
        let feeds = self.scene.feed.iter().map(|feed| usize::from(feed.species) + sizes(&feed.radius));
        let mixture = spawner.chain(feeds).max().unwrap_or(0);
        let walls = self.scene.walls.iter().map(|wall| usize::from(wall.species()));
        let silo = self.scene.silo.iter().map(|silo| usize::from(silo.species));
        let grains = self.grains.iter().map(|grain| usize::from(grain.species.0));
        let fixed = self.fixed.iter().map(|grain| usize::from(grain.species.0));
        let pairs = self.scene.pairs.iter().flat_map(|pair| [pair.species.0, pair.species.1]).map(usize::from);
        walls.chain(silo).chain(grains).chain(fixed).chain(pairs).fold(mixture, usize::max)
    }

    /// Fixed discs of a planar scene, without the door and without moving discs: from the silo file, from the scene and
    /// from `fill`.
    #[must_use]
    pub fn wall_discs(&self) -> Vec<Disc> {
        if self.scene.space != Dimension::Plane {
            return Vec::new();
        }
        let own = self.scene.walls.iter().filter_map(Wall::wall_grain);
        let own = own.map(|(centre, radius, _)| Disc { centre: centre.get(), radius });
        let still = self.fixed.iter().filter(|grain| grain.velocity == Solid::ZERO);
        let fixed = still.map(|grain| Disc { centre: grain.position.truncate(), radius: grain.radius });
        self.silo.wall.iter().copied().chain(own).chain(fixed).collect()
    }

    /// Whether a wall surface is a door.
    #[must_use]
    pub fn has_door_surface(&self) -> bool {
        self.scene.walls.iter().any(|wall| self.scene.door_of(wall).is_some())
    }

    /// Whether grains can leave through a door: of discs of the silo file, or a wall surface.
    #[must_use]
    pub fn has_outlet(&self) -> bool {
        !self.silo.door.is_empty() || self.has_door_surface()
    }

    /// The boxes around the doors, m: that of the door discs of the silo file, and those of walls; z is 0 in the plane.
    #[must_use]
    pub fn outlets(&self) -> Vec<[Solid; 2]> {
        let discs = self.silo.door.iter().map(|disc| {
            let (centre, reach) = (disc.centre.extend(0.0), Solid::splat(disc.radius));
            [centre - reach, centre + reach]
        });
        let around = discs.reduce(|[low, high], [lower, higher]| [low.min(lower), high.max(higher)]);
        let of_walls =
            self.scene.walls.iter().filter(|wall| self.scene.door_of(wall).is_some()).filter_map(Wall::bounds);
        around.into_iter().chain(of_walls).collect()
    }

    /// The wall surfaces at the start.
    #[must_use]
    pub fn surfaces<V: Space>(&self) -> Vec<SurfaceWall<V>> {
        if self.scene.motions.is_empty() {
            return self.surfaces_in_scene();
        }
        Surfaces::new(self.surfaces_in_scene(), 0.0).with_movers(self.movers()).all
    }

    /// The wall surfaces at the places that the scene gives, from which motions start.
    #[must_use]
    pub fn surfaces_in_scene<V: Space>(&self) -> Vec<SurfaceWall<V>> {
        let walls = self.scene.walls.iter().filter(|wall| wall.is_surface()).enumerate();
        let surfaces = walls.flat_map(|(number, wall)| {
            let door = self.scene.door_of(wall);
            wall.surfaces(number).into_iter().map(move |surface| SurfaceWall { door, ..surface })
        });
        surfaces.collect()
    }

    /// The wall surfaces without those that a motion moves.
    #[must_use]
    pub fn still_surfaces<V: Space>(&self) -> Vec<SurfaceWall<V>> {
        let walls: Vec<_> = self.scene.walls.iter().filter(|wall| wall.is_surface()).collect();
        let moves = |number: usize| self.scene.motions.iter().any(|motion| walls[number].name() == Some(&motion.walls));
        self.surfaces_in_scene().into_iter().filter(|surface| !moves(surface.number)).collect()
    }

    /// Returns the moving walls: those of `motions`, and doors that move.
    pub(crate) fn movers<V: Space>(&self) -> Vec<Mover<V>> {
        let surfaces: Vec<_> = self.surfaces_in_scene::<V>().into_iter().enumerate().collect();
        let walls: Vec<_> = self.scene.walls.iter().filter(|wall| wall.is_surface()).collect();
        let home = |belongs: &dyn Fn(&SurfaceWall<V>) -> bool| {
            surfaces.iter().filter(|(_, surface)| belongs(surface)).cloned().collect()
        };
        let motions = self.scene.motions.iter().map(|motion| {
            let home = home(&|surface| walls[surface.number].name() == Some(&motion.walls));
            Mover::new(home, Drive::Motion(motion.clone()))
        });
        let leaves = self.scene.door_controls().into_iter().filter_map(|(number, _, control)| {
            let DoorMotion::Move { by, speed } = control.how else { return None };
            let home = home(&|surface| surface.door == Some(number));
            let state = LeafState::default();
            Some(Mover::new(home, Drive::Leaf { door: number, by: by.get(), speed: speed.get(), state }))
        });
        motions.chain(leaves).collect()
    }

    /// The samplers of `wall_bands`.
    #[must_use]
    pub fn wall_bands<V: Space>(&self) -> Vec<BandSampler> {
        let names: Vec<_> = self.scene.walls.iter().filter(|wall| wall.is_surface()).map(Wall::name).collect();
        let surfaces = if self.scene.wall_bands.is_empty() { Vec::new() } else { self.surfaces::<V>() };
        let samplers = self.scene.wall_bands.iter().map(|bands| {
            let walls: Vec<_> = (0..names.len()).filter(|&number| names[number] == Some(&bands.walls)).collect();
            let own = surfaces.iter().filter(|wall| walls.contains(&wall.number)).map(|wall| wall.surface.clone());
            let own: Vec<_> = own.collect();
            BandSampler::new(bands.clone(), walls, &own)
        });
        samplers.collect()
    }

    /// Radii of all fixed discs and spheres, m.
    pub(crate) fn fixed_radii(&self) -> impl Iterator<Item = f64> {
        let own = self.scene.walls.iter().filter_map(Wall::wall_grain).map(|(_, radius, _)| radius);
        let silo = self.silo.wall.iter().chain(&self.silo.door).map(|disc| disc.radius);
        own.chain(silo).chain(self.fixed.iter().map(|grain| grain.radius))
    }

    /// Smallest and largest radius of all grains, present and to be released, m; `None` without grains.
    #[must_use]
    pub fn grain_radii(&self) -> Option<(f64, f64)> {
        let start = self.grains.iter().map(|grain| (grain.radius, grain.radius));
        let to_come = self.scene.spawner.iter().filter(|s| s.count > 0).map(|spawner| spawner.radius.range());
        let feeds = self.scene.feed.iter().map(|feed| feed.radius.range());
        start.chain(to_come).chain(feeds).reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)))
    }

    /// The largest range of a contact beyond touch, m, for the largest grain in a hollow of the wall that multiplies its reduced radius
    /// by up to 8.
    #[must_use]
    pub fn adhesive_range(&self) -> f64 {
        self.grain_radii().map_or(0.0, |(_, largest)| self.contacts().range(8.0 * largest))
    }

    /// The largest centre distance, m, at which a grain touches another particle.
    #[must_use]
    pub fn contact_range(&self) -> f64 {
        let largest_fixed = self.fixed_radii().fold(0.0, f64::max);
        self.grain_radii().map_or(0.0, |(_, largest)| largest + largest.max(largest_fixed))
    }

    /// The lowest id that is free for grains to be released.
    #[must_use]
    pub fn first_free_id(&self) -> u32 {
        self.grains.iter().map(|grain| grain.id.number()).max().map_or(1, |largest| largest.saturating_add(1))
    }

    /// The neighbour search: the scene's, or a Verlet list with a skin of the smallest radius, in solid space a
    /// fifth of it: there, a thicker skin costs more candidates than it saves list renewals.
    #[must_use]
    pub fn neighbours(&self) -> Neighbours {
        let share = if self.scene.space == Dimension::Solid { 0.2 } else { 1.0 };
        self.scene.neighbours.unwrap_or_else(|| {
            let skin = self.grain_radii().and_then(|(smallest, _)| Positive::try_from(share * smallest).ok());
            skin.map_or(Neighbours::AllPairs, |skin| Neighbours::VerletList { skin })
        })
    }
}
