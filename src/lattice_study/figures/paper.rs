//! What figures are drawn on: an SVG document in the making, white, in px with y down; and where a lattice is on it.
//!
//! Limits. A formula knows one thing, the subscript: `_` and the digits after it.

use std::fmt::Write as _;

use crate::lattice::velocities::in_bonds;
use crate::space::Vector;
use crate::writers::colour::{Rgb, hex};

/// Text, outlines, what is at rest.
pub(super) const INK: Rgb = [0x22; 3];
/// What stands behind.
pub(super) const FAINT: Rgb = [0xc4; 3];
/// Velocities to nearest neighbours (blue of Okabe and Ito).
pub(super) const NEAREST: Rgb = [0x00, 0x72, 0xb2];
/// Velocities to second-nearest neighbours (their vermilion).
pub(super) const SECOND: Rgb = [0xd5, 0x5e, 0x00];

/// How lines are drawn.
#[derive(Clone, Copy)]
pub(super) struct Pen {
    pub width: f64,
    pub colour: Rgb,
}

/// Which point of a text its place is.
#[derive(Clone, Copy)]
pub(super) enum Anchor {
    Start,
    Middle,
    End,
}

/// The document.
pub(super) struct Paper(String);

impl Paper {
    /// White paper.
    pub fn new(width: f64, height: f64) -> Self {
        let mut paper = Self(String::new());
        paper.put(format_args!(
            r#"<svg xmlns="http://www.w3.org/2000/svg" width="{width:.0}" height="{height:.0}" viewBox="0 0 {width:.0} {height:.0}">"#
        ));
        paper.put(format_args!(r##"<rect width="{width:.0}" height="{height:.0}" fill="#ffffff"/>"##));
        paper
    }

    /// Appends one element. Writing to a string cannot fail.
    pub fn put(&mut self, element: std::fmt::Arguments<'_>) {
        let _ = self.0.write_fmt(element);
        self.0.push('\n');
    }

    /// The whole document.
    pub fn finish(mut self) -> String {
        self.0.push_str("</svg>\n");
        self.0
    }

    pub fn line(&mut self, from: Vector, to: Vector, pen: Pen) {
        self.way(&[from, to], pen);
    }

    /// A line through all these points.
    pub fn way(&mut self, points: &[Vector], Pen { width, colour }: Pen) {
        let mut path = String::new();
        for point in points {
            let _ = write!(path, "{}{:.1} {:.1}", if path.is_empty() { 'M' } else { 'L' }, point.x, point.y);
        }
        let colour = hex(colour);
        self.put(format_args!(
            r#"<path d="{path}" fill="none" stroke="{colour}" stroke-width="{width}" stroke-linejoin="round"/>"#
        ));
    }

    /// An arrow; its head is as large as its pen asks for, or as its length allows.
    pub fn arrow(&mut self, from: Vector, to: Vector, pen: Pen) {
        let way = to - from;
        let length = way.length();
        let ahead = if length > 0.0 { way / length } else { Vector::new(1.0, 0.0) };
        let head = (5.0 * pen.width).min(0.7 * length);
        let (base, aside) = (to - head * ahead, 0.4 * head * Vector::new(-ahead.y, ahead.x));
        // A little into the head, so that no seam shows.
        self.line(from, base + 0.2 * head * ahead, pen);
        let (a, b) = (base + aside, base - aside);
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
        let text = escaped(text);
        self.write(at, size, anchor, &text);
    }

    /// A text with subscripts.
    pub fn formula(&mut self, at: Vector, size: f64, anchor: Anchor, text: &str) {
        let (down, small) = (0.22 * size, 0.75 * size);
        let mut parts = text.split('_');
        let mut written = escaped(parts.next().unwrap_or_default());
        for part in parts {
            let (digits, rest) = part.split_at(part.find(|c: char| !c.is_ascii_digit()).unwrap_or(part.len()));
            let _ = write!(written, r#"<tspan dy="{down:.1}" font-size="{small:.1}">{digits}</tspan>"#);
            if !rest.is_empty() {
                let _ = write!(written, r#"<tspan dy="-{down:.1}">{}</tspan>"#, escaped(rest));
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

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;")
}

/// A lattice on paper: where its site (0, 0) is, and how long a bond, px.
#[derive(Clone, Copy)]
pub(super) struct Lattice {
    pub origin: Vector,
    pub bond: f64,
}

impl Lattice {
    /// Where the site (X, Y) is, or the tip of a sum of velocities from the origin.
    pub fn at(self, site: (i32, i32)) -> Vector {
        let (x, y) = in_bonds(site);
        self.origin + self.bond * Vector::new(x, -y)
    }
}
