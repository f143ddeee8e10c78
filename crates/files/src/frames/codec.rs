//! The bytes of a record of `frames.bin`: its parts in postcard, its columns as bytes of equal place together.
//!
//! | part of a frame | content |
//! |---|---|
//! | 4 bytes | length of the head |
//! | head | step, time, counts, changed walls, and name, unit, type and components of every column, by postcard |
//! | columns | one after the other: the first byte of all its numbers, then the second of all, and so on |
//!
//! Numbers of a column are alike in sign, exponent and high bytes. Bytes of equal place together are therefore shorter after
//! compression. Whole numbers and floats are little-endian, and every bit of a float is kept.
//!
//! A frame is read part by part. The sizes that its head declares are compared with a limit before anything is allocated for them.

use std::io::{self, Read};

use serde::{Deserialize, Serialize};

use super::{Column, FORMAT, Frame, Header, Table, Values, WallGeometry};
use siloflow_dem::persist::{decode, encode};

#[derive(Deserialize, Serialize)]
struct Head {
    step: u64,
    time: f64,
    counts: [u64; 4],
    changed_walls: Vec<WallGeometry>,
    tables: Vec<TableHead>,
}

#[derive(Deserialize, Serialize)]
struct TableHead {
    name: String,
    rows: u64,
    columns: Vec<ColumnHead>,
}

#[derive(Deserialize, Serialize)]
struct ColumnHead {
    name: String,
    unit: String,
    components: u8,
    kind: Kind,
}

/// Type of the numbers of a column.
#[derive(Clone, Copy, Deserialize, Serialize)]
enum Kind {
    F64,
    I32,
    U32,
    U16,
    U8,
}

pub(super) fn damaged(what: impl Into<String>) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidData, what.into())
}

pub(super) fn encode_header(header: &Header) -> io::Result<Vec<u8>> {
    encode(header).map_err(io::Error::other)
}

pub(super) fn decode_header(bytes: &[u8]) -> io::Result<Header> {
    let unknown = |problem: String| damaged(format!("its header is unknown: {problem}"));
    // The first field of every format.
    let (format, _) = postcard::take_from_bytes::<u32>(bytes).map_err(|error| unknown(error.to_string()))?;
    if format == 0 || format > FORMAT {
        return Err(damaged(format!("its format is {format}, and this siloflow reads formats 1 to {FORMAT}")));
    }
    // Format 1 lacks the list at the end. The code of an empty list is a zero.
    let list: &[u8] = if format == 1 { &[0] } else { &[] };
    decode(&[bytes, list].concat()).map_err(unknown)
}

pub(super) fn encode_frame(frame: &Frame) -> io::Result<Vec<u8>> {
    let columns = |table: &Table| table.columns.iter().map(column_head).collect();
    let head = Head {
        step: frame.step,
        time: frame.time,
        counts: frame.counts,
        changed_walls: frame.changed_walls.clone(),
        tables: frame
            .tables
            .iter()
            .map(|table| TableHead { name: table.name.clone(), rows: table.rows as u64, columns: columns(table) })
            .collect(),
    };
    let head = encode(&head).map_err(io::Error::other)?;
    let mut bytes = u32::try_from(head.len()).map_err(io::Error::other)?.to_le_bytes().to_vec();
    bytes.extend(head);
    for column in frame.tables.iter().flat_map(|table| &table.columns) {
        match &column.values {
            Values::F64(numbers) => shuffle(&mut bytes, numbers, f64::to_le_bytes),
            Values::I32(numbers) => shuffle(&mut bytes, numbers, i32::to_le_bytes),
            Values::U32(numbers) => shuffle(&mut bytes, numbers, u32::to_le_bytes),
            Values::U16(numbers) => shuffle(&mut bytes, numbers, u16::to_le_bytes),
            Values::U8(numbers) => bytes.extend(numbers),
        }
    }
    Ok(bytes)
}

fn column_head(column: &Column) -> ColumnHead {
    let kind = match column.values {
        Values::F64(_) => Kind::F64,
        Values::I32(_) => Kind::I32,
        Values::U32(_) => Kind::U32,
        Values::U16(_) => Kind::U16,
        Values::U8(_) => Kind::U8,
    };
    ColumnHead { name: column.name.clone(), unit: column.unit.clone(), components: column.components, kind }
}

