//! Ten grains stacked on a floor settle under their weight. At the start they just touch.

use crate::discs::{Disc, Discs, GRAVITY, MASS, RADIUS, STIFFNESS, Scheme, Setting, damping};
use crate::numbers::{Double, Numbers};
use crate::table::{Measure, OFFSETS, rms, row};

const GRAINS: u32 = 10;
/// A time while the column still oscillates (the slowest mode has a period of 0.05 s), and a time long after, s.
const OSCILLATING: f64 = 0.1;
const SETTLED: f64 = 15.0;

#[derive(Clone, Copy)]
enum Quantity {
    /// Rms distance from the positions in f64 while the grains oscillate, over the lowest overlap.
    Path,
    /// Rms error of the overlaps at rest, each over its exact value: the weight above over k.
    Overlap,
    /// Rms speed at rest, m/s.
    Speed,
}

struct Column {
    /// Smallest t_c/dt.
    steps: f64,
    offset: f64,
    quantity: Quantity,
}

impl Column {
    fn after<N: Numbers>(&self, time: f64) -> Vec<Disc> {
        let (drag, duration) = damping(0.5);
        let steps = (time / duration * self.steps).ceil();
        let setting = Setting {
            drag,
            gravity: GRAVITY,
            floor: self.offset,
            corner: 0.0,
            periods: [f64::INFINITY; 2],
            scheme: Scheme::Averaged,
            dt: time / steps,
        };
        let disc = |i: u32| Disc {
            x: [self.offset, self.offset + RADIUS * f64::from(2 * i + 1)],
            v: [0.0; 2],
            radius: RADIUS,
        };
        let mut column = Discs::<N>::new(setting, &(0..GRAINS).map(disc).collect::<Vec<_>>());
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a whole positive number")]
        column.run(steps as u64);
        column.discs()
    }

    /// Returns the heights above the floor, m.
    fn heights<N: Numbers>(&self, time: f64) -> Vec<f64> {
        self.after::<N>(time).iter().map(|disc| disc.x[1] - self.offset).collect()
    }

    /// Returns the rms distance between two columns over the lowest overlap at rest.
    fn distance(a: &[f64], b: &[f64]) -> f64 {
        rms(a.iter().zip(b).map(|(a, b)| a - b)) / (f64::from(GRAINS) * MASS * GRAVITY / STIFFNESS)
    }

    /// Returns the error of the path due to the time step.
    fn time_step_error(&self) -> f64 {
        let fine = Column { steps: 3000.0, ..*self };
        Self::distance(&self.heights::<Double>(OSCILLATING), &fine.heights::<Double>(OSCILLATING))
    }
}

impl Measure for Column {
    fn of<N: Numbers>(&self) -> (f64, Option<f64>) {
        let figure = match self.quantity {
            Quantity::Path => {
                let origin = Column { offset: 0.0, ..*self };
                Self::distance(&self.heights::<N>(OSCILLATING), &origin.heights::<Double>(OSCILLATING))
            }
            Quantity::Overlap => {
                let heights = self.heights::<N>(SETTLED);
                let below = std::iter::once(-RADIUS).chain(heights.iter().copied());
                rms(heights.iter().zip(below).zip(0..GRAINS).map(|((above, below), i)| {
                    let exact = f64::from(GRAINS - i) * MASS * GRAVITY / STIFFNESS;
                    (2.0 * RADIUS - (above - below)) / exact - 1.0
                }))
            }
            Quantity::Speed => rms(self.after::<N>(SETTLED).iter().map(|disc| disc.v[1])),
        };
        (figure, None)
    }
}

pub fn rows(print_line: &mut impl FnMut(String)) {
    for steps in [20.0, 100.0] {
        let time_step_error = Column { steps, offset: 0.0, quantity: Quantity::Path }.time_step_error();
        for offset in OFFSETS {
            let column = |quantity| Column { steps, offset, quantity };
            print_line(row(
                &format!("column, t_c/{steps}: path"),
                offset,
                Some(time_step_error),
                &column(Quantity::Path),
            ));
            print_line(row(
                &format!("column, t_c/{steps}: overlaps at rest"),
                offset,
                None,
                &column(Quantity::Overlap),
            ));
            print_line(row(&format!("column, t_c/{steps}: speed left, m/s"), offset, None, &column(Quantity::Speed)));
        }
    }
}
