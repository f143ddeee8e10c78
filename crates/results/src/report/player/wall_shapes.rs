//! Walls as bytes. Each geometry is written once; frames refer to it.
//!
//! | part | content |
//! |---|---|
//! | count | number of walls that follow |
//! | wall | its place among the walls of the run |
//! | kind | 0: a geometry that was written before, of this number; 1: new points for the lines and triangles of the wall at the start; 2: new points, lines and triangles |
//! | points | count; three signed numbers for each, less those of the same point in the wall's geometry before, if that has as many |
//! | lines, triangles | count; the places of their points |

use rustc_hash::FxHashMap;

use super::bytes::{length, put, put_signed};
use super::grid::Grid;
use siloflow_files::frames::WallGeometry;

/// Points of a wall in steps of the grid.
type Points = Vec<[i32; 3]>;

/// Geometries that have been written.
#[derive(Default)]
pub(super) struct WallShapes {
    /// Numbers of geometries by wall and points. Only those with the lines and triangles of the start are found again.
    known: FxHashMap<(usize, Points), u32>,
    count: u32,
    /// The last points of each wall.
    last: Vec<Points>,
}

impl WallShapes {
    /// Adds walls at the start of the run, or those of a frame that are different then.
    pub fn pack(
        &mut self,
        bytes: &mut Vec<u8>,
        start: &[WallGeometry],
        walls: &[WallGeometry],
        grid: &Grid,
        is_start: bool,
    ) {
        self.last.resize(start.len(), Vec::new());
        // A wall that the header does not have cannot be drawn.
        let place = |wall: &WallGeometry| start.iter().position(|first| first.number == wall.number);
        let walls: Vec<(usize, &WallGeometry)> = walls.iter().filter_map(|wall| Some((place(wall)?, wall))).collect();
        put(bytes, length(walls.len()));
        for (place, wall) in walls {
            put(bytes, length(place));
            let points: Points = wall.points.iter().map(|point| grid.point(*point)).collect();
            // A wall that has been removed has no points, and needs no lines.
            let first = &start[place];
            let is_same = wall.points.is_empty() || (wall.lines == first.lines && wall.triangles == first.triangles);
            let key = (place, points);
            if let Some(known) = self.known.get(&key).filter(|_| is_same) {
                put(bytes, 0);
                put(bytes, *known);
                continue;
            }
            put(bytes, if is_same && !is_start { 1 } else { 2 });
            self.put_points(bytes, place, &key.1);
            if is_start || !is_same {
                put(bytes, length(wall.lines.len()));
                wall.lines.iter().flatten().for_each(|&point| put(bytes, point));
                put(bytes, length(wall.triangles.len()));
                wall.triangles.iter().flatten().for_each(|&point| put(bytes, point));
            }
            self.last[place].clone_from(&key.1);
            if is_same {
                self.known.insert(key, self.count);
            }
            self.count += 1;
        }
    }

    fn put_points(&self, bytes: &mut Vec<u8>, place: usize, points: &Points) {
        put(bytes, length(points.len()));
        let last = &self.last[place];
        for (number, point) in points.iter().enumerate() {
            let before = if last.len() == points.len() { last[number] } else { [0; 3] };
            (0..3).for_each(|axis| put_signed(bytes, point[axis] - before[axis]));
        }
    }
}
