//! A sheet of density pictures: one row per variant, one column per time (the paper's figures 5 to 18). All pictures
//! have the same length scale and the same grey scale.

use std::fmt::Write as _;

use super::paper::{Anchor, INK, Paper, Pen};
use super::shading::{LEVELS, paths, shade};
use crate::lattice_silo::pictures::DensityCell;
use siloflow_dem::space::Vector;
use siloflow_figures::colour::hex;

const WIDTH: f64 = 900.0;
const MARGIN: f64 = 10.0;
const GAP: f64 = 10.0;
/// Height of the legend and the column headings, px.
const TOP: f64 = 66.0;
const TEXT: f64 = 14.0;

/// A row of a sheet: the pictures of a variant.
#[derive(Clone, Debug)]
pub struct SheetRow {
    /// Name of the variant, for example `g = 0.95`.
    pub name: String,
    /// Pictures of the variant, in the order of the columns.
    pub panels: Vec<Panel>,
}

/// A picture of a sheet.
#[derive(Clone, Debug)]
pub struct Panel {
    /// Density cells, all of equal size and on one grid.
    pub cells: Vec<DensityCell>,
    /// Lines of the outline of the silo, m.
    pub lines: Vec<(Vector, Vector)>,
}

impl Panel {
    /// Returns the lower left and the upper right corner, m; zero for an empty panel.
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

/// Draws a sheet. Darker is denser, from 0 to 13 particles per site. `columns` are the column headings, for example
/// `t = 100`. All panels have the same scale and are aligned at the bottom of their row.
#[must_use]
pub fn sheet(rows: &[SheetRow], columns: &[String]) -> String {
    let layout = Layout::of(rows, columns);
    let mut paper = Paper::new(WIDTH, TOP + rows.iter().map(|row| layout.height(row)).sum::<f64>());
    legend(&mut paper);
    for (x, head) in layout.column_middles().zip(columns) {
        paper.text(Vector::new(x, TOP - 8.0), TEXT, Anchor::Middle, head);
    }
    let mut top = TOP;
    for row in rows {
        let floor = top + layout.height(row);
        paper.text(Vector::new(MARGIN, 0.5 * (top + floor)), TEXT, Anchor::Start, &row.name);
        for (x, panel) in layout.column_middles().zip(&row.panels) {
            draw(&mut paper, panel, Vector::new(x, floor - 1.5 * GAP), layout.scale);
        }
        top = floor;
    }
    paper.finish()
}

/// Layout of a sheet: left end and width of the columns, px, and scale, px/m.
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

    /// Returns x of the middle of each column, px.
    fn column_middles(&self) -> impl Iterator<Item = f64> {
        std::iter::successors(Some(self.left + 0.5 * self.pitch), |x| Some(x + self.pitch))
    }

    /// Returns the height of a row, px.
    fn height(&self, row: &SheetRow) -> f64 {
        let highest = row.panels.iter().map(|panel| panel.size().y).fold(0.0, f64::max);
        (self.scale * highest).max(2.0 * TEXT) + 2.0 * GAP
    }
}

/// Estimates the width of a text, px.
fn width(text: &str) -> f64 {
    text.chars().fold(0.0, |width, _| width + 0.53 * TEXT)
}

/// Draws the scale of the grey levels.
fn legend(paper: &mut Paper) {
    let swatch = 12.0;
    let y = 14.0;
    let x = WIDTH - MARGIN - swatch * f64::from(LEVELS) - 24.0;
    for level in 0..LEVELS {
        let x = x + swatch * f64::from(level);
        let fill = hex(shade(level));
        paper.put(format_args!(r#"<rect x="{x}" y="{y}" width="{swatch}" height="14" fill="{fill}"/>"#));
    }
    let right = x + swatch * f64::from(LEVELS);
    let frame = hex(INK);
    paper.put(format_args!(
        r#"<rect x="{x}" y="{y}" width="{}" height="14" fill="none" stroke="{frame}" stroke-width="0.6"/>"#,
        right - x
    ));
    paper.text(Vector::new(x - 8.0, y + 12.0), TEXT, Anchor::End, "particles a site: 0");
    paper.text(Vector::new(right + 6.0, y + 12.0), TEXT, Anchor::Start, "13");
}

/// Draws a panel with the middle of its bottom edge at `floor`.
fn draw(paper: &mut Paper, panel: &Panel, floor: Vector, scale: f64) {
    let (low, high) = panel.bounds();
    let foot = Vector::new(0.5 * (low.x + high.x), low.y);
    let at = |x: Vector| floor + scale * Vector::new(x.x - foot.x, foot.y - x.y);
    if let Some(first) = panel.cells.first() {
        // In units of cells, a stroke runs along the middle of its column.
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
        let a = at(from);
        let b = at(to);
        // Writing to a string cannot fail.
        let _ = write!(path, "M{:.1} {:.1}L{:.1} {:.1}", a.x, a.y, b.x, b.y);
    }
    let Pen { width, colour } = Pen { width: 0.7, colour: INK };
    paper.put(format_args!(r#"<path d="{path}" fill="none" stroke="{}" stroke-width="{width}"/>"#, hex(colour)));
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lattice_silo::pictures::densities;
    use siloflow_lattice::draws::{Purpose, Streams, below};
    use siloflow_lattice::gas::Gas;
    use siloflow_lattice::outline::Polygon;
    use siloflow_lattice::sites::Sites;

    /// A silo in which each state is occupied with probability 1/2, so that the density varies as much as in a gas.
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
        Panel { cells: densities(&sites, &gas, crate::lattice_silo::pictures::CELL), lines: sites.lines().to_vec() }
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
