//! Minimal plots as SVG: panels with two linear or logarithmic axes, curves as lines or dots, and a legend.

use std::fmt::Write as _;

use crate::text::for_xml;

/// An axis of a panel.
#[derive(Clone, Debug)]
pub struct Axis {
    /// Quantity and unit.
    pub label: &'static str,
    /// Value at the lower or left end.
    pub from: f64,
    /// Value at the upper or right end.
    pub to: f64,
    /// Whether the axis is logarithmic. Both ends must be positive then.
    pub is_log: bool,
    /// Values of the ticks.
    pub ticks: Vec<f64>,
}

impl Axis {
    /// Returns a linear axis with about five ticks, at whole multiples of 1, 2 or 5 times a power of ten.
    #[must_use]
    pub fn linear(label: &'static str, from: f64, to: f64) -> Self {
        let rough = ((to - from) / 5.0).max(f64::MIN_POSITIVE);
        let power = 10f64.powf(rough.log10().floor());
        let step = [1.0, 2.0, 5.0, 10.0].map(|m| m * power).into_iter().find(|&step| step >= rough).unwrap_or(rough);
        let first = (from / step - 1e-9).ceil();
        let ticks = (0..12u8).map(|n| (first + f64::from(n)) * step).take_while(|&tick| tick <= to + 1e-9 * step);
        Self { label, from, to, is_log: false, ticks: ticks.collect() }
    }

    /// Returns a logarithmic axis around the positive finite numbers of `values`.
    ///
    /// It extends a factor 2 beyond them and has ticks at powers of ten. An axis of less than three decades also has
    /// ticks at 2 and 5 times powers of ten.
    #[must_use]
    pub fn logarithmic(label: &'static str, values: impl IntoIterator<Item = f64>) -> Self {
        let (low, high) = values
            .into_iter()
            .filter(|&value| value > 0.0 && value.is_finite())
            .fold((f64::INFINITY, 0.0), |(low, high), value| (value.min(low), value.max(high)));
        let (from, to) = if low <= high { (low / 2.0, high * 2.0) } else { (0.1, 10.0) };
        #[expect(clippy::cast_possible_truncation, reason = "the exponent of a double")]
        let decades = || from.log10().floor() as i32..=to.log10().ceil() as i32;
        let multiples: &[f64] = if to / from < 1e3 { &[1.0, 2.0, 5.0] } else { &[1.0] };
        let ticks = decades().flat_map(|n| multiples.iter().map(move |m| m * 10f64.powi(n)));
        Self { label, from, to, is_log: true, ticks: ticks.filter(|&tick| (from..=to).contains(&tick)).collect() }
    }

    /// Returns the position of `value` along the axis, 0 at its lower end and 1 at its upper end.
    fn fraction(&self, value: f64) -> f64 {
        if self.is_log {
            (value / self.from).ln() / (self.to / self.from).ln()
        } else {
            (value - self.from) / (self.to - self.from)
        }
    }
}

/// A curve of a panel.
#[derive(Clone, Debug)]
pub struct Curve {
    /// Name in the legend.
    pub name: String,
    /// Colour in the notation of SVG.
    pub colour: &'static str,
    /// Points in the units of the axes.
    pub points: Vec<(f64, f64)>,
    /// Whether a line joins the points.
    pub has_line: bool,
    /// Whether each point is a dot.
    pub has_dots: bool,
}

/// Returns the colour of curve `number`; the first is black.
///
/// Colours are distinguishable with colour blindness (Okabe and Ito) and repeat after seven curves.
#[must_use]
pub fn colour(number: usize) -> &'static str {
    const COLOURS: [&str; 7] = ["#222222", "#0072b2", "#d55e00", "#009e73", "#e69f00", "#cc79a7", "#56b4e9"];
    COLOURS[number % COLOURS.len()]
}

/// Width and height of a panel, px.
const SIZE: (f64, f64) = (520.0, 400.0);
/// Margins of a panel (left, top, right, bottom), px.
const MARGIN: (f64, f64, f64, f64) = (72.0, 44.0, 16.0, 56.0);

fn text(svg: &mut String, x: f64, y: f64, anchor: &str, turn: &str, words: &str) {
    let words = for_xml(words);
    // Writing to a string cannot fail; the same holds below.
    let _ = writeln!(
        svg,
        r##"<text x="{x:.1}" y="{y:.1}" font-size="13" font-family="sans-serif" text-anchor="{anchor}" fill="#222222"{turn}>{words}</text>"##
    );
}

