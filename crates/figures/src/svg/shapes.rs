//! The view of a picture: cells, surfaces, lines, discs, bonds and labels.
//!
//! Bonds have a light halo, so that they can be seen on dark discs. Bonds of one colour and nearly the same width are one path.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;

use super::{Finish, INK, Paper, Patch};
use crate::colour::{Rgb, hex, mix};
use crate::png::FARTHEST;
use siloflow_dem::space::Vector;

/// Width of an outline over the radius of the smallest disc, and over the width of the picture.
const OUTLINE: [f64; 2] = [0.16, 0.0016];

/// Thinnest outline that is drawn, px: thinner ones only darken their discs.
const THINNEST: f64 = 0.25;

/// Width of the halo on each side of a bond over the width of the picture. A halo is at most as wide as its bond.
const HALO: f64 = 0.002;

/// Widths of bonds over the width of the picture are rounded to multiples of this.
const BOND_STEP: f64 = 0.0004;

impl Paper<'_> {
    pub(super) fn shapes(&mut self) {
        let picture = self.picture;
        self.cells();
        picture.behind.iter().for_each(|patch| self.patch(patch));
        for &(from, to, colour) in &picture.lines {
            self.line(from, to, 0.004 * picture.width, colour);
        }
        self.discs();
        self.bonds();
        picture.front.iter().for_each(|patch| self.patch(patch));
        for (place, words) in &picture.labels {
            let at = self.at(*place);
            self.text(at.x, at.y, self.text, "middle", words);
        }
    }

    /// Draws a line between two points (m), `width` px wide.
    fn line(&mut self, from: Vector, to: Vector, width: f64, colour: Rgb) {
        let a = self.at(from);
        let b = self.at(to);
        let colour = hex(colour);
        self.put(format_args!(
            r#"<line x1="{:.2}" y1="{:.2}" x2="{:.2}" y2="{:.2}" stroke="{colour}" stroke-width="{width:.2}"/>"#,
            a.x, a.y, b.x, b.y
        ));
    }

    /// Draws all rectangles of one colour as one path, so that smoothing leaves no seams between neighbours.
    fn cells(&mut self) {
        for (colour, cells) in &self.picture.cells {
            let mut path = String::new();
            for &(low, high) in cells {
                let a = self.at(low);
                let b = self.at(high);
                // Writing to a string cannot fail.
                let _ = write!(path, "M{:.1} {:.1}H{:.1}V{:.1}H{:.1}Z", a.x, a.y, b.x, b.y, a.x);
            }
            let fill = hex(*colour);
            self.put(format_args!(r#"<path d="{path}" fill="{fill}" shape-rendering="crispEdges"/>"#));
        }
    }

    /// Draws the polygons of a patch as one path, so that neighbours have no seams.
    fn patch(&mut self, patch: &Patch) {
        let colour = hex(patch.colour);
        let mut outline = String::new();
        for corners in &patch.polygons {
            for (number, &corner) in corners.iter().enumerate() {
                let at = self.at(corner);
                let _ = write!(outline, "{}{:.1} {:.1}", if number == 0 { 'M' } else { 'L' }, at.x, at.y);
            }
            outline.push('Z');
        }
        if !outline.is_empty() && patch.opacity > 0.0 {
            let opacity = patch.opacity;
            self.put(format_args!(r#"<path d="{outline}" fill="{colour}" fill-opacity="{opacity:.2}"/>"#));
        }
        let edges = self.path_of(patch.edges.iter().copied());
        if !edges.is_empty() {
            let width = 0.0028 * self.picture.width;
            self.put(format_args!(
                r#"<path d="{edges}" fill="none" stroke="{colour}" stroke-width="{width:.2}" stroke-linecap="round"/>"#
            ));
        }
    }

    fn path_of(&self, lines: impl Iterator<Item = [Vector; 2]>) -> String {
        let mut path = String::new();
        for [from, to] in lines {
            let a = self.at(from);
            let b = self.at(to);
            let _ = write!(path, "M{:.1} {:.1}L{:.1} {:.1}", a.x, a.y, b.x, b.y);
        }
        path
    }

    fn discs(&mut self) {
        let picture = self.picture;
        let smallest = picture.discs.iter().map(|disc| disc.1).fold(f64::INFINITY, f64::min) * self.scale;
        let mut outline = (OUTLINE[0] * smallest).min(OUTLINE[1] * picture.width);
        if picture.finish == Finish::Plain || outline < THINNEST {
            outline = 0.0;
        }
        if picture.finish == Finish::Shaded {
            self.gradients();
        }
        if outline > 0.0 {
            self.put(format_args!(r##"<g stroke="#101820" stroke-opacity="0.6" stroke-width="{outline:.2}">"##));
        }
        for &(centre, radius, colour) in &picture.discs {
            // The outer edge of the outline is the edge of the disc.
            let c = self.at(centre);
            let r = (radius * self.scale - 0.5 * outline).min(FARTHEST);
            match picture.finish {
                Finish::Shaded => {
                    let [r8, g8, b8] = coarse(colour);
                    self.put(format_args!(
                        r#"<circle cx="{:.1}" cy="{:.1}" r="{r:.1}" fill="url(#s{r8:02x}{g8:02x}{b8:02x})"/>"#,
                        c.x, c.y
                    ));
                }
                _ => self.put(format_args!(
                    r#"<circle cx="{:.2}" cy="{:.2}" r="{r:.2}" fill="{}"/>"#,
                    c.x,
                    c.y,
                    hex(colour)
                )),
            }
        }
        if outline > 0.0 {
            self.put(format_args!("</g>"));
        }
    }

    /// Writes the shades of every colour of a sphere.
    fn gradients(&mut self) {
        let colours: BTreeSet<Rgb> = self.picture.discs.iter().map(|disc| coarse(disc.2)).collect();
        for colour in colours {
            let [r, g, b] = colour;
            let light = hex(mix(colour, [255; 3], 0.4));
            let dark = hex(mix(colour, [0; 3], 0.4));
            self.put(format_args!(
                r#"<radialGradient id="s{r:02x}{g:02x}{b:02x}" cx="0.36" cy="0.32" r="0.72"><stop stop-color="{light}"/><stop offset="0.4" stop-color="{}"/><stop offset="1" stop-color="{dark}"/></radialGradient>"#,
                hex(colour)
            ));
        }
    }

    fn bonds(&mut self) {
        let step = BOND_STEP * self.picture.width;
        let mut classes: BTreeMap<(u32, Rgb), Vec<[Vector; 2]>> = BTreeMap::new();
        for &(from, to, width, colour) in &self.picture.bonds {
            #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a class of widths")]
            let class = (width * self.scale / step).round().clamp(0.0, 1e6) as u32;
            if class > 0 {
                classes.entry((class, colour)).or_default().push([from, to]);
            }
        }
        let paths: Vec<_> = classes
            .iter()
            .map(|(&(class, colour), bonds)| (f64::from(class) * step, colour, self.path_of(bonds.iter().copied())))
            .collect();
        let halo = HALO * self.picture.width;
        for (width, _, path) in &paths {
            let width = width + 2.0 * halo.min(*width);
            self.put(format_args!(
                r##"<path d="{path}" fill="none" stroke="#ffffff" stroke-opacity="0.85" stroke-width="{width:.2}"/>"##
            ));
        }
        for (width, colour, path) in &paths {
            let colour = hex(*colour);
            self.put(format_args!(r#"<path d="{path}" fill="none" stroke="{colour}" stroke-width="{width:.2}"/>"#));
        }
    }

    /// Draws a line in px.
    pub(super) fn stroke(&mut self, [a, b]: [Vector; 2], width: f64, colour: Option<Rgb>) {
        let colour = colour.map_or_else(|| INK.to_owned(), hex);
        self.put(format_args!(
            r#"<line x1="{:.2}" y1="{:.2}" x2="{:.2}" y2="{:.2}" stroke="{colour}" stroke-width="{width:.2}"/>"#,
            a.x, a.y, b.x, b.y
        ));
    }
}

/// Returns a colour near this one, of a few dozen along a colour map.
fn coarse(colour: Rgb) -> Rgb {
    colour.map(|channel| (channel & 0xf8) | 0x04)
}
