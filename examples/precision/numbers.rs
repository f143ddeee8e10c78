//! Number types for a discrete element method.

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
    #[expect(clippy::cast_possible_truncation, reason = "the rounding is the subject of this study")]
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

/// Returns the nearest image of a separation.
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

/// One coordinate of a position, m.
pub trait Place: Copy {
    /// Type of displacements.
    type Motion: Real;

    fn at(x: f64) -> Self;
    fn metres(self) -> f64;
    fn moved(self, by: Self::Motion) -> Self;
    /// Returns the coordinate moved by a period of the box.
    fn shifted(self, by: f64) -> Self;
    /// Returns the distance from `other` to this coordinate, to the nearest image, rounded to `F` at the end.
    fn apart<F: Real>(self, other: Self, period: f64) -> F;
}

impl<T: Real> Place for T {
    type Motion = T;

    fn at(x: f64) -> T {
        T::of(x)
    }
    fn metres(self) -> f64 {
        self.wide()
    }
    fn moved(self, by: T) -> T {
        self + by
    }
    fn shifted(self, by: f64) -> T {
        self + T::of(by)
    }
    fn apart<F: Real>(self, other: T, period: f64) -> F {
        F::of(nearest(self - other, T::of(period)).wide())
    }
}

/// Side of a cell, m: a power of two, so that a change of cell causes no rounding.
const CELL: f64 = 0.125;

/// The centre of a cell, and an offset of at most [`CELL`]/2 from it.
impl Place for (f64, f32) {
    type Motion = f32;

    fn at(x: f64) -> Self {
        let anchor = (x / CELL).round() * CELL;
        (anchor, f32::of(x - anchor))
    }
    fn metres(self) -> f64 {
        self.0 + self.1.wide()
    }
    fn moved(self, by: f32) -> Self {
        let offset = self.1 + by;
        if offset.abs() <= f32::of(0.5 * CELL) {
            return (self.0, offset);
        }
        let cells = (offset.wide() / CELL).round() * CELL;
        (self.0 + cells, offset - f32::of(cells))
    }
    fn shifted(self, by: f64) -> Self {
        (self.0 + by, self.1)
    }
    fn apart<F: Real>(self, other: Self, period: f64) -> F {
        F::of((f32::of(nearest(self.0 - other.0, period)) + (self.1 - other.1)).wide())
    }
}

/// The number types of a simulation.
pub trait Numbers {
    const NAME: &'static str;
    /// One coordinate of a position.
    type Place: Place<Motion = Self::Motion>;
    /// Velocities, accelerations, sums of forces and the time step.
    type Motion: Real;
    /// Separation, closing velocity and force of a pair.
    type Force: Real;
}

/// All numbers in f64.
pub struct Double;

impl Numbers for Double {
    const NAME: &'static str = "f64";
    type Place = f64;
    type Motion = f64;
    type Force = f64;
}

/// Separations and relative velocities are computed in f64 and rounded. Pair forces are computed in f32 and summed in
/// f64.
pub struct SingleForces;

impl Numbers for SingleForces {
    const NAME: &'static str = "f32 forces";
    type Place = f64;
    type Motion = f64;
    type Force = f32;
}

/// All numbers in f32. Positions are offsets from the centres of cells, and the centres are f64.
pub struct Anchored;

impl Numbers for Anchored {
    const NAME: &'static str = "f32 in cells";
    type Place = (f64, f32);
    type Motion = f32;
    type Force = f32;
}

/// All numbers in f32.
pub struct Single;

impl Numbers for Single {
    const NAME: &'static str = "f32";
    type Place = f32;
    type Motion = f32;
    type Force = f32;
}
