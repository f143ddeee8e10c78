//! The input of a contact law: two bodies that touch, seen from one of them.

use crate::particle::Species;
use crate::space::{Plane, Space};

/// A touching pair, seen from the side of i: the input of a contact law.
#[derive(Clone, Copy, Debug)]
pub struct Pair<V: Space = Plane> {
    /// Unit vector from j to i.
    pub normal: V,
    /// Overlap, m, positive. Centred laws also get gaps, as negative overlaps.
    pub overlap: f64,
    /// v_i - v_j of the centres, m/s.
    pub relative_velocity: V,
    /// m_i m_j/(m_i + m_j), kg. Against a fixed partner it is m_i.
    pub reduced_mass: f64,
    /// sqrt(reduced mass), kg^(1/2). May be zero unless the law asks for it
    /// ([`needs_mass_root`](crate::contact::law::PairLaw::needs_mass_root)).
    pub mass_root: f64,
    /// R_i and R_j, m. R_j is infinite for a wall surface. May be zero unless the law requires radii.
    pub radii: [f64; 2],
    /// 1/(R_i + R_j), 1/m; for a wall surface of mean curvature H, H/(1 + R_i H). May be zero unless the law requires
    /// radii.
    pub inverse_reach: f64,
    /// Spins of i and j, rad/s; zero unless the law requires spins.
    pub spins: [V::Spin; 2],
    /// Species of i and j; both are species 0 unless the law requires species.
    pub species: [Species; 2],
    /// Time by which the law advances the memory in this evaluation, s: the step, or 0 if the evaluation must not
    /// advance it.
    pub dt: f64,
    /// Time by which the springs of the memory are ahead of the evaluation, s: half a step with contacts under the scheme `Centred`
    /// whose springs advance with predicted velocities, else 0.
    pub springs_ahead: f64,
    /// The velocities with which springs advance, if they differ from those of the pair.
    pub gathered: Option<Gathered<V>>,
    /// Velocity changes until the end of the step, for [`centred`](crate::contact::law::PairLaw::centred); else zero.
    pub ahead: VelocityPrediction<V>,
}

/// The times by which an evaluation treats memories, s; see [`Pair`].
#[derive(Clone, Copy, Debug, Default)]
pub struct MemoryTimes {
    /// [`Pair::dt`].
    pub dt: f64,
    /// [`Pair::springs_ahead`].
    pub springs_ahead: f64,
}

/// Velocities of a pair in the middle of the step. Springs that advance with them have exactly the stretch that positions have.
#[derive(Clone, Copy, Debug)]
pub struct Gathered<V: Space = Plane> {
    /// v_i - v_j of the centres, m/s.
    pub relative_velocity: V,
    /// Spins of i and j, rad/s.
    pub spins: [V::Spin; 2],
}

impl<V: Space> Pair<V> {
    /// Returns the pair as seen from j, without the velocity prediction.
    #[must_use]
    pub fn seen_from_partner(&self) -> Self {
        let swapped = |[i, j]: [f64; 2]| [j, i];
        Self {
            normal: -self.normal,
            relative_velocity: -self.relative_velocity,
            radii: swapped(self.radii),
            spins: [self.spins[1], self.spins[0]],
            species: [self.species[1], self.species[0]],
            gathered: self.gathered.map(|Gathered { relative_velocity, spins: [i, j] }| Gathered {
                relative_velocity: -relative_velocity,
                spins: [j, i],
            }),
            ahead: VelocityPrediction::default(),
            ..*self
        }
    }

    /// Returns the pair with the velocities with which springs advance.
    #[inline(always)]
    #[must_use]
    pub fn gathering(&self) -> Self {
        match self.gathered {
            Some(Gathered { relative_velocity, spins }) => Self { relative_velocity, spins, ..*self },
            None => *self,
        }
    }

    /// Returns whether velocities are predicted for the end of the step ([`centred`](crate::contact::centred)).
    #[inline(always)]
    #[must_use]
    pub fn is_predicted(&self) -> bool {
        self.springs_ahead > 0.0 || self.gathered.is_some()
    }

    /// Returns R_i R_j/(R_i + R_j), m; R_i/(1 + R_i H) against a wall surface of mean curvature H.
    #[inline(always)]
    #[must_use]
    pub fn reduced_radius(&self) -> f64 {
        let [i, j] = self.radii;
        if j.is_infinite() { i * (1.0 - i * self.inverse_reach) } else { i * j * self.inverse_reach }
    }

    /// Returns (v_i - v_j).n, m/s: negative while i and j approach.
    #[inline(always)]
    #[must_use]
    pub fn normal_velocity(&self) -> f64 {
        self.relative_velocity.dot(self.normal)
    }