/// Returns the label of a tick, without digits that come from binary rounding.
fn number(value: f64, is_log: bool) -> String {
    if is_log && !(0.01..1e4).contains(&value) {
        format!("{value:.0e}")
    } else {
        format!("{}", (value * 1e9).round() / 1e9)
    }
}

/// Draws a panel whose left edge is at `left` px. The first line of the legend is at `key` px from the top.
fn panel(svg: &mut String, left: f64, title: &str, x: &Axis, y: &Axis, curves: &[Curve], key: f64) {
    let (margin, top, margin_right, bottom) = MARGIN;
    let (width, height) = (SIZE.0 - margin - margin_right, SIZE.1 - top - bottom);
    let at = |px: f64, py: f64| place(left, x, y, px, py);
    text(svg, left + margin, 26.0, "start", "", title);
    for &tick in &x.ticks {
        let (px, py) = at(tick, y.from);
        let _ = writeln!(svg, r##"<path d="M{px:.1} {py:.1}V{top}" stroke="#e4e4e4"/>"##);
        text(svg, px, py + 18.0, "middle", "", &number(tick, x.is_log));
    }
    for &tick in &y.ticks {
        let (px, py) = at(x.from, tick);
        let _ = writeln!(svg, r##"<path d="M{px:.1} {py:.1}h{width}" stroke="#e4e4e4"/>"##);
        text(svg, px - 6.0, py + 4.0, "end", "", &number(tick, y.is_log));
    }
    let frame = left + margin;
    let _ = writeln!(
        svg,
        r##"<rect x="{frame}" y="{top}" width="{width}" height="{height}" fill="none" stroke="#222222"/>"##
    );
    text(svg, frame + 0.5 * width, SIZE.1 - 14.0, "middle", "", x.label);
    let (px, py) = (left + 18.0, top + 0.5 * height);
    text(svg, px, py, "middle", &format!(r#" transform="rotate(-90 {px} {py})""#), y.label);
    for (row, curve) in (0u32..).zip(curves) {
        let points: Vec<_> = curve.points.iter().map(|&(px, py)| at(px, py)).collect();
        draw(svg, curve, &points, (frame + 14.0, key + 18.0 * f64::from(row)));
    }
}

/// Draws a curve through `points` (px), and its legend line at `key` (px).
fn draw(svg: &mut String, curve: &Curve, points: &[(f64, f64)], key: (f64, f64)) {
    let (colour, (key_x, key_y)) = (curve.colour, key);
    if curve.has_line {
        let path: Vec<_> = points.iter().map(|(px, py)| format!("{px:.1},{py:.1}")).collect();
        let path = path.join(" ");
        let _ = writeln!(svg, r#"<polyline points="{path}" fill="none" stroke="{colour}" stroke-width="1.5"/>"#);
        let _ = writeln!(svg, r#"<path d="M{:.1} {key_y:.1}h16" stroke="{colour}" stroke-width="1.5"/>"#, key_x - 8.0);
    }
    if curve.has_dots {
        for (px, py) in points.iter().chain([&key]) {
            let _ = writeln!(svg, r#"<circle cx="{px:.1}" cy="{py:.1}" r="3.4" fill="{colour}"/>"#);
        }
    }
    text(svg, key_x + 14.0, key_y + 4.0, "start", "", &curve.name);
}

/// One panel of a sheet.
#[derive(Clone, Debug)]
pub struct Panel<'a> {
    /// Title above the panel.
    pub title: &'a str,
    /// Horizontal axis.
    pub x: Axis,
    /// Vertical axis.
    pub y: Axis,
    /// Curves.
    pub curves: Vec<Curve>,
    /// Points with a ring, in the units of the axes.
    pub rings: Vec<(f64, f64)>,
}

/// Returns an SVG figure of panels in rows of `per_row` (at least one).
#[must_use]
pub fn sheet(panels: &[Panel], per_row: usize) -> String {
    let per_row = per_row.max(1);
    let real = |count: usize| f64::from(u16::try_from(count).unwrap_or(u16::MAX));
    let (width, height) = (SIZE.0 * real(per_row.min(panels.len())), SIZE.1 * real(panels.len().div_ceil(per_row)));
    let mut svg = format!(
        r##"<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{height}" viewBox="0 0 {width} {height}"><rect width="{width}" height="{height}" fill="#ffffff"/>
"##
    );
    for (number, at) in panels.iter().enumerate() {
        let (left, down) = (SIZE.0 * real(number % per_row), SIZE.1 * real(number / per_row));
        let _ = writeln!(svg, r#"<g transform="translate(0 {down})">"#);
        // The legend is at the lower left, which falling curves leave free.
        let rows = real(at.curves.len());
        panel(&mut svg, left, at.title, &at.x, &at.y, &at.curves, SIZE.1 - MARGIN.3 - 18.0 * rows);
        for &(px, py) in &at.rings {
            let (px, py) = place(left, &at.x, &at.y, px, py);
            let _ = writeln!(svg, r##"<circle cx="{px:.1}" cy="{py:.1}" r="6.4" fill="none" stroke="#222222"/>"##);
        }
        svg += "</g>\n";
    }
    svg + "</svg>\n"
}

/// Returns the position (px) of the point (`px`, `py`) in a panel whose left edge is at `left` px.
fn place(left: f64, x: &Axis, y: &Axis, px: f64, py: f64) -> (f64, f64) {
    let (margin, top, margin_right, bottom) = MARGIN;
    let (width, height) = (SIZE.0 - margin - margin_right, SIZE.1 - top - bottom);
    (left + margin + x.fraction(px) * width, top + (1.0 - y.fraction(py)) * height)
}

/// Returns an SVG figure of panels side by side, each given as (title, x axis, y axis, curves).
#[must_use]
pub fn figure(panels: &[(&str, Axis, Axis, Vec<Curve>)]) -> String {
    let width = SIZE.0 * f64::from(u8::try_from(panels.len()).unwrap_or(1));
    let mut svg = format!(
        r##"<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{h}" viewBox="0 0 {width} {h}"><rect width="{width}" height="{h}" fill="#ffffff"/>
"##,
        h = SIZE.1
    );
    let mut left = 0.0;
    for (title, x, y, curves) in panels {
        panel(&mut svg, left, title, x, y, curves, MARGIN.1 + 18.0);
        left += SIZE.0;
    }
    svg + "</svg>\n"
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_round_and_within_the_axis() {
        let ticks = |axis: &Axis| axis.ticks.iter().map(|&tick| number(tick, axis.is_log)).collect::<Vec<_>>();
        assert_eq!(ticks(&Axis::linear("", 0.0, 1.0)), ["0", "0.2", "0.4", "0.6", "0.8", "1"]);
        assert_eq!(ticks(&Axis::linear("", 0.0, 2.37)), ["0", "0.5", "1", "1.5", "2"]);
        assert_eq!(ticks(&Axis::logarithmic("", [1.0, 10.0])), ["0.5", "1", "2", "5", "10", "20"]);
        assert_eq!(ticks(&Axis::logarithmic("", [1e-6, 1.0])), ["1e-6", "1e-5", "1e-4", "1e-3", "0.01", "0.1", "1"]);
        assert_eq!(ticks(&Axis::logarithmic("", [])), ["0.1", "0.2", "0.5", "1", "2", "5", "10"]);
    }

    #[test]
    fn points_are_placed_by_the_axes_and_names_are_escaped() {
        let curve = Curve {
            name: "a < b & c".to_owned(),
            colour: colour(0),
            points: vec![(0.5, 10.0)],
            has_line: false,
            has_dots: true,
        };
        let y = Axis { label: "y", from: 1.0, to: 100.0, is_log: true, ticks: vec![] };
        let svg = figure(&[("", Axis::linear("x", 0.0, 1.0), y, vec![curve])]);
        // The panel extends from 72 to 504 px and from 44 to 344 px; the point is in its middle.
        assert!(svg.contains(r#"<circle cx="288.0" cy="194.0""#) && svg.contains("a &lt; b &amp; c"), "{svg}");
    }

    #[test]
    fn a_sheet_has_rows_and_rings() {
        let axis = || Axis { label: "", from: 1.0, to: 100.0, is_log: true, ticks: vec![] };
        let panel = || Panel { title: "", x: axis(), y: axis(), curves: vec![], rings: vec![(10.0, 10.0)] };
        let svg = sheet(&[panel(), panel(), panel()], 2);
        // The sheet has two by two panels. The third is below the first and has a ring in its middle.
        assert!(svg.contains(r#"viewBox="0 0 1040 800""#), "{svg}");
        let third = svg.split_once("translate(0 400)").unwrap().1;
        assert!(third.contains(r#"<circle cx="288.0" cy="194.0" r="6.4" fill="none""#), "{svg}");
    }
}
