//! Bed at rest: height and packing fraction.
//!
//! *Fill height* (m above the origin) is a mean over 100 columns of equal width across the bed. Each column counts with
//! the top of its highest grain, a column without grains with the lowest point of the bed.
//!
//! *Packing fraction* is the share of the window's area that grains cover. It is sampled on a square grid of 1/20 of
//! the smallest radius; overlaps count once. The window must lie inside the bed, away from walls and surface. Then the
//! result is the bulk value, except for the layering next to walls. The sampling error is about (grid/R)/sqrt(number of
//! grains in the window), less than 1e-3 for a hundred grains. A window with more than 4e6 points gets a wider grid.

use bevy_app::{App, Plugin};
use bevy_ecs::prelude::*;
use serde::{Deserialize, Serialize};

use crate::measure::ObserveStage;
use siloflow_dem::messages::CameToRest;
use siloflow_dem::particles::Particles;
use siloflow_dem::persist::PersistApp as _;
use siloflow_dem::space::Vector;
use siloflow_dem::step::Step;
use siloflow_dem::store::PlainCommands;
use siloflow_dem::values::FiniteVector;

/// The scene key `bed`: a window inside the bed at rest.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Bed {
    /// Lower left corner, m.
    pub low: FiniteVector,
    /// Upper right corner, m.
    pub high: FiniteVector,
}

/// Results of the measurement.
#[derive(Resource, Clone, Copy, Debug, Serialize, Deserialize)]
pub struct BedFigures {
    /// Mean height of the surface above the origin, m.
    pub fill_height_m: f64,
    /// Share of the window that grains cover.
    pub packing_fraction: f64,
}

#[derive(Resource)]
struct Window(Bed);

fn measure(mut commands: Commands, window: Res<Window>, particles: Particles, mut rest: MessageReader<CameToRest>) {
    if rest.read().next().is_none() {
        return;
    }
    let grains: Vec<_> = particles.grains().map(|grain| (particles.position(grain), particles.radius(grain))).collect();
    commands.insert_resource(BedFigures {
        fill_height_m: fill_height(&grains),
        packing_fraction: packing_fraction(&grains, window.0.low.get(), window.0.high.get()),
    });
}

fn fill_height(grains: &[(Vector, f64)]) -> f64 {
    const COLUMNS: usize = 100;
    let left = grains.iter().map(|(x, r)| x.x - r).fold(f64::INFINITY, f64::min);
    let right = grains.iter().map(|(x, r)| x.x + r).fold(f64::NEG_INFINITY, f64::max);
    let lowest = grains.iter().map(|(x, r)| x.y - r).fold(f64::INFINITY, f64::min);
    let width = (right - left) / 100.0;
    let mut tops = [lowest; COLUMNS];
    for (column, top) in (0u8..).zip(&mut tops) {
        let middle = left + (f64::from(column) + 0.5) * width;
        for (x, r) in grains {
            let half = r * r - (x.x - middle).powi(2);
            if half > 0.0 {
                *top = top.max(x.y + half.sqrt());
            }
        }
    }
    tops.iter().sum::<f64>() / 100.0
}

/// Largest number of grid points in a window.
const MAX_POINTS: f64 = 4e6;

fn packing_fraction(grains: &[(Vector, f64)], low: Vector, high: Vector) -> f64 {
    let smallest = grains.iter().map(|(_, r)| *r).fold(f64::INFINITY, f64::min);
    let near: Vec<_> = grains
        .iter()
        .filter(|(x, r)| x.cmpgt(low - Vector::splat(*r)).all() && x.cmplt(high + Vector::splat(*r)).all())
        .collect();
    let area = (high - low).element_product();
    let step = (smallest / 20.0).max((area / MAX_POINTS).sqrt());
    let mut covered = 0u32;
    let mut points = 0u32;
    let mut y = low.y + 0.5 * step;
    while y < high.y {
        let row: Vec<_> = near.iter().filter(|(x, r)| (x.y - y).abs() < *r).collect();
        let mut x = low.x + 0.5 * step;
        while x < high.x {
            let point = Vector::new(x, y);
            points += 1;
            covered += u32::from(row.iter().any(|(centre, r)| centre.distance_squared(point) < r * r));
            x += step;
        }
        y += step;
    }
    f64::from(covered) / f64::from(points.max(1))
}

/// Measures the bed when it comes to rest.
pub struct BedPlugin(pub Bed);

impl Plugin for BedPlugin {
    fn build(&self, app: &mut App) {
        app.insert_resource(Window(self.0))
            .persist_sound::<BedFigures>()
            .add_systems(Step, measure.in_set(ObserveStage::Measure).in_set(PlainCommands));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    #[test]
    fn packing_fraction_of_a_square_lattice_is_that_of_its_cell() {
        // With this radius the grid does not repeat from cell to cell, so the errors of 196 cells average out.
        let radius = 0.47;
        let grains: Vec<_> =
            (0..20u8).flat_map(|i| (0..20u8).map(move |j| (Vector::new(f64::from(i), f64::from(j)), radius))).collect();
        let phi = packing_fraction(&grains, Vector::splat(2.5), Vector::splat(16.5));
        // The error of one circle on a grid of R/20 is about (1/20)^1.5, and 196 circles divide it by 14. The window
        // ends within half a grid cell, 0.0235/2 of 14.
        assert!((phi - PI * radius * radius).abs() < 2e-3, "{phi}");
        // The mean height of a half circle over its width is pi R/4. Gaps between circles of the top row show the sides
        // of the row below, so the mean is lower.
        let height = fill_height(&grains);
        assert!(height < 19.0 + PI * radius / 4.0 && height > 18.9, "{height}");
    }
}