    /// Returns the relative velocity of the surfaces in the tangent plane, m/s: v_ij - v_n n - (l_i w_i + l_j w_j) x n.
    /// `arms` are the distances l from the centres to the contact, m.
    #[inline(always)]
    #[must_use]
    pub fn sliding_velocity(&self, arms: [f64; 2]) -> V {
        let turning = self.spins[0] * arms[0] + self.spins[1] * arms[1];
        self.relative_velocity - self.normal * self.normal_velocity() - self.normal.turned_by(turning)
    }
}

/// Velocity prediction of a pair: velocity gains until the end of the step if the forces at its beginning persist. Seen
/// from the side of i.
#[derive(Clone, Copy, Debug, Default)]
pub struct VelocityPrediction<V: Space = Plane> {
    /// dt/2 (a_i - a_j), m/s.
    pub velocity: V,
    /// dt/2 times the angular accelerations of i and j, rad/s.
    pub spins: [V::Spin; 2],
    /// 1/m of i and j, 1/kg: 0 for a fixed particle or wall.
    pub inverse_masses: [f64; 2],
    /// 1/I of i and j, 1/(kg m^2): 0 for a fixed particle or wall.
    pub inverse_inertias: [f64; 2],
    /// For i and for j: 1 if it is lone, else 0.
    pub lone: [f64; 2],
    /// Additions of rigid bodies of several spheres to these numbers; zero for spheres.
    pub beside: BesideSpheres<V>,
}

/// Changes of motion by a momentum at a contact of rigid bodies of several spheres, beyond those of spheres. The momentum turns the bodies about their
/// centres of mass, so that one along the normal changes the sliding velocity, and one along the tangent plane the closing speed.
#[derive(Clone, Copy, Debug, Default)]
pub struct BesideSpheres<V: Space = Plane> {
    /// Change of the relative velocity of the spheres' centres, by the turn of i and by that of j, per momentum along the normal on i, 1/kg.
    pub velocities: [V; 2],
    /// Change of the spins of i and j per momentum along the normal on i, 1/(kg m).
    pub spins: [V::Spin; 2],
    /// The mobility of i and of j along the sliding velocity, without that of a sphere, 1/m + l^2/I, 1/kg.
    pub mobilities: [f64; 2],
}

impl<V: Space> VelocityPrediction<V> {
    /// Returns the change of the closing speed per momentum transferred along the normal, 1/kg, summed only over lone grains.
    #[inline(always)]
    pub(super) fn lone_mobility(&self) -> f64 {
        self.lone[0] * self.inverse_masses[0] + self.lone[1] * self.inverse_masses[1]
    }
}

impl<V: Space> Pair<V> {
    /// Returns the pair with the velocities predicted for the end of the step.
    #[inline(always)]
    #[must_use]
    pub fn predicted(&self) -> Self {
        let mut pair = *self;
        pair.relative_velocity += self.ahead.velocity;
        pair.spins[0] += self.ahead.spins[0];
        pair.spins[1] += self.ahead.spins[1];
        pair
    }

    /// Returns what `velocity` makes of the changes of velocities and spins per momentum along the normal, 1/kg: those of i and j, then only
    /// of lone grains.
    #[inline(always)]
    #[must_use]
    pub fn pushed<T>(&self, velocity: impl Fn(&Self) -> T) -> [T; 2] {
        let BesideSpheres { velocities: [v_i, v_j], spins: [w_i, w_j], .. } = self.ahead.beside;
        [[1.0; 2], self.ahead.lone]
            .map(|[i, j]| velocity(&Self { relative_velocity: v_i * i + v_j * j, spins: [w_i * i, w_j * j], ..*self }))
    }

    /// Returns the pair with another overlap, m; a negative `overlap` is replaced by 0.
    #[inline(always)]
    #[must_use]
    pub fn at_overlap(&self, overlap: f64) -> Self {
        Self { overlap: overlap.max(0.0), ..*self }
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::space::Vector;

    /// Returns two equal grains of radius 4 cm that touch along x, at rest.
    pub(crate) fn pair() -> Pair {
        Pair {
            normal: Vector::X,
            overlap: 1e-3,
            relative_velocity: Vector::ZERO,
            reduced_mass: 0.1,
            mass_root: 0.1f64.sqrt(),
            radii: [0.04, 0.04],
            inverse_reach: 1.0 / 0.08,
            spins: [0.0, 0.0],
            species: [Species(0); 2],
            dt: 1e-4,
            springs_ahead: 0.0,
            gathered: None,
            ahead: VelocityPrediction::default(),
        }
    }
}
