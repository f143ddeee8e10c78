//! Energies that contacts lose, J.

use std::ops::AddAssign;

use serde::{Deserialize, Serialize};

/// Energy lost in contacts in one step, J.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize, Serialize)]
pub struct ContactLosses {
    /// Lost to sliding.
    pub sliding: f64,
    /// Lost to rolling beyond the cap.
    pub rolling: f64,
    /// Lost to tangential dashpots, computed with the velocities that the force evaluation uses.
    pub dashpots: f64,
    /// Lost where contacts beyond touch break.
    pub breaking: f64,
}

/// Energies lost where a contact ends, J.
#[derive(Clone, Copy, Debug, Default)]
pub struct EndLosses {
    /// Lost with the tangential spring.
    pub sliding: f64,
    /// Lost with the rolling spring.
    pub rolling: f64,
    /// Lost by the normal force.
    pub breaking: f64,
}

impl ContactLosses {
    /// Adds the losses of a contact that has ended.
    #[inline]
    pub(crate) fn add(&mut self, ended: EndLosses) {
        self.sliding += ended.sliding;
        self.rolling += ended.rolling;
        self.breaking += ended.breaking;
    }
}

impl AddAssign for ContactLosses {
    fn add_assign(&mut self, more: Self) {
        self.sliding += more.sliding;
        self.rolling += more.rolling;
        self.dashpots += more.dashpots;
        self.breaking += more.breaking;
    }
}
