//! Growth of softened grains: how much larger the radii are on each rung, so that the distances of grains in the bed are those at the stiffness of
//! the scene (`scene/load/growth.rs` explains the scene key `growth`).
//!
//! A first run at the softest rung, without growth, measures the mean overlap of its bed at rest, over the radius. At given load overlaps grow with a
//! power of the softness s, so that rung s needs
//!
//! ```text
//! growth = overlap/2 (s^p - 1)/s_first^p,    p: 2/3 with Hertz's law, 1 with linear springs
//! ```
//!
//! Limits: the load of a contact is taken as that of the first run. Growth removes a part of the bias, in the plane less than in solid space; the
//! law of the ladder holds for what remains.

use siloflow_results::run_results::RunResults;
use siloflow_text::fault::Fault;

/// The growth of all rungs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Growth {
    /// Mean overlap of contacts between grains at rest, over the mean radius of the pair, in a run without growth.
    pub overlap: f64,
    /// The softness of that run.
    pub softness: f64,
    /// The power of the softness with which overlaps grow.
    pub power: f64,
    /// The growth that the scene itself asks for.
    pub own: f64,
}

impl Growth {
    /// Returns the value of the scene key at a softness.
    #[must_use]
    pub fn at(&self, softness: f64) -> f64 {
        let share = (softness.powf(self.power) - 1.0) / self.softness.powf(self.power);
        let growth = self.own + 0.5 * self.overlap * share;
        // Six digits, so that what a table shows is what the run used.
        format!("{growth:.5e}").parse().unwrap_or(growth)
    }
}

/// Returns the mean overlap of a run at rest, over the radius: that of the last row of `series.csv` up to the time of rest. `None` if it did not
/// come to rest, or has no row before.
///
/// # Errors
/// If the series cannot be read.
pub fn overlap_at_rest(run: &RunResults) -> Result<Option<f64>, Fault> {
    let (Some(rest), Some(series)) = (run.number("/rest_time_s"), run.table("series.csv")?) else { return Ok(None) };
    let [times, overlaps] = ["time_s", "mean_overlap_ratio"].map(|name| series.needed(name));
    let rows = times?.into_iter().zip(overlaps?);
    let mut at_rest = rows.filter(|(time, overlap)| *time <= rest && *overlap > 0.0);
    Ok(at_rest.next_back().map(|(_, overlap)| overlap))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn growth_is_half_of_the_further_overlap() {
        let hertz = Growth { overlap: 0.08, softness: 1000.0, power: 2.0 / 3.0, own: 0.0 };
        assert!((hertz.at(1.0)).abs() < 1e-12);
        // (1000^(2/3) - 1)/1000^(2/3) = 0.99, and 31.6 has a tenth of the overlap, of which a tenth is there without softening.
        assert!((hertz.at(1000.0) - 0.0396).abs() < 1e-9);
        assert!((hertz.at(31.622_776_6) - 0.0036).abs() < 1e-9);
        assert!((Growth { own: 0.01, ..hertz }.at(1.0) - 0.01).abs() < 1e-12);
    }
}
