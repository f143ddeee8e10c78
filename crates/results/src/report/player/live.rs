//! Single frames of a run that goes on, for a page that draws them with the script of the player.
//!
//! Each frame is packed as a run of one frame (`packing.rs`), without compression: the length of the first part (4 bytes), the first part, and
//! the frame. Grids of all frames are equal where the scene has a size, so that a view stays where it is, and colours count from the numbers of
//! all frames so far.

use std::io;

use rustc_hash::FxHashMap;

use super::bytes::length;
use super::facts::{Bounds, Facts};
use super::frame_packer::FramePacker;
use super::packing::{FrameColumns, write_first_part};
use super::plan::Plan;
use super::scale::Spread;
use siloflow_files::frames::{Frame, Header};

/// Packs the frames of a run one by one.
#[derive(Debug)]
pub struct LiveFrames {
    header: Header,
    /// Numbers of each quantity in all frames so far.
    spreads: FxHashMap<String, Spread>,
    forces: Spread,
}

impl LiveFrames {
    /// Begins, with the header of the frames.
    #[must_use]
    pub fn new(header: Header) -> Self {
        Self { header, spreads: FxHashMap::default(), forces: Spread::default() }
    }

    /// The header of the frames.
    #[must_use]
    pub fn header(&self) -> &Header {
        &self.header
    }

    /// Packs a frame.
    ///
    /// # Errors
    /// If the frame breaks the rules of the format.
    pub fn pack(&mut self, frame: &Frame) -> io::Result<Vec<u8>> {
        let mut facts = Facts::of_frame(&self.header, frame)?;
        for quantity in &mut facts.quantities {
            let all = self.spreads.entry(quantity.name.clone()).or_default();
            all.merge(&quantity.spread);
            quantity.spread = all.clone();
        }
        self.forces.merge(&facts.forces);
        facts.forces = self.forces.clone();
        if self.has_size() {
            facts.bounds = Bounds([[f64::NEG_INFINITY; 3], [f64::INFINITY; 3]]);
        }
        let plan = Plan::new(&self.header, facts);
        let packed = FramePacker::new(&self.header, &plan).0.pack(frame)?;
        let mut columns = FrameColumns::default();
        columns.add(frame, packed.len());
        let mut bytes = vec![0; 4];
        write_first_part(&self.header, &plan, &columns, &mut bytes)?;
        let first = length(bytes.len() - 4).to_le_bytes();
        bytes[..4].copy_from_slice(&first);
        bytes.extend(packed);
        Ok(bytes)
    }

    fn has_size(&self) -> bool {
        let [low, high] = self.header.domain;
        (0..3).any(|axis| high[axis] > low[axis])
    }
}
