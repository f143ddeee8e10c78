//! Whether a header and a frame are such that their readers can index them: a file may come from somebody else.
//!
//! A vector has as many components as the space, in floats; any other column has one number in each row. Lines and triangles lie between
//! points that are there.

use std::io;

use super::codec::damaged;
use super::{Column, Frame, Header, Values, WallGeometry};

/// Columns of vectors.
const VECTORS: [&str; 6] = ["position", "velocity", "force", "tangential_force", "point", "director"];

/// Refuses a header whose space or walls are none.
pub(super) fn header(header: &Header) -> io::Result<()> {
    if !matches!(header.dimension, 2 | 3) {
        return Err(damaged(format!("its space has {} dimensions", header.dimension)));
    }
    header.walls.iter().try_for_each(wall)
}

/// Refuses a frame of a run with this header whose columns or walls are none.
pub(super) fn frame(header: &Header, frame: &Frame) -> io::Result<()> {
    frame.changed_walls.iter().try_for_each(wall)?;
    let columns = frame.tables.iter().flat_map(|table| &table.columns);
    columns.into_iter().try_for_each(|found| column(header.dimension, found))
}

fn column(dimension: u8, column: &Column) -> io::Result<()> {
    let is_float = matches!(column.values, Values::F64(_));
    let (components, has_type) = match column.name.as_str() {
        name if VECTORS.contains(&name) => (dimension, is_float),
        "spin" => (if dimension == 2 { 1 } else { 3 }, is_float),
        _ => (1, true),
    };
    if column.components == components && has_type {
        Ok(())
    } else {
        Err(damaged(format!("its column `{}` has other numbers than such a column", column.name)))
    }
}

fn wall(wall: &WallGeometry) -> io::Result<()> {
    let places = wall.lines.iter().flatten().chain(wall.triangles.iter().flatten());
    match places.copied().find(|place| *place as usize >= wall.points.len()) {
        Some(place) => Err(damaged(format!("its wall {} has no point {place}", wall.number))),
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::super::Table;
    use super::super::reader::tests::header as flat;
    use super::*;

    #[test]
    fn what_a_reader_cannot_index_is_refused() {
        let of = |name: &str, components, values| {
            let column = Column { name: name.to_owned(), unit: String::new(), components, values };
            Frame {
                tables: vec![Table { name: "grains".to_owned(), rows: 1, columns: vec![column] }],
                ..Frame::default()
            }
        };
        let floats = |count| Values::F64(vec![0.0; count]);
        for good in [of("position", 2, floats(2)), of("spin", 1, floats(1)), of("heat", 1, Values::U8(vec![1]))] {
            frame(&flat(), &good).unwrap();
        }
        for wrong in [
            of("position", 1, floats(1)),
            of("velocity", 2, Values::U8(vec![0; 2])),
            of("spin", 3, floats(3)),
            of("heat", 0, floats(0)),
        ] {
            assert!(frame(&flat(), &wrong).is_err(), "{wrong:?}");
        }
        let open = WallGeometry { points: vec![[0.0; 3]; 2], lines: vec![[0, 2]], ..WallGeometry::default() };
        assert!(
            header(&Header { walls: vec![open.clone()], ..flat() }).unwrap_err().to_string().contains("no point 2")
        );
        assert!(frame(&flat(), &Frame { changed_walls: vec![open], ..Frame::default() }).is_err());
        assert!(header(&Header { dimension: 1, ..flat() }).is_err());
    }
}
