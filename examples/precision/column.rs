//! Ten grains stacked on a floor that settle under their weight, from where they just touch.

use crate::discs::{Disc, Discs, GRAVITY, MASS, RADIUS, STIFFNESS, Scheme, Setting, damping};
use crate::numbers::{Double, Numbers};
use crate::table::{Measure, OFFSETS, rms, row};

const GRAINS: u32 = 10;
/// While it still swings (the slowest mode has a period of 0.05 s), and long after, s.
const SWINGING: f64 = 0.1;
const SETTLED: f64 = 15.0;

#[derive(Clone, Copy)]
enum Asked {
    /// Rms distance from where f64 has the grains while they swing, over the lowest overlap.
    Path,
    /// Rms error of the overlaps at rest, each over its exact value: the weight above over k.
    Overlap,
    /// Rms speed at rest, m/s.
    Speed,
}

struct Column {
    /// t_c/dt, at least.
    steps: f64,
    offset: f64,
    asked: Asked,
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

    /// Heights above the floor, m.
    fn heights<N: Numbers>(&self, time: f64) -> Vec<f64> {
        self.after::<N>(time).iter().map(|disc| disc.x[1] - self.offset).collect()
    }

    /// Rms distance between two columns over the lowest overlap at rest.
    fn distance(a: &[f64], b: &[f64]) -> f64 {
        rms(a.iter().zip(b).map(|(a, b)| a - b)) / (f64::from(GRAINS) * MASS * GRAVITY / STIFFNESS)
    }

    /// What the time step makes of the path.
    fn of_the_step(&self) -> f64 {
        let fine = Column { steps: 3000.0, ..*self };
        Self::distance(&self.heights::<Double>(SWINGING), &fine.heights::<Double>(SWINGING))
    }
}

impl Measure for Column {
    fn of<N: Numbers>(&self) -> (f64, Option<f64>) {
        let figure = match self.asked {
            Asked::Path => {
                let origin = Column { offset: 0.0, ..*self };
                Self::distance(&self.heights::<N>(SWINGING), &origin.heights::<Double>(SWINGING))
            }
            Asked::Overlap => {
                let heights = self.heights::<N>(SETTLED);
                let below = std::iter::once(-RADIUS).chain(heights.iter().copied());
                rms(heights.iter().zip(below).zip(0..GRAINS).map(|((above, below), i)| {
                    let exact = f64::from(GRAINS - i) * MASS * GRAVITY / STIFFNESS;
                    (2.0 * RADIUS - (above - below)) / exact - 1.0
                }))
            }
            Asked::Speed => rms(self.after::<N>(SETTLED).iter().map(|disc| disc.v[1])),
        };
        (figure, None)
    }
}

pub fn rows(say: &mut impl FnMut(String)) {
    for steps in [20.0, 100.0] {
        let of_the_step = Column { steps, offset: 0.0, asked: Asked::Path }.of_the_step();
        for offset in OFFSETS {
            let column = |asked| Column { steps, offset, asked };
            say(row(&format!("column, t_c/{steps}: path"), offset, Some(of_the_step), &column(Asked::Path)));
            say(row(&format!("column, t_c/{steps}: overlaps at rest"), offset, None, &column(Asked::Overlap)));
            say(row(&format!("column, t_c/{steps}: speed left, m/s"), offset, None, &column(Asked::Speed)));
        }
    }
}
