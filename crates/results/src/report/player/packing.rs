//! The data of a player: two compressed parts, each in base64.
//!
//! | part | content |
//! |---|---|
//! | first | length of a description (4 bytes); the description in JSON (`description.rs`); for each frame its time, the grains released, inside, out and lost (8-byte floats) and its length (4 bytes); for each particle its id, radius and time of its first frame (4 bytes each), kind and species (1 byte each), and its level of each quantity that it keeps (1 byte); the walls at the start (`wall_shapes.rs`) |
//! | second | the frames (`frame_packer.rs`) |
//!
//! The columns of the first part are one after the other. Numbers are little-endian. Both parts are zlib streams.

use std::io::{self, Write as _};
use std::path::Path;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use flate2::Compression;
use flate2::write::ZlibEncoder;

use super::bytes::length;
use super::description::Description;
use super::facts::Facts;
use super::frame_packer::FramePacker;
use super::plan::Plan;
use super::scale::TOP;
use siloflow_files::frames::reader::FrameReader;
use siloflow_files::frames::{Frame, Header};

/// Level of the compression: higher ones take twice the time for 2 % less.
const LEVEL: u32 = 6;

/// Returns the level of compression of all parts.
pub(super) fn compression() -> Compression {
    Compression::new(LEVEL)
}

/// Returns two compressed parts as text.
pub(super) fn join(first: &[u8], second: &[u8]) -> String {
    format!("{} {}", STANDARD.encode(first), STANDARD.encode(second))
}

/// Facts about the packed frames.
#[derive(Default)]
pub(super) struct FrameColumns {
    times: Vec<f64>,
    counts: Vec<[u64; 4]>,
    lengths: Vec<u32>,
}

/// Packs the frames of the file at `path`, each of at most `of_frame` bytes, into at most `most` characters, if two frames fit into them.
///
/// # Errors
/// If the file cannot be read, or is damaged.
pub(super) fn pack((path, of_frame): (&Path, u64), most: usize) -> io::Result<String> {
    let reader = FrameReader::open_within(path, of_frame)?;
    let header = reader.header.clone();
    let facts = Facts::of(&header, reader)?;
    let mut plan = Plan::new(&header, facts);
    // Base64 has four characters for three bytes.
    let most = most / 4 * 3;
    loop {
        let (bytes, columns, is_whole) = pack_frames((path, of_frame), &header, &plan, most)?;
        if is_whole || !plan.thinning.thin(bytes.len(), columns.times.len(), most) {
            let first = first_part(&header, &plan, &columns)?;
            return Ok(join(&first, &bytes));
        }
    }
}

/// Returns the compressed frames, facts about them, and whether these are all: packing ends at `most` bytes unless there are only two.
fn pack_frames(
    (path, of_frame): (&Path, u64),
    header: &Header,
    plan: &Plan,
    most: usize,
) -> io::Result<(Vec<u8>, FrameColumns, bool)> {
    let (mut packer, _) = FramePacker::new(header, plan);
    let mut encoder = ZlibEncoder::new(Vec::new(), compression());
    let mut columns = FrameColumns::default();
    // A run that goes on has more frames now.
    for (number, frame) in FrameReader::open_within(path, of_frame)?.enumerate().take(plan.facts.frames) {
        let frame = frame?;
        if !plan.thinning.takes(number) {
            continue;
        }
        let bytes = packer.pack(&frame)?;
        encoder.write_all(&bytes)?;
        columns.add(&frame, bytes.len());
        if encoder.get_ref().len() > most && plan.thinning.kept > 2 {
            return Ok((encoder.finish()?, columns, false));
        }
    }
    let bytes = encoder.finish()?;
    let is_whole = bytes.len() <= most;
    Ok((bytes, columns, is_whole))
}

impl FrameColumns {
    pub(super) fn add(&mut self, frame: &Frame, bytes: usize) {
        self.times.push(frame.time);
        self.counts.push(frame.counts);
        self.lengths.push(length(bytes));
    }
}

fn first_part(header: &Header, plan: &Plan, columns: &FrameColumns) -> io::Result<Vec<u8>> {
    let mut encoder = ZlibEncoder::new(Vec::new(), compression());
    write_first_part(header, plan, columns, &mut encoder)?;
    encoder.finish()
}

/// Writes the first part, not compressed.
#[expect(
    clippy::cast_precision_loss,
    clippy::cast_possible_truncation,
    reason = "counts are small; a radius of 4 bytes has 7 digits"
)]
pub(super) fn write_first_part(
    header: &Header,
    plan: &Plan,
    columns: &FrameColumns,
    out: &mut impl io::Write,
) -> io::Result<()> {
    let description =
        serde_json::to_vec(&Description::of(header, plan, columns.times.len())).map_err(io::Error::other)?;
    out.write_all(&length(description.len()).to_le_bytes())?;
    out.write_all(&description)?;
    let mut column = |bytes: Vec<u8>| out.write_all(&bytes);
    column(columns.times.iter().flat_map(|time| time.to_le_bytes()).collect())?;
    column(columns.counts.iter().flatten().flat_map(|&count| (count as f64).to_le_bytes()).collect())?;
    column(columns.lengths.iter().flat_map(|length| length.to_le_bytes()).collect())?;
    let particles = &plan.facts.particles;
    column(particles.iter().flat_map(|particle| particle.key.id.to_le_bytes()).collect())?;
    column(particles.iter().flat_map(|particle| (particle.radius as f32).to_le_bytes()).collect())?;
    column(particles.iter().flat_map(|particle| (particle.first as f32).to_le_bytes()).collect())?;
    column(particles.iter().map(|particle| particle.kind).collect())?;
    column(particles.iter().map(|particle| particle.species).collect())?;
    for (numbers, scale) in plan.kept() {
        column(numbers.iter().map(|&number| scale.level(number, TOP)).collect())?;
    }
    column(FramePacker::new(header, plan).1)
}
