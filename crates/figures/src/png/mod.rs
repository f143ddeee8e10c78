//! Conversion of SVG to PNG. The font is part of the program, so labels do not depend on fonts of the machine.
//!
//! A document may come from elsewhere. Nothing but its text is read, and only what siloflow's own pictures consist of is drawn. A
//! document is refused if it has
//!
//! * more than 64 MiB, more than [`MOST_PIXELS`], or about a million elements (a limit of usvg);
//! * elements other than [`ELEMENTS`], so no images, links, styles, masks and patterns; or opacity or filters of groups. A short
//!   document can nest such effects so that it takes any time and memory;
//! * a label of more than [`LONGEST_LABEL`] characters, whose time grows with the square of its length;
//! * coordinates beyond [`FARTHEST`](crate::svg::FARTHEST), for which tiny-skia panics.
//!
//! [`encode_within`] also gives up after a time.
//!
//! Without the feature `png` nothing is drawn: each function returns an error that says so.

#[cfg(not(feature = "png"))]
mod absent;
#[cfg(feature = "png")]
mod drawing;

use std::time::Duration;

#[cfg(not(feature = "png"))]
pub use self::absent::{encode, encode_within, pixels};
#[cfg(feature = "png")]
pub use self::drawing::{ELEMENTS, LONGEST_LABEL, encode, encode_within, pixels};

/// Most pixels of a PNG. While it is drawn, a pixel takes up to 8 bytes.
pub const MOST_PIXELS: f64 = 5.0e7;

/// Most shapes of a PNG, below the limit of usvg, 1,000,000 elements.
pub const MOST_SHAPES: usize = 900_000;

/// Longest time for which a file from elsewhere is drawn.
pub const LONGEST_DRAWING: Duration = Duration::from_mins(1);

/// Whether this program draws PNG.
pub const IS_AVAILABLE: bool = cfg!(feature = "png");

/// A drawing as pixels.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Pixels {
    /// Width and height.
    pub size: [u32; 2],
    /// Red, green and blue of each pixel, by rows from above.
    pub colours: Vec<u8>,
}
