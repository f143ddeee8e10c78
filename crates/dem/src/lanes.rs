//! Lanes: numbers of many contacts, or of many bodies, side by side, so that one vector instruction processes several of them.

use std::ops::{Deref, DerefMut};

use crate::space::{Linear, Rotor, Space, quad};

/// Contacts in a batch, or bodies: a multiple of every vector width. The largest batch fits into an L1 cache of 32 kB: friction
/// with memory in solid space takes 25 kB, and 30 kB with velocity prediction.
pub const LANES: usize = 48;

/// One entry per lane. Aligned to cache lines, so that no vector of lanes straddles two of them.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
pub struct PerLane<T>([T; LANES]);

impl<T: Copy + Default> Default for PerLane<T> {
    fn default() -> Self {
        Self([T::default(); LANES])
    }
}

impl<T> Deref for PerLane<T> {
    type Target = [T; LANES];

    #[inline(always)]
    fn deref(&self) -> &[T; LANES] {
        &self.0
    }
}

impl<T> DerefMut for PerLane<T> {
    #[inline(always)]
    fn deref_mut(&mut self) -> &mut [T; LANES] {
        &mut self.0
    }
}

/// One number per lane.
pub type Scalars = PerLane<f64>;

/// Returns the numbers of both particles of the contact in a lane.
#[inline(always)]
pub fn of_both(both: &[Scalars; 2], lane: usize) -> [f64; 2] {
    [both[0][lane], both[1][lane]]
}

/// Returns the smaller number, or `b` if one is a NaN: one vector instruction, where `f64::min` takes three.
#[inline(always)]
#[must_use]
pub fn smaller(a: f64, b: f64) -> f64 {
    if a < b { a } else { b }
}

/// Returns the larger number, or `b` if one is a NaN: one vector instruction, where `f64::max` takes three.
#[inline(always)]
#[must_use]
pub fn larger(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}

/// One vector or spin per lane, stored component by component.
#[derive(Clone, Debug)]
pub struct Lanes<T> {
    components: [Scalars; 3],
    kind: std::marker::PhantomData<T>,
}

impl<T> Default for Lanes<T> {
    fn default() -> Self {
        Self { components: Default::default(), kind: std::marker::PhantomData }
    }
}

/// Four numbers per lane, side by side. Writing them takes a half or a quarter of the instructions of single writes.
pub type Quads = PerLane<[f64; 4]>;

/// Transposes the first `lanes` lanes of `quads` into four arrays.
#[inline(always)]
pub fn spread(
    quads: &Quads,
    lanes: usize,
    first: &mut Scalars,
    second: &mut Scalars,
    third: &mut Scalars,
    fourth: &mut Scalars,
) {
    for lane in 0..lanes.min(LANES) {
        [first[lane], second[lane], third[lane], fourth[lane]] = quads[lane];
    }
}

impl<T: Linear> Lanes<T> {
    /// Returns the arrays of all components, axis by axis.
    #[inline(always)]
    pub fn axes(&mut self) -> [&mut Scalars; 3] {
        self.components.each_mut()
    }

    /// Returns the vector of a lane.
    #[inline(always)]
    #[must_use]
    pub fn get(&self, lane: usize) -> T {
        T::from_components(
            #[inline(always)]
            |axis| self.components[axis][lane],
        )
    }

    /// Sets the vector of a lane.
    #[inline(always)]
    pub fn set(&mut self, lane: usize, value: T) {
        for axis in 0..T::COUNT {
            self.components[axis][lane] = value.component(axis);
        }
    }
}

/// One orientation per lane, stored number by number.
#[derive(Clone, Debug)]
pub struct RotorLanes<V: Space> {
    numbers: [Scalars; 4],
    kind: std::marker::PhantomData<V::Rotor>,
}

impl<V: Space> Default for RotorLanes<V> {
    fn default() -> Self {
        Self { numbers: Default::default(), kind: std::marker::PhantomData }
    }
}

impl<V: Space> RotorLanes<V> {
    /// Returns the orientation of a lane.
    #[inline(always)]
    #[must_use]
    pub fn get(&self, lane: usize) -> V::Rotor {
        V::Rotor::of_numbers(quad(
            #[inline(always)]
            |number| self.numbers[number][lane],
        ))
    }

    /// Sets the orientation of a lane.
    #[inline(always)]
    pub fn set(&mut self, lane: usize, rotor: V::Rotor) {
        for (lanes, number) in self.numbers.iter_mut().zip(rotor.numbers()).take(V::Rotor::NUMBERS) {
            lanes[lane] = number;
        }
    }
}

#[cfg(test)]
#[expect(clippy::float_cmp, reason = "exact values")]
mod tests {
    use super::*;

    #[test]
    fn a_nan_gives_the_second_number() {
        assert_eq!([smaller(1.0, 2.0), smaller(2.0, 1.0), smaller(f64::NAN, 1.0)], [1.0, 1.0, 1.0]);
        assert_eq!([larger(1.0, 2.0), larger(2.0, 1.0), larger(f64::NAN, 1.0)], [2.0, 2.0, 1.0]);
    }
}
