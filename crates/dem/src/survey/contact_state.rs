//! The state of one contact for measurements and pictures.

use serde::{Deserialize, Serialize};

use crate::contact::memory::Memory;
use crate::particle::GrainId;
use crate::space::{Plane, Space};

/// Partner of a grain in a contact.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Deserialize, Serialize)]
pub enum Touched {
    /// A grain or a wall grain.
    Particle(GrainId),
    /// A wall surface, by its number in the scene, counted from 1 without discs.
    Wall(usize),
}

/// State of one contact, SI.
#[derive(Clone, Copy, Debug)]
pub struct ContactState<V: Space = Plane> {
    /// The grain from which the contact is seen.
    pub grain: GrainId,
    /// Number of the sphere of the grain that touches; 0 if the grain is one sphere.
    pub sphere: u16,
    /// Its partner.
    pub with: Touched,
    /// Number of the sphere of the partner that touches; 0 for walls and for particles that are one sphere.
    pub partner_sphere: u16,
    /// Centre of the grain, m.
    pub from: V,
    /// Vector from the centre of the grain to the centre of the partner, or to the nearest point of the wall, m.
    pub to_partner: V,
    /// Overlap, m.
    pub overlap: f64,
    /// Unit vector from the partner to the grain.
    pub normal: V,
    /// Normal force, N; positive if repulsive.
    pub normal_force: f64,
    /// Friction on the grain, N.
    pub friction: V,
    /// |F_t| over mu |F_n|, from 0 to 1; 0 without friction.
    pub mobilised: f64,
    /// Whether friction is at its cap.
    pub is_sliding: bool,
    /// Memory of the contact.
    pub memory: Memory,
}
