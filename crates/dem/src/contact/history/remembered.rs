//! Memories by the ids of their particles, so that they can pass from one run to another: as rows of a CSV file.
//!
//! | column | unit | meaning |
//! |---|---|---|
//! | `grain` | | id of a grain |
//! | `with` | | kind of its partner: `grain`, `wall_grain` or `wall` |
//! | `number` | | the partner's id; for a wall grain its number; for a wall its place among all surfaces of the scene (a polygon has several); from 1 |
//! | `wall` | | name of the wall, empty if it has none; may be missing |
//! | `sphere`, `partner_sphere` | | numbers of the spheres that touch in the shapes of `grain` and its partner, from 0; only if grains have shapes |
//! | `at_x`, `at_y`, `at_z` | m | point of the wall that the grain touches, for a wall grain its centre, empty for a grain; may be missing |
//!
//! All other columns are numbers of the memory, seen from `grain`, under the names that the law gives its variables
//! ([`MemoryVariable`](crate::contact::memory::MemoryVariable)). A file of the program's own laws has all of these:
//!
//! | column | unit | meaning |
//! |---|---|---|
//! | `spring_x`, `spring_y`, `spring_z` | m | tangential spring, seen from `grain` |
//! | `rolling_x`, `rolling_y`, `rolling_z` | m | rolling spring |
//! | `stiffness` | N/m | tangential stiffness at the last evaluation, for laws whose stiffness changes |
//! | `twist` | m | twisting spring; may be missing |
//!
//! Numbers are written with enough digits to be read back to the same bits.
//!
//! The place of a wall in a list is no identity: another scene may list its walls in another order. The name and the point are,
//! and the scene that reads the rows finds their walls by them. Without a point `number` counts.

use std::collections::HashMap;
use std::fmt;
use std::io;

use serde::de::{Error as _, MapAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize};

use crate::contact::history::{History, HistoryBlock, resized};
use crate::contact::memory::{Memory, MemoryLayout};
use crate::contact::spring_memory;
use crate::neighbours::list::{BLOCK, Candidate};
use crate::particle::GrainId;
use crate::space::{Plane, Solid, Space};
use crate::store::ParticleStore;
use crate::walls::surface_wall::SurfaceWall;

/// Kind of the partner of a contact.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum PartnerKind {
    /// A grain.
    Grain,
    /// A wall grain.
    WallGrain,
    /// A wall surface.
    Wall,
}

/// The memory of a contact: one row of the file.
#[derive(Clone, Debug, PartialEq)]
pub struct Remembered {
    /// Number of a grain.
    pub grain: u32,
    /// Kind of its partner.
    pub with: PartnerKind,
    /// Number of its partner.
    pub number: u32,
    /// Numbers of the memory, one for each of [`RememberedContacts::columns`].
    numbers: Vec<f64>,
    /// Name of the wall.
    pub wall: Option<String>,
    /// Numbers of the spheres that touch, in the shapes of the grain and its partner; `None` for grains that are one sphere.
    pub spheres: [Option<u16>; 2],
    at: [Option<f64>; 3],
}

impl Remembered {
    /// The point of the wall that the grain touches, or the centre of the wall grain, m.
    #[must_use]
    pub fn at(&self) -> Option<Solid> {
        let [x, y, z] = self.at;
        Some(Solid::new(x?, y?, z?))
    }

    /// The row with this partner at this point (m).
    #[must_use]
    pub fn with_partner_at(self, number: u32, at: Solid) -> Self {
        Self { number, at: [Some(at.x), Some(at.y), Some(at.z)], ..self }
    }

    fn is_finite(&self) -> bool {
        self.numbers.iter().chain(self.at.iter().flatten()).copied().all(f64::is_finite)
    }
}

/// The memories of contacts: the content of the file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RememberedContacts {
    /// Names of the columns of numbers.
    pub columns: Vec<String>,
    /// The rows.
    pub rows: Vec<Remembered>,
}

/// Columns before and after the numbers of the memory.
const FIRST: [&str; 3] = ["grain", "with", "number"];
const LAST: [&str; 4] = ["wall", "at_x", "at_y", "at_z"];

/// Columns of grains with shapes, at the end.
const OF_SHAPES: [&str; 2] = ["sphere", "partner_sphere"];

/// A row with the names of its columns.
struct NamedRow {
    columns: Vec<String>,
    row: Remembered,
}

impl<'de> Deserialize<'de> for NamedRow {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_map(RowVisitor)
    }
}

