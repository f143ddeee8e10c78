//! A dense bed at rest: 43 columns by 12 rows between periodic sides, radii spread by 1 %, compressed sideways by 0.07
//! %.

use crate::discs::{Disc, Discs, GRAVITY, MASS, RADIUS, STIFFNESS, Scheme, Setting, damping};
use crate::gas::uniform;
use crate::numbers::{Double, Numbers};
use crate::table::{Measure, OFFSETS, rms, row};

const COLUMNS: u32 = 43;
const ROWS: u32 = 12;
/// Length of a period, m: 43 diameters less 0.07 %, a multiple of 1/64 m.
const SIDE: f64 = 3.4375;
/// Time to settle, and time of observation after that, s.
const SETTLING: f64 = 12.0;
const OBSERVED: f64 = 5.0;

#[derive(Clone, Copy)]
enum Quantity {
    /// Rms error of the elastic pair forces over their mean, at the rest positions of f64.
    Force,
    /// Rms acceleration at rest over g: zero for exact forces and positions.
    Balance,
    /// Rms speed after 5 s more, m/s.
    Speed,
    /// Rms distance from the rest positions after 5 s more, over the mean overlap.
    Drift,
}

struct Bed<'a> {
    settled: &'a [Disc],
    offset: f64,
    quantity: Quantity,
}

fn setting(offset: f64) -> Setting {
    let (drag, duration) = damping(0.2);
    Setting {
        drag,
        gravity: GRAVITY,
        floor: offset,
        corner: offset,
        periods: [SIDE, f64::INFINITY],
        scheme: Scheme::Averaged,
        dt: duration / 20.0,
    }
}

#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a small positive number")]
fn steps(time: f64) -> u64 {
    (time / setting(0.0).dt).ceil() as u64
}

/// Returns the bed at rest, computed with f64 at the origin.
fn settled() -> Vec<Disc> {
    let pitch = SIDE / f64::from(COLUMNS);
    let disc = |i: u32| {
        let column = f64::from(i % COLUMNS);
        let row = f64::from(i / COLUMNS);
        Disc {
            x: [pitch * (column + 0.5 * (row % 2.0) + 0.25), RADIUS * (1.0 + 3.0f64.sqrt() * row)],
            v: [0.0; 2],
            radius: RADIUS * (1.0 + 0.01 * uniform(1, u64::from(i))),
        }
    };
    let mut bed = Discs::<Double>::new(setting(0.0), &(0..COLUMNS * ROWS).map(disc).collect::<Vec<_>>());
    bed.run(steps(SETTLING));
    bed.discs()
}

impl Bed<'_> {
    fn set<N: Numbers>(&self, offset: f64) -> Discs<N> {
        let moved = |disc: &Disc| Disc { x: disc.x.map(|x| x + offset), ..*disc };
        Discs::new(setting(offset), &self.settled.iter().map(moved).collect::<Vec<_>>())
    }

    /// Returns the mean elastic force, N.
    fn mean_force(&self) -> f64 {
        let forces = self.set::<Double>(0.0).forces();
        forces.iter().map(|pair| pair.1).sum::<f64>() / f64::from(u32::try_from(forces.len()).unwrap_or(1))
    }
}

impl Measure for Bed<'_> {
    fn of<N: Numbers>(&self) -> (f64, Option<f64>) {
        let mut bed = self.set::<N>(self.offset);
        let figure = match self.quantity {
            Quantity::Force => {
                let exact = self.set::<Double>(0.0).forces();
                let here = bed.forces();
                let force = |pair| here.iter().find(|other| other.0 == pair).map_or(0.0, |other| other.1);
                rms(exact.iter().map(|&(pair, exact)| force(pair) - exact)) / self.mean_force()
            }
            Quantity::Balance => rms(bed.accelerations().concat()) / GRAVITY,
            Quantity::Speed => {
                bed.run(steps(OBSERVED));
                rms(bed.discs().iter().flat_map(|disc| disc.v))
            }
            Quantity::Drift => {
                bed.run(steps(OBSERVED));
                let distance = |(now, then): (&Disc, &Disc)| {
                    let x = now.x[0] - self.offset - then.x[0];
                    [x - SIDE * (x / SIDE).round(), now.x[1] - self.offset - then.x[1]]
                };
                rms(bed.discs().iter().zip(self.settled).flat_map(distance)) / (self.mean_force() / STIFFNESS)
            }
        };
        (figure, None)
    }
}

pub fn rows(print_line: &mut impl FnMut(String)) {
    let settled = settled();
    let bed = |offset, quantity| Bed { settled: &settled, offset, quantity };
    let contacts = bed(0.0, Quantity::Force).set::<Double>(0.0).forces().len();
    let mean = bed(0.0, Quantity::Force).mean_force();
    print_line(format!(
        "(the bed: {} grains, {contacts} contacts, mean force {mean:.2} N or {:.1} m g, mean overlap {:.1e} R)",
        settled.len(),
        mean / (MASS * GRAVITY),
        mean / STIFFNESS / RADIUS
    ));
    for offset in OFFSETS {
        print_line(row("bed: pair force", offset, None, &bed(offset, Quantity::Force)));
        print_line(row("bed: acceleration left, g", offset, None, &bed(offset, Quantity::Balance)));
        print_line(row("bed after 5 s: speed, m/s", offset, None, &bed(offset, Quantity::Speed)));
        print_line(row("bed after 5 s: moved, mean overlaps", offset, None, &bed(offset, Quantity::Drift)));
    }
}
