//! Prints one row per case: the results with the four sets of number types.

use crate::numbers::{Anchored, Double, Numbers, Single, SingleForces};

/// Distances from the origin at which every case is run, m.
pub const OFFSETS: [f64; 4] = [0.0, 1.0, 1.0e3, 1.0e6];

/// A quantity measured with each set of number types.
pub trait Measure {
    /// Returns the value, and its standard error if it is a mean.
    fn of<N: Numbers>(&self) -> (f64, Option<f64>);
}

pub fn heading() -> String {
    let names = [Double::NAME, SingleForces::NAME, Anchored::NAME, Single::NAME];
    let store = names.map(|name| format!("{name:>18}")).concat();
    format!("{:44}{:>8}{:>12}{store}", "case", "offset", "time step")
}

/// Returns a row. `step` is the error due to the time step, if the case has one.
pub fn row(case: &str, offset: f64, step: Option<f64>, measure: &impl Measure) -> String {
    let figures =
        [measure.of::<Double>(), measure.of::<SingleForces>(), measure.of::<Anchored>(), measure.of::<Single>()];
    let store = figures.map(|figure| format!("{:>18}", text(figure))).concat();
    let step = step.map_or_else(|| "-".to_owned(), |x| format!("{x:.1e}"));
    format!("{case:44}{offset:>8.0e}{step:>12}{store}")
}

fn text((value, error): (f64, Option<f64>)) -> String {
    match error {
        _ if !value.is_finite() => "lost".to_owned(),
        Some(error) => format!("{value:.1e} +- {error:.0e}"),
        None => format!("{value:.1e}"),
    }
}

/// Returns the root mean square.
pub fn rms(values: impl IntoIterator<Item = f64>) -> f64 {
    let (sum, count) = values.into_iter().fold((0.0, 0.0), |(sum, count), x| (sum + x * x, count + 1.0));
    (sum / f64::max(count, 1.0)).sqrt()
}
