//! Minimal plots as SVG: panels with two linear or logarithmic axes, curves as lines or dots, coloured cells, marks, and a legend.

mod axis;
mod panel;

use std::fmt::Write as _;

pub use self::axis::Axis;

/// A curve of a panel.
#[derive(Clone, Debug, Default)]
pub struct Curve {
    /// Name in the legend; without one the legend does not list the curve.
    pub name: String,
    /// Colour in the notation of SVG.
    pub colour: &'static str,
    /// Points in the units of the axes. One that is not finite interrupts the line.
    pub points: Vec<(f64, f64)>,
    /// Whether a line joins the points.
    pub has_line: bool,
    /// Whether each point is a dot.
    pub has_dots: bool,
    /// Whether the line is dashed.
    pub is_dashed: bool,
}

/// A vertical line with a name.
#[derive(Clone, Debug)]
pub struct Mark {
    /// Place on the horizontal axis.
    pub at: f64,
    /// Name beside the line.
    pub name: String,
}

/// A filled rectangle.
#[derive(Clone, Copy, Debug)]
pub struct Cell {
    /// Lower left corner, in the units of the axes.
    pub low: (f64, f64),
    /// Upper right corner.
    pub high: (f64, f64),
    /// Colour: red, green, blue.
    pub colour: [u8; 3],
}

/// A bar that tells the values of colours, to the right of the plot.
#[derive(Clone, Debug)]
pub struct Scale {
    /// Quantity, unit, range and ticks.
    pub axis: Axis,
    /// Colour of a share from 0 to 1 of the range.
    pub map: fn(f64) -> [u8; 3],
}

/// The start of an axis of time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Clock {
    /// The start of the run.
    Run,
    /// The opening of the door.
    Opening,
}

/// The place of the legend.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Key {
    /// Over the plot, at its upper left.
    #[default]
    UpperLeft,
    /// Over the plot, at its lower left.
    LowerLeft,
    /// Between title and plot, which is lower then.
    Above,
}

/// One panel of a sheet.
#[derive(Clone, Debug)]
pub struct Panel {
    /// Title above the panel.
    pub title: String,
    /// Horizontal axis.
    pub x: Axis,
    /// Vertical axis.
    pub y: Axis,
    /// Curves.
    pub curves: Vec<Curve>,
    /// Points with a ring, in the units of the axes.
    pub rings: Vec<(f64, f64)>,
    /// Vertical lines.
    pub marks: Vec<Mark>,
    /// Rectangles, below everything else.
    pub cells: Vec<Cell>,
    /// Scale of the colours of cells.
    pub scale: Option<Scale>,
    /// Place of the legend.
    pub key: Key,
    /// The clock of the horizontal axis, if it is one of time. The group of the panel then has attributes that a page needs to draw a
    /// cursor: `data-clock` (`run` or `opening`), `data-left`, `data-right`, `data-top`, `data-bottom` (ends of the axes in the SVG),
    /// `data-from` and `data-to` (the times at the left and right end).
    pub clock: Option<Clock>,
}

impl Panel {
    /// Width over height of the plot of a panel with a scale and without a legend, of any size.
    pub const ASPECT_WITH_SCALE: f64 = (SIZE.0 - MARGIN.0 - MARGIN.2 - SCALE) / (SIZE.1 - MARGIN.1 - MARGIN.3);

    /// Returns a panel with axes and nothing else.
    #[must_use]
    pub fn new(title: impl Into<String>, x: Axis, y: Axis) -> Self {
        Self {
            title: title.into(),
            x,
            y,
            curves: Vec::new(),
            rings: Vec::new(),
            marks: Vec::new(),
            cells: Vec::new(),
            scale: None,
            key: Key::default(),
            clock: None,
        }
    }
}

const COLOURS: [&str; 7] = ["#222222", "#0072b2", "#d55e00", "#009e73", "#e69f00", "#cc79a7", "#56b4e9"];

/// Returns the colour of curve `number`; the first is black.
///
/// Colours are distinguishable with colour blindness (Okabe and Ito) and repeat after seven curves.
#[must_use]
pub fn colour(number: usize) -> &'static str {
    COLOURS[number % COLOURS.len()]
}

/// Returns the class of elements of a colour of [`colour`].
fn class(colour: &str) -> String {
    COLOURS.iter().position(|known| *known == colour).map_or_else(String::new, |number| format!("k{number}"))
}

/// Width and height of a panel, px.
const SIZE: (f64, f64) = (520.0, 400.0);
/// Height of letters, px.
const FONT: f64 = 13.0;
/// Margins of a panel (left, top, right, bottom), px.
const MARGIN: (f64, f64, f64, f64) = (72.0, 44.0, 16.0, 56.0);

/// Width of a colour scale, px.
const SCALE: f64 = 96.0;

/// The look of a sheet.
#[derive(Clone, Debug)]
pub struct Look {
    /// Width and height of a panel, px.
    pub size: (f64, f64),
    /// Height of letters, px. Lines, dots and margins grow with it.
    pub font: f64,
    /// A line above all panels.
    pub title: Option<String>,
}

impl Default for Look {
    fn default() -> Self {
        Self { size: SIZE, font: FONT, title: None }
    }
}

/// Height of the line above all panels, px at a height of letters of [`FONT`].
const HEAD: f64 = 28.0;

