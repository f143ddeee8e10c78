//! A sheet of density pictures: a row a variant, a column a time, one scale and one grey for all (the paper's figures 5 to
//! 18).

use std::fmt::Write as _;

use super::paper::{Anchor, INK, Paper, Pen};
use super::shading::{LEVELS, paths, shade};
use crate::lattice::pictures::Cell;
use crate::space::Vector;
use crate::writers::colour::hex;

const WIDTH: f64 = 900.0;
const MARGIN: f64 = 10.0;
const GAP: f64 = 10.0;
/// Legend and heads of the columns.
const TOP: f64 = 66.0;
const TEXT: f64 = 14.0;

/// A variant.
#[derive(Clone, Debug)]
pub struct SheetRow {
    /// What it is, as `g = 0.95`.
    pub name: String,
    /// Its pictures, column by column.
    pub panels: Vec<Panel>,
}

/// A picture.
#[derive(Clone, Debug)]
pub struct Panel {
    /// Densities in cells of one size, on one grid.
    pub cells: Vec<Cell>,
    /// Outline of the silo, m.
    pub lines: Vec<(Vector, Vector)>,
}

impl Panel {
    /// Lower left and upper right corner, m; of an empty panel, of nothing.
    fn bounds(&self) -> (Vector, Vector) {
        let cells = self.cells.iter().map(|cell| (cell.low, cell.high));
        let lines = self.lines.iter().map(|&(a, b)| (a.min(b), a.max(b)));
        let bounds = cells.chain(lines).reduce(|(low, high), (a, b)| (low.min(a), high.max(b)));
        bounds.unwrap_or((Vector::ZERO, Vector::ZERO))
    }

    fn size(&self) -> Vector {
        let (low, high) = self.bounds();
        high - low
    }
}

/// The sheet: darker is denser, from 0 to 13 particles a site; `columns` are the heads of the columns, as `t = 100`. All
/// panels have one scale and stand on the floor of their row.
#[must_use]
pub fn sheet(rows: &[SheetRow], columns: &[String]) -> String {
    let layout = Layout::of(rows, columns);
    let mut paper = Paper::new(WIDTH, TOP + rows.iter().map(|row| layout.height(row)).sum::<f64>());
    legend(&mut paper);
    for (x, head) in layout.middles().zip(columns) {
        paper.text(Vector::new(x, TOP - 8.0), TEXT, Anchor::Middle, head);
    }
    let mut top = TOP;
    for row in rows {
        let floor = top + layout.height(row);
        paper.text(Vector::new(MARGIN, 0.5 * (top + floor)), TEXT, Anchor::Start, &row.name);
        for (x, panel) in layout.middles().zip(&row.panels) {
            draw(&mut paper, panel, Vector::new(x, floor - 1.5 * GAP), layout.scale);
        }
        top = floor;
    }
    paper.finish()
}

/// Where columns are, px, and the scale, px a m.
struct Layout {
    left: f64,
    pitch: f64,
    scale: f64,
}

impl Layout {
    fn of(rows: &[SheetRow], columns: &[String]) -> Self {
        let count = rows.iter().map(|row| row.panels.len()).chain([columns.len(), 1]).max().unwrap_or(1);
        let count = (0..count).fold(0.0, |count, _| count + 1.0);
        let left = 2.0 * MARGIN + rows.iter().map(|row| width(&row.name)).fold(0.0, f64::max);
        let pitch = (WIDTH - left - MARGIN) / count;
        let panels = rows.iter().flat_map(|row| &row.panels);
        let widest = panels.map(|panel| panel.size().x).fold(0.0, f64::max);
        let scale = if widest > 0.0 { (pitch - GAP) / widest } else { 1.0 };
        Self { left, pitch, scale }
    }

    /// The middles of the columns.
    fn middles(&self) -> impl Iterator<Item = f64> {
        std::iter::successors(Some(self.left + 0.5 * self.pitch), |x| Some(x + self.pitch))
    }

    /// Height of a row.
    fn height(&self, row: &SheetRow) -> f64 {
        let highest = row.panels.iter().map(|panel| panel.size().y).fold(0.0, f64::max);
        (self.scale * highest).max(2.0 * TEXT) + 2.0 * GAP
    }
}

/// About how wide a text is, px.
fn width(text: &str) -> f64 {
    text.chars().fold(0.0, |width, _| width + 0.53 * TEXT)
}

