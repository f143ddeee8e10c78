//! The drawing of one panel: grid, frame, labels, cells, curves, marks and legend.
//!
//! Every element has its colours as attributes, for a picture on white, and a class, so that a page with another background
//! can change them by a style sheet: `paper`, `ink` (text), `grid`, `frame`, `mark`, and `k0` for the colour of a first curve.

use std::fmt::Write as _;

use super::axis::Axis;
use super::{Clock, Curve, FONT, Key, MARGIN, Panel, SCALE, Scale, class};
use siloflow_text::safe::for_xml;

/// Height of a line of the legend, px.
const LINE: f64 = 18.0;
/// Mean width of a letter of 13 px, px.
const LETTER: f64 = 7.0;

/// The place of the plot area in a figure, px.
pub(super) struct Area {
    left: f64,
    right: f64,
    top: f64,
    bottom: f64,
}

impl Area {
    /// Returns the area of a panel of this size whose left edge is at `left`, px. A legend above it takes space. A panel with a scale keeps its
    /// aspect.
    pub(super) fn of(panel: &Panel, left: f64, size: (f64, f64)) -> Self {
        let (margin, top, margin_right, bottom) = MARGIN;
        let rows = if panel.key == Key::Above { legend_rows(&panel.curves, size.0).1 } else { 0.0 };
        let margin_right = margin_right + if panel.scale.is_some() { SCALE } else { 0.0 };
        let mut area = Self {
            left: left + margin,
            right: left + size.0 - margin_right,
            top: top + LINE * rows,
            bottom: size.1 - bottom,
        };
        if panel.scale.is_some() {
            let width = (area.right - area.left).min(Panel::ASPECT_WITH_SCALE * (area.bottom - area.top));
            area.right = area.left + width;
            area.top = area.bottom - width / Panel::ASPECT_WITH_SCALE;
        }
        area
    }

    /// Returns the position (px) of a point.
    pub(super) fn place(&self, x: &Axis, y: &Axis, (px, py): (f64, f64)) -> (f64, f64) {
        let width = self.right - self.left;
        let height = self.bottom - self.top;
        (self.left + x.fraction(px) * width, self.bottom - y.fraction(py) * height)
    }
}

/// Returns the place of each entry in a legend above the plot of a panel of this width, in px from its left end and in lines, and the number of
/// lines.
fn legend_rows(curves: &[Curve], width: f64) -> (Vec<(f64, f64)>, f64) {
    let longest = width - MARGIN.0 - MARGIN.2;
    let mut x = 0.0;
    let mut row = 0.0;
    let mut place = |curve: &Curve| {
        let width = 40.0 + width_of(&curve.name);
        if x > 0.0 && x + width > longest {
            (x, row) = (0.0, row + 1.0);
        }
        x += width;
        (x - width, row)
    };
    let places: Vec<_> = curves.iter().filter(|curve| !curve.name.is_empty()).map(&mut place).collect();
    let rows = places.last().map_or(0.0, |place| place.1 + 1.0);
    (places, rows)
}

/// Returns the mean width of a text, px.
fn width_of(text: &str) -> f64 {
    LETTER * f64::from(u16::try_from(text.chars().count()).unwrap_or(u16::MAX))
}

