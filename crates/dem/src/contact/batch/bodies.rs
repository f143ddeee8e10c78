//! The bodies of the pairs of a batch, and the contact quantities that follow from bodies alone.
//!
//! Stores dominate the run time here. So numbers are loaded, subtracted and stored in groups of four, one vector
//! instruction each. When the batch is full, they are transposed into the lanes, four lanes at a time.

use crate::contact::geometry::ContactLine;
use crate::contact::needs::BodyNumbers;
use crate::instruction_set::InstructionSet;
use crate::lanes::{LANES, Lanes, Quads, Scalars, spread};
use crate::periodic::Metric;
use crate::space::{COINCIDENT, PARTED, Space, quad};
use crate::store::Body;

/// The bodies of contacts i, j side by side; SI units.
#[derive(Clone, Debug, Default)]
pub struct Bodies<V: Space> {
    /// Numbers as loaded, before the transposition.
    ///
    /// In the plane: separation and relative velocity; then radii and inverse masses. In solid space: separation and
    /// first component of the relative velocity; then its other components and the radii. The inverse masses do not fit
    /// there and are kept apart. With [`BodyNumbers::Sums`] there are sums of radii and of inverse masses
    /// instead; in the plane these two sums are stored alone.
    loaded: [Quads; 2],
    /// From j to i, m.
    separation: Lanes<V>,
    /// Unit vector from j to i.
    pub normal: Lanes<V>,
    /// Overlap, m.
    pub overlap: Scalars,
    pub relative_velocity: Lanes<V>,
    pub reduced_mass: Scalars,
    /// Root of the reduced mass if the law needs it, else 0.
    pub mass_root: Scalars,
    /// Sum of the radii, m.
    pub reach: Scalars,
    /// Inverse of `reach`, 1/m, if the law requires radii, else 0.
    pub inverse_reach: Scalars,
    /// Sum of the inverse masses, 1/kg.
    mobility: Scalars,
    /// Radii of i and j, m; not set with [`BodyNumbers::Sums`].
    pub radii: [Scalars; 2],
    /// Inverse masses of i and j, 1/kg; set in the plane alone, and not with [`BodyNumbers::Sums`].
    inverse_masses: [Scalars; 2],
}

/// The numbers that decide whether a pair is a contact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Approach {
    /// Square of the distance of the centres, m^2.
    pub(super) squared: f64,
    /// Sum of the radii, m.
    pub(super) reach: f64,
}

impl<V: Space> Bodies<V> {
    /// Loads two bodies into a lane: numbers of each body if `INDIVIDUAL` is set, else sums.
    #[inline(always)]
    pub(super) fn take<const INDIVIDUAL: bool>(
        &mut self,
        lane: usize,
        metric: &impl Metric<V>,
        [i, j]: [&Body<V>; 2],
    ) -> Approach {
        let [one, two] = &mut self.loaded;
        let x = |body: &Body<V>, axis| body.position.axis(axis);
        let v = |body: &Body<V>, axis| body.velocity.axis(axis);
        // Side by side, so that one instruction adds both.
        let [reach, mobility] = [i.radius + j.radius, i.inverse_mass + j.inverse_mass];
        if V::COMPONENTS == 2 {
            let state = |body| [x(body, 0), x(body, 1), v(body, 0), v(body, 1)];
            let i_state = state(i);
            let j_state = state(j);
            let apart = metric.shorten(quad(|axis| i_state[axis] - j_state[axis]));
            one[lane] = apart;
            if INDIVIDUAL {
                two[lane] = [i.radius, i.inverse_mass, j.radius, j.inverse_mass];
            } else {
                // The other two numbers are never read: skipping them saves a store.
                (two[lane][0], two[lane][1]) = (reach, mobility);
            }
            let squares = quad(|axis| apart[axis] * apart[axis]);
            Approach { squared: squares[0] + squares[1], reach }
        } else {
            let state = |body| [x(body, 0), x(body, 1), x(body, 2), v(body, 0)];
            let i_state = state(i);
            let j_state = state(j);
            let apart = metric.shorten(quad(|axis| i_state[axis] - j_state[axis]));
            one[lane] = apart;
            let [vy, vz] = [v(i, 1) - v(j, 1), v(i, 2) - v(j, 2)];
            if INDIVIDUAL {
                two[lane] = [vy, vz, i.radius, j.radius];
                self.mobility[lane] = mobility;
            } else {
                two[lane] = [vy, vz, reach, mobility];
            }
            // Three of each four are needed, but one vector instruction makes all four.
            let squares = quad(|axis| apart[axis] * apart[axis]);
            Approach { squared: squares[0] + squares[1] + squares[2], reach }
        }
    }

