//! Unpacks the data of a player in tests, from the description of its bytes alone.

use std::io::Read as _;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use serde_json::Value;

/// The content of a packed run, as a page unpacks it.
pub struct Unpacked {
    pub description: Value,
    pub ids: Vec<i32>,
    pub radii: Vec<f32>,
    pub first: Vec<f32>,
    pub kinds: Vec<u8>,
    pub frames: Vec<UnpackedFrame>,
}

/// A frame; rows are in the order of ids.
#[derive(Debug, Default)]
pub struct UnpackedFrame {
    pub time: f64,
    pub counts: Vec<f64>,
    /// Places of the rows' particles in `ids`.
    pub particles: Vec<usize>,
    pub left_out: u32,
    /// m
    pub positions: Vec<[f64; 3]>,
    /// Numbers of each quantity, row by row.
    pub numbers: Vec<(String, Vec<f64>)>,
    /// Rows of both grains, level of the force, sliding.
    pub contacts: Vec<(usize, usize, u8, bool)>,
    /// Row of the grain, point (m), level of the force, sliding.
    pub wall_contacts: Vec<(usize, [f64; 3], u8, bool)>,
    /// Points (m) of each wall, and numbers of its lines and triangles.
    pub walls: Vec<(Vec<[f64; 3]>, usize, usize)>,
}

struct Bytes<'a>(&'a [u8]);

impl<'a> Bytes<'a> {
    fn take(&mut self, count: usize) -> &'a [u8] {
        let (part, rest) = self.0.split_at(count);
        self.0 = rest;
        part
    }

    fn number(&mut self) -> u32 {
        let mut number = 0;
        let mut shift = 0;
        loop {
            let byte = self.take(1)[0];
            number |= u32::from(byte & 127) << shift;
            shift += 7;
            if byte < 128 {
                return number;
            }
        }
    }

    fn count(&mut self) -> usize {
        self.number() as usize
    }

    fn signed(&mut self) -> i32 {
        let number = self.number();
        (number >> 1).cast_signed() ^ -(number & 1).cast_signed()
    }

    fn column<T, const N: usize>(&mut self, count: usize, from: fn([u8; N]) -> T) -> Vec<T> {
        self.take(N * count).as_chunks::<N>().0.iter().map(|bytes| from(*bytes)).collect()
    }
}

fn inflate(text: &str) -> Vec<u8> {
    let packed = STANDARD.decode(text).unwrap();
    let mut bytes = Vec::new();
    flate2::read::ZlibDecoder::new(&packed[..]).read_to_end(&mut bytes).unwrap();
    bytes
}

/// Returns the content of both parts.
pub fn parts(text: &str) -> (Vec<u8>, Vec<u8>) {
    let (first, second) = text.split_once(' ').unwrap();
    (inflate(first), inflate(second))
}

type Shape = (Vec<[i32; 3]>, usize, usize);

/// The state of unpacking.
struct Unpacker {
    low: Vec<f64>,
    step: f64,
    axes: usize,
    shapes: Vec<Shape>,
    /// Number of each wall's geometry at the start.
    start: Vec<usize>,
    last: Vec<Vec<[i32; 3]>>,
    places: Vec<[u16; 3]>,
    levels: Vec<Vec<u8>>,
}

pub fn unpack(text: &str) -> Unpacked {
    let (first, second) = parts(text);
    let mut facts = Bytes(&first);
    let mut all = Bytes(&second);
    let length = u32::from_le_bytes(facts.take(4).try_into().unwrap()) as usize;
    let description: Value = serde_json::from_slice(facts.take(length)).unwrap();
    let whole = |name: &str| usize::try_from(description[name].as_u64().unwrap()).unwrap();
    let count = whole("particles");
    let frames = whole("frames");
    let times = facts.column(frames, f64::from_le_bytes);
    let counts = facts.column(4 * frames, f64::from_le_bytes);
    let lengths = facts.column(frames, u32::from_le_bytes);
    let ids = facts.column(count, i32::from_le_bytes);
    let radii = facts.column(count, f32::from_le_bytes);
    let first = facts.column(count, f32::from_le_bytes);
    let kinds = facts.take(count).to_vec();
    let _species = facts.take(count);
    let quantities = description["quantities"].as_array().unwrap();
    let is_kept = |quantity: &&Value| quantity["is_kept"].as_bool().unwrap();
    let kept: Vec<&[u8]> = quantities.iter().filter(is_kept).map(|_| facts.take(count)).collect();
    let numbers = |quantity: &Value, levels: Vec<u8>| {
        let [low, high] = ["low", "high"].map(|name| quantity[name].as_f64().unwrap());
        let power = if quantity["is_root"].as_bool().unwrap() { 2 } else { 1 };
        let number = |&level: &u8| {
            if level == 255 { f64::NAN } else { low + (f64::from(level) / 254.0).powi(power) * (high - low) }
        };
        (quantity["name"].as_str().unwrap().to_owned(), levels.iter().map(number).collect::<Vec<f64>>())
    };
    let mut unpacker = Unpacker {
        low: description["low"].as_array().unwrap().iter().map(|low| low.as_f64().unwrap()).collect(),
        step: description["step"].as_f64().unwrap(),
        axes: whole("dimension"),
        shapes: Vec::new(),
        start: Vec::new(),
        last: vec![Vec::new(); description["doors"].as_array().unwrap().len()],
        places: vec![[0; 3]; count],
        levels: vec![vec![0; count]; quantities.len() - kept.len()],
    };
    unpacker.start = unpacker.walls(&mut facts);
    assert!(facts.0.is_empty());
    let mut list = Vec::new();
    for number in 0..frames {
        let mut frame = unpacker.frame(&mut Bytes(all.take(lengths[number] as usize)));
        (frame.time, frame.counts) = (times[number], counts[4 * number..4 * number + 4].to_vec());
        let mut changing = std::mem::take(&mut frame.numbers).into_iter();
        let mut of_kept = kept.iter();
        for quantity in quantities {
            let levels = if is_kept(&quantity) {
                let levels = of_kept.next().unwrap();
                frame.particles.iter().map(|&particle| levels[particle]).collect()
            } else {
                changing.next().unwrap().1.iter().map(|&level| level as u8).collect()
            };
            frame.numbers.push(numbers(quantity, levels));
        }
        list.push(frame);
    }
    assert!(all.0.is_empty());
    Unpacked { description, ids, radii, first, kinds, frames: list }
}

