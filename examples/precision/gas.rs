//! An undamped gas of 400 discs in a periodic box: the change of energy in 1e5 steps.

use crate::discs::{Disc, Discs, MASS, RADIUS, STIFFNESS, Scheme, Setting, damping};
use crate::numbers::Numbers;
use crate::table::{Measure, OFFSETS, row};

const ROWS: u32 = 20;
/// Side of the box, m: packing fraction 0.6, and a multiple of 1/64 m.
const SIDE: f64 = 1.828_125;
const STEPS: u64 = 100_000;

const SEEDS: u32 = 8;

struct Gas {
    /// t_c/dt.
    steps: f64,
    offset: f64,
}

/// Returns the `n`th number of a stream, uniform in -1..1 (splitmix64).
pub fn uniform(seed: u64, n: u64) -> f64 {
    let mut z = (seed << 32 | n).wrapping_add(1).wrapping_mul(0x9E37_79B9_7F4A_7C15);
    z = (z ^ z >> 30).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    z = (z ^ z >> 27).wrapping_mul(0x94D0_49BB_1331_11EB);
    #[expect(clippy::cast_precision_loss, reason = "rounded to 53 bits on purpose")]
    let share = ((z ^ z >> 31) >> 11) as f64 / (1u64 << 53) as f64;
    2.0 * share - 1.0
}

fn energy(discs: &[Disc]) -> f64 {
    let kinetic: f64 = discs.iter().map(|disc| 0.5 * MASS * (disc.v[0].powi(2) + disc.v[1].powi(2))).sum();
    let mut elastic = 0.0;
    for (i, a) in discs.iter().enumerate() {
        for b in &discs[..i] {
            let d = [0, 1].map(|axis| {
                let d = a.x[axis] - b.x[axis];
                d - SIDE * (d / SIDE).round()
            });
            elastic += 0.5 * STIFFNESS * (a.radius + b.radius - d[0].hypot(d[1])).max(0.0).powi(2);
        }
    }
    kinetic + elastic
}

impl Gas {
    /// Returns the relative change of the energy.
    fn change<N: Numbers>(&self, seed: u64) -> f64 {
        let setting = Setting {
            drag: 0.0,
            gravity: 0.0,
            floor: f64::NEG_INFINITY,
            corner: self.offset,
            periods: [SIDE; 2],
            scheme: Scheme::Plain,
            dt: damping(1.0).1 / self.steps,
        };
        let pitch = SIDE / f64::from(ROWS);
        let disc = |i: u32| {
            // 0.7 m/s rms in each direction.
            let v = |n: u32| 0.7 * 3.0f64.sqrt() * uniform(seed, u64::from(n));
            let at = |n: u32| self.offset + pitch * (f64::from(n) + 0.5);
            Disc { x: [at(i % ROWS), at(i / ROWS)], v: [v(2 * i), v(2 * i + 1)], radius: RADIUS }
        };
        let discs: Vec<_> = (0..ROWS * ROWS).map(disc).collect();
        let before = energy(&discs);
        let mut gas = Discs::<N>::new(setting, &discs);
        for _ in 0..100 {
            gas.run(STEPS / 100);
            let now = energy(&gas.discs());
            if now.is_nan() || now > 100.0 * before {
                return f64::NAN;
            }
        }
        energy(&gas.discs()) / before - 1.0
    }
}

impl Measure for Gas {
    /// Mean over the seeds.
    fn of<N: Numbers>(&self) -> (f64, Option<f64>) {
        let changes: Vec<f64> = std::thread::scope(|scope| {
            let runs: Vec<_> = (0..SEEDS).map(|seed| scope.spawn(move || self.change::<N>(seed.into()))).collect();
            runs.into_iter().map(|run| run.join().unwrap_or(f64::NAN)).collect()
        });
        let mean = changes.iter().sum::<f64>() / f64::from(SEEDS);
        let squares: f64 = changes.iter().map(|x| (x - mean).powi(2)).sum();
        (mean, Some((squares / f64::from(SEEDS * (SEEDS - 1))).sqrt()))
    }
}

pub fn rows(print_line: &mut impl FnMut(String)) {
    for n in [20.0, 100.0] {
        let steps = n + std::f64::consts::PI / 8.0;
        for offset in OFFSETS {
            print_line(row(&format!("gas, t_c/{n}: energy, relative"), offset, None, &Gas { steps, offset }));
        }
    }
}