    /// Transposes the loaded numbers of the first `lanes` lanes.
    #[inline(always)]
    fn spread<const INDIVIDUAL: bool>(&mut self, lanes: usize) {
        let [one, two] = &self.loaded;
        let [m_i, m_j] = self.inverse_masses.each_mut();
        let [x, y, z] = self.separation.axes();
        let [vx, vy, vz] = self.relative_velocity.axes();
        let [r_i, r_j] = self.radii.each_mut();
        let reach = &mut self.reach;
        let mobility = &mut self.mobility;
        match (V::COMPONENTS, INDIVIDUAL) {
            (2, true) => {
                spread(one, lanes, x, y, vx, vy);
                spread(two, lanes, r_i, m_i, r_j, m_j);
            }
            (2, false) => {
                spread(one, lanes, x, y, vx, vy);
                for lane in 0..lanes.min(LANES) {
                    [reach[lane], mobility[lane], ..] = two[lane];
                }
            }
            (_, true) => {
                spread(one, lanes, x, y, z, vx);
                spread(two, lanes, vy, vz, r_i, r_j);
            }
            (_, false) => {
                spread(one, lanes, x, y, z, vx);
                spread(two, lanes, vy, vz, reach, mobility);
            }
        }
        if INDIVIDUAL {
            for lane in 0..lanes.min(LANES) {
                reach[lane] = r_i[lane] + r_j[lane];
                if V::COMPONENTS == 2 {
                    mobility[lane] = m_i[lane] + m_j[lane];
                }
            }
        }
    }

    /// Computes the contact quantities from separations and masses, with [`Self::inverse_reach`] if `RADII` is set. Returns the number of
    /// coincident centres.
    #[inline(always)]
    fn compute_lanes<const RADII: bool>(&mut self, lanes: usize, mass_root: bool) -> u32 {
        let mut coincident = 0;
        for lane in 0..lanes.min(LANES) {
            let separation = self.separation.get(lane);
            let line = ContactLine::new(separation, self.mobility[lane]);
            self.normal.set(lane, line.normal);
            self.overlap[lane] = self.reach[lane] - line.distance;
            self.reduced_mass[lane] = line.reduced_mass;
            if RADII {
                // The division runs here, where no other instruction depends on it.
                self.inverse_reach[lane] = 1.0 / self.reach[lane];
            }
            coincident += u32::from(separation.length_squared() < COINCIDENT);
        }
        if mass_root {
            for lane in 0..lanes.min(LANES) {
                self.mass_root[lane] = self.reduced_mass[lane].sqrt();
            }
        }
        coincident
    }

    /// Transposes the first `lanes` lanes and computes their contact quantities, with the root of the reduced mass if
    /// `mass_root` is set. Returns whether any centres may coincide.
    pub fn measure(
        &mut self,
        lanes: usize,
        numbers: BodyNumbers,
        mass_root: bool,
        instructions: InstructionSet,
    ) -> bool {
        match numbers {
            BodyNumbers::Sums => self.measure_by::<false, false>(lanes, mass_root, instructions),
            BodyNumbers::Each => self.measure_by::<true, false>(lanes, mass_root, instructions),
            BodyNumbers::EachWithRadii => self.measure_by::<true, true>(lanes, mass_root, instructions),
        }
    }

