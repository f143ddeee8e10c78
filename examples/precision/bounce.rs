//! Head-on collision of two grains at 1 m/s: the error of the restitution.

use crate::discs::{Disc, Discs, RADIUS, Scheme, Setting, damping};
use crate::numbers::{Double, Numbers};
use crate::table::{Measure, OFFSETS, rms, row};

const PHASES: u32 = 40;

struct Bounce {
    e: f64,
    /// t_c/dt.
    steps: f64,
    scheme: Scheme,
    offset: f64,
}

impl Bounce {
    /// Returns the restitution for each phase of a step at which the contact begins.
    fn all<N: Numbers>(&self) -> Vec<f64> {
        (0..PHASES).map(|phase| self.one::<N>((f64::from(phase) + 0.5) / f64::from(PHASES))).collect()
    }

    fn one<N: Numbers>(&self, phase: f64) -> f64 {
        let (drag, duration) = damping(self.e);
        let dt = duration / self.steps;
        let setting = Setting {
            drag,
            gravity: 0.0,
            floor: f64::NEG_INFINITY,
            corner: 0.0,
            periods: [f64::INFINITY; 2],
            scheme: self.scheme,
            dt,
        };
        // The gap closes within the second step, at 1 m/s.
        let apart = RADIUS + 0.5 * dt * (1.0 + phase);
        let disc =
            |side: f64| Disc { x: [self.offset + side * apart, self.offset], v: [-0.5 * side, 0.0], radius: RADIUS };
        let mut pair = Discs::<N>::new(setting, &[disc(-1.0), disc(1.0)]);
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a small positive number")]
        pair.run((1.6 * self.steps).ceil() as u64 + 10);
        let after = pair.discs();
        after[1].v[0] - after[0].v[0]
    }

    /// Returns the rms error against the closed form.
    fn error(&self) -> f64 {
        rms(self.all::<Double>().into_iter().map(|restitution| restitution - self.e))
    }
}

impl Measure for Bounce {
    /// Returns the rms difference from f64 at the origin, phase by phase.
    fn of<N: Numbers>(&self) -> (f64, Option<f64>) {
        let origin = Bounce { offset: 0.0, ..*self };
        (rms(self.all::<N>().into_iter().zip(origin.all::<Double>()).map(|(here, there)| here - there)), None)
    }
}

pub fn rows(print_line: &mut impl FnMut(String)) {
    for e in [0.9, 0.5, 0.2] {
        for n in [20.0, 50.0, 100.0, 200.0, 500.0, 1000.0] {
            let steps = n + std::f64::consts::PI / 8.0;
            let plain = Bounce { e, steps, scheme: Scheme::Plain, offset: 0.0 };
            let averaged = Bounce { scheme: Scheme::Averaged, ..plain };
            let of_plain = plain.error();
            let of_averaged = averaged.error();
            for offset in OFFSETS {
                let case = format!("bounce, e = {e}, t_c/{n} (plain: {of_plain:.1e})");
                print_line(row(&case, offset, Some(of_averaged), &Bounce { offset, ..averaged }));
            }
        }
    }
}