/// Draws the line above all panels, with its middle at `x`.
pub(super) fn heading(svg: &mut String, x: f64, title: &str) {
    text(svg, (x, 22.0), "middle", r#" font-weight="bold""#, title);
}

/// Draws a panel of a size whose left edge is at `left`, px.
pub(super) fn draw(svg: &mut String, panel: &Panel, left: f64, size: (f64, f64)) {
    let area = Area::of(panel, left, size);
    let Area { left: x0, right: x1, top, bottom } = area;
    let x = &panel.x;
    let y = &panel.y;
    // Writing to a string cannot fail; the same holds below.
    let _ = write!(svg, r#"<g class="panel""#);
    if let Some(clock) = panel.clock {
        let clock = if clock == Clock::Run { "run" } else { "opening" };
        let _ = write!(
            svg,
            r#" data-clock="{clock}" data-left="{x0}" data-right="{x1}" data-top="{top}" data-bottom="{bottom}""#
        );
        let _ = write!(svg, r#" data-from="{}" data-to="{}""#, x.from, x.to);
    }
    svg.push_str(">\n");
    text(svg, (left + MARGIN.0, 26.0), "start", "", &panel.title);
    for cell in &panel.cells {
        let low = area.place(x, y, cell.low);
        let high = area.place(x, y, cell.high);
        let [px, py] = [low.0, high.1];
        let width = high.0 - low.0;
        let height = low.1 - high.1;
        let [red, green, blue] = cell.colour;
        let _ = writeln!(
            svg,
            r##"<path d="M{px:.2} {py:.2}h{width:.2}v{height:.2}h-{width:.2}z" fill="#{red:02x}{green:02x}{blue:02x}" stroke="none"/>"##
        );
    }
    grid(svg, panel, &area, size.1);
    if let Some(scale) = &panel.scale {
        colour_bar(svg, scale, &area);
    }
    for curve in &panel.curves {
        let points: Vec<_> = curve.points.iter().map(|&point| area.place(x, y, point)).collect();
        line(svg, curve, &points);
    }
    for &ring in &panel.rings {
        let (px, py) = area.place(x, y, ring);
        let _ = writeln!(
            svg,
            r##"<circle class="frame" cx="{px:.1}" cy="{py:.1}" r="6.4" fill="none" stroke="#222222"/>"##
        );
    }
    for (number, mark) in (0u8..).zip(&panel.marks) {
        let px = area.place(x, y, (mark.at, y.to)).0;
        let py = top + 14.0 + 15.0 * f64::from(number % 3);
        let _ = writeln!(
            svg,
            r##"<path class="mark" d="M{px:.1} {bottom}V{top}" stroke="#777777" stroke-dasharray="4 3" fill="none"/>"##
        );
        let (anchor, gap) = if px > 0.5 * (x0 + x1) { ("end", -4.0) } else { ("start", 4.0) };
        text(svg, (px + gap, py), anchor, "", &mark.name);
    }
    legend(svg, panel, &area, size.0);
    svg.push_str("</g>\n");
}

/// Draws grid lines, ticks, frame and axis labels of a panel of this height, px. Numbers of the horizontal axis that would overlap are left out.
fn grid(svg: &mut String, panel: &Panel, area: &Area, height_of_panel: f64) {
    let Area { left, right, top, bottom } = *area;
    let x = &panel.x;
    let y = &panel.y;
    let mut free_from = f64::NEG_INFINITY;
    for &tick in &x.ticks {
        let (px, py) = area.place(x, y, (tick, y.from));
        let _ = writeln!(svg, r##"<path class="grid" d="M{px:.1} {py:.1}V{top}" stroke="#e4e4e4"/>"##);
        let label = x.tick_label(tick);
        let half = 0.5 * width_of(&label);
        if px - half >= free_from {
            text(svg, (px, py + 18.0), "middle", "", &label);
            free_from = px + half + LETTER;
        }
    }
    for &tick in &y.ticks {
        let (px, py) = area.place(x, y, (x.from, tick));
        let _ = writeln!(svg, r##"<path class="grid" d="M{px:.1} {py:.1}H{right}" stroke="#e4e4e4"/>"##);
        text(svg, (px - 6.0, py + 4.0), "end", "", &y.tick_label(tick));
    }
    let width = right - left;
    let height = bottom - top;
    let _ = writeln!(
        svg,
        r##"<rect class="frame" x="{left}" y="{top}" width="{width}" height="{height}" fill="none" stroke="#222222"/>"##
    );
    text(svg, (left + 0.5 * width, height_of_panel - 14.0), "middle", "", &x.label);
    let px = left - MARGIN.0 + 18.0;
    let py = top + 0.5 * height;
    text(svg, (px, py), "middle", &format!(r#" transform="rotate(-90 {px} {py})""#), &y.label);
}

/// Draws the bar of a colour scale.
fn colour_bar(svg: &mut String, scale: &Scale, area: &Area) {
    const STEPS: u8 = 50;
    let left = area.right + 16.0;
    let width = 14.0;
    let height = area.bottom - area.top;
    for step in 0..STEPS {
        let [red, green, blue] = (scale.map)((f64::from(step) + 0.5) / f64::from(STEPS));
        let top = area.bottom - height * f64::from(step + 1) / f64::from(STEPS);
        let _ = writeln!(
            svg,
            r##"<path d="M{left} {top:.2}h{width}v{:.2}h-{width}z" fill="#{red:02x}{green:02x}{blue:02x}"/>"##,
            height / f64::from(STEPS) + 0.3
        );
    }
    for &tick in &scale.axis.ticks {
        let py = area.bottom - height * scale.axis.fraction(tick);
        text(svg, (left + width + 4.0, py + 4.0), "start", "", &scale.axis.tick_label(tick));
    }
    let px = left + width + 58.0;
    let py = area.top + 0.5 * height;
    text(svg, (px, py), "middle", &format!(r#" transform="rotate(-90 {px} {py})""#), &scale.axis.label);
}

/// Draws a curve through `points` (px). A point that is not finite interrupts the line.
fn line(svg: &mut String, curve: &Curve, points: &[(f64, f64)]) {
    let colour = curve.colour;
    let class = class(curve.colour);
    let dashes = if curve.is_dashed { r#" stroke-dasharray="6 4""# } else { "" };
    for part in points.split(|(px, py)| !px.is_finite() || !py.is_finite()) {
        if curve.has_line && !part.is_empty() {
            let path: Vec<_> = part.iter().map(|(px, py)| format!("{px:.1},{py:.1}")).collect();
            let path = path.join(" ");
            let _ = writeln!(
                svg,
                r#"<polyline class="{class}" points="{path}" fill="none" stroke="{colour}" stroke-width="1.5"{dashes}/>"#
            );
        }
        if curve.has_dots {
            for &point in part {
                dot(svg, curve.colour, point);
            }
        }
    }
}

fn dot(svg: &mut String, colour: &str, (px, py): (f64, f64)) {
    let class = class(colour);
    let _ = writeln!(svg, r#"<circle class="{class}" cx="{px:.1}" cy="{py:.1}" r="3.4" fill="{colour}"/>"#);
}

/// Draws a line of the legend for each curve with a name, in a panel of this width, px.
fn legend(svg: &mut String, panel: &Panel, area: &Area, width: f64) {
    let named: Vec<_> = panel.curves.iter().filter(|curve| !curve.name.is_empty()).collect();
    let count = f64::from(u16::try_from(named.len()).unwrap_or(u16::MAX));
    let above = legend_rows(&panel.curves, width).0;
    for ((row, curve), (right, line)) in (0u32..).zip(named).zip(above) {
        let row = f64::from(row);
        let (px, py) = match panel.key {
            Key::UpperLeft => (area.left + 14.0, area.top + LINE * (row + 1.0)),
            // The lower left is free where curves fall.
            Key::LowerLeft => (area.left + 14.0, area.bottom - LINE * (count - row)),
            Key::Above => (area.left + 8.0 + right, MARGIN.1 - 4.0 + LINE * line),
        };
        let colour = curve.colour;
        let class = class(curve.colour);
        let dashes = if curve.is_dashed { r#" stroke-dasharray="6 4""# } else { "" };
        if curve.has_line {
            let _ = writeln!(
                svg,
                r#"<path class="{class}" d="M{:.1} {py:.1}h16" stroke="{colour}" stroke-width="1.5" fill="none"{dashes}/>"#,
                px - 8.0
            );
        }
        if curve.has_dots {
            dot(svg, colour, (px, py));
        }
        text(svg, (px + 14.0, py + 4.0), "start", "", &curve.name);
    }
}

fn text(svg: &mut String, (x, y): (f64, f64), anchor: &str, turn: &str, words: &str) {
    let words = for_xml(words);
    let _ = writeln!(
        svg,
        r##"<text class="ink" x="{x:.1}" y="{y:.1}" font-size="{FONT}" font-family="sans-serif" text-anchor="{anchor}" fill="#222222"{turn}>{words}</text>"##
    );
}
