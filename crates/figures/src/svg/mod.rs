//! Draws a picture of discs, lines and polygons as SVG, with y up: a header and a legend above the view, the scale bar and the
//! key of the bonds below it. Nothing in these margins covers a shape.
//!
//! | part | content |
//! |---|---|
//! | `shapes.rs` | what the view shows |
//! | `margins.rs` | header, legend, key, scale bar |
//! | `ticks.rs` | numbers at a colour scale |
//!
//! All lengths in pixels are proportional to the width in pixels, so the picture looks the same at any size.

mod margins;
mod shapes;
mod ticks;

use std::fmt::Write as _;

use crate::colour::Rgb;
use glam::DVec2;
use siloflow_text::safe::{LONGEST_QUOTATION, cut, for_xml};

/// Largest coordinate of a shape, px. tiny-skia, which draws PNG, panics for much larger ones.
pub const FARTHEST: f64 = 1.0e7;

/// A picture to be drawn. Shapes are drawn in the order of the fields from `cells` to `labels`.
#[derive(Clone, Debug, Default)]
pub struct Picture {
    /// Lower left corner of the view, m.
    pub low: DVec2,
    /// Upper right corner of the view, m.
    pub high: DVec2,
    /// Width of the picture, px.
    pub width: f64,
    /// Lines of the header.
    pub header: Vec<String>,
    /// Legend.
    pub legend: Legend,
    /// Whether there is space for a legend of many classes although this picture has few.
    pub legend_rows: usize,
    /// Bonds that are explained below the view, as (width in m, colour, text).
    pub key: Vec<(f64, Rgb, String)>,
    /// Axes that are drawn below the view, as (name, direction, at most 1 long).
    pub axes: Vec<(&'static str, DVec2)>,
    /// Rectangles below all other shapes: for each colour, pairs of lower left and upper right corner in m.
    pub cells: Vec<(Rgb, Vec<(DVec2, DVec2)>)>,
    /// Surfaces behind the discs.
    pub behind: Vec<Patch>,
    /// Lines as (end in m, end in m, colour).
    pub lines: Vec<(DVec2, DVec2, Rgb)>,
    /// Discs as (centre in m, radius in m, colour).
    pub discs: Vec<(DVec2, f64, Rgb)>,
    /// How discs are drawn.
    pub finish: Finish,
    /// Bonds on top of the discs, as (end in m, end in m, width in m, colour).
    pub bonds: Vec<(DVec2, DVec2, f64, Rgb)>,
    /// Surfaces in front of the discs.
    pub front: Vec<Patch>,
    /// Labels on top of all shapes, as (middle of the baseline in m, text).
    pub labels: Vec<(DVec2, String)>,
}

/// How discs are drawn.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Finish {
    /// In one colour.
    #[default]
    Plain,
    /// With an outline, which separates discs that touch or hide each other.
    Outlined,
    /// As spheres: with an outline, and lighter where light falls on them.
    Shaded,
}

/// A translucent surface: polygons of one colour, and edges.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Patch {
    /// Colour of the polygons and the edges.
    pub colour: Rgb,
    /// Opacity of the polygons, from 0 to 1. Where polygons of a patch overlap, it counts once.
    pub opacity: f64,
    /// Polygons by their corners, m.
    pub polygons: Vec<Vec<DVec2>>,
    /// Edges by their ends, m.
    pub edges: Vec<[DVec2; 2]>,
}

/// Explanation of the colours.
#[derive(Clone, Debug, Default)]
pub enum Legend {
    /// No legend.
    #[default]
    None,
    /// Categories, each with its name and colour.
    Classes(Vec<(String, Rgb)>),
    /// A continuous scale.
    Scale {
        /// Value at the lower end.
        from: f64,
        /// Value at the upper end.
        to: f64,
        /// Quantity and unit.
        title: String,
        /// Returns the colour of a position on the scale, from 0 at the lower end to 1 at the upper end.
        map: fn(f64) -> Rgb,
    },
}

impl Legend {
    fn rows(&self) -> usize {
        match self {
            Self::None => 0,
            Self::Classes(classes) => classes.len(),
            Self::Scale { .. } => 3,
        }
    }
}

/// Font size over the width of the picture. Margins are multiples of the font size.
const TEXT: f64 = 0.028;

