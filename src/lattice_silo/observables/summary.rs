//! All observables of a discharge, with their symbols, names and units for reports.

use super::History;
use super::density::{bottom_density, onset_density};
use super::dilation::threshold_free_height;
use super::outflow::outflow_rate;
use super::surface::{dip, inclination};
use super::uniformity::{centre_to_side_ratio, overall_variation, row_variation};
use super::zone::{central_share, zone_aspect_ratio, zone_height, zone_width};

/// Step at which the height of the rising dilatant zone is measured. The zone has not reached the surface yet.
pub const RISING: u64 = 80;

/// Step at which the shape of the dilatant zone is measured.
pub const DEVELOPED: u64 = 200;

/// All observables of a discharge. A value is `None` if the discharge has nothing to measure.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Observables {
    /// Outflow rate Q ([`outflow_rate`]), particles per step.
    pub outflow_rate: Option<f64>,
    /// Onset density rho0 ([`onset_density`]), particles per site.
    pub onset_density: Option<f64>,
    /// Bottom density rhob ([`bottom_density`]), particles per site.
    pub bottom_density: Option<f64>,
    /// Inclination of the surface, incl ([`inclination`]), degrees.
    pub inclination: Option<f64>,
    /// Dip of the surface ([`dip`]), spacings.
    pub dip: Option<f64>,
    /// Zone height zh at step 80 ([`zone_height`]), spacings.
    pub rising_zone_height: Option<f64>,
    /// Zone height zh at step 200 ([`zone_height`]), spacings.
    pub zone_height: Option<f64>,
    /// Zone width zw at step 200 ([`zone_width`]), spacings.
    pub zone_width: Option<f64>,
    /// Zone aspect ratio za at step 200 ([`zone_aspect_ratio`]).
    pub zone_aspect_ratio: Option<f64>,
    /// Central share zc of the zone at step 200 ([`central_share`]).
    pub central_share: Option<f64>,
    /// Threshold-free zone height hz at step 80 ([`threshold_free_height`]), spacings.
    pub threshold_free_height: Option<f64>,
    /// Centre-to-side density ratio cs ([`centre_to_side_ratio`]).
    pub centre_to_side_ratio: Option<f64>,
    /// Density variation within rows, cvr ([`row_variation`]).
    pub row_variation: Option<f64>,
    /// Density variation of the whole silo, cvg ([`overall_variation`]).
    pub overall_variation: Option<f64>,
}

impl Observables {
    /// Computes all observables of a discharge.
    #[must_use]
    pub fn of(history: &History) -> Self {
        Self {
            outflow_rate: outflow_rate(history),
            onset_density: onset_density(history),
            bottom_density: bottom_density(history),
            inclination: inclination(history),
            dip: dip(history),
            rising_zone_height: zone_height(history, RISING),
            zone_height: zone_height(history, DEVELOPED),
            zone_width: zone_width(history, DEVELOPED),
            zone_aspect_ratio: zone_aspect_ratio(history, DEVELOPED),
            central_share: central_share(history, DEVELOPED),
            threshold_free_height: threshold_free_height(history, RISING),
            centre_to_side_ratio: centre_to_side_ratio(history),
            row_variation: row_variation(history),
            overall_variation: overall_variation(history),
        }
    }
}

/// Description of an observable for reports.
#[derive(Clone, Copy, Debug)]
pub struct Quantity {
    /// Symbol; zh80 is zh at step 80.
    pub symbol: &'static str,
    /// Name.
    pub name: &'static str,
    /// Unit; "1" for a dimensionless number.
    pub unit: &'static str,
    /// Returns the value of the observable.
    pub value: fn(&Observables) -> Option<f64>,
}

const fn quantity(
    symbol: &'static str,
    name: &'static str,
    unit: &'static str,
    value: fn(&Observables) -> Option<f64>,
) -> Quantity {
    Quantity { symbol, name, unit, value }
}

/// Descriptions of all observables, in the order of [`Observables`].
pub const QUANTITIES: [Quantity; 14] = [
    quantity("Q", "outflow rate", "particles/step", |all| all.outflow_rate),
    quantity("rho0", "onset density", "particles/site", |all| all.onset_density),
    quantity("rhob", "bottom density", "particles/site", |all| all.bottom_density),
    quantity("incl", "inclination of the surface", "deg", |all| all.inclination),
    quantity("dip", "dip of the surface", "spacings", |all| all.dip),
    quantity("zh80", "zone height at step 80", "spacings", |all| all.rising_zone_height),
    quantity("zh", "zone height at step 200", "spacings", |all| all.zone_height),
    quantity("zw", "zone width at step 200", "spacings", |all| all.zone_width),
    quantity("za", "zone aspect ratio at step 200", "1", |all| all.zone_aspect_ratio),
    quantity("zc", "central share of the zone at step 200", "1", |all| all.central_share),
    quantity("hz", "threshold-free zone height at step 80", "spacings", |all| all.threshold_free_height),
    quantity("cs", "centre-to-side density ratio, row by row", "1", |all| all.centre_to_side_ratio),
    quantity("cvr", "density variation within rows", "1", |all| all.row_variation),
    quantity("cvg", "density variation of the whole silo", "1", |all| all.overall_variation),
];