struct RowVisitor;

impl<'de> Visitor<'de> for RowVisitor {
    type Value = NamedRow;

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str("a row of a file of memories")
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<NamedRow, A::Error> {
        let mut grain = None;
        let mut with = None;
        let mut number = None;
        let mut wall = None;
        let mut at = [None; 3];
        let mut spheres = [None; 2];
        let mut columns = Vec::new();
        let mut numbers = Vec::new();
        while let Some(name) = map.next_key::<String>()? {
            match name.as_str() {
                "grain" => grain = Some(map.next_value()?),
                "with" => with = Some(map.next_value()?),
                "number" => number = Some(map.next_value()?),
                "wall" => wall = map.next_value()?,
                "sphere" => spheres[0] = map.next_value()?,
                "partner_sphere" => spheres[1] = map.next_value()?,
                "at_x" => at[0] = map.next_value()?,
                "at_y" => at[1] = map.next_value()?,
                "at_z" => at[2] = map.next_value()?,
                _ => {
                    numbers.push(map.next_value()?);
                    columns.push(name);
                }
            }
        }
        let missing = |name| A::Error::missing_field(name);
        let row = Remembered {
            grain: grain.ok_or_else(|| missing(FIRST[0]))?,
            with: with.ok_or_else(|| missing(FIRST[1]))?,
            number: number.ok_or_else(|| missing(FIRST[2]))?,
            numbers,
            wall,
            spheres,
            at,
        };
        check_names(&columns).map_err(A::Error::custom)?;
        Ok(NamedRow { columns, row })
    }
}

/// Refuses a file of the program's own laws with unknown or missing columns. A file without any column of these laws is one of a law of
/// another crate, whose columns are known only to that law.
fn check_names(columns: &[String]) -> Result<(), String> {
    let own = MemoryLayout::new::<Plane>(spring_memory::ALL, false).columns();
    if columns == own || !columns.iter().any(|column| own.contains(column)) {
        return Ok(());
    }
    if let Some(unknown) = columns.iter().find(|column| !own.contains(column)) {
        let known = FIRST.into_iter().chain(own.iter().map(String::as_str)).chain(LAST).chain(OF_SHAPES);
        let known: Vec<_> = known.map(|name| format!("`{name}`")).collect();
        return Err(format!("unknown field `{unknown}`, expected one of {}", known.join(", ")));
    }
    // Files of earlier versions have no twist.
    let mut required = own.iter().filter(|name| *name != spring_memory::TWIST.name);
    match required.find(|name| !columns.contains(name)) {
        Some(missing) => Err(format!("missing field `{missing}`")),
        None => Ok(()),
    }
}

/// Reads a file of memories.
///
/// # Errors
/// The reason, with the line.
pub fn read(file: impl io::Read) -> Result<RememberedContacts, String> {
    let mut reader = csv::Reader::from_reader(file);
    let mut contacts = RememberedContacts::default();
    // Rows would be read as if there were none if the header cannot be read.
    reader.headers().map_err(|error| error.to_string())?;
    for row in reader.into_deserialize() {
        let NamedRow { columns, row } = row.map_err(|error| error.to_string())?;
        if !row.is_finite() {
            return Err(format!("row {}: every number must be finite", contacts.rows.len() + 1));
        }
        contacts.columns = columns;
        contacts.rows.push(row);
    }
    Ok(contacts)
}

/// Returns the text of a file of memories.
///
/// # Errors
/// If a row cannot be written.
pub fn write(contacts: &RememberedContacts) -> Result<String, String> {
    let RememberedContacts { columns, rows } = contacts;
    let mut writer = csv::WriterBuilder::new().has_headers(false).from_writer(Vec::new());
    let have_shapes = rows.iter().any(|row| row.spheres != [None; 2]);
    if !rows.is_empty() {
        let of_shapes = if have_shapes { &OF_SHAPES[..] } else { &[] };
        let header = FIRST.into_iter().chain(columns.iter().map(String::as_str)).chain(LAST);
        let header = header.chain(of_shapes.iter().copied());
        writer.write_record(header).map_err(|error| error.to_string())?;
    }
    for Remembered { grain, with, number, numbers, wall, spheres, at } in rows {
        let row = (grain, with, number, numbers, wall, at);
        let written = if have_shapes { writer.serialize((row, spheres)) } else { writer.serialize(row) };
        written.map_err(|error| error.to_string())?;
    }
    let bytes = writer.into_inner().map_err(|error| error.to_string())?;
    String::from_utf8(bytes).map_err(|error| error.to_string())
}

