//! A frame as bytes. Numbers of grains are differences to the same grain in the packed frame before, or to 0.
//!
//! | part | content |
//! |---|---|
//! | rows, runs | number of rows; number of runs; for each run how many particles of the run are not in the frame, and how many then are |
//! | left out | number of grains outside of the grid |
//! | places | for each axis the low bytes of all rows, then the high bytes |
//! | levels | for each quantity that changes, the levels of all rows |
//! | contacts | see `links.rs` |
//! | walls | see `wall_shapes.rs` |

use std::io;

use super::bytes::{length, put};
use super::grains::Grains;
use super::links;
use super::plan::Plan;
use super::scale::{NO_LEVEL, TOP};
use super::wall_shapes::WallShapes;
use siloflow_files::frames::{Frame, Header, ParticleKey};

/// Packs frames one after the other.
pub(super) struct FramePacker<'a> {
    header: &'a Header,
    plan: &'a Plan,
    walls: WallShapes,
    /// Place of each particle in the last packed frame.
    places: Vec<[u16; 3]>,
    /// Level of each particle in the last packed frame, for each quantity that changes.
    levels: Vec<Vec<u8>>,
    /// Row of each particle in the frame, if it has one.
    rows: Vec<Option<u32>>,
}

impl<'a> FramePacker<'a> {
    /// Begins, and returns the bytes of the walls at the start.
    pub fn new(header: &'a Header, plan: &'a Plan) -> (Self, Vec<u8>) {
        let particles = plan.facts.particles.len();
        let levels = vec![vec![0; particles]; plan.changing().count()];
        let mut walls = WallShapes::default();
        let mut bytes = Vec::new();
        walls.pack(&mut bytes, &header.walls, &header.walls, &plan.grid, true);
        (Self { header, plan, walls, places: vec![[0; 3]; particles], levels, rows: vec![None; particles] }, bytes)
    }

    /// Returns the bytes of a frame.
    ///
    /// # Errors
    /// If the frame breaks the rules of the format, or has other grains than when it was first read.
    pub fn pack(&mut self, frame: &Frame) -> io::Result<Vec<u8>> {
        let grains = Grains::of(frame, self.header.dimension)?;
        let mut bytes = Vec::new();
        let mut shown = Vec::new();
        let all = grains.as_ref().map_or(&[][..], |grains| &grains.keys);
        for (row, key) in all.iter().enumerate() {
            let particle = self.plan.facts.place.get(key).copied().ok_or_else(changed)?;
            let place = grains.as_ref().and_then(|grains| self.plan.grid.place(grains.position(row)));
            shown.extend(place.map(|place| (row, particle, place)));
        }
        self.put_presence(&mut bytes, &shown);
        put(&mut bytes, length(all.len() - shown.len()));
        self.put_places(&mut bytes, &shown);
        if let Some(grains) = &grains {
            self.put_levels(&mut bytes, grains, &shown);
        }
        let places: Vec<[u16; 3]> = shown.iter().map(|(_, _, place)| *place).collect();
        let row_of = |key: ParticleKey| self.rows[*self.plan.facts.place.get(&key)?];
        bytes.extend(links::pack(frame, &row_of, &places, &self.plan.grid, self.plan.forces));
        self.walls.pack(&mut bytes, &self.header.walls, &frame.changed_walls, &self.plan.grid, false);
        Ok(bytes)
    }

    fn put_presence(&mut self, bytes: &mut Vec<u8>, shown: &[(usize, usize, [u16; 3])]) {
        self.rows.fill(None);
        let mut runs: Vec<(usize, usize)> = Vec::new();
        let mut end = 0;
        for (row, (_, particle, _)) in shown.iter().enumerate() {
            self.rows[*particle] = Some(length(row));
            match runs.last_mut() {
                Some((_, taken)) if *particle == end => *taken += 1,
                _ => runs.push((particle - end, 1)),
            }
            end = particle + 1;
        }
        put(bytes, length(shown.len()));
        put(bytes, length(runs.len()));
        for (skipped, taken) in runs {
            put(bytes, length(skipped));
            put(bytes, length(taken));
        }
    }

    fn put_places(&mut self, bytes: &mut Vec<u8>, shown: &[(usize, usize, [u16; 3])]) {
        let axes = usize::from(self.header.dimension).min(3);
        for axis in 0..axes {
            let start = bytes.len();
            bytes.resize(start + 2 * shown.len(), 0);
            let (low, high) = bytes[start..].split_at_mut(shown.len());
            for (row, (_, particle, place)) in shown.iter().enumerate() {
                [low[row], high[row]] = place[axis].wrapping_sub(self.places[*particle][axis]).to_le_bytes();
            }
        }
        // A particle that leaves the grid and returns starts at 0 again.
        self.places.fill([0; 3]);
        for (_, particle, place) in shown {
            self.places[*particle] = *place;
        }
    }

    fn put_levels(&mut self, bytes: &mut Vec<u8>, grains: &Grains, shown: &[(usize, usize, [u16; 3])]) {
        let quantities = grains.quantities();
        for ((facts, scale), last) in self.plan.changing().zip(&mut self.levels) {
            let quantity = quantities.iter().find(|quantity| quantity.name == facts.name);
            let mut now = vec![0; last.len()];
            for (row, particle, _) in shown {
                let level = quantity.map_or(NO_LEVEL, |quantity| scale.level(quantity.number(*row), TOP));
                now[*particle] = level;
                bytes.push(level.wrapping_sub(last[*particle]));
            }
            *last = now;
        }
    }
}

fn changed() -> io::Error {
    io::Error::other("it has changed while it was read")
}
