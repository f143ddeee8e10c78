//! Lanes: numbers of many contacts side by side, so that one instruction works on several.

use std::ops::{Deref, DerefMut};

use crate::space::Linear;

/// Contacts in a batch. A multiple of every vector width; what friction with memory asks for in solid space, 25 kB, stays in a first
/// cache of 32, and with a scheme that looks ahead 30 kB.
pub const LANES: usize = 48;

/// One entry a lane. Aligned as cache lines are, so that no vector of lanes straddles two.
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

/// One number a lane.
pub type Scalars = PerLane<f64>;

/// The numbers of both of a contact.
#[inline(always)]
pub fn of_both(both: &[Scalars; 2], lane: usize) -> [f64; 2] {
    [both[0][lane], both[1][lane]]
}

/// One vector or spin a lane, component by component.
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

/// Four numbers a lane, side by side: they are written with half as many instructions as one by one, or a quarter.
pub type Quads = PerLane<[f64; 4]>;

/// Puts the numbers of the first `lanes` lanes where they belong.
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
    /// All numbers, axis by axis.
    #[inline(always)]
    pub fn axes(&mut self) -> [&mut Scalars; 3] {
        self.components.each_mut()
    }

    /// That of a lane.
    #[inline(always)]
    #[must_use]
    pub fn get(&self, lane: usize) -> T {
        T::from_components(
            #[inline(always)]
            |axis| self.components[axis][lane],
        )
    }

    /// Sets that of a lane.
    #[inline(always)]
    pub fn set(&mut self, lane: usize, value: T) {
        for axis in 0..T::COUNT {
            self.components[axis][lane] = value.component(axis);
        }
    }
}
