//! By how much the counts of a run are ahead of the published ones in time, and how far both are apart once they are moved by that time.
//!
//! The deviation at a shift s is the root of the mean of ((n(t - s) - m(t))/N)^2 over all zones and published times t, with the count n of siloflow, the mean m of both codes,
//! and the number N of grains of the material. The lead is the shift with the least deviation.

use crate::studies::validation::verdict::{FigureRow, Judgement};
use siloflow_figures::statistics::mean::mean;
use siloflow_figures::statistics::points::interpolated;

/// A material in a zone.
pub(super) struct Zone {
    /// Counts of siloflow: time (s), grains.
    pub(super) counts: Vec<(f64, f64)>,
    /// Mean of both codes: time (s), grains.
    pub(super) codes: Vec<(f64, f64)>,
    /// Grains of the material.
    pub(super) grains: f64,
}

/// The end of the comparison, s: the middle of the last average of the stiffest run, less the largest shift.
const END: f64 = 2.35;

/// Shifts that are tried, s.
fn shifts() -> impl Iterator<Item = f64> {
    (-40..=40).map(|n| 0.005 * f64::from(n))
}

/// Returns the deviation at a shift (s), a share of the grains.
fn deviation(zones: &[Zone], shift: f64) -> f64 {
    let square = |zone: &Zone, (time, of_codes): (f64, f64)| {
        let count = interpolated(&zone.counts, time - shift)?;
        Some(((count - of_codes) / zone.grains).powi(2))
    };
    let points = zones.iter().flat_map(|zone| zone.codes.iter().map(move |point| (zone, *point)));
    let within = points.filter(|(_, (time, _))| (0.3..END).contains(time));
    mean(within.filter_map(|(zone, point)| square(zone, point))).map_or(f64::NAN, |mean| mean.value.sqrt())
}

/// Adds the deviation of a run, its lead, and its deviation at that shift.
pub(super) fn rows(zones: &[Zone], words: &str, judgement: &mut Judgement) {
    let best = shifts().min_by(|a, b| deviation(zones, *a).total_cmp(&deviation(zones, *b))).unwrap_or(0.0);
    let name = |what: &str| format!("{words}, 0.3 to {END} s: {what}");
    judgement.rows.extend([
        FigureRow::new(name("rms deviation of all four counts"), "% of the grains", 100.0 * deviation(zones, 0.0)),
        FigureRow::new(name("lead over both codes"), "s", best),
        FigureRow::new(name("the deviation moved by this lead"), "% of the grains", 100.0 * deviation(zones, best)),
    ]);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_lead_of_a_curve_that_is_early_is_found() {
        let curve = |early: f64| {
            (0..40).map(move |n| 0.1 * f64::from(n)).map(move |t| (t, 500.0 * (1.0 + (3.0 * (t + early)).sin())))
        };
        let zone = Zone { counts: curve(0.1).collect(), codes: curve(0.0).collect(), grains: 1000.0 };
        let mut judgement = Judgement::default();
        rows(&[zone], "early", &mut judgement);
        let found: Vec<_> = judgement.rows.iter().map(|row| row.found).collect();
        // A curve that is linear between points 0.1 s apart differs by up to 500 (3 * 0.1)^2/8 = 0.6 % of the grains.
        assert!((found[1] - 0.1).abs() < 0.011 && found[0] > 5.0 && found[2] < 0.6, "{found:?}");
    }
}