/// The greys, and what they mean.
fn legend(paper: &mut Paper) {
    let (swatch, y) = (12.0, 14.0);
    let x = WIDTH - MARGIN - swatch * f64::from(LEVELS) - 24.0;
    for level in 0..LEVELS {
        let (x, fill) = (x + swatch * f64::from(level), hex(shade(level)));
        paper.put(format_args!(r#"<rect x="{x}" y="{y}" width="{swatch}" height="14" fill="{fill}"/>"#));
    }
    let (right, frame) = (x + swatch * f64::from(LEVELS), hex(INK));
    paper.put(format_args!(
        r#"<rect x="{x}" y="{y}" width="{}" height="14" fill="none" stroke="{frame}" stroke-width="0.6"/>"#,
        right - x
    ));
    paper.text(Vector::new(x - 8.0, y + 12.0), TEXT, Anchor::End, "particles a site: 0");
    paper.text(Vector::new(right + 6.0, y + 12.0), TEXT, Anchor::Start, "13");
}

/// A panel whose floor has its middle there.
fn draw(paper: &mut Paper, panel: &Panel, floor: Vector, scale: f64) {
    let (low, high) = panel.bounds();
    let foot = Vector::new(0.5 * (low.x + high.x), low.y);
    let at = |x: Vector| floor + scale * Vector::new(x.x - foot.x, foot.y - x.y);
    if let Some(first) = panel.cells.first() {
        // A cell is one unit wide and high, and a stroke runs in the middle of its column.
        let unit = scale * (first.high - first.low);
        let corner = at(first.low) + Vector::new(0.5 * unit.x, 0.0);
        paper.put(format_args!(
            r#"<g fill="none" stroke-width="1" shape-rendering="crispEdges" transform="translate({:.3} {:.3}) scale({:.5} {:.5})">"#,
            corner.x, corner.y, unit.x, -unit.y
        ));
        for (level, path) in paths(&panel.cells) {
            paper.put(format_args!(r#"<path d="{path}" stroke="{}"/>"#, hex(shade(level))));
        }
        paper.put(format_args!("</g>"));
    }
    outline(paper, panel, at);
}

fn outline(paper: &mut Paper, panel: &Panel, at: impl Fn(Vector) -> Vector) {
    let mut path = String::new();
    for &(from, to) in &panel.lines {
        let (a, b) = (at(from), at(to));
        // Writing to a string cannot fail.
        let _ = write!(path, "M{:.1} {:.1}L{:.1} {:.1}", a.x, a.y, b.x, b.y);
    }
    let Pen { width, colour } = Pen { width: 0.7, colour: INK };
    paper.put(format_args!(r#"<path d="{path}" fill="none" stroke="{}" stroke-width="{width}"/>"#, hex(colour)));
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lattice::draws::{Purpose, Streams, below};
    use crate::lattice::gas::Gas;
    use crate::lattice::outline::Polygon;
    use crate::lattice::pictures::densities;
    use crate::lattice::sites::Sites;

    /// The silo of the paper with each state taken by chance, about half of them: as uneven as a gas is.
    fn panel() -> Panel {
        let corners = [(-0.602, 0.0), (0.602, 0.0), (0.602, 2.865), (-0.602, 2.865)];
        let outline = Polygon(corners.iter().map(|&(x, y)| Vector::new(x, y)).collect());
        let sites = Sites::new(&outline, &[], None, 0.01);
        let mut gas = Gas::new(&sites);
        for site in sites.fluid() {
            let draws = Streams::new(1, 0, Purpose::Enter, 0).of(site);
            for state in (0..13).filter(|&state| below(draws.high(state), 2) == 0) {
                gas.add(site, usize::try_from(state).unwrap());
            }
        }
        Panel { cells: densities(&sites, &gas, crate::lattice::pictures::CELL), lines: sites.lines().to_vec() }
    }

    #[test]
    fn a_sheet_of_thirteen_variants_is_not_too_large() {
        let panel = panel();
        assert!(panel.cells.len() > 10_000);
        let row = |n| SheetRow { name: format!("g = {n}"), panels: vec![panel.clone(); 5] };
        let columns: Vec<String> = (0..5).map(|n| format!("t = {}", 50 * n)).collect();
        let svg = sheet(&(0..13).map(row).collect::<Vec<_>>(), &columns);
        assert!(svg.len() < 3_000_000, "{}", svg.len());
        super::super::renders(&sheet(&[row(1)], &columns));
    }

    #[test]
    fn a_sheet_may_be_empty() {
        super::super::renders(&sheet(&[], &[]));
        let nothing = Panel { cells: Vec::new(), lines: Vec::new() };
        super::super::renders(&sheet(&[SheetRow { name: "a < b".to_owned(), panels: vec![nothing] }], &[]));
    }
}
