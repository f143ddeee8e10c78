//! A layer on an incline in one window of time: its depth, friction, inertial number and exponent.

use crate::studies::validation::runs::FinishedRun;
use siloflow_figures::statistics::fit::{Law, best_line};
use siloflow_figures::statistics::mean::Mean;
use siloflow_text::fault::Fault;

/// Mean diameter of the spheres (m), and gravity (m/s^2).
const DIAMETER: f64 = 1.0e-3;
const GRAVITY: f64 = 9.81;

/// Cells that count: heights above this, and depths below this, diameters.
const FLOOR: f64 = 5.0;
const SURFACE: f64 = 2.0;

/// A cell: height (diameters), solid fraction, velocity (m/s), normal and shear stress (Pa).
type Cell = [f64; 5];

/// The layer in one window of time.
#[derive(Clone, Debug)]
pub(super) struct Layer {
    /// Angle, radians.
    pub(super) angle: f64,
    /// Points (depth in diameters, velocity in m/s) of the cells that count.
    pub(super) points: Vec<(f64, f64)>,
    /// Depth of the layer, diameters.
    pub(super) depth: f64,
    /// Mean over the solid, m/s.
    pub(super) mean_velocity: f64,
    pub(super) friction: f64,
    pub(super) exponent: f64,
    pub(super) inertial: f64,
}

impl Layer {
    /// Takes the cells of a window; `None` without a dense layer.
    fn of(angle: f64, cells: &[Cell]) -> Option<Self> {
        let solid: f64 = cells.iter().map(|cell| cell[1]).sum();
        let dense: Vec<f64> = cells.iter().filter(|cell| cell[0] > FLOOR).map(|cell| cell[1]).collect();
        // The mean over the part of the layer that is far from its floor and surface.
        let bulk = dense.iter().copied().filter(|phi| *phi > 0.4).collect::<Vec<_>>();
        let bulk = Mean::of(&bulk)?.value;
        let above = |n: usize| (cells[n + 1..].iter().map(|cell| cell[1]).sum::<f64>() + 0.5 * cells[n][1]) / bulk;
        let counted: Vec<_> = (0..cells.len()).filter(|n| cells[*n][0] > FLOOR && above(*n) > SURFACE).collect();
        let points: Vec<_> = counted.iter().map(|n| (above(*n), cells[*n][2])).collect();
        let sum = |column: usize| counted.iter().map(|n| cells[*n][column]).sum::<f64>();
        let exponent = best_line(&points, (50..=300).map(|n| 0.01 * f64::from(n)), f64::powf)?.candidate;
        let bagnold = Law::Line.fit(&points.iter().map(|(depth, v)| (depth.powf(1.5), *v)).collect::<Vec<_>>())?;
        let amplitude = -bagnold.value("slope")?;
        let flux: f64 = cells.iter().filter(|cell| cell[1] > 0.0).map(|cell| cell[1] * cell[2]).sum();
        Some(Self {
            angle,
            depth: solid / bulk,
            mean_velocity: flux / solid,
            friction: -sum(4) / sum(3),
            exponent,
            inertial: 1.5 * amplitude / (bulk * GRAVITY * angle.cos() * DIAMETER).sqrt(),
            points,
        })
    }

    /// Reads the layers of the second half of a run's windows.
    pub(super) fn all(run: &FinishedRun) -> Result<Vec<Self>, Fault> {
        let table = run.table("fields.csv")?;
        let column = |name: &str| table.numbers(name).unwrap_or_default();
        let from = column("from_s");
        let to = column("to_s");
        let last = to.iter().copied().fold(0.0, f64::max);
        let first = from.iter().copied().fold(f64::INFINITY, f64::min);
        let names = ["x3_m", "solid_fraction", "v1", "contact_33", "kinetic_33", "contact_13", "kinetic_13"];
        let [z, phi, v, p, pk, s, sk] = names.map(column);
        let angle = run.number("parameters.angle").or(run.value("parameters.angle")).unwrap_or(f64::NAN).to_radians();
        let mut layers = Vec::new();
        let mut cells: Vec<Cell> = Vec::new();
        for n in 0..from.len() {
            cells.push([z[n] / DIAMETER, phi[n], if v[n].is_nan() { 0.0 } else { v[n] }, p[n] + pk[n], s[n] + sk[n]]);
            let is_last = n + 1 == from.len() || (from[n + 1] - from[n]).abs() > 1e-9;
            if is_last {
                let is_whole = to[n] - from[n] > 0.2;
                if is_whole && from[n] > 0.5 * (first + last) - 0.05 {
                    layers.extend(Self::of(angle, &cells));
                }
                cells.clear();
            }
        }
        Ok(layers)
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    /// Returns a layer 30 deep in which the velocity is v_s - A D^n.
    pub(in super::super) fn layer(exponent: f64, friction: f64) -> Layer {
        let angle = 24f64.to_radians();
        let cell = |n: u8| {
            let z = f64::from(n) + 0.5;
            let depth = 30.0 - z;
            let pressure = 2500.0 * 0.57 * GRAVITY * angle.cos() * depth * DIAMETER;
            [z, 0.57, 1.8 - 0.01 * depth.powf(exponent), pressure, -friction * pressure]
        };
        Layer::of(angle, &(0..30).map(cell).collect::<Vec<_>>()).unwrap()
    }

    #[test]
    fn exponent_friction_and_inertial_number_of_an_exact_layer_are_recovered() {
        let it = layer(1.5, 0.43);
        let inertial = 1.5 * 0.01 / (0.57 * GRAVITY * it.angle.cos() * DIAMETER).sqrt();
        for (found, expected) in [(it.exponent, 1.5), (it.friction, 0.43), (it.inertial, inertial), (it.depth, 30.0)] {
            assert!((found - expected).abs() < 1e-9, "{found} {expected}");
        }
        assert!((layer(2.0, 0.43).exponent - 2.0).abs() < 1e-9);
    }
}
