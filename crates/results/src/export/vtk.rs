//! A directory for ParaView: `grains.pvd`, `contacts.pvd`, `walls.pvd` and `bodies.pvd`, each a list of times and of files
//! `grains-00000.vtp` and so on.
//!
//! | file | geometry | columns |
//! |---|---|---|
//! | `grains` | a point for each particle | all columns of the frame, and `kinetic_energy` |
//! | `contacts` | a line from the centre of the grain to that of its partner or to the wall | `grain`, `partner` (id, or number of the wall), `with_wall`, `normal_force`, `tangential_force`, `overlap`, `sliding` |
//! | `walls` | lines and triangles | `wall`, `species`, `door` |
//! | `bodies` | a point for each grain with a shape, its centre of mass | all columns of the table `bodies` |
//!
//! Contacts, walls and bodies are left out if the frames do not hold them. A contact through a periodic side is a line to the nearest image
//! of the partner.

use std::collections::HashMap;
use std::io;
use std::path::{Path, PathBuf};

use super::grain_columns;
use super::vtp::PolyData;
use crate::export::Format;
use siloflow_files::frames::{Column, Frame, Header, ParticleKey, Table, Values};
use siloflow_files::growing::Growing;
use siloflow_files::own_files;
use siloflow_files::run_files::{Extent, RunFile, RunFiles};
use siloflow_files::whole_file;

/// A directory of frames that grows.
#[derive(Debug)]
pub struct Directory {
    /// Where the directory is.
    pub path: PathBuf,
    /// Number of frames so far.
    count: u64,
    /// Lists of times: of grains, contacts, walls and bodies.
    lists: [Option<List>; 4],
    /// The record of the run's files.
    files: RunFiles,
}

/// Names of the files of a frame, without their numbers.
const NAMES: [&str; 4] = ["grains", "contacts", "walls", "bodies"];

impl Directory {
    /// Starts in an empty directory, or continues in one that has frames.
    ///
    /// # Errors
    /// If there is no such directory, or a list cannot be opened.
    pub fn open(path: &Path, files: &RunFiles) -> io::Result<Self> {
        if !own_files::is_directory(path) {
            return Err(io::Error::from(io::ErrorKind::NotADirectory));
        }
        let mut lists = [const { None }; 4];
        for (list, name) in lists.iter_mut().zip(NAMES) {
            let place = list_of(path, name);
            let is_there = place.symlink_metadata().is_ok();
            *list = if is_there { Some(List::reopen(&place, in_record(files, &place))?) } else { None };
        }
        Ok(Self { path: path.to_owned(), count: 0, lists, files: files.clone() })
    }

    /// Adds a frame.
    ///
    /// # Errors
    /// If a file cannot be written.
    pub fn add(&mut self, header: &Header, frame: &Frame) -> io::Result<()> {
        for ((list, name), content) in self.lists.iter_mut().zip(NAMES).zip(files(header, frame)) {
            let Some(content) = content else { continue };
            let file = format!("{name}-{:05}.vtp", self.count);
            let path = self.path.join(&file);
            let bytes = content.bytes();
            whole_file::write(&path, &bytes)?;
            in_record(&self.files, &path).is_written(Extent::default().with(&bytes));
            let list = if let Some(list) = list {
                list
            } else {
                let path = list_of(&self.path, name);
                list.insert(List::create(&path, in_record(&self.files, &path))?)
            };
            list.add(content.time, &file)?;
        }
        self.count += 1;
        Ok(())
    }

    /// Returns the number of frames, and the length of each list; 0 for one that is not there.
    #[must_use]
    pub fn saved(&self) -> Vec<u64> {
        let lengths = self.lists.iter().map(|list| list.as_ref().map_or(0, |list| list.0.length()));
        std::iter::once(self.count).chain(lengths).collect()
    }