fn cut() -> io::Error {
    damaged("a frame is cut short")
}

/// The error of content that is larger than `most` bytes.
pub(super) fn too_large(what: &str, most: u64) -> io::Error {
    damaged(format!("{what} is larger than the {most} bytes that its scene can need"))
}

/// Reads the next `length` bytes. Memory grows with what is there, not with what is declared.
fn take(content: &mut impl Read, length: u64) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    content.take(length).read_to_end(&mut bytes).map_err(|error| damaged(error.to_string()))?;
    if bytes.len() as u64 == length { Ok(bytes) } else { Err(cut()) }
}

impl Kind {
    /// Bytes of a number.
    fn size(self) -> u64 {
        match self {
            Self::F64 => 8,
            Self::I32 | Self::U32 => 4,
            Self::U16 => 2,
            Self::U8 => 1,
        }
    }
}

/// Bytes of all columns; `None` if there is no such number.
fn declared(head: &Head) -> Option<u64> {
    let columns = head.tables.iter().flat_map(|table| table.columns.iter().map(|column| (table.rows, column)));
    columns
        .map(|(rows, column)| rows.checked_mul(column.components.into())?.checked_mul(column.kind.size()))
        .try_fold(0_u64, |sum, bytes| sum.checked_add(bytes?))
}

/// Reads a frame of at most `most` bytes.
pub(super) fn decode_frame(mut content: impl Read, most: u64) -> io::Result<Frame> {
    let length = take(&mut content, 4)?.try_into().map(u32::from_le_bytes).map_err(|_| cut())?;
    if u64::from(length) > most {
        return Err(too_large("a frame", most));
    }
    let head = take(&mut content, length.into())?;
    let head: Head = decode(&head).map_err(|problem| damaged(format!("the head of a frame is unknown: {problem}")))?;
    if declared(&head).is_none_or(|bytes| bytes > most) {
        return Err(too_large("a frame", most));
    }
    let mut tables = Vec::new();
    for TableHead { name, rows, columns: heads } in head.tables {
        let mut columns = Vec::new();
        for ColumnHead { name, unit, components, kind } in heads {
            let count = rows.checked_mul(components.into()).ok_or_else(cut)?;
            let planes = take(&mut content, count.checked_mul(kind.size()).ok_or_else(cut)?)?;
            let count = usize::try_from(count).map_err(|_| cut())?;
            let values = match kind {
                Kind::F64 => Values::F64(unshuffle(&planes, count, f64::from_le_bytes)),
                Kind::I32 => Values::I32(unshuffle(&planes, count, i32::from_le_bytes)),
                Kind::U32 => Values::U32(unshuffle(&planes, count, u32::from_le_bytes)),
                Kind::U16 => Values::U16(unshuffle(&planes, count, u16::from_le_bytes)),
                Kind::U8 => Values::U8(planes),
            };
            columns.push(Column { name, unit, components, values });
        }
        tables.push(Table { name, rows: usize::try_from(rows).map_err(|_| cut())?, columns });
    }
    let mut more = Vec::new();
    content.take(1).read_to_end(&mut more).map_err(|error| damaged(error.to_string()))?;
    if !more.is_empty() {
        return Err(damaged("a frame has more bytes than columns"));
    }
    let Head { step, time, counts, changed_walls, .. } = head;
    Ok(Frame { step, time, counts, changed_walls, tables })
}

/// Adds the first byte of all numbers, then the second of all, and so on.
fn shuffle<T: Copy, const N: usize>(bytes: &mut Vec<u8>, numbers: &[T], to_bytes: impl Fn(T) -> [u8; N]) {
    let start = bytes.len();
    bytes.resize(start + N * numbers.len(), 0);
    let out = &mut bytes[start..];
    for (row, &number) in numbers.iter().enumerate() {
        for (place, byte) in to_bytes(number).into_iter().enumerate() {
            out[place * numbers.len() + row] = byte;
        }
    }
}

