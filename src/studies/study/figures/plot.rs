//! A plot of positions in spacings, with equal scales on both axes.

use super::paper::{Anchor, FAINT, Paper, Pen};
use siloflow_dem::space::Vector;

/// Largest width and height of the plot, px. The plot reaches one of them.
const PLOT: Vector = Vector::new(640.0, 640.0);

/// Margin to the left of the plot and above it, px.
const MARGIN: Vector = Vector::new(50.0, 20.0);

/// The mapping from spacings to px.
pub(super) struct Plot {
    low: Vector,
    high: Vector,
    scale: f64,
}

impl Plot {
    /// Creates a plot that contains the origin and all these points. Its range ends at multiples of 10.
    pub fn of<'a>(points: impl Iterator<Item = &'a Vector>) -> Self {
        let (low, high) = points.fold((Vector::ZERO, Vector::ZERO), |(low, high), &x| (low.min(x), high.max(x)));
        let low = 10.0 * (low / 10.0).floor();
        let high = 10.0 * (high / 10.0).ceil();
        Self { low, high, scale: (PLOT / (high - low)).min_element() }
    }

    /// Returns the lower right corner of the plot, px.
    pub fn corner(&self) -> Vector {
        self.at(Vector::new(self.high.x, self.low.y))
    }

    /// Returns the position of a point in the document, px.
    pub fn at(&self, x: Vector) -> Vector {
        MARGIN + self.scale * Vector::new(x.x - self.low.x, self.high.y - x.y)
    }

    /// Draws a polyline through the points.
    pub fn polyline(&self, paper: &mut Paper, points: &[Vector], pen: Pen) {
        let points: Vec<Vector> = points.iter().map(|&x| self.at(x)).collect();
        paper.polyline(&points, pen);
    }

    /// Draws grid lines at all multiples of 10, with numbers.
    pub fn axes(&self, paper: &mut Paper) {
        let pen = Pen { width: 0.8, colour: FAINT };
        for x in tens(self.low.x, self.high.x) {
            let from = self.at(Vector::new(x, self.low.y));
            let to = self.at(Vector::new(x, self.high.y));
            paper.line(from, to, pen);
            paper.text(from + Vector::new(0.0, 18.0), 13.0, Anchor::Middle, &format!("{x:.0}"));
        }
        for y in tens(self.low.y, self.high.y) {
            let from = self.at(Vector::new(self.low.x, y));
            let to = self.at(Vector::new(self.high.x, y));
            paper.line(from, to, pen);
            paper.text(from + Vector::new(-8.0, 5.0), 13.0, Anchor::End, &format!("{y:.0}"));
        }
        let below = self.at(Vector::new(0.5 * (self.low.x + self.high.x), self.low.y));
        paper.text(below + Vector::new(0.0, 40.0), 14.0, Anchor::Middle, "x and y in spacings, one scale");
    }
}

/// Returns the multiples of 10 from `from` to `to`, both of which are multiples of 10.
fn tens(from: f64, to: f64) -> impl Iterator<Item = f64> {
    std::iter::successors(Some(from), |x| Some(x + 10.0)).take_while(move |&x| x <= to)
}
