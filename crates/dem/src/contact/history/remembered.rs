//! Memories by the ids of their particles, so that they can pass from one run to another: as rows of a CSV file.
//!
//! | column | unit | meaning |
//! |---|---|---|
//! | `grain` | | id of a grain |
//! | `with` | | kind of its partner: `grain`, `wall_grain` or `wall` |
//! | `number` | | the partner's id; for a wall grain its number; for a wall its place among all surfaces of the scene (a polygon has several); from 1 |
//! | `wall` | | name of the wall, empty if it has none; may be missing |
//! | `at_x`, `at_y`, `at_z` | m | point of the wall that the grain touches, for a wall grain its centre, empty for a grain; may be missing |
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
use std::io;

use serde::{Deserialize, Serialize};

use crate::contact::history::{History, HistoryBlock, rewrite};
use crate::contact::{Memory, MemoryParts};
use crate::neighbours::list::Candidate;
use crate::particle::GrainId;
use crate::space::{Solid, Space};
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
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Remembered {
    /// Number of a grain.
    pub grain: u32,
    /// Kind of its partner.
    pub with: PartnerKind,
    /// Number of its partner.
    pub number: u32,
    spring_x: f64,
    spring_y: f64,
    spring_z: f64,
    rolling_x: f64,
    rolling_y: f64,
    rolling_z: f64,
    stiffness: f64,
    #[serde(default)]
    twist: f64,
    /// Name of the wall.
    #[serde(default)]
    pub wall: Option<String>,
    #[serde(default)]
    at_x: Option<f64>,
    #[serde(default)]
    at_y: Option<f64>,
    #[serde(default)]
    at_z: Option<f64>,
}

impl Remembered {
    fn new<V: Space>(grain: GrainId, (with, number): (PartnerKind, u32), memory: &Memory<V>) -> Self {
        let spring = memory.spring.spread();
        let rolling = memory.rolling.spread();
        Self {
            grain: grain.number(),
            with,
            number,
            spring_x: spring.x,
            spring_y: spring.y,
            spring_z: spring.z,
            rolling_x: rolling.x,
            rolling_y: rolling.y,
            rolling_z: rolling.z,
            stiffness: memory.stiffness,
            twist: memory.twist,
            wall: None,
            at_x: None,
            at_y: None,
            at_z: None,
        }
    }

    /// The point of the wall that the grain touches, or the centre of the wall grain, m.
    #[must_use]
    pub fn at(&self) -> Option<Solid> {
        Some(Solid::new(self.at_x?, self.at_y?, self.at_z?))
    }

    /// The row with this partner at this point (m).
    #[must_use]
    pub fn with_partner_at(self, number: u32, at: Solid) -> Self {
        Self { number, at_x: Some(at.x), at_y: Some(at.y), at_z: Some(at.z), ..self }
    }

    /// The memory, seen from `grain`.
    fn memory<V: Space>(&self) -> Memory<V> {
        Memory {
            spring: V::narrow(Solid::new(self.spring_x, self.spring_y, self.spring_z)),
            rolling: V::narrow(Solid::new(self.rolling_x, self.rolling_y, self.rolling_z)),
            stiffness: self.stiffness,
            twist: self.twist,
        }
    }

    fn is_finite(&self) -> bool {
        let springs = [self.spring_x, self.spring_y, self.spring_z, self.rolling_x, self.rolling_y, self.rolling_z];
        let at = [self.at_x, self.at_y, self.at_z].into_iter().flatten();
        springs.into_iter().chain([self.stiffness, self.twist]).chain(at).all(f64::is_finite)
    }
}

/// Reads a file of memories.
///
/// # Errors
/// The reason, with the line.
pub fn read(file: impl io::Read) -> Result<Vec<Remembered>, String> {
    let mut reader = csv::Reader::from_reader(file);
    let mut rows = Vec::new();
    // Rows would be read as if there were none if the header cannot be read.
    reader.headers().map_err(|error| error.to_string())?;
    for row in reader.into_deserialize() {
        let row: Remembered = row.map_err(|error| error.to_string())?;
        if !row.is_finite() {
            return Err(format!("row {}: every number must be finite", rows.len() + 1));
        }
        rows.push(row);
    }
    Ok(rows)
}

/// Returns the text of a file of memories.
///
/// # Errors
/// If a row cannot be written.
pub fn write(rows: &[Remembered]) -> Result<String, String> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    rows.iter().try_for_each(|row| writer.serialize(row)).map_err(|error| error.to_string())?;
    let bytes = writer.into_inner().map_err(|error| error.to_string())?;
    String::from_utf8(bytes).map_err(|error| error.to_string())
}

