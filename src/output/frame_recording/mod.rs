//! Content of a frame of a run: the state of all particles, contacts and walls at the end of a step.
//!
//! | table | columns |
//! |---|---|
//! | `grains` | `id`, `kind` (0 grain, 1 wall grain, 2 door grain), `species`, `radius`, `mass`, `position`, `velocity`, `spin` where grains spin, `force`, `pressure`, `coordination` (contacts with particles and walls), and the columns that behaviours [register](crate::measure::outputs) |
//! | `contacts` | of particles: `grain`, `partner` (ids), `normal_force`, `tangential_force` (vector, on `grain`), `overlap`, `sliding` (0 or 1) |
//! | `wall_contacts` | with wall surfaces: `grain`, `wall` (number), the same forces, and `point`, the nearest point of the wall |
//!
//! In scenes with shapes `grains` has a row for each sphere, with the columns `sphere` (its number in the grain) and `inclination` (angle of the grain to
//! the vertical, see [`orientation`](crate::measure::orientation)), and contacts have `sphere` and `partner_sphere`. The table `bodies`
//! (`bodies.rs`) has a row for each grain with a shape.
//!
//! The id of wall grain 3 is -3. Rows are in ascending order of ids, wall grains after grains and in the order of their numbers. Forces are those of the full step, as in
//! [`survey::view`](siloflow_dem::survey::view). The pressure of a particle is the sum of its elastic contact forces over its circumference, or in solid space over its surface.

mod bodies;
pub mod geometry;
pub mod live;
mod pressure;
mod species;
pub mod writer;

use std::marker::PhantomData;
use std::sync::Arc;

use bevy_app::{App, Plugin};
use bevy_ecs::prelude::*;
use bevy_ecs::system::{RunSystemOnce as _, SystemParam};

use self::writer::FrameWriter;
use crate::ledger::Ledger;
use crate::measure::orientation::{inclination, vertical};
use crate::measure::outputs::{self, BehaviourOutputs, GrainColumn, GrainValues, Quantity};
use crate::measure::times::Times;
use crate::measure::{ObserveStage, due, observe_at};
use crate::output::frame_recording::live::LiveFormats;
use crate::scene::loaded::Loaded;
use crate::scene::outputs::DataFrames;
use crate::writers::rows::TakenOnce;
use siloflow_dem::gravity::Gravity;
use siloflow_dem::outcome::Outcome;
use siloflow_dem::particle::{Door, Grain, GrainId, Slot};
use siloflow_dem::persist::PersistApp as _;
use siloflow_dem::space::{Linear, Solid, Space};
use siloflow_dem::step::{Clock, Step};
use siloflow_dem::store::SphereOfBody;
use siloflow_dem::survey::contact_state::{ContactState, Touched};
use siloflow_dem::survey::{Partner, Survey, SurveyParam};
use siloflow_figures::colour;
use siloflow_files::frames::file::FrameFile;
use siloflow_files::frames::{Column, FORMAT, Frame, Header, RegisteredColumn, Table, Values, WallGeometry};
use siloflow_files::growing::OutputPlace;

/// The content of the frames of a run.
#[derive(Clone, Debug)]
pub(in crate::output) struct Content {
    /// Whether it holds contacts.
    pub contacts: bool,
    /// Whether it holds walls.
    pub walls: bool,
    /// Whether it holds all columns of grains. Others hold no measured ones: `force`, `pressure`,
    /// `coordination`, and those of behaviours.
    pub measured: bool,
    /// Ends of the half-planes, as in [`Header::domain`], m.
    pub domain: [Solid; 2],
    /// Walls of the header; none if the frame holds no walls.
    pub first_walls: Vec<WallGeometry>,
    /// Columns that behaviours register.
    pub columns: Vec<RegisteredColumn>,
}

impl Content {
    /// Returns the content of the frames of a header.
    pub fn new(header: &Header, contacts: bool, walls: bool, measured: bool) -> Self {
        let domain = header.domain.map(Solid::from_array);
        let columns = if measured { header.columns.clone() } else { Vec::new() };
        Self { contacts, walls, measured, domain, first_walls: header.walls.clone(), columns }
    }
}

/// The frames of a run: their content, and the latest of them.
#[derive(Resource, Clone, Debug)]
pub(in crate::output) struct Recording {
    /// Content of each frame.
    pub content: Content,
    /// The latest frame, which the pictures of the same step are drawn from.
    pub latest: Option<Arc<Frame>>,
}

