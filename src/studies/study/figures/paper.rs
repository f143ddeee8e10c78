//! Drawing primitives for figures: a white SVG document in px with y downwards, and the position of a lattice in it.
//!
//! Limits. Formulas support subscripts only: `_` and the digits after it.

use std::fmt::Write as _;

use siloflow_dem::space::Vector;
use siloflow_figures::colour::{Rgb, hex};
use siloflow_lattice::velocities::in_bonds;
use siloflow_text::safe::for_xml;

/// Colour of text, outlines and particles at rest.
pub(super) const INK: Rgb = [0x22; 3];
/// Colour of the background lines.
pub(super) const FAINT: Rgb = [0xc4; 3];
/// Colour of velocities to nearest neighbours (blue of Okabe and Ito).
pub(super) const NEAREST: Rgb = [0x00, 0x72, 0xb2];
/// Colour of velocities to second-nearest neighbours (vermilion of Okabe and Ito).
pub(super) const SECOND: Rgb = [0xd5, 0x5e, 0x00];

/// Width (px) and colour of lines.
#[derive(Clone, Copy)]
pub(super) struct Pen {
    pub width: f64,
    pub colour: Rgb,
}

/// The point of a text that is put at the given position.
#[derive(Clone, Copy)]
pub(super) enum Anchor {
    Start,
    Middle,
    End,
}

/// An SVG document under construction.
pub(super) struct Paper(String);

impl Paper {
    /// Creates a white document of this size, px.
    pub fn new(width: f64, height: f64) -> Self {
        let mut paper = Self(String::new());
        paper.put(format_args!(
            r#"<svg xmlns="http://www.w3.org/2000/svg" width="{width:.0}" height="{height:.0}" viewBox="0 0 {width:.0} {height:.0}">"#
        ));
        paper.put(format_args!(r##"<rect width="{width:.0}" height="{height:.0}" fill="#ffffff"/>"##));
        paper
    }

    /// Appends an SVG element.
    // Writing to a string cannot fail.
    pub fn put(&mut self, element: std::fmt::Arguments<'_>) {
        let _ = self.0.write_fmt(element);
        self.0.push('\n');
    }

    /// Returns the complete document.
    pub fn finish(mut self) -> String {
        self.0.push_str("</svg>\n");
        self.0
    }

    pub fn line(&mut self, from: Vector, to: Vector, pen: Pen) {
        self.polyline(&[from, to], pen);
    }

    /// Draws a polyline through the points.
    pub fn polyline(&mut self, points: &[Vector], Pen { width, colour }: Pen) {
        let mut path = String::new();
        for point in points {
            let _ = write!(path, "{}{:.1} {:.1}", if path.is_empty() { 'M' } else { 'L' }, point.x, point.y);
        }
        let colour = hex(colour);
        self.put(format_args!(
            r#"<path d="{path}" fill="none" stroke="{colour}" stroke-width="{width}" stroke-linejoin="round"/>"#
        ));
    }

    /// Draws an arrow. The length of its head is 5 pen widths, but at most 0.7 of the length of the arrow.
    pub fn arrow(&mut self, from: Vector, to: Vector, pen: Pen) {
        let vector = to - from;
        let length = vector.length();
        let ahead = if length > 0.0 { vector / length } else { Vector::new(1.0, 0.0) };
        let head = (5.0 * pen.width).min(0.7 * length);
        let base = to - head * ahead;
        let aside = 0.4 * head * Vector::new(-ahead.y, ahead.x);
        // The line overlaps the head slightly, so that no gap is visible.
        self.line(from, base + 0.2 * head * ahead, pen);
        let a = base + aside;
        let b = base - aside;
        self.put(format_args!(
            r#"<path d="M{:.1} {:.1}L{:.1} {:.1}L{:.1} {:.1}Z" fill="{}"/>"#,
            to.x,
            to.y,
            a.x,
            a.y,
            b.x,
            b.y,
            hex(pen.colour)
        ));
    }

    pub fn dot(&mut self, at: Vector, radius: f64, fill: Rgb) {
        let fill = hex(fill);
        self.put(format_args!(r#"<circle cx="{:.1}" cy="{:.1}" r="{radius}" fill="{fill}"/>"#, at.x, at.y));
    }

    pub fn ring(&mut self, at: Vector, radius: f64, Pen { width, colour }: Pen) {
        let colour = hex(colour);
        self.put(format_args!(
            r#"<circle cx="{:.1}" cy="{:.1}" r="{radius}" fill="none" stroke="{colour}" stroke-width="{width}"/>"#,
            at.x, at.y
        ));
    }

    pub fn text(&mut self, at: Vector, size: f64, anchor: Anchor, text: &str) {
        let text = for_xml(text);
        self.write(at, size, anchor, &text);
    }

    /// Draws a text with subscripts.
    pub fn formula(&mut self, at: Vector, size: f64, anchor: Anchor, text: &str) {
        let down = 0.22 * size;
        let small = 0.75 * size;
        let mut parts = text.split('_');
        let mut written = for_xml(parts.next().unwrap_or_default());
        for part in parts {
            let (digits, rest) = part.split_at(part.find(|c: char| !c.is_ascii_digit()).unwrap_or(part.len()));
            let _ = write!(written, r#"<tspan dy="{down:.1}" font-size="{small:.1}">{digits}</tspan>"#);
            if !rest.is_empty() {
                let _ = write!(written, r#"<tspan dy="-{down:.1}">{}</tspan>"#, for_xml(rest));
            }
        }
        self.write(at, size, anchor, &written);
    }

    fn write(&mut self, at: Vector, size: f64, anchor: Anchor, written: &str) {
        let anchor = match anchor {
            Anchor::Start => "start",
            Anchor::Middle => "middle",
            Anchor::End => "end",
        };
        self.put(format_args!(
            r#"<text x="{:.1}" y="{:.1}" font-size="{size}" font-family="sans-serif" text-anchor="{anchor}" fill="{}">{written}</text>"#,
            at.x, at.y, hex(INK)
        ));
    }
}

/// Position of a lattice in the document: its site (0, 0), and the length of a bond, px.
#[derive(Clone, Copy)]
pub(super) struct Lattice {
    pub origin: Vector,
    pub bond: f64,
}

impl Lattice {
    /// Returns the position of the site (X, Y), px. It is also the tip of the arrow for a sum of velocities (X, Y).
    pub fn at(self, site: (i32, i32)) -> Vector {
        let (x, y) = in_bonds(site);
        self.origin + self.bond * Vector::new(x, -y)
    }
}