impl Unpacker {
    fn frame(&mut self, bytes: &mut Bytes) -> UnpackedFrame {
        let rows = bytes.count();
        let runs = bytes.count();
        let mut particles = Vec::new();
        let mut next = 0;
        for _ in 0..runs {
            let skipped = bytes.count();
            let taken = bytes.count();
            particles.extend(next + skipped..next + skipped + taken);
            next += skipped + taken;
        }
        assert_eq!(particles.len(), rows);
        let left_out = bytes.number();
        let mut places = vec![[0_u16; 3]; self.places.len()];
        let columns: Vec<_> = (0..self.axes).map(|_| (bytes.take(rows), bytes.take(rows))).collect();
        for (row, &particle) in particles.iter().enumerate() {
            for (axis, (low, high)) in columns.iter().enumerate() {
                let difference = u16::from_le_bytes([low[row], high[row]]);
                places[particle][axis] = self.places[particle][axis].wrapping_add(difference);
            }
        }
        self.places = places;
        let mut numbers = Vec::new();
        for last in &mut self.levels {
            let mut now = vec![0; last.len()];
            for (&particle, &difference) in particles.iter().zip(bytes.take(rows)) {
                now[particle] = last[particle].wrapping_add(difference);
            }
            *last = now;
            numbers.push((String::new(), particles.iter().map(|&particle| last[particle].into()).collect()));
        }
        let rows: Vec<[u16; 3]> = particles.iter().map(|&particle| self.places[particle]).collect();
        let between = contacts(bytes, |first, partners| first + partners.count());
        let wall_contacts = contacts(bytes, |first, partners| {
            let place = rows[first].map(i32::from);
            let mut point = place;
            (0..self.axes).for_each(|axis| point[axis] += partners.signed());
            self.metres(point)
        });
        let positions = rows.iter().map(|place| self.metres(place.map(i32::from))).collect();
        let walls = self.walls(bytes);
        let walls = walls.iter().map(|&shape| &self.shapes[shape]);
        let walls = walls
            .map(|(points, lines, triangles)| (points.iter().map(|&p| self.metres(p)).collect(), *lines, *triangles));
        let walls = walls.collect();
        assert!(bytes.0.is_empty());
        UnpackedFrame {
            particles,
            left_out,
            positions,
            numbers,
            contacts: between,
            wall_contacts,
            walls,
            ..UnpackedFrame::default()
        }
    }

    fn metres(&self, place: [i32; 3]) -> [f64; 3] {
        [0, 1, 2].map(|axis| if axis < self.axes { self.low[axis] + f64::from(place[axis]) * self.step } else { 0.0 })
    }

    /// Returns the geometry of each wall.
    fn walls(&mut self, bytes: &mut Bytes) -> Vec<usize> {
        let mut walls = self.start.clone();
        walls.resize(self.last.len(), usize::MAX);
        for _ in 0..bytes.count() {
            let wall = bytes.count();
            let kind = bytes.count();
            if kind == 0 {
                walls[wall] = bytes.count();
                continue;
            }
            let count = bytes.count();
            let before = Some(&self.last[wall]).filter(|last| last.len() == count);
            let before = before.cloned().unwrap_or(vec![[0; 3]; count]);
            let points: Vec<[i32; 3]> = before.iter().map(|point| point.map(|place| place + bytes.signed())).collect();
            let list = |ends: usize, bytes: &mut Bytes| {
                let length = bytes.count();
                (0..ends * length).for_each(|_| assert!(bytes.count() < count));
                length
            };
            let (lines, triangles) = match kind {
                2 => (list(2, bytes), list(3, bytes)),
                _ if count == 0 => (0, 0),
                _ => (self.shapes[self.start[wall]].1, self.shapes[self.start[wall]].2),
            };
            self.last[wall].clone_from(&points);
            walls[wall] = self.shapes.len();
            self.shapes.push((points, lines, triangles));
        }
        walls
    }
}

fn contacts<T>(bytes: &mut Bytes, partner: impl Fn(usize, &mut Bytes) -> T) -> Vec<(usize, T, u8, bool)> {
    let count = bytes.count();
    let length = bytes.count();
    let mut rows = Bytes(bytes.take(length));
    let length = bytes.count();
    let mut partners = Bytes(bytes.take(length));
    let mut row = 0;
    let forces = bytes.take(count);
    let list = forces.iter().map(|force| {
        row += rows.count();
        (row, partner(row, &mut partners), force / 2, force % 2 == 1)
    });
    let list = list.collect();
    assert!(rows.0.is_empty() && partners.0.is_empty());
    list
}