type Kinds<'w, 's> = Query<'w, 's, (&'static Slot, Has<Door>, Has<Grain>)>;

/// The set that records frames. Pictures are drawn after it.
#[derive(SystemSet, Clone, Debug, PartialEq, Eq, Hash)]
pub(in crate::output) struct FramesRecorded;

/// System parameter: the state that frames are made from.
#[derive(SystemParam)]
pub(in crate::output) struct Observed<'w, 's, V: Space> {
    pub clock: Res<'w, Clock>,
    ledger: Res<'w, Ledger>,
    survey: SurveyParam<'w, V>,
    kinds: Kinds<'w, 's>,
    gravity: Res<'w, Gravity<V>>,
    registered: Option<Res<'w, GrainValues>>,
}

impl<V: Space> Observed<'_, '_, V> {
    /// Returns a frame of the present state.
    pub fn frame(&self, content: &Content) -> Frame {
        let survey = self.survey.survey();
        let mut of_grains = grains(&survey, &self.kinds, vertical(self.gravity.0), content.measured);
        if let Some(values) = &self.registered {
            add_registered(&mut of_grains, &content.columns, values, &rows(&survey));
        }
        let mut tables = vec![of_grains];
        let has_shapes = !survey.store.bodies.shapes.is_empty();
        if content.contacts {
            tables.extend(contacts(&survey.view(self.clock.dt), has_shapes));
        }
        if has_shapes {
            tables.push(bodies::table(survey.store));
        }
        let changed_walls = if content.walls {
            geometry::changed(&content.first_walls, geometry::walls(&survey.walls.all, content.domain))
        } else {
            Vec::new()
        };
        let ledger = &self.ledger;
        let counts = [ledger.released, ledger.inside(), ledger.out(), ledger.lost()].map(u64::from);
        Frame { step: self.clock.steps, time: self.clock.time(), counts, changed_walls, tables }
    }
}

fn record<V: Space>(
    observed: Observed<V>,
    mut recording: ResMut<Recording>,
    mut writer: ResMut<FrameWriter>,
    mut outcome: ResMut<Outcome>,
) {
    let frame = Arc::new(observed.frame(&recording.content));
    recording.latest = Some(Arc::clone(&frame));
    writer.add(frame, &mut outcome);
}

/// Returns the rows of the store that a frame has, in its order.
fn rows<V: Space>(survey: &Survey<V>) -> Vec<usize> {
    let mut rows = survey.store.by_id();
    rows.retain(|&row| survey.store.is_present(row));
    rows
}

/// Adds the columns that behaviours register.
fn add_registered(table: &mut Table, columns: &[RegisteredColumn], values: &GrainValues, rows: &[usize]) {
    for (place, RegisteredColumn { name, unit, .. }) in columns.iter().enumerate() {
        let numbers = Values::F64(rows.iter().map(|&row| values.get(place, row)).collect());
        table.columns.push(column(name, unit, 1, numbers));
    }
}

fn grains<V: Space>(survey: &Survey<V>, kinds: &Kinds, vertical: V, measured: bool) -> Table {
    let store = survey.store;
    let rows = rows(survey);
    let mut kind_of = vec![0; store.len()];
    for (slot, is_door, is_grain) in kinds {
        // A particle that has no slot yet is not in the frame.
        if let Some(kind) = kind_of.get_mut(slot.index()) {
            *kind = if is_grain { 0 } else { 1 + u8::from(is_door) };
        }
    }
    let bytes = |of: &dyn Fn(usize) -> u8| Values::U8(rows.iter().map(|&row| of(row)).collect());
    let floats = |of: &dyn Fn(usize) -> f64| Values::F64(rows.iter().map(|&row| of(row)).collect());
    let vectors = |of: &dyn Fn(usize) -> V| vectors(rows.iter().map(|&row| of(row)));
    let d = V::COMPONENTS;
    let sphere = |row: usize| store.bodies.sphere(row);
    // The spheres of a grain share its mass, so that sums over rows are sums over grains.
    let mass = |row: usize| match sphere(row) {
        Some(SphereOfBody { body, .. }) => {
            let count = u32::try_from(store.bodies.rows_of(body).len()).unwrap_or(u32::MAX);
            store.mass[store.row_of_body(body)] / f64::from(count)
        }
        None => store.mass[row],
    };
    let mut columns = vec![
        column("id", "", 1, Values::I32(rows.iter().map(|&row| id_number(store.id[row])).collect())),
        column("kind", "", 1, bytes(&|row| kind_of[row])),
        column("species", "", 1, bytes(&|row| store.species[row].0)),
        column("radius", "m", 1, floats(&|row| store.body[row].radius)),
        column("mass", "kg", 1, floats(&mass)),
        column("position", "m", d, vectors(&|row| store.body[row].position)),
        column("velocity", "m/s", d, vectors(&|row| store.body[row].velocity)),
    ];
    // A property of the run: frames without grains have the column too.
    if store.has_spins() {
        let spins = self::vectors(rows.iter().map(|&row| store.spin(row)));
        columns.push(column("spin", "rad/s", V::Spin::COUNT, spins));
    }
    // A property of the scene, too.
    if !store.bodies.shapes.is_empty() {
        let numbers = rows.iter().map(|&row| sphere(row).map_or(0, |sphere| sphere.number));
        columns.push(column("sphere", "", 1, Values::U16(numbers.collect())));
        let inclination = |row: usize| store.director(row).map_or(f64::NAN, |director| inclination(director, vertical));
        columns.push(column("inclination", "rad", 1, floats(&inclination)));
    }
    if measured {
        let pressures = pressure::of(survey);
        let coordination = coordination(survey);
        let pressure_unit = if V::COMPONENTS == 2 { "N/m" } else { "N/m^2" };
        columns.extend([
            column("force", "N", d, vectors(&|row| store.loads.force.get(row).unwrap_or(V::ZERO))),
            column("pressure", pressure_unit, 1, floats(&|row| pressures[row])),
            column("coordination", "", 1, Values::U16(rows.iter().map(|&row| coordination[row]).collect())),
        ]);
    }
    Table { name: "grains".to_owned(), rows: rows.len(), columns }
}

/// Returns the number of contacts with particles and walls for each slot.
fn coordination<V: Space>(survey: &Survey<V>) -> Vec<u16> {
    let mut coordination = vec![0_u16; survey.store.len()];
    for contact in survey.touching() {
        coordination[contact.row()] = coordination[contact.row()].saturating_add(1);
        if let Partner::Particle(partner) = contact.partner() {
            coordination[partner] = coordination[partner].saturating_add(1);
        }
    }
    coordination
}

/// Returns the tables of contacts between particles and with walls, with the numbers of spheres if `has_shapes`.
fn contacts<V: Space>(all: &[ContactState<V>], has_shapes: bool) -> [Table; 2] {
    // The view lists contacts with walls last.
    let end = all.iter().position(|contact| matches!(contact.with, Touched::Wall(_))).unwrap_or(all.len());
    let (between, with_walls) = all.split_at(end);
    let partners = between.iter().map(|contact| match contact.with {
        Touched::Particle(id) => id_number(id),
        Touched::Wall(_) => 0,
    });
    let walls = with_walls.iter().map(|contact| match contact.with {
        Touched::Wall(number) => u32::try_from(number).unwrap_or(u32::MAX),
        Touched::Particle(_) => 0,
    });
    let partners = Values::I32(partners.collect());
    let walls = Values::U32(walls.collect());
    let table = |name: &str, partner: Column, contacts: &[ContactState<V>]| {
        let floats = |of: fn(&ContactState<V>) -> f64| Values::F64(contacts.iter().map(of).collect());
        let mut columns = vec![
            column("grain", "", 1, Values::I32(contacts.iter().map(|contact| id_number(contact.grain)).collect())),
            partner,
            column("normal_force", "N", 1, floats(|contact| contact.normal_force)),
            column("tangential_force", "N", V::COMPONENTS, vectors(contacts.iter().map(|contact| contact.friction))),
            column("overlap", "m", 1, floats(|contact| contact.overlap)),
            column("sliding", "", 1, Values::U8(contacts.iter().map(|contact| contact.is_sliding.into()).collect())),
        ];
        if has_shapes {
            let spheres = Values::U16(contacts.iter().map(|contact| contact.sphere).collect());
            columns.push(column("sphere", "", 1, spheres));
        }
        Table { name: name.to_owned(), rows: contacts.len(), columns }
    };
    let mut of_walls = table("wall_contacts", column("wall", "", 1, walls), with_walls);
    let points = vectors(with_walls.iter().map(|contact| contact.from + contact.to_partner));
    of_walls.columns.push(column("point", "m", V::COMPONENTS, points));
    let mut of_pairs = table("contacts", column("partner", "", 1, partners), between);
    if has_shapes {
        let spheres = Values::U16(between.iter().map(|contact| contact.partner_sphere).collect());
        of_pairs.columns.push(column("partner_sphere", "", 1, spheres));
    }
    [of_pairs, of_walls]
}

fn column(name: &str, unit: &str, components: usize, values: Values) -> Column {
    // A vector has at most three components.
    let components = u8::try_from(components).unwrap_or(1);
    Column { name: name.to_owned(), unit: unit.to_owned(), components, values }
}

fn vectors<T: Linear>(all: impl Iterator<Item = T>) -> Values {
    Values::F64(all.flat_map(|v| (0..T::COUNT).map(move |axis| v.component(axis))).collect())
}

/// The number of an id in frames, unique among all particles: wall grains are negative. Many programs have whole numbers of 4 bytes
/// with a sign.
fn id_number(id: GrainId) -> i32 {
    let number = id.number().cast_signed();
    if id.is_wall() { -number } else { number }
}

/// Returns the header of a scene's frames. The world has the columns that behaviours have registered.
#[must_use]
pub fn header<V: Space>(loaded: &Loaded, config: &DataFrames, world: &World) -> Header {
    let domain = geometry::domain(loaded);
    let walls = if config.walls { geometry::walls(&loaded.surfaces::<V>(), domain) } else { Vec::new() };
    let names = (0..=u8::MAX).zip(species::names(loaded));
    Header {
        format: FORMAT,
        version: env!("CARGO_PKG_VERSION").to_owned(),
        scene: loaded.source.name.clone(),
        title: loaded.scene.title.clone(),
        // Two or three.
        dimension: if V::COMPONENTS == 2 { 2 } else { 3 },
        species: names.map(|(number, name)| (name, colour::species(number))).collect(),
        periodic: loaded.scene.periodic.axes(),
        domain: domain.map(|corner| corner.to_array()),
        walls,
        columns: BehaviourOutputs::of_grains(world).iter().map(registered).collect(),
    }
}

/// Returns a frame of the present state with all columns, of a scene with this header.
///
/// # Errors
/// If a system cannot run on this world.
pub fn frame_of_world<V: Space>(header: &Header, contacts: bool, world: &mut World) -> Result<Frame, String> {
    let content = Content::new(header, contacts, true, true);
    world.run_system_once(move |observed: Observed<V>| observed.frame(&content)).map_err(|error| error.to_string())
}

fn registered(column: &GrainColumn) -> RegisteredColumn {
    let GrainColumn { quantity: Quantity { name, unit, label, behaviour }, scale, .. } = column;
    let [name, unit, label, behaviour] = [name, unit, label, behaviour].map(Clone::clone);
    RegisteredColumn { name, unit, label, behaviour, scale: *scale }
}

/// Writes `frames.bin`.
pub struct FrameDataPlugin<V: Space> {
    recording: Recording,
    times: Times,
    writer: TakenOnce<FrameWriter>,
    space: PhantomData<V>,
}

impl<V: Space> FrameDataPlugin<V> {
    /// Creates the file with its header, or continues it; `None` if the scene keeps no frames. The world has the columns that
    /// behaviours have registered.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn create(loaded: &Loaded, world: &World, place: &OutputPlace) -> std::io::Result<Option<Self>> {
        let Some((config, times)) = loaded.data_frames() else { return Ok(None) };
        let header = header::<V>(loaded, config, world);
        let frames = FrameFile::at(place, &header)?;
        let formats = LiveFormats::open(&config.format, header.clone(), place)?;
        let writer = TakenOnce::new(FrameWriter::new(frames, formats));
        let content = Content::new(&header, config.contacts, config.walls, true);
        let recording = Recording { content, latest: None };
        Ok(Some(Self { recording, times, writer, space: PhantomData }))
    }
}

impl<V: Space> Plugin for FrameDataPlugin<V> {
    fn build(&self, app: &mut App) {
        let Some(writer) = self.writer.open() else { return };
        observe_at::<DataFrames>(app, self.times);
        outputs::compute_grain_columns(app, due::<DataFrames>);
        FrameWriter::persist(app);
        app.derived::<Recording>();
        app.insert_resource(self.recording.clone()).insert_resource(writer).add_systems(
            Step,
            record::<V>.in_set(ObserveStage::Write).in_set(FramesRecorded).run_if(due::<DataFrames>),
        );
    }
}