impl Look {
    /// Returns an SVG figure of panels in rows of `per_row` (at least one).
    #[must_use]
    pub fn sheet(&self, panels: &[Panel], per_row: usize) -> String {
        let per_row = per_row.max(1);
        let real = |count: usize| f64::from(u16::try_from(count).unwrap_or(u16::MAX));
        let scale = self.font / FONT;
        // The panels are drawn with letters of the usual height, and the whole sheet is scaled.
        let size = (self.size.0 / scale, self.size.1 / scale);
        let head = if self.title.is_some() { HEAD } else { 0.0 };
        let width = size.0 * real(per_row.min(panels.len()));
        let height = head + size.1 * real(panels.len().div_ceil(per_row));
        let [shown_width, shown_height] = [width, height].map(|length| length * scale);
        let mut svg = format!(
            r##"<svg xmlns="http://www.w3.org/2000/svg" width="{shown_width}" height="{shown_height}" viewBox="0 0 {width} {height}"><rect class="paper" width="{width}" height="{height}" fill="#ffffff"/>
"##
        );
        if let Some(title) = &self.title {
            panel::heading(&mut svg, 0.5 * width, title);
        }
        for (number, panel) in panels.iter().enumerate() {
            let left = size.0 * real(number % per_row);
            let down = head + size.1 * real(number / per_row);
            // Writing to a string cannot fail.
            let _ = writeln!(svg, r#"<g transform="translate(0 {down})">"#);
            panel::draw(&mut svg, panel, left, size);
            svg += "</g>\n";
        }
        svg + "</svg>\n"
    }
}

/// Returns an SVG figure of panels of the usual look in rows of `per_row` (at least one).
#[must_use]
pub fn sheet(panels: &[Panel], per_row: usize) -> String {
    Look::default().sheet(panels, per_row)
}

/// Returns an SVG figure of panels side by side, each given as (title, x axis, y axis, curves).
#[must_use]
pub fn figure(panels: &[(&str, Axis, Axis, Vec<Curve>)]) -> String {
    let panels: Vec<_> = panels
        .iter()
        .map(|(title, x, y, curves)| Panel { curves: curves.clone(), ..Panel::new(*title, x.clone(), y.clone()) })
        .collect();
    sheet(&panels, panels.len())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn axis() -> Axis {
        Axis { label: "y".into(), from: 1.0, to: 100.0, is_log: true, ticks: vec![] }
    }

    fn curve(points: Vec<(f64, f64)>) -> Curve {
        Curve { name: "a < b & c".to_owned(), colour: colour(0), points, ..Curve::default() }
    }

    #[test]
    fn points_are_placed_by_the_axes_and_names_are_escaped() {
        let curve = Curve { has_dots: true, ..curve(vec![(0.5, 10.0)]) };
        let svg = figure(&[("", Axis::linear("x", 0.0, 1.0), axis(), vec![curve])]);
        // The panel extends from 72 to 504 px and from 44 to 344 px; the point is in its middle.
        assert!(svg.contains(r#"cx="288.0" cy="194.0""#) && svg.contains("a &lt; b &amp; c"), "{svg}");
    }

    #[test]
    fn a_sheet_has_rows_and_rings() {
        let panel = || Panel { rings: vec![(10.0, 10.0)], ..Panel::new("", axis(), axis()) };
        let svg = sheet(&[panel(), panel(), panel()], 2);
        // The sheet has two by two panels. The third is below the first and has a ring in its middle.
        assert!(svg.contains(r#"viewBox="0 0 1040 800""#), "{svg}");
        let third = svg.split_once("translate(0 400)").unwrap().1;
        assert!(third.contains(r#"cx="288.0" cy="194.0" r="6.4" fill="none""#), "{svg}");
    }

    #[test]
    fn a_look_sets_the_size_of_panels_and_of_letters_and_a_title() {
        let look = Look { size: (260.0, 200.0), font: 6.5, title: Some("a < b".to_owned()) };
        let panel = Panel { curves: vec![curve(vec![(10.0, 10.0)])], ..Panel::new("", axis(), axis()) };
        let svg = look.sheet(std::slice::from_ref(&panel), 1);
        // Half of everything: the title takes 28 px of the drawing.
        assert!(svg.contains(r#"width="260" height="214" viewBox="0 0 520 428""#) && svg.contains("a &lt; b"), "{svg}");
        // Large letters leave a smaller drawing, whose plot ends 16 px before its edge.
        let svg = Look { font: 26.0, ..Look::default() }.sheet(&[panel], 1);
        assert!(svg.contains(r#"width="520" height="400" viewBox="0 0 260 200""#), "{svg}");
        assert!(svg.contains(r#"x="72" y="44" width="172" height="100""#), "{svg}");
    }

    #[test]
    fn a_point_that_is_not_finite_interrupts_the_line() {
        let curve = Curve { has_line: true, ..curve(vec![(1.0, 1.0), (2.0, f64::NAN), (3.0, 2.0), (4.0, 3.0)]) };
        let panel = Panel { curves: vec![curve], ..Panel::new("", axis(), axis()) };
        assert_eq!(sheet(&[panel], 1).matches("<polyline").count(), 2);
    }

    #[test]
    fn a_legend_above_the_plot_makes_it_lower_and_a_panel_over_time_tells_its_place() {
        let names = vec![curve(vec![]); 6];
        let panel = Panel {
            curves: names,
            key: Key::Above,
            clock: Some(Clock::Opening),
            ..Panel::new("", Axis::linear("", 0.0, 2.0), axis())
        };
        let svg = sheet(&[panel], 1);
        // Each name takes 103 px of 432, so six names need two lines of 18 px.
        assert!(
            svg.contains(
                r#"data-clock="opening" data-left="72" data-right="504" data-top="80" data-bottom="344" data-from="0" data-to="2""#
            )
        );
    }
}
