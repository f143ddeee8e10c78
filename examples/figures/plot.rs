//! Just enough of a plot: two axes, linear or logarithmic, lines, points, labels; as SVG.

use std::fmt::Write as _;

/// One axis.
pub struct Axis {
    pub label: &'static str,
    pub from: f64,
    pub to: f64,
    pub is_log: bool,
    /// Where numbers stand.
    pub ticks: Vec<f64>,
}

impl Axis {
    fn share(&self, value: f64) -> f64 {
        if self.is_log {
            (value / self.from).ln() / (self.to / self.from).ln()
        } else {
            (value - self.from) / (self.to - self.from)
        }
    }
}

/// One curve.
pub struct Curve {
    pub name: String,
    pub colour: &'static str,
    pub points: Vec<(f64, f64)>,
    pub has_line: bool,
    pub has_dots: bool,
}

const SIZE: (f64, f64) = (520.0, 400.0);
const MARGIN: (f64, f64, f64, f64) = (72.0, 44.0, 16.0, 56.0);

fn text(svg: &mut String, x: f64, y: f64, anchor: &str, turn: &str, words: &str) {
    let _ = writeln!(
        svg,
        r##"<text x="{x:.1}" y="{y:.1}" font-size="13" font-family="sans-serif" text-anchor="{anchor}" fill="#222222"{turn}>{words}</text>"##
    );
}

fn number(value: f64, is_log: bool) -> String {
    if is_log && !(0.01..1e4).contains(&value) { format!("1e{:.0}", value.log10()) } else { format!("{value}") }
}

/// One panel as an SVG group, `left` px from the left edge.
fn panel(svg: &mut String, left: f64, title: &str, x: &Axis, y: &Axis, curves: &[Curve]) {
    let (margin, top, margin_right, bottom) = MARGIN;
    let (width, height) = (SIZE.0 - margin - margin_right, SIZE.1 - top - bottom);
    let at = |px: f64, py: f64| (left + margin + x.share(px) * width, top + (1.0 - y.share(py)) * height);
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
    for (row, curve) in (0u8..).zip(curves) {
        let points: Vec<_> = curve.points.iter().map(|&(px, py)| at(px, py)).collect();
        let path: Vec<_> = points.iter().map(|(px, py)| format!("{px:.1},{py:.1}")).collect();
        let (key_x, key_y) = (frame + 14.0, top + 18.0 + 18.0 * f64::from(row));
        if curve.has_line {
            let colour = curve.colour;
            let _ = writeln!(
                svg,
                r#"<polyline points="{}" fill="none" stroke="{colour}" stroke-width="1.5"/>"#,
                path.join(" ")
            );
            let _ =
                writeln!(svg, r#"<path d="M{:.1} {key_y:.1}h16" stroke="{colour}" stroke-width="1.5"/>"#, key_x - 8.0);
        }
        if curve.has_dots {
            for (px, py) in points.iter().chain([&(key_x, key_y)]) {
                let _ = writeln!(svg, r#"<circle cx="{px:.1}" cy="{py:.1}" r="3.4" fill="{}"/>"#, curve.colour);
            }
        }
        text(svg, key_x + 14.0, key_y + 4.0, "start", "", &curve.name);
    }
}

/// A figure of panels side by side: (title, x, y, curves).
pub fn figure(panels: &[(&str, Axis, Axis, Vec<Curve>)]) -> String {
    let width = SIZE.0 * f64::from(u8::try_from(panels.len()).unwrap_or(1));
    let mut svg = format!(
        r##"<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{h}" viewBox="0 0 {width} {h}"><rect width="{width}" height="{h}" fill="#ffffff"/>
"##,
        h = SIZE.1
    );
    let mut left = 0.0;
    for (title, x, y, curves) in panels {
        panel(&mut svg, left, title, x, y, curves);
        left += SIZE.0;
    }
    svg + "</svg>\n"
}