impl History {
    /// Returns the memories of all contacts of the present grains, in the order of slots. Rows of walls have no name yet. `layout` is that
    /// of the memories.
    #[must_use]
    pub fn remembered<V: Space>(
        &self,
        store: &ParticleStore<V>,
        surfaces: &[SurfaceWall<V>],
        layout: &MemoryLayout,
    ) -> RememberedContacts {
        let row = |grain: GrainId, with: PartnerKind, number: u32, memory: &Memory| Remembered {
            grain: grain.number(),
            with,
            number,
            numbers: layout.numbers_in_columns::<V>(memory),
            wall: None,
            spheres: [None; 2],
            at: [None; 3],
        };
        let number_in_shape = |slot: usize| store.bodies.sphere(slot).map(|sphere| sphere.number);
        let are_present = |slots: &[usize]| slots.iter().all(|&slot| store.is_present(slot));
        let pairs = self.pair_blocks.iter().flat_map(HistoryBlock::all);
        let pairs = pairs.filter(|(contact, memory)| are_present(&contact.slots()) && !memory.is_empty());
        let pairs = pairs.map(|(contact, memory)| {
            let [i, j] = contact.slots();
            let id = store.id[j];
            let spheres = [i, j].map(number_in_shape);
            if id.is_wall() {
                let row = row(store.id[i], PartnerKind::WallGrain, id.number(), &memory);
                Remembered { spheres, ..row.with_partner_at(id.number(), store.body[j].position.spread()) }
            } else {
                Remembered { spheres, ..row(store.id[i], PartnerKind::Grain, id.number(), &memory) }
            }
        });
        let walls = self.wall_blocks.iter().flat_map(HistoryBlock::all);
        let walls = walls.filter(|(contact, memory)| are_present(&[contact.row()]) && !memory.is_empty());
        let walls = walls.filter_map(|(contact, memory)| {
            let [i, index] = contact.row_and_partner();
            let number = u32::try_from(index + 1).ok()?;
            let at = surfaces.get(index)?.surface.nearest_point(store.body[i].position);
            let row = row(store.id[i], PartnerKind::Wall, number, &memory);
            Some(Remembered { spheres: [number_in_shape(i), None], ..row.with_partner_at(number, at.spread()) })
        });
        RememberedContacts { columns: layout.columns(), rows: pairs.chain(walls).collect() }
    }

