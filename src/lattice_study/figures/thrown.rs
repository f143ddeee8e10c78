//! Traces of single particles thrown in the field of gravity (the paper's figure 4).

use super::flights::{Flights, STEPS, expected, holds_until, mean, parabola};
use super::paper::{Anchor, INK, NEAREST, Paper, Pen, SECOND};
use super::plot::Plot;
use crate::space::Vector;
use crate::writers::colour::Rgb;

/// Most traces that are drawn one by one.
const MOST_TRACES: usize = 12;

/// The parabola is drawn as far as it is this close to the exact mean, spacings.
const CLOSE: f64 = 0.5;

/// Roundings of both, spacings.
const EXACT: f64 = 1e-9;

/// Width of the legend, px.
const LEGEND: f64 = 330.0;
const PARABOLA: Rgb = [0xf2, 0xc1, 0x4e];
const TRACE: Rgb = [0x8a; 3];

/// Draws the traces of the first dozen of some thrown particles, the mean of all, the exact mean, and the parabola (a) as far
/// as it is close to it.
#[must_use]
pub fn thrown(flights: &Flights) -> String {
    let Flights { g, flights } = flights;
    let g = *g;
    let (exact, shown) = (expected(g), &flights[..flights.len().min(MOST_TRACES)]);
    let plot = Plot::of(shown.iter().flatten().chain(&exact));
    let mut paper = Paper::new(plot.corner().x + LEGEND, plot.corner().y + 52.0);
    plot.axes(&mut paper);
    let arc: Vec<Vector> = parabola(g).into_iter().take(holds_until(g, CLOSE) + 1).collect();
    plot.way(&mut paper, &arc, Sign::PARABOLA);
    for flight in shown {
        plot.way(&mut paper, flight, Sign::TRACE);
    }
    plot.way(&mut paper, &exact, Sign::EXACT);
    for &at in &mean(flights) {
        Sign::Mean.put(&mut paper, plot.at(at));
    }
    Sign::LastExact.put(&mut paper, plot.at(arc[holds_until(g, EXACT)]));
    Sign::Start.put(&mut paper, plot.at(Vector::ZERO));
    paper.text(plot.at(arc[arc.len() - 1]) + Vector::new(0.0, -14.0), 20.0, Anchor::Middle, "a");
    legend(&mut paper, Vector::new(plot.corner().x + 24.0, 30.0), g, (shown.len(), flights.len()));
    paper.finish()
}

/// Explains the signs, from a place downwards; so many traces are shown of so many particles.
fn legend(paper: &mut Paper, mut at: Vector, g: f64, (shown, seeds): (usize, usize)) {
    let texts = [
        (Sign::Line(Sign::PARABOLA), "a: parabola 1.5 t - g t (t + 1)/2".to_owned()),
        (Sign::None, format!("to t = {}, within {CLOSE} of the exact mean", holds_until(g, CLOSE))),
        (Sign::LastExact, format!("up to here, t = {}, it is exact", holds_until(g, EXACT))),
        (Sign::Line(Sign::EXACT), "exact mean of the Markov chain".to_owned()),
        (Sign::Mean, format!("mean of {seeds} particles, step by step")),
        (Sign::Line(Sign::TRACE), format!("traces of {shown} of them")),
        (Sign::Start, "where they are thrown with v_7".to_owned()),
        (Sign::None, format!("g = {g}, h = 0, {STEPS} steps")),
    ];
    for (sign, text) in texts {
        sign.explain(paper, at, &text);
        at.y += 24.0;
    }
}

/// What stands for what.
enum Sign {
    None,
    Line(Pen),
    Mean,
    LastExact,
    Start,
}

impl Sign {
    const PARABOLA: Pen = Pen { width: 9.0, colour: PARABOLA };
    const EXACT: Pen = Pen { width: 1.8, colour: INK };
    const TRACE: Pen = Pen { width: 0.8, colour: TRACE };

    fn put(&self, paper: &mut Paper, at: Vector) {
        match self {
            Self::None => {}
            Self::Line(pen) => paper.line(at - Vector::new(15.0, 0.0), at + Vector::new(15.0, 0.0), *pen),
            Self::Mean => paper.ring(at, 3.2, Pen { width: 1.4, colour: NEAREST }),
            Self::LastExact => paper.dot(at, 5.0, SECOND),
            Self::Start => paper.dot(at, 4.0, INK),
        }
    }

    fn explain(&self, paper: &mut Paper, at: Vector, text: &str) {
        self.put(paper, at + Vector::new(15.0, 0.0));
        paper.formula(at + Vector::new(42.0, 5.0), 14.0, Anchor::Start, text);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_draws_for_any_probability() {
        for (seeds, g) in [(2, 0.05), (1, 0.0), (0, 0.95), (1, 1.0)] {
            super::super::renders(&thrown(&Flights::run(seeds, g).unwrap()));
        }
        assert!(Flights::run(1, 1.5).is_err());
        assert!(Flights::run(0, f64::NAN).is_err());
    }
}
