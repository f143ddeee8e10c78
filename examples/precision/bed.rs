//! A dense bed at rest, 43 columns by 12 rows between periodic sides, radii spread by 1 %, pressed sideways by 0.07 %.

use crate::discs::{Disc, Discs, GRAVITY, MASS, RADIUS, STIFFNESS, Scheme, Setting, damping};
use crate::gas::uniform;
use crate::numbers::{Double, Numbers};
use crate::table::{Measure, OFFSETS, rms, row};

const COLUMNS: u32 = 43;
const ROWS: u32 = 12;
/// Length of a period, m: 43 diameters less 0.07 %, a whole number of 1/64 m.
const SIDE: f64 = 3.4375;
/// Time to settle, and then to be watched, s.
const SETTLING: f64 = 12.0;
const WATCHED: f64 = 5.0;

#[derive(Clone, Copy)]
enum Asked {
    /// Rms error of the elastic pair forces over their mean, the places being those at rest in f64.
    Force,
    /// Rms acceleration at rest over g: zero if forces and places were exact.
    Balance,
    /// After 5 s more: rms speed, m/s.
    Speed,
    /// ... and rms distance from the places at rest over the mean overlap.
    Creep,
}

struct Bed<'a> {
    settled: &'a [Disc],
    offset: f64,
    asked: Asked,
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

/// The bed at rest, by f64 at the origin.
fn settled() -> Vec<Disc> {
    let pitch = SIDE / f64::from(COLUMNS);
    let disc = |i: u32| {
        let (column, row) = (f64::from(i % COLUMNS), f64::from(i / COLUMNS));
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

    /// Mean elastic force, N.
    fn mean_force(&self) -> f64 {
        let forces = self.set::<Double>(0.0).forces();
        forces.iter().map(|pair| pair.1).sum::<f64>() / f64::from(u32::try_from(forces.len()).unwrap_or(1))
    }
}

impl Measure for Bed<'_> {
    fn of<N: Numbers>(&self) -> (f64, Option<f64>) {
        let mut bed = self.set::<N>(self.offset);
        let figure = match self.asked {
            Asked::Force => {
                let (exact, here) = (self.set::<Double>(0.0).forces(), bed.forces());
                let force = |pair| here.iter().find(|other| other.0 == pair).map_or(0.0, |other| other.1);
                rms(exact.iter().map(|&(pair, exact)| force(pair) - exact)) / self.mean_force()
            }
            Asked::Balance => rms(bed.accelerations().concat()) / GRAVITY,
            Asked::Speed => {
                bed.run(steps(WATCHED));
                rms(bed.discs().iter().flat_map(|disc| disc.v))
            }
            Asked::Creep => {
                bed.run(steps(WATCHED));
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

pub fn rows(say: &mut impl FnMut(String)) {
    let settled = settled();
    let bed = |offset, asked| Bed { settled: &settled, offset, asked };
    let contacts = bed(0.0, Asked::Force).set::<Double>(0.0).forces().len();
    let mean = bed(0.0, Asked::Force).mean_force();
    say(format!(
        "(the bed: {} grains, {contacts} contacts, mean force {mean:.2} N or {:.1} m g, mean overlap {:.1e} R)",
        settled.len(),
        mean / (MASS * GRAVITY),
        mean / STIFFNESS / RADIUS
    ));
    for offset in OFFSETS {
        say(row("bed: pair force", offset, None, &bed(offset, Asked::Force)));
        say(row("bed: acceleration left, g", offset, None, &bed(offset, Asked::Balance)));
        say(row("bed after 5 s: speed, m/s", offset, None, &bed(offset, Asked::Speed)));
        say(row("bed after 5 s: moved, mean overlaps", offset, None, &bed(offset, Asked::Creep)));
    }
}