    /// Replaces all memories. Walls are found by their numbers, up to `surfaces`. Rows of particles and walls that do not exist are
    /// left out: the scene that reads them has refused them. Variables of the law without a column are zero.
    pub(in crate::contact) fn replace<V: Space>(
        &mut self,
        store: &ParticleStore<V>,
        surfaces: usize,
        contacts: &RememberedContacts,
        layout: &MemoryLayout,
    ) {
        let columns = layout.columns();
        let places: Vec<_> =
            columns.iter().map(|name| contacts.columns.iter().position(|column| column == name)).collect();
        let number_in_shape = |slot: u32| store.bodies.sphere(slot as usize).map(|sphere| sphere.number);
        let all =
            store.id.iter().copied().zip(0..).filter(|&(_, slot)| store.contact_rows().contains(&(slot as usize)));
        let slots: HashMap<(GrainId, Option<u16>), u32> =
            all.map(|(id, slot)| ((id, number_in_shape(slot)), slot)).collect();
        let slot = |id: Option<GrainId>, sphere: Option<u16>| slots.get(&(id?, sphere)).copied();
        let mut pairs = Vec::new();
        let mut walls = Vec::new();
        for row in &contacts.rows {
            let Some(i) = slot(GrainId::grain(row.grain), row.spheres[0]) else { continue };
            let memory =
                layout.memory_from_columns::<V>(|column| places[column].map_or(0.0, |place| row.numbers[place]));
            let j = match row.with {
                PartnerKind::Grain => slot(GrainId::grain(row.number), row.spheres[1]),
                PartnerKind::WallGrain => slot(GrainId::numbered_wall(row.number), row.spheres[1]),
                PartnerKind::Wall => {
                    let wall = row.number.checked_sub(1).filter(|&wall| (wall as usize) < surfaces);
                    walls.extend(wall.map(|wall| (Candidate::new(i, wall), memory)));
                    None
                }
            };
            if let Some(j) = j.filter(|&j| j != i) {
                let memory = if i > j { layout.seen_from_partner(&memory) } else { memory };
                pairs.push((Candidate::of_slots(i, j), memory));
            }
        }
        for (blocks, mut contacts) in [(&mut self.pair_blocks, pairs), (&mut self.wall_blocks, walls)] {
            // A contact that occurs twice keeps its first row.
            contacts.sort_by_key(|(contact, _)| *contact);
            contacts.dedup_by_key(|(contact, _)| *contact);
            let blocks = resized(blocks, store);
            blocks.iter_mut().for_each(HistoryBlock::clear);
            for (contact, memory) in contacts {
                blocks[contact.row() / BLOCK].push(layout, contact, &memory);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::history::tests::{memory, store};
    use crate::neighbours::list::BLOCK;
    use crate::particle::Species;
    use crate::walls::shapes::half_plane::HalfPlane;
    use crate::walls::surface::Surface;
    use siloflow_text::encoding::TextReader;

    /// The layout of friction with a spring.
    const LAYOUT: &MemoryLayout = &MemoryLayout::new::<Plane>(
        &[
            spring_memory::SPRING,
            spring_memory::ROLLING.kept_if(false),
            spring_memory::STIFFNESS.kept_if(false),
            spring_memory::TWIST.kept_if(false),
        ],
        false,
    );

    #[test]
    fn memories_pass_from_one_order_of_slots_to_another() {
        let ids: Vec<u32> = (0..1500).collect();
        let before = store(&ids, &[]);
        let mut history = History::default();
        for [row, partner] in [[1, 0], [700, 3], [1400, 1200]] {
            let block = &mut history.blocks_mut(&before).0[row as usize / BLOCK];
            block.push(LAYOUT, Candidate::new(row, partner), &memory(0.1 + f64::from(partner)));
        }
        history.blocks_mut(&before).1[0].push(LAYOUT, [5, 2].into(), &memory(7.0));
        let floor = Surface::HalfPlane(HalfPlane { point: Plane::ZERO, normal: Plane::Y });
        let walls = vec![SurfaceWall::still(floor, Species(0)); 3];
        let text = write(&history.remembered(&before, &walls, LAYOUT)).unwrap();
        let read = read(text.as_bytes()).unwrap();
        assert_eq!((read.rows.len(), &read), (4, &history.remembered(&before, &walls, LAYOUT)));
        // The point of the floor below grain 5.
        assert_eq!((read.rows[3].number, read.rows[3].at()), (3, Some(Solid::new(5.0, 0.0, 0.0))));
        // In the reverse order, and without grain 700.
        let reversed: Vec<u32> = (0..1500).rev().filter(|&id| id != 700).collect();
        let after = store(&reversed, &[]);
        let slot = |id: u32| reversed.iter().position(|&other| other == id).unwrap();
        let mut passed = History::default();
        passed.replace(&after, 3, &read, LAYOUT);
        let spring = |a: u32, b: u32| passed.of_pair(slot(a), slot(b)).map(|memory| memory.numbers[0]);
        assert_eq!([spring(0, 1), spring(1200, 1400), spring(3, 4)], [Some(-0.1), Some(-1200.1), None]);
        assert_eq!(passed.of_wall(slot(5), 2).map(|memory| memory.numbers[0]), Some(7.0));
        assert_eq!(passed.remembered(&after, &walls, LAYOUT).rows.len(), 3);
        // Without the third wall its memory is left out.
        passed.replace(&after, 2, &read, LAYOUT);
        assert_eq!((passed.of_wall(slot(5), 2), passed.remembered(&after, &walls, LAYOUT).rows.len()), (None, 2));
    }

    #[test]
    fn wrong_files_are_refused_with_their_line() {
        let header = "grain,with,number,spring_x,spring_y,spring_z,rolling_x,rolling_y,rolling_z,stiffness\n";
        for (row, word) in [
            ("1,grain,2,0,0,0,0,0,0,inf\n", "finite"),
            ("1,stone,2,0,0,0,0,0,0,0\n", "line: 2"),
            ("1,grain,2,0,0,0,0,0,0\n", "line: 2"),
        ] {
            let problem = read(format!("{header}{row}").as_bytes()).unwrap_err();
            assert!(problem.contains(word), "{problem}");
        }
        assert!(read("grain,with\n1,grain\n".as_bytes()).is_err());
        let latin_1 = [header.as_bytes(), b"1,gr\xe4in,2\n"].concat();
        assert!(read(TextReader::new(&latin_1[..])).unwrap_err().contains("line 2, column 5"));
    }
}
