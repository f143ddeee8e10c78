//! Traces of single particles thrown obliquely upwards under gravity (the paper's figure 4).

use super::flights::{Flights, STEPS, expected, mean, parabola, parabola_holds_until};
use super::paper::{Anchor, INK, NEAREST, Paper, Pen, SECOND};
use super::plot::Plot;
use siloflow_dem::space::Vector;
use siloflow_figures::colour::Rgb;

/// Largest number of single traces that are drawn.
const MOST_TRACES: usize = 12;

/// Largest distance from the exact mean up to which the parabola is drawn, spacings.
const CLOSE: f64 = 0.5;

/// Distance from the exact mean up to which the parabola counts as exact, spacings; it covers rounding errors.
const EXACT: f64 = 1e-9;

/// Width of the legend, px.
const LEGEND: f64 = 330.0;
const PARABOLA: Rgb = [0xf2, 0xc1, 0x4e];
const TRACE: Rgb = [0x8a; 3];

/// Draws the traces of the first 12 particles, the mean of all particles, the exact mean, and the parabola (a). The
/// parabola ends where it differs from the exact mean by more than 0.5 spacings.
#[must_use]
pub fn thrown(flights: &Flights) -> String {
    let Flights { g, flights } = flights;
    let g = *g;
    let exact = expected(g);
    let shown = &flights[..flights.len().min(MOST_TRACES)];
    let plot = Plot::of(shown.iter().flatten().chain(&exact));
    let mut paper = Paper::new(plot.corner().x + LEGEND, plot.corner().y + 52.0);
    plot.axes(&mut paper);
    let arc: Vec<Vector> = parabola(g).into_iter().take(parabola_holds_until(g, CLOSE) + 1).collect();
    plot.polyline(&mut paper, &arc, Symbol::PARABOLA);
    for flight in shown {
        plot.polyline(&mut paper, flight, Symbol::TRACE);
    }
    plot.polyline(&mut paper, &exact, Symbol::EXACT);
    for &at in &mean(flights) {
        Symbol::Mean.put(&mut paper, plot.at(at));
    }
    Symbol::LastExact.put(&mut paper, plot.at(arc[parabola_holds_until(g, EXACT)]));
    Symbol::Start.put(&mut paper, plot.at(Vector::ZERO));
    paper.text(plot.at(arc[arc.len() - 1]) + Vector::new(0.0, -14.0), 20.0, Anchor::Middle, "a");
    legend(
        &mut paper,
        Vector::new(plot.corner().x + 24.0, 30.0),
        g,
        Traces { shown: shown.len(), seeds: flights.len() },
    );
    paper.finish()
}

/// Numbers of traces that are drawn, and of particles that are thrown.
struct Traces {
    shown: usize,
    seeds: usize,
}

/// Draws the legend from `at` downwards.
fn legend(paper: &mut Paper, mut at: Vector, g: f64, Traces { shown, seeds }: Traces) {
    let texts = [
        (Symbol::Line(Symbol::PARABOLA), "a: parabola 1.5 t - g t (t + 1)/2".to_owned()),
        (Symbol::None, format!("to t = {}, within {CLOSE} of the exact mean", parabola_holds_until(g, CLOSE))),
        (Symbol::LastExact, format!("up to here, t = {}, it is exact", parabola_holds_until(g, EXACT))),
        (Symbol::Line(Symbol::EXACT), "exact mean of the Markov chain".to_owned()),
        (Symbol::Mean, format!("mean of {seeds} particles, step by step")),
        (Symbol::Line(Symbol::TRACE), format!("traces of {shown} of them")),
        (Symbol::Start, "where they are thrown with v_7".to_owned()),
        (Symbol::None, format!("g = {g}, h = 0, {STEPS} steps")),
    ];
    for (symbol, text) in texts {
        symbol.put_with_text(paper, at, &text);
        at.y += 24.0;
    }
}

/// A symbol of the figure.
enum Symbol {
    None,
    Line(Pen),
    Mean,
    LastExact,
    Start,
}

impl Symbol {
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

    fn put_with_text(&self, paper: &mut Paper, at: Vector, text: &str) {
        self.put(paper, at + Vector::new(15.0, 0.0));
        paper.formula(at + Vector::new(42.0, 5.0), 14.0, Anchor::Start, text);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_figure_renders_for_any_probability() {
        for (seeds, g) in [(2, 0.05), (1, 0.0), (0, 0.95), (1, 1.0)] {
            super::super::renders(&thrown(&Flights::run(seeds, g).unwrap()));
        }
        assert!(Flights::run(1, 1.5).is_err());
        assert!(Flights::run(0, f64::NAN).is_err());
    }
}