/// Returns `count` numbers from their bytes, which are N times as many.
fn unshuffle<T, const N: usize>(planes: &[u8], count: usize, from_bytes: fn([u8; N]) -> T) -> Vec<T> {
    (0..count).map(|row| from_bytes(std::array::from_fn(|place| planes[place * count + row]))).collect()
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    const MOST: u64 = 1 << 20;

    #[test]
    fn a_frame_that_declares_more_than_its_scene_can_need_is_refused_before_it_is_unpacked() {
        let bytes = encode_frame(&frame(&[1.0, 2.0], &[3])).unwrap();
        let head = Head {
            step: 0,
            time: 0.0,
            counts: [0; 4],
            changed_walls: Vec::new(),
            tables: vec![TableHead {
                name: "grains".to_owned(),
                rows: 1 << 40,
                columns: vec![ColumnHead {
                    name: "radius".to_owned(),
                    unit: String::new(),
                    components: 1,
                    kind: Kind::F64,
                }],
            }],
        };
        let head = encode(&head).unwrap();
        let length = u32::try_from(head.len()).unwrap().to_le_bytes();
        // A reader without an end stands for content that would be unpacked.
        let endless = (&length[..]).chain(&head[..]).chain(std::io::repeat(0));
        assert!(decode_frame(endless, MOST).unwrap_err().to_string().contains("1048576 bytes"));
        assert!(decode_frame(std::io::repeat(0xff), MOST).unwrap_err().to_string().contains("larger"));
        assert!(decode_frame(&bytes[..], 20).unwrap_err().to_string().contains("larger"));
    }

    fn frame(numbers: &[f64], ids: &[u32]) -> Frame {
        let column =
            |name: &str, components, values| Column { name: name.into(), unit: "m".into(), components, values };
        let small = |id: &u32| (id % 251) as u8;
        Frame {
            step: 7,
            time: 0.1,
            counts: [4, 3, 2, 1],
            changed_walls: vec![WallGeometry { number: 2, is_door: true, ..WallGeometry::default() }],
            tables: vec![Table {
                name: "grains".to_owned(),
                rows: ids.len(),
                columns: vec![
                    column("position", 2, Values::F64(numbers.to_vec())),
                    column("id", 1, Values::I32(ids.iter().map(|id| id.cast_signed()).collect())),
                    column("number", 1, Values::U32(ids.to_vec())),
                    column("count", 1, Values::U16(ids.iter().map(|id| 300 + u16::from(small(id))).collect())),
                    column("kind", 1, Values::U8(ids.iter().map(small).collect())),
                ],
            }],
        }
    }

    proptest! {
        #[test]
        fn every_bit_is_read_back(rows in proptest::collection::vec((any::<u64>(), any::<u64>(), any::<u32>()), 0..50)) {
            let numbers: Vec<f64> = rows.iter().flat_map(|row| [row.0, row.1].map(f64::from_bits)).collect();
            let ids: Vec<u32> = rows.iter().map(|row| row.2).collect();
            let written = frame(&numbers, &ids);
            let bytes = encode_frame(&written).unwrap();
            let read = decode_frame(&bytes[..], MOST).unwrap();
            let bits = |frame: &Frame| {
                let floats = frame.tables[0].floats("position").unwrap();
                floats.iter().map(|number| number.to_bits()).collect::<Vec<_>>()
            };
            prop_assert_eq!(bits(&read), bits(&written));
            prop_assert_eq!(encode_frame(&read).unwrap(), bytes);
            prop_assert!(read.tables[0].whole("number").unwrap().iter().zip(&ids).all(|(read, id)| *read == i64::from(*id)));
            let signed = ids.iter().map(|id| i64::from(id.cast_signed()));
            prop_assert!(read.tables[0].whole("id").unwrap().into_iter().eq(signed));
        }

        #[test]
        fn other_bytes_are_an_error_and_no_panic(bytes in proptest::collection::vec(any::<u8>(), 0..200), place in 0_usize..200) {
            let _ = decode_frame(&bytes[..], MOST);
            let mut near = encode_frame(&frame(&[1.0, 2.0], &[3])).unwrap();
            let place = place % near.len();
            near[place] ^= bytes.first().copied().unwrap_or(1);
            let _ = decode_frame(&near[..], MOST);
        }
    }

    #[test]
    fn every_cut_is_refused() {
        let whole = encode_frame(&frame(&[1.0, 2.0, 3.0, 4.0], &[5, 6])).unwrap();
        for length in 0..whole.len() {
            assert!(decode_frame(&whole[..length], MOST).is_err(), "cut to {length} of {} bytes", whole.len());
        }
        assert!(decode_frame(&[&whole[..], b"more"].concat()[..], MOST).is_err());
    }
}
