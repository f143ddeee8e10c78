//! The number types that a discrete element method may be built on.

use std::ops::{Add, AddAssign, Div, Mul, Sub, SubAssign};

/// `f32` or `f64`.
pub trait Real:
    Copy
    + PartialOrd
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + AddAssign
    + SubAssign
{
    const ZERO: Self;
    const ONE: Self;
    fn of(x: f64) -> Self;
    fn wide(self) -> f64;
    fn root(self) -> Self;
    fn size(self) -> Self;
}

impl Real for f64 {
    const ZERO: Self = 0.0;
    const ONE: Self = 1.0;
    fn of(x: f64) -> Self {
        x
    }
    fn wide(self) -> f64 {
        self
    }
    fn root(self) -> Self {
        self.sqrt()
    }
    fn size(self) -> Self {
        self.abs()
    }
}

impl Real for f32 {
    const ZERO: Self = 0.0;
    const ONE: Self = 1.0;
    #[expect(clippy::cast_possible_truncation, reason = "to round is what is studied here")]
    fn of(x: f64) -> Self {
        x as f32
    }
    fn wide(self) -> f64 {
        f64::from(self)
    }
    fn root(self) -> Self {
        self.sqrt()
    }
    fn size(self) -> Self {
        self.abs()
    }
}

/// Which numbers hold what.
pub trait Numbers {
    const NAME: &'static str;
    /// One coordinate of a place, m.
    type Place: Copy;
    /// Velocities, accelerations, sums of forces and the time step.
    type Motion: Real;
    /// A pair's separation, closing velocity and force.
    type Force: Real;

    fn place(x: f64) -> Self::Place;
    fn wide(x: Self::Place) -> f64;
    fn moved(x: Self::Place, by: Self::Motion) -> Self::Place;
    /// Moved by a period of the box.
    fn shifted(x: Self::Place, by: f64) -> Self::Place;
    /// a - b, to the nearest image.
    fn apart(a: Self::Place, b: Self::Place, period: f64) -> Self::Force;
}

/// The nearest image of a separation.
fn nearest<T: Real>(d: T, period: T) -> T {
    let half = T::of(0.5) * period;
    if d > half {
        d - period
    } else if d + half < T::ZERO {
        d + period
    } else {
        d
    }
}

/// All in f64.
pub struct Double;

impl Numbers for Double {
    const NAME: &'static str = "f64";
    type Place = f64;
    type Motion = f64;
    type Force = f64;

    fn place(x: f64) -> f64 {
        x
    }
    fn wide(x: f64) -> f64 {
        x
    }
    fn moved(x: f64, by: f64) -> f64 {
        x + by
    }
    fn shifted(x: f64, by: f64) -> f64 {
        x + by
    }
    fn apart(a: f64, b: f64, period: f64) -> f64 {
        nearest(a - b, period)
    }
}

/// Separations and relative velocities are taken in f64 and rounded, pair forces worked out in f32, summed in f64.
pub struct SingleForces;

impl Numbers for SingleForces {
    const NAME: &'static str = "f32 forces";
    type Place = f64;
    type Motion = f64;
    type Force = f32;

    fn place(x: f64) -> f64 {
        x
    }
    fn wide(x: f64) -> f64 {
        x
    }
    fn moved(x: f64, by: f64) -> f64 {
        x + by
    }
    fn shifted(x: f64, by: f64) -> f64 {
        x + by
    }
    fn apart(a: f64, b: f64, period: f64) -> f32 {
        f32::of(nearest(a - b, period))
    }
}

/// All in f32, places as offsets of at most [`CELL`]/2 from a cell's centre, which is kept in f64.
pub struct Anchored;

/// Side of a cell, m: a power of two, so that a change of cell rounds nothing.
const CELL: f64 = 0.125;

impl Numbers for Anchored {
    const NAME: &'static str = "f32 in cells";
    type Place = (f64, f32);
    type Motion = f32;
    type Force = f32;

    fn place(x: f64) -> (f64, f32) {
        let anchor = (x / CELL).round() * CELL;
        (anchor, f32::of(x - anchor))
    }
    fn wide((anchor, offset): (f64, f32)) -> f64 {
        anchor + offset.wide()
    }
    fn moved((anchor, offset): (f64, f32), by: f32) -> (f64, f32) {
        let offset = offset + by;
        if offset.abs() <= f32::of(0.5 * CELL) {
            return (anchor, offset);
        }
        let cells = (offset.wide() / CELL).round() * CELL;
        (anchor + cells, offset - f32::of(cells))
    }
    fn shifted((anchor, offset): (f64, f32), by: f64) -> (f64, f32) {
        (anchor + by, offset)
    }
    fn apart(a: (f64, f32), b: (f64, f32), period: f64) -> f32 {
        f32::of(nearest(a.0 - b.0, period)) + (a.1 - b.1)
    }
}

/// All in f32.
pub struct Single;

impl Numbers for Single {
    const NAME: &'static str = "f32";
    type Place = f32;
    type Motion = f32;
    type Force = f32;

    fn place(x: f64) -> f32 {
        f32::of(x)
    }
    fn wide(x: f32) -> f64 {
        x.wide()
    }
    fn moved(x: f32, by: f32) -> f32 {
        x + by
    }
    fn shifted(x: f32, by: f64) -> f32 {
        x + f32::of(by)
    }
    fn apart(a: f32, b: f32, period: f64) -> f32 {
        nearest(a - b, f32::of(period))
    }
}