    /// Removes all frames beyond those of [`Directory::saved`].
    ///
    /// # Errors
    /// If a file cannot be changed.
    pub fn restore(&mut self, saved: &[u64]) -> io::Result<()> {
        let (Some((&count, lengths)), true) = (saved.split_first(), saved.len() == 1 + NAMES.len()) else {
            return Err(io::Error::other("the checkpoint has other lists of frames"));
        };
        self.count = count;
        for ((list, name), &length) in self.lists.iter_mut().zip(NAMES).zip(lengths) {
            match list {
                Some(list) if length > 0 => list.0.restore(length).map_err(io::Error::other)?,
                _ => {
                    *list = None;
                    let path = list_of(&self.path, name);
                    whole_file::remove_if_there(&path)?;
                    in_record(&self.files, &path).is_removed();
                }
            }
        }
        for entry in own_files::entries(&self.path)? {
            let path = entry?.path();
            let stem = path.file_stem().and_then(|stem| stem.to_str()).unwrap_or_default();
            let number = stem.rsplit_once('-').and_then(|(_, number)| number.parse::<u64>().ok());
            if number.is_some_and(|number| number >= count) {
                whole_file::remove_if_there(&path)?;
            }
        }
        Ok(())
    }
}

fn list_of(directory: &Path, name: &str) -> PathBuf {
    directory.join(format!("{name}.pvd"))
}

/// The place in the record of a file in the directory.
fn in_record(files: &RunFiles, path: &Path) -> RunFile {
    files.file(format!("{}/{}", Format::Vtk.file_name(), path.file_name().unwrap_or_default().to_string_lossy()))
}

/// A list of times and files. Each row is written over the end of the list, and the end behind it.
#[derive(Debug)]
struct List(Growing);

const LIST_START: &str = "<?xml version=\"1.0\"?>\n\
    <VTKFile type=\"Collection\" version=\"1.0\" byte_order=\"LittleEndian\">\n<Collection>\n";
const LIST_END: &[u8] = b"</Collection>\n</VTKFile>\n";

impl List {
    fn create(path: &Path, record: RunFile) -> io::Result<Self> {
        let mut list = Self(Growing::create(path, record, LIST_END)?);
        list.0.append(LIST_START.as_bytes())?;
        Ok(list)
    }

    fn reopen(path: &Path, record: RunFile) -> io::Result<Self> {
        Growing::reopen(path, record, LIST_END).map(Self)
    }

    fn add(&mut self, time: f64, name: &str) -> io::Result<()> {
        self.0.append(format!("<DataSet timestep=\"{time:e}\" file=\"{name}\"/>\n").as_bytes())
    }
}

/// Returns the files of a frame, in the order of [`NAMES`]; `None` where the frames do not hold such data.
fn files(header: &Header, frame: &Frame) -> [Option<PolyData>; 4] {
    let walls = (!header.walls.is_empty()).then(|| walls(header, frame));
    [Some(grains(header, frame)), contacts(header, frame), walls, bodies(header, frame)]
}

fn bodies(header: &Header, frame: &Frame) -> Option<PolyData> {
    let table = frame.table("bodies")?;
    let columns = table.columns.iter().filter(|column| column.name != "position").cloned().collect();
    let points = points(table, "position", header);
    Some(PolyData { time: frame.time, points, point_data: columns, verts: true, ..PolyData::default() })
}

fn grains(header: &Header, frame: &Frame) -> PolyData {
    let (_, mut columns) = grain_columns(header, frame);
    columns.retain(|column| column.name != "position");
    let points = frame.table("grains").map_or(Vec::new(), |grains| points(grains, "position", header));
    PolyData { time: frame.time, points, point_data: columns, verts: true, ..PolyData::default() }
}

/// Returns a column of vectors, padded to three components.
fn points(table: &Table, name: &str, header: &Header) -> Vec<[f64; 3]> {
    let padded = |x: &[f64]| [x[0], x[1], x.get(2).copied().unwrap_or(0.0)];
    table.floats(name).unwrap_or_default().chunks_exact(header.dimension.into()).map(padded).collect()
}