/// Height of the margin below the view over the font size.
const BOTTOM: f64 = 2.6;

/// Colour of text, and of lines that are no walls.
const INK: &str = "#222222";

/// A picture in the course of drawing.
struct Paper<'a> {
    picture: &'a Picture,
    /// Pixels a metre.
    scale: f64,
    /// Font size, px.
    text: f64,
    /// Upper and lower end of the view, px from above.
    view: [f64; 2],
    svg: String,
}

/// Returns the height in px of the header, for a width in px and a number of lines.
fn top(width: f64, lines: usize) -> f64 {
    #[expect(clippy::cast_precision_loss, reason = "a few lines of text")]
    let lines = lines.max(1) as f64;
    (lines * 1.35 + 0.7) * TEXT * width
}

/// Returns the number of pixels of a picture of this width (px), with this view (m) and number of lines in its header.
#[must_use]
pub fn pixels(width: f64, (low, high): (DVec2, DVec2), lines: usize) -> f64 {
    let size = high - low;
    width * (top(width, lines) + width / size.x * size.y + BOTTOM * TEXT * width)
}

impl Picture {
    /// Returns the picture as an SVG document.
    #[must_use]
    pub fn to_svg(&self) -> String {
        let size = self.high - self.low;
        let scale = self.width / size.x;
        let rows = self.header.len().max(self.legend.rows()).max(self.legend_rows);
        let top = top(self.width, rows);
        let text = TEXT * self.width;
        let mut paper =
            Paper { picture: self, scale, text, view: [top, top + size.y * scale], svg: String::with_capacity(4096) };
        paper.begin();
        paper.shapes();
        paper.margins();
        paper.svg.push_str("</svg>\n");
        paper.svg
    }
}

impl Paper<'_> {
    /// Appends one element. Writing to a string cannot fail.
    fn put(&mut self, element: std::fmt::Arguments<'_>) {
        let _ = self.svg.write_fmt(element);
        self.svg.push('\n');
    }

    /// Returns the position in px of a point in m. A point far outside of the picture is moved to where renderers can follow.
    fn at(&self, x: DVec2) -> DVec2 {
        let x = DVec2::new(
            (x.x - self.picture.low.x) * self.scale,
            self.view[0] + (self.picture.high.y - x.y) * self.scale,
        );
        x.clamp(DVec2::splat(-FARTHEST), DVec2::splat(FARTHEST))
    }

    fn begin(&mut self) {
        // The height is a number of whole pixels, so that no pixel of a PNG is partly covered.
        let width = self.picture.width;
        let height = (self.view[1] + BOTTOM * self.text).ceil();
        self.put(format_args!(
            r#"<svg xmlns="http://www.w3.org/2000/svg" width="{width:.0}" height="{height:.0}" viewBox="0 0 {width:.2} {height:.2}">"#
        ));
        self.put(format_args!(r##"<rect width="{width:.2}" height="{height:.2}" fill="#ffffff"/>"##));
    }

    fn text(&mut self, x: f64, y: f64, size: f64, anchor: &str, text: &str) {
        let text = for_xml(&cut(text, LONGEST_QUOTATION));
        self.put(format_args!(
            r#"<text x="{x:.2}" y="{y:.2}" font-size="{size:.2}" font-family="sans-serif" text-anchor="{anchor}" fill="{INK}">{text}</text>"#
        ));
    }

    /// Writes a text into at most `width` px: smaller if it is too long, and cut if it is much too long.
    fn fitted(&mut self, (x, y): (f64, f64), width: f64, anchor: &str, text: &str) {
        #[expect(clippy::cast_precision_loss, reason = "the length of a line")]
        let natural = text.chars().count() as f64 * LETTER * self.text;
        let size = self.text * (width / natural).clamp(SMALLEST, 1.0);
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a number of letters")]
        let letters = (width / (LETTER * size)).max(1.0) as usize;
        if text.chars().count() > letters {
            self.text(x, y, size, anchor, &cut(text, letters.saturating_sub(1)));
        } else {
            self.text(x, y, size, anchor, text);
        }
    }
}

/// Width of a letter over the font size, on average and with a reserve for wide fonts.
const LETTER: f64 = 0.54;

/// Smallest size of a fitted text over the font size.
const SMALLEST: f64 = 0.7;

#[cfg(test)]
#[cfg(feature = "png")]
mod tests;
