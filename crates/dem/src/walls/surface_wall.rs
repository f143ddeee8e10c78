//! A surface of a wall in a run: its shape, place, motion and material, and the load of the grains on it.
//!
//! The wall has infinite mass. The overlap is delta = R - d, with d the distance from the centre of the grain to the
//! surface. The normal points from the nearest point of the surface to the centre. The reduced mass is the mass of the grain.

use std::ops::AddAssign;

use serde::{Deserialize, Serialize};

use crate::particle::Species;
use crate::space::{Linear, Plane, Space};
use crate::walls::pose::Pose;
use crate::walls::surface::Surface;

/// A wall surface: a wall of the scene, or a triangle of one.
#[derive(Clone, Debug)]
pub struct SurfaceWall<V: Space = Plane> {
    /// Geometry.
    pub surface: Surface<V>,
    /// Number of the wall in the scene, from 0, without discs. The triangles of a polygon have one number.
    pub number: usize,
    /// Number of the surface within its wall, from 0. Images of a surface beyond periodic sides have its numbers.
    pub piece: u32,
    /// The point of the wall about which torques on it are measured, m; it moves with the wall. If the wall turns about its
    /// axis, the point is on the axis.
    pub reference: V,
    /// Velocity of the wall at the reference point, m/s; of a belt, along the wall.
    pub velocity: V,
    /// Angular velocity, rad/s.
    pub spin: V::Spin,
    /// The part of `velocity` and `spin` that is gained after the middle of the step, where contacts take velocities predicted for its end.
    /// `None` for a wall at a constant rate.
    pub gained: Option<Box<WallGain<V>>>,
    /// Material.
    pub species: Species,
    /// Number of the door that the wall belongs to: [`Door`](crate::particle::Door).
    pub door: Option<u16>,
    /// Whether the wall is present; a door that has opened is not.
    pub is_present: bool,
}

impl<V: Space> SurfaceWall<V> {
    /// Returns a wall at rest that is no door.
    #[must_use]
    pub fn still(surface: Surface<V>, species: Species) -> Self {
        Self {
            number: 0,
            piece: 0,
            reference: surface.shape().reference(),
            surface,
            velocity: V::ZERO,
            spin: V::Spin::ZERO,
            gained: None,
            species,
            door: None,
            is_present: true,
        }
    }

    /// Returns the image of the wall that is shifted by whole lengths of a periodic box, m.
    #[must_use]
    pub fn image(&self, shift: V) -> Self {
        let surface = self.surface.placed(&Pose::shifted(shift));
        Self { surface, reference: self.reference + shift, ..self.clone() }
    }

    /// Returns the velocity of the wall at one of its points, m/s.
    #[inline(always)]
    pub(crate) fn velocity_at(&self, point: impl FnOnce() -> V) -> V {
        if self.spin == V::Spin::ZERO {
            self.velocity
        } else {
            self.velocity + (point() - self.reference).turned_by(self.spin)
        }
    }

    /// Returns the part of [`Self::velocity_at`] that is [gained](Self::gained) after the middle of the step, m/s.
    #[inline(always)]
    pub(crate) fn gained_at(&self, point: impl FnOnce() -> V) -> Option<V> {
        let WallGain { velocity, spin } = **self.gained.as_ref()?;
        Some(velocity + (point() - self.reference).turned_by(spin))
    }
}

/// Gain of the motion of a wall in half a step.
#[derive(Clone, Copy, Debug, Default)]
pub struct WallGain<V: Space> {
    /// Gain of [`SurfaceWall::velocity`], m/s.
    pub velocity: V,
    /// Gain of [`SurfaceWall::spin`], rad/s.
    pub spin: V::Spin,
}

impl<V: Space> WallGain<V> {
    /// Whether nothing is gained.
    pub(super) fn is_zero(&self) -> bool {
        self.velocity == V::ZERO && self.spin == V::Spin::ZERO
    }
}

/// Load of the grains on a wall in the present step.
#[derive(Clone, Copy, Debug, Default, Deserialize, Serialize)]
#[serde(bound = "")]
pub struct WallLoad<V: Space> {
    /// Force on the wall, N.
    pub force: V,
    /// Dissipative part of the force, from normal and tangential dashpots, N.
    pub drag: V,
    /// Torque of the force about [`SurfaceWall::reference`], N m.
    pub torque: V::Spin,
    /// Torque of the dissipative part, N m.
    pub drag_torque: V::Spin,
}

impl<V: Space> WallLoad<V> {
    /// Returns the load of a force and its dissipative part, N, at the point `arm` (m) from the reference point.
    #[inline]
    pub(crate) fn of(force: V, drag: V, arm: V) -> Self {
        Self { force, drag, torque: arm.cross(force), drag_torque: arm.cross(drag) }
    }
}

impl<V: Space> AddAssign for WallLoad<V> {
    fn add_assign(&mut self, more: Self) {
        self.force += more.force;
        self.drag += more.drag;
        self.torque += more.torque;
        self.drag_torque += more.drag_torque;
    }
}