fn contacts(header: &Header, frame: &Frame) -> Option<PolyData> {
    let grains = frame.table("grains")?;
    let between = frame.table("contacts")?;
    let walls = frame.table("wall_contacts")?;
    let keys = grains.particles("id", "sphere")?;
    let places = points(grains, "position", header);
    let place_of: HashMap<ParticleKey, [f64; 3]> = keys.into_iter().zip(places).collect();
    let place_of = |key: &ParticleKey| place_of.get(key).copied().unwrap_or([f64::NAN; 3]);
    let [first, second] = [between.particles("grain", "sphere")?, between.particles("partner", "partner_sphere")?];
    let pairs = first.iter().zip(&second).flat_map(|(grain, partner)| {
        let from = place_of(grain);
        [from, nearest_image(header, from, place_of(partner))]
    });
    let of_walls = walls.particles("grain", "sphere")?;
    let wall_points = points(walls, "point", header);
    let to_walls = of_walls.iter().zip(&wall_points).flat_map(|(grain, &point)| [place_of(grain), point]);
    let ends: Vec<_> = pairs.chain(to_walls).collect();
    let count = u32::try_from(ends.len() / 2).unwrap_or(u32::MAX);
    let with_wall = [vec![0; between.rows], vec![1; walls.rows]].concat();
    let mut columns = vec![
        column("grain", Values::I32(first.iter().chain(&of_walls).map(|key| key.id).collect())),
        column("partner", whole([second.iter().map(|key| key.id.into()).collect(), walls.whole("wall")?].concat())),
        column("with_wall", Values::U8(with_wall)),
    ];
    // The columns that both tables have.
    for one in between.columns.iter().skip(2) {
        let joined = match (&one.values, walls.column(&one.name).map(|other| &other.values)) {
            (Values::F64(a), Some(Values::F64(b))) => Values::F64([&a[..], b].concat()),
            (Values::I32(a), Some(Values::I32(b))) => Values::I32([&a[..], b].concat()),
            (Values::U32(a), Some(Values::U32(b))) => Values::U32([&a[..], b].concat()),
            (Values::U16(a), Some(Values::U16(b))) => Values::U16([&a[..], b].concat()),
            (Values::U8(a), Some(Values::U8(b))) => Values::U8([&a[..], b].concat()),
            _ => continue,
        };
        columns.push(Column { values: joined, ..one.clone() });
    }
    let lines = (0..count).map(|line| [2 * line, 2 * line + 1]).collect();
    Some(PolyData { time: frame.time, points: ends, lines, cell_data: columns, ..PolyData::default() })
}

fn whole(numbers: Vec<i64>) -> Values {
    Values::I32(numbers.into_iter().map(|number| i32::try_from(number).unwrap_or(i32::MAX)).collect())
}

/// Returns the image of `to` through periodic sides that is nearest to `from`.
fn nearest_image(header: &Header, from: [f64; 3], to: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|axis| match header.periodic[axis] {
        Some((low, high)) => {
            let length = high - low;
            to[axis] - length * ((to[axis] - from[axis]) / length).round()
        }
        None => to[axis],
    })
}

fn walls(header: &Header, frame: &Frame) -> PolyData {
    let walls = frame.walls(header);
    let mut data = PolyData { time: frame.time, ..PolyData::default() };
    // The columns of lines come before those of triangles.
    let mut of_lines = Vec::new();
    let mut of_triangles = Vec::new();
    for wall in walls {
        let first = u32::try_from(data.points.len()).unwrap_or(u32::MAX);
        data.points.extend(&wall.points);
        data.lines.extend(wall.lines.iter().map(|line| line.map(|place| first + place)));
        data.triangles.extend(wall.triangles.iter().map(|triangle| triangle.map(|place| first + place)));
        of_lines.extend(wall.lines.iter().map(|_| wall));
        of_triangles.extend(wall.triangles.iter().map(|_| wall));
    }
    of_lines.extend(of_triangles);
    data.cell_data = vec![
        column("wall", Values::U32(of_lines.iter().map(|wall| wall.number).collect())),
        column("species", Values::U8(of_lines.iter().map(|wall| wall.species).collect())),
        column("door", Values::U8(of_lines.iter().map(|wall| wall.is_door.into()).collect())),
    ];
    data
}

fn column(name: &str, values: Values) -> Column {
    Column { name: name.to_owned(), unit: String::new(), components: 1, values }
}