    fn measure_by<const INDIVIDUAL: bool, const RADII: bool>(
        &mut self,
        lanes: usize,
        mass_root: bool,
        instructions: InstructionSet,
    ) -> bool {
        let coincident = instructions.run(
            #[inline(always)]
            || {
                self.spread::<INDIVIDUAL>(lanes);
                self.compute_lanes::<RADII>(lanes, mass_root)
            },
        );
        coincident > 0
    }

    /// Gives coincident centres the direction that `normal` returns for their lane. The separation along it is so small
    /// that the overlap does not change.
    #[cold]
    pub fn part_coincident(&mut self, lanes: usize, normal: impl Fn(usize) -> V) {
        for lane in 0..lanes {
            if self.separation.get(lane).length_squared() < COINCIDENT {
                self.separation.set(lane, normal(lane) * PARTED);
            }
        }
        self.compute_lanes::<true>(lanes, false);
    }
}

#[cfg(test)]
#[expect(clippy::float_cmp, reason = "exact values")]
mod tests {
    use super::*;
    use crate::periodic::Open;
    use crate::space::{Plane, Solid};

    /// Loads bodies with distinct numbers and checks that every number arrives in its lane.
    fn check_loading<V: Space>(numbers: BodyNumbers) {
        let body = |lane: usize, side: usize| {
            let number = |index: usize| f64::from(u32::try_from(1000 * side + 10 * lane + index).unwrap());
            let at = |from: usize| V::narrow(Solid::new(number(from), number(from + 1), -number(from + 2)));
            Body {
                position: at(1),
                velocity: at(4),
                radius: number(7),
                inverse_mass: number(8),
                middle: V::MiddleInBody::default(),
            }
        };
        for instructions in InstructionSet::all() {
            let mut bodies = Bodies::<V>::default();
            for lane in 0..LANES {
                let [i, j] = [body(lane, 0), body(lane, 1)];
                let separation = i.position - j.position;
                let measured = Approach { squared: separation.length_squared(), reach: i.radius + j.radius };
                let taken = if numbers == BodyNumbers::Sums {
                    bodies.take::<false>(lane, &Open, [&i, &j])
                } else {
                    bodies.take::<true>(lane, &Open, [&i, &j])
                };
                assert_eq!(taken, measured);
            }
            assert!(!bodies.measure(LANES, numbers, true, instructions));
            for lane in 0..LANES {
                let [i, j] = [body(lane, 0), body(lane, 1)];
                let separation = i.position - j.position;
                assert_eq!(bodies.relative_velocity.get(lane), i.velocity - j.velocity);
                // The inverse root is accurate to one eps. Up to five roundings of half an eps each follow.
                let error = 4.0 * f64::EPSILON;
                assert!(bodies.normal.get(lane).distance(separation * (1.0 / separation.length())) < error);
                let reduced_mass = 1.0 / (i.inverse_mass + j.inverse_mass);
                assert!((bodies.reduced_mass[lane] / reduced_mass - 1.0).abs() < error);
                assert!((bodies.mass_root[lane] / reduced_mass.sqrt() - 1.0).abs() < error);
                let overlap = i.radius + j.radius - separation.length();
                assert!((bodies.overlap[lane] - overlap).abs() < error * separation.length());
                if numbers == BodyNumbers::EachWithRadii {
                    assert!((bodies.inverse_reach[lane] * (i.radius + j.radius) - 1.0).abs() < error);
                }
                if numbers != BodyNumbers::Sums {
                    assert_eq!(bodies.radii.map(|radii| radii[lane]), [i.radius, j.radius]);
                }
            }
        }
    }

    #[test]
    fn loaded_numbers_arrive_in_their_lane() {
        for numbers in [BodyNumbers::Sums, BodyNumbers::Each, BodyNumbers::EachWithRadii] {
            check_loading::<Plane>(numbers);
            check_loading::<Solid>(numbers);
        }
    }
}
