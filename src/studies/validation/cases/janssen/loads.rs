//! Loads on wall and floor over time, and their balance with the weight.
//!
//! The force of each row of `wall_groups.csv` is a mean over all steps since the row before. Summed over a time with steps of dt it changes the momentum P of
//! `centres.csv`: walls + floor = M g + dP/dt. The momentum at a row has only half of the force of its own step, so the balance holds up to the difference of
//! the forces at both ends, times dt/2, over the time. That difference is at most about the weight: friction jumps when the wall starts or stops.

use crate::studies::validation::runs::FinishedRun;
use siloflow_text::fault::Fault;

/// Gravity, m/s^2.
pub(super) const GRAVITY: f64 = 9.81;

/// A time of a run, s.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Window {
    pub from: f64,
    pub to: f64,
}

/// Loads of a run: a row of each number for each time.
#[derive(Debug)]
pub(super) struct Loads {
    pub times: Vec<f64>,
    /// Upward force on the grains, N.
    pub wall: Vec<f64>,
    pub floor: Vec<f64>,
    /// Mass, kg, and upward momentum, kg m/s.
    mass: Vec<f64>,
    momentum: Vec<f64>,
    /// Time step, s.
    step: f64,
}

impl Loads {
    /// Reads the loads of a run. The outlet counts as floor.
    pub(super) fn of(run: &FinishedRun) -> Result<Self, Fault> {
        let forces = run.table("wall_groups.csv")?;
        let names = forces.texts("walls").unwrap_or_default();
        let times_of_rows = forces.needed("time_s")?;
        let along = forces.needed("fz_n")?;
        let centres = run.table("centres.csv")?;
        let times = centres.needed("time_s")?;
        let mass = centres.needed("mass_kg")?;
        let speed = centres.numbers("vz_m_per_s").unwrap_or_default();
        let momentum = mass.iter().zip(speed).map(|(m, v)| if *m > 0.0 { m * v } else { 0.0 }).collect();
        let mut loads = Self {
            wall: vec![0.0; times.len()],
            floor: vec![0.0; times.len()],
            times,
            mass,
            momentum,
            step: run.number("time_s").zip(run.number("steps")).map_or(f64::NAN, |(time, steps)| time / steps),
        };
        let mut row = 0;
        for ((time, name), force) in times_of_rows.iter().zip(names).zip(along) {
            while row + 1 < loads.times.len() && loads.times[row] < time - 1e-9 {
                row += 1;
            }
            let load = if name == "wall" { &mut loads.wall } else { &mut loads.floor };
            if let Some(load) = load.get_mut(row) {
                *load -= force;
            }
        }
        Ok(loads)
    }

    /// Returns the rows whose means lie within a window.
    fn rows(&self, window: Window) -> std::ops::Range<usize> {
        let first = self.times.iter().position(|time| *time >= window.from - 1e-9).unwrap_or(self.times.len());
        let last = self.times.iter().rposition(|time| *time <= window.to + 1e-9).map_or(first, |last| last + 1);
        (first + 1).min(last)..last
    }

    /// Returns the mean of a load in a window, N.
    pub(super) fn mean(&self, load: &[f64], window: Window) -> f64 {
        let rows = self.rows(window);
        let sum: f64 = rows.clone().map(|row| load[row] * (self.times[row] - self.times[row - 1])).sum();
        sum / self.span(&rows)
    }

    fn span(&self, rows: &std::ops::Range<usize>) -> f64 {
        if rows.is_empty() { f64::NAN } else { self.times[rows.end - 1] - self.times[rows.start - 1] }
    }

    /// Returns the weight at the begin of a window, N.
    pub(super) fn weight(&self, window: Window) -> f64 {
        self.rows(window).next().map_or(f64::NAN, |row| GRAVITY * self.mass[row])
    }

    /// Returns walls + floor - weight - dP/dt over the weight in a window, and its bound.
    pub(super) fn balance(&self, window: Window) -> (f64, f64) {
        let rows = self.rows(window);
        let span = self.span(&rows);
        let weight = self.weight(window);
        if rows.is_empty() {
            return (f64::NAN, f64::NAN);
        }
        let first = rows.start - 1;
        let last = rows.end - 1;
        let borne = self.mean(&self.wall, window) + self.mean(&self.floor, window);
        let gained = (self.momentum[last] - self.momentum[first]) / span;
        ((borne - weight - gained) / weight, 0.5 * self.step / span)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A body of 2 kg that is held by a force which grows over two rows of 100 steps each.
    fn held() -> Loads {
        let step = 1e-3;
        let weight = 2.0 * GRAVITY;
        let forces: Vec<_> = (0..=200).map(|n| weight * (1.0 + 1e-3 * f64::from(n))).collect();
        let mean = |from: usize, to: usize| forces[from..=to].iter().sum::<f64>() / 100.0;
        // Velocity Verlet: half of both ends.
        let momentum =
            |last: usize| (0..last).map(|n| step * (0.5 * (forces[n] + forces[n + 1]) - weight)).sum::<f64>();
        Loads {
            times: vec![0.0, 0.1, 0.2],
            wall: [0.0, mean(1, 100), mean(101, 200)].map(|force| 0.25 * force).to_vec(),
            floor: [0.0, mean(1, 100), mean(101, 200)].map(|force| 0.75 * force).to_vec(),
            mass: vec![2.0; 3],
            momentum: [0, 100, 200].map(momentum).to_vec(),
            step,
        }
    }

    #[test]
    fn a_body_that_speeds_up_is_in_balance_within_the_bound_and_a_missing_load_is_not() {
        let window = Window { from: 0.0, to: 0.2 };
        let mut loads = held();
        let (balance, bound) = loads.balance(window);
        // Half a step of the difference of the ends: 0.2 weight, 0.5e-3 s, over 0.2 s.
        assert!((balance - 5e-4).abs() < 1e-9 && balance < bound && bound < 2.6e-3, "{balance} {bound}");
        assert!((loads.mean(&loads.wall, window) / loads.weight(window) - 0.25 * 1.1005).abs() < 1e-9);
        loads.floor.iter_mut().for_each(|force| *force *= 0.99);
        assert!(loads.balance(window).0.abs() > 5e-3);
    }

    #[test]
    fn a_window_without_rows_has_no_numbers() {
        let (balance, bound) = held().balance(Window { from: 5.0, to: 6.0 });
        assert!(balance.is_nan() && bound.is_nan());
    }
}
