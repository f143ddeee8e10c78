//! Draws a picture of discs and lines as SVG, with y up, a header, a legend and a scale bar.
//!
//! All lengths in pixels are proportional to the width in pixels, so the picture looks the same at any size.

use std::fmt::Write as _;

use crate::space::Vector;
use crate::text::{LONGEST_QUOTATION, cut, for_xml};
use crate::writers::colour::{Rgb, hex};
use crate::writers::png::FARTHEST;

/// A picture to be drawn.
#[derive(Clone, Debug, Default)]
pub struct Picture {
    /// Lower left corner of the view, m.
    pub low: Vector,
    /// Upper right corner of the view, m.
    pub high: Vector,
    /// Width of the picture, px.
    pub width: f64,
    /// Lines of the header.
    pub header: Vec<String>,
    /// Legend.
    pub legend: Legend,
    /// Discs as (centre in m, radius in m, colour).
    pub discs: Vec<(Vector, f64, Rgb)>,
    /// Labels on top of all shapes, as (middle of the baseline in m, text).
    pub labels: Vec<(Vector, String)>,
    /// Whether discs have an outline, which separates discs that hide each other.
    pub outlined: bool,
    /// Bonds on top of the discs, as (end in m, end in m, width in m, colour).
    pub bonds: Vec<(Vector, Vector, f64, Rgb)>,
    /// Rectangles below all other shapes: for each colour, pairs of lower left and upper right corner in m.
    pub cells: Vec<(Rgb, Vec<(Vector, Vector)>)>,
    /// Lines as (end in m, end in m, colour).
    pub lines: Vec<(Vector, Vector, Rgb)>,
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

/// Font size over the width of the picture. Margins are multiples of the font size.
const TEXT: f64 = 0.028;

/// A picture in the course of drawing.
struct Paper<'a> {
    picture: &'a Picture,
    scale: f64,
    top: f64,
    height: f64,
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
pub fn pixels(width: f64, (low, high): (Vector, Vector), lines: usize) -> f64 {
    let size = high - low;
    width * (top(width, lines) + width / size.x * size.y)
}

impl Picture {
    /// Returns the picture as an SVG document.
    #[must_use]
    pub fn to_svg(&self) -> String {
        let size = self.high - self.low;
        let scale = self.width / size.x;
        let text = TEXT * self.width;
        let legend_rows = match &self.legend {
            Legend::None => 0,
            Legend::Classes(classes) => classes.len(),
            Legend::Scale { .. } => 2,
        };
        let top = top(self.width, self.header.len().max(legend_rows));
        let height = top + size.y * scale;
        let mut paper = Paper { picture: self, scale, top, height, svg: String::new() };
        paper.frame();
        paper.bodies();
        for (place, words) in &self.labels {
            let at = paper.at(*place);
            paper.text(at.x, at.y, text, "middle", words);
        }
        paper.header(text);
        paper.legend(text);
        paper.scale_bar(text);
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
    fn at(&self, x: Vector) -> Vector {
        let x =
            Vector::new((x.x - self.picture.low.x) * self.scale, self.top + (self.picture.high.y - x.y) * self.scale);
        x.clamp(Vector::splat(-FARTHEST), Vector::splat(FARTHEST))
    }

    fn frame(&mut self) {
        let (width, height) = (self.picture.width, self.height);
        self.put(format_args!(
            r#"<svg xmlns="http://www.w3.org/2000/svg" width="{width:.0}" height="{height:.0}" viewBox="0 0 {width:.2} {height:.2}">"#
        ));
        self.put(format_args!(r##"<rect width="{width:.2}" height="{height:.2}" fill="#ffffff"/>"##));
    }

    /// Draws a line between two points (m), `width` px wide.
    fn line(&mut self, from: Vector, to: Vector, width: f64, colour: Rgb) {
        let (a, b) = (self.at(from), self.at(to));
        let colour = hex(colour);
        self.put(format_args!(
            r#"<line x1="{:.2}" y1="{:.2}" x2="{:.2}" y2="{:.2}" stroke="{colour}" stroke-width="{width:.2}"/>"#,
            a.x, a.y, b.x, b.y
        ));
    }

    fn bodies(&mut self) {
        self.cells();
        for &(from, to, colour) in &self.picture.lines {
            self.line(from, to, 0.004 * self.picture.width, colour);
        }
        if self.picture.outlined {
            let width = 0.0008 * self.picture.width;
            self.put(format_args!(r##"<g stroke="#222222" stroke-width="{width:.2}">"##));
        }
        for &(centre, radius, colour) in &self.picture.discs {
            let (c, r) = (self.at(centre), (radius * self.scale).min(FARTHEST));
            self.put(format_args!(r#"<circle cx="{:.2}" cy="{:.2}" r="{r:.2}" fill="{}"/>"#, c.x, c.y, hex(colour)));
        }
        if self.picture.outlined {
            self.put(format_args!("</g>"));
        }
        for &(from, to, width, colour) in &self.picture.bonds {
            self.line(from, to, width * self.scale, colour);
        }
        // A white rectangle covers shapes that extend into the header. Clipping them would take three times as long.
        let (width, top) = (self.picture.width, self.top);
        self.put(format_args!(r##"<rect width="{width:.2}" height="{top:.2}" fill="#ffffff"/>"##));
    }

    /// Draws all rectangles of one colour as one path, so that smoothing leaves no seams between neighbours.
    fn cells(&mut self) {
        for (colour, cells) in &self.picture.cells {
            let mut path = String::new();
            for &(low, high) in cells {
                let (a, b) = (self.at(low), self.at(high));
                // Writing to a string cannot fail.
                let _ = write!(path, "M{:.1} {:.1}H{:.1}V{:.1}H{:.1}Z", a.x, a.y, b.x, b.y, a.x);
            }
            let fill = hex(*colour);
            self.put(format_args!(r#"<path d="{path}" fill="{fill}" shape-rendering="crispEdges"/>"#));
        }
    }

    fn text(&mut self, x: f64, y: f64, size: f64, anchor: &str, text: &str) {
        let text = for_xml(&cut(text, LONGEST_QUOTATION));
        self.put(format_args!(
            r##"<text x="{x:.2}" y="{y:.2}" font-size="{size:.2}" font-family="sans-serif" text-anchor="{anchor}" fill="#222222">{text}</text>"##
        ));
    }

    fn header(&mut self, text: f64) {
        let mut y = 1.35 * text;
        for line in &self.picture.header {
            self.text(0.6 * text, y, text, "start", line);
            y += 1.35 * text;
        }
    }

    fn legend(&mut self, text: f64) {
        let right = self.picture.width - 0.6 * text;
        match &self.picture.legend {
            Legend::None => {}
            Legend::Classes(classes) => {
                let mut y = 1.35 * text;
                for (name, colour) in classes {
                    self.text(right - 1.2 * text, y, text, "end", name);
                    let (x, y_middle, r) = (right - 0.4 * text, y - 0.35 * text, 0.4 * text);
                    self.put(format_args!(
                        r#"<circle cx="{x:.2}" cy="{y_middle:.2}" r="{r:.2}" fill="{}"/>"#,
                        hex(*colour)
                    ));
                    y += 1.35 * text;
                }
            }
            Legend::Scale { from, to, title, map } => {
                let width = 0.3 * self.picture.width;
                self.text(right, 1.35 * text, text, "end", &format!("{title}: {} to {}", rounded(*from), rounded(*to)));
                self.put(format_args!(r#"<linearGradient id="scale">"#));
                for stop in 0..=20u8 {
                    let share = f64::from(stop) / 20.0;
                    let fill = hex(map(share));
                    self.put(format_args!(r#"<stop offset="{share}" stop-color="{fill}"/>"#));
                }
                self.put(format_args!("</linearGradient>"));
                let (x, y, height) = (right - width, 1.8 * text, 0.8 * text);
                self.put(format_args!(
                    r#"<rect x="{x:.2}" y="{y:.2}" width="{width:.2}" height="{height:.2}" fill="url(#scale)"/>"#
                ));
            }
        }
    }

    /// Draws a scale bar of 1, 2 or 5 times a power of ten metres, at most a quarter of the width.
    fn scale_bar(&mut self, text: f64) {
        let limit = 0.25 * self.picture.width / self.scale;
        let power = 10f64.powf(limit.log10().floor());
        let metres = [5.0, 2.0, 1.0].into_iter().map(|m| m * power).find(|&m| m <= limit).unwrap_or(power);
        let (right, y) = (self.picture.width - text, self.height - 0.8 * text);
        let left = right - metres * self.scale;
        let width = 0.12 * text;
        // A light background keeps the bar legible on top of shapes.
        let (label, height) = ((right - left).max(3.5 * text) + text, 2.1 * text);
        let (x, top) = (0.5 * (left + right - label), y - 1.6 * text);
        self.put(format_args!(
            r##"<rect x="{x:.2}" y="{top:.2}" width="{label:.2}" height="{height:.2}" fill="#ffffff" fill-opacity="0.85"/>"##
        ));
        self.put(format_args!(
            r##"<line x1="{left:.2}" y1="{y:.2}" x2="{right:.2}" y2="{y:.2}" stroke="#222222" stroke-width="{width:.2}"/>"##
        ));
        self.text(0.5 * (left + right), y - 0.4 * text, text, "middle", &format!("{} m", rounded(metres)));
    }
}

/// Returns a number as text, without digits that come from binary rounding.
fn rounded(value: f64) -> String {
    if value == 0.0 || value >= 1e-3 { format!("{}", (value * 1e6).round() / 1e6) } else { format!("{value:e}") }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn picture(width: f64) -> Picture {
        Picture {
            low: Vector::ZERO,
            high: Vector::new(2.0, 1.0),
            width,
            header: vec!["a < b & c ]]> \u{1b}".to_owned()],
            cells: vec![([0, 0, 255], vec![(Vector::ZERO, Vector::splat(0.5))])],
            labels: vec![(Vector::new(1.0, 0.5), "half".to_owned())],
            discs: vec![(Vector::new(0.5, 0.25), 0.1, [255, 0, 0])],
            ..Picture::default()
        }
    }

    #[test]
    fn metres_map_to_pixels_with_y_up() {
        let svg = picture(200.0).to_svg();
        // The header has (1.35 + 0.7) lines of 5.6 px; the disc is 75 px below the top of a view of 100 px.
        assert!(svg.contains(r##"<circle cx="50.00" cy="86.48" r="10.00" fill="#ff0000"/>"##), "{svg}");
        assert!(svg.contains(r##"<path d="M0.0 111.5H50.0V61.5H0.0Z" fill="#0000ff""##), "{svg}");
        assert!(svg.contains(r#"<text x="100.00" y="61.48""#) && svg.contains(">half<"), "{svg}");
        assert!(svg.contains("a &lt; b &amp; c ]]&gt; \u{fffd}"));
        assert!(svg.contains(">0.5 m<"));
        assert!((pixels(200.0, (Vector::ZERO, Vector::new(2.0, 1.0)), 1) - 200.0 * (2.05 * 5.6 + 100.0)).abs() < 1e-9);
    }

    #[test]
    fn every_title_can_be_drawn() {
        let titles =
            ["]]>", "<!--", "\u{0}\u{1b}[2J\u{ffff}", "\u{202e}\u{200d}\u{301}", "🌾 صومعة 谷仓", &"&".repeat(100_000)];
        for title in titles {
            let svg = Picture { header: vec![title.to_owned()], ..picture(100.0) }.to_svg();
            assert!(svg.len() < 5_000, "{}", svg.len());
            crate::writers::png::encode(&svg).unwrap_or_else(|error| panic!("{title:?}: {error}"));
        }
    }
}