#[cfg(test)]
mod tests {
    use super::super::synthetic::{Silo, close};
    use super::super::{Blocks, Frame};
    use super::*;

    #[test]
    fn every_observable_is_measured_at_its_step() {
        let density = |step, x: f64, y| {
            let top = if step <= 100 { 40.0 } else { 100.0 };
            if x.abs() < 20.0 && y < top { 7.0 } else { 10.0 }
        };
        let mut history = Silo::STANDARD.history(|_, _| 10.0, density);
        history.frames.iter_mut().for_each(|frame| frame.out = 3 * frame.step);
        let all = Observables::of(&history);
        assert!(QUANTITIES.iter().all(|quantity| (quantity.value)(&all).is_some()), "{all:?}");
        close(all.outflow_rate, 3.0, 0.0);
        close(all.rising_zone_height, 40.0, 0.0);
        close(all.zone_height, 100.0, 0.0);
        close(all.threshold_free_height, 40.0, 1e-12);
    }

    #[test]
    fn the_table_lists_each_observable_once_in_order() {
        let all = Observables {
            outflow_rate: Some(0.0),
            onset_density: Some(1.0),
            bottom_density: Some(2.0),
            inclination: Some(3.0),
            dip: Some(4.0),
            rising_zone_height: Some(5.0),
            zone_height: Some(6.0),
            zone_width: Some(7.0),
            zone_aspect_ratio: Some(8.0),
            central_share: Some(9.0),
            threshold_free_height: Some(10.0),
            centre_to_side_ratio: Some(11.0),
            row_variation: Some(12.0),
            overall_variation: Some(13.0),
        };
        for (number, quantity) in (0..14).zip(&QUANTITIES) {
            close((quantity.value)(&all), f64::from(number), 0.0);
        }
        let mut symbols: Vec<_> = QUANTITIES.iter().map(|quantity| quantity.symbol).collect();
        symbols.sort_unstable();
        symbols.dedup();
        assert_eq!(symbols.len(), QUANTITIES.len());
    }

    #[test]
    fn an_empty_history_has_no_observables() {
        let blocks = Blocks { columns: 0, rows: 0, sites: vec![], x: vec![], y: vec![] };
        let start = Frame { step: 0, out: 0, counts: vec![] };
        let history = History { blocks, start, frames: vec![] };
        assert_eq!(Observables::of(&history), Observables::default());
        // Without frames, only the densities before opening are defined.
        let mut silo = Silo::STANDARD.history(|_, _| 10.0, |_, _, _| 10.0);
        silo.frames.clear();
        let densities = Observables { onset_density: Some(10.0), bottom_density: Some(10.0), ..Observables::default() };
        assert_eq!(Observables::of(&silo), densities);
    }

    /// Pseudo-random test histories: a linear congruential generator, of which the upper half of the state is used.
    struct Numbers(u64);

    impl Numbers {
        fn below(&mut self, end: u32) -> u32 {
            self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            u32::try_from(((self.0 >> 32) * u64::from(end)) >> 32).unwrap()
        }

        fn place(&mut self) -> f64 {
            match self.below(40) {
                0 => f64::NAN,
                1 => f64::INFINITY,
                _ => f64::from(self.below(200)) - 60.0,
            }
        }

        fn frame(&mut self, blocks: usize) -> Frame {
            let step = if self.below(50) == 0 { u64::MAX } else { u64::from(self.below(40)) * 10 };
            let out = if self.below(20) == 0 { u64::MAX } else { u64::from(self.below(1000)) };
            let largest = [1, 2, 20, 260, u32::MAX][self.below(5) as usize];
            Frame { step, out, counts: (0..blocks).map(|_| self.below(largest)).collect() }
        }

        fn history(&mut self) -> History {
            let columns = self.below(8) as usize;
            let rows = self.below(8) as usize;
            let sites = (0..columns * rows).map(|_| self.below(30)).collect();
            let x = (0..columns).map(|_| self.place()).collect();
            let y = (0..rows).map(|_| self.place()).collect();
            let start = Frame { step: 0, ..self.frame(columns * rows) };
            let mut frames: Vec<_> = (0..self.below(60)).map(|_| self.frame(columns * rows)).collect();
            if self.below(2) == 0 {
                // Regular frames, one every 10 steps.
                (1..).zip(&mut frames).for_each(|(number, frame)| frame.step = 10 * number);
            }
            History { blocks: Blocks { columns, rows, sites, x, y }, start, frames }
        }
    }

    #[test]
    fn random_histories_give_finite_values_or_none() {
        let mut numbers = Numbers(1);
        let mut found = [0; QUANTITIES.len()];
        for _ in 0..2000 {
            let all = Observables::of(&numbers.history());
            for (quantity, found) in QUANTITIES.iter().zip(&mut found) {
                let value = (quantity.value)(&all);
                assert!(value.is_none_or(f64::is_finite), "{}: {value:?}", quantity.symbol);
                *found += usize::from(value.is_some());
            }
        }
        // Each observable must be defined for some of the random histories, or the test would check nothing.
        assert!(found.iter().all(|&found| found > 20), "{found:?}");
    }
}