impl<V: Space> History<V> {
    /// Returns the memories of all contacts of the present grains, in the order of slots. Rows of walls have no name yet.
    #[must_use]
    pub fn remembered(&self, store: &ParticleStore<V>, surfaces: &[SurfaceWall<V>]) -> Vec<Remembered> {
        let are_present = |slots: &[usize]| slots.iter().all(|&slot| store.is_present(slot));
        let pairs = self.pair_blocks.iter().flat_map(HistoryBlock::all);
        let pairs = pairs.filter(|(contact, memory)| are_present(&contact.both()) && !memory.is_empty());
        let pairs = pairs.map(|(contact, memory)| {
            let [i, j] = contact.both();
            let id = store.id[j];
            if id.is_wall() {
                let row = Remembered::new(store.id[i], (PartnerKind::WallGrain, id.number()), &memory);
                row.with_partner_at(id.number(), store.body[j].position.spread())
            } else {
                Remembered::new(store.id[i], (PartnerKind::Grain, id.number()), &memory)
            }
        });
        let walls = self.wall_blocks.iter().flat_map(HistoryBlock::all);
        let walls = walls.filter(|(contact, memory)| are_present(&[contact.first()]) && !memory.is_empty());
        let walls = walls.filter_map(|(contact, memory)| {
            let [i, index] = contact.both();
            let number = u32::try_from(index + 1).ok()?;
            let at = surfaces.get(index)?.surface.nearest_point(store.body[i].position);
            let row = Remembered::new(store.id[i], (PartnerKind::Wall, number), &memory);
            Some(row.with_partner_at(number, at.spread()))
        });
        pairs.chain(walls).collect()
    }

    /// Replaces all memories. Walls are found by their numbers, up to `surfaces`. Rows of particles and walls that do not exist are
    /// left out: the scene that reads them has refused them.
    pub(in crate::contact) fn replace(
        &mut self,
        store: &ParticleStore<V>,
        surfaces: usize,
        rows: &[Remembered],
        parts: MemoryParts,
    ) {
        let slots: HashMap<GrainId, u32> = store.id.iter().copied().zip(0..).collect();
        let slot = |id: Option<GrainId>| slots.get(&id?).copied();
        let mut pairs = Vec::new();
        let mut walls = Vec::new();
        for row in rows {
            let Some(i) = slot(GrainId::grain(row.grain)) else { continue };
            let memory = row.memory::<V>();
            let j = match row.with {
                PartnerKind::Grain => slot(GrainId::grain(row.number)),
                PartnerKind::WallGrain => slot(GrainId::numbered_wall(row.number)),
                PartnerKind::Wall => {
                    let wall = row.number.checked_sub(1).filter(|&wall| (wall as usize) < surfaces);
                    walls.extend(wall.map(|wall| (Candidate::new(i, wall), memory)));
                    None
                }
            };
            if let Some(j) = j.filter(|&j| j != i) {
                let memory = if i > j { memory.seen_from_partner() } else { memory };
                pairs.push((Candidate::new(i.min(j), i.max(j)), memory));
            }
        }
        for (blocks, mut contacts) in [(&mut self.pair_blocks, pairs), (&mut self.wall_blocks, walls)] {
            // A contact that occurs twice keeps its first row.
            contacts.sort_by_key(|(contact, _)| *contact);
            contacts.dedup_by_key(|(contact, _)| *contact);
            rewrite(blocks, store, contacts, parts);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::history::tests::{SPRINGS, memory, store};
    use crate::particle::Species;
    use crate::space::Plane;
    use crate::walls::shapes::half_plane::HalfPlane;
    use crate::walls::surface::Surface;
    use siloflow_text::encoding::TextReader;

    #[test]
    fn memories_pass_from_one_order_of_slots_to_another() {
        let ids: Vec<u32> = (0..1500).collect();
        let before = store(&ids, &[]);
        let mut history = History::default();
        for contact in [[0, 1], [3, 700], [1200, 1400]] {
            let block = &mut history.blocks_mut(&before).0[contact[0] as usize / 1024];
            block.push(SPRINGS, contact.into(), &memory(0.1 + f64::from(contact[0])));
        }
        history.blocks_mut(&before).1[0].push(SPRINGS, [5, 2].into(), &memory(7.0));
        let floor = Surface::HalfPlane(HalfPlane { point: Plane::ZERO, normal: Plane::Y });
        let walls = vec![SurfaceWall::still(floor, Species(0)); 3];
        let text = write(&history.remembered(&before, &walls)).unwrap();
        let rows = read(text.as_bytes()).unwrap();
        assert_eq!((rows.len(), &rows), (4, &history.remembered(&before, &walls)));
        // The point of the floor below grain 5.
        assert_eq!((rows[3].number, rows[3].at()), (3, Some(Solid::new(5.0, 0.0, 0.0))));
        // In the reverse order, and without grain 700.
        let reversed: Vec<u32> = (0..1500).rev().filter(|&id| id != 700).collect();
        let after = store(&reversed, &[]);
        let slot = |id: u32| reversed.iter().position(|&other| other == id).unwrap();
        let mut passed = History::default();
        passed.replace(&after, 3, &rows, SPRINGS);
        let spring = |a: u32, b: u32| passed.of_pair(slot(a), slot(b)).map(|memory| memory.spring.x);
        assert_eq!([spring(0, 1), spring(1200, 1400), spring(3, 4)], [Some(-0.1), Some(-1200.1), None]);
        assert_eq!(passed.of_wall(slot(5), 2).map(|memory| memory.spring.x), Some(7.0));
        assert_eq!(passed.remembered(&after, &walls).len(), 3);
        // Without the third wall its memory is left out.
        passed.replace(&after, 2, &rows, SPRINGS);
        assert_eq!((passed.of_wall(slot(5), 2), passed.remembered(&after, &walls).len()), (None, 2));
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
