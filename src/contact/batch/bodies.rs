//! What a batch takes of the bodies of each pair, and what follows from that alone.
//!
//! What takes time here is storing. So numbers are taken side by side, by fours that an instruction loads, subtracts and stores
//! at once, and spread over the lanes when the batch is full: a transposition, four lanes at a time.

use crate::contact::LawRequirements;
use crate::contact::geometry::ContactLine;
use crate::contact::lanes::{LANES, Lanes, Quads, Scalars, spread};
use crate::instructions::Instructions;
use crate::periodic::Metric;
use crate::space::{COINCIDENT, PARTED, Space, quad};
use crate::store::Body;

/// The bodies of contacts i, j side by side; SI.
#[derive(Clone, Debug, Default)]
pub struct Bodies<V: Space> {
    /// As taken. In the plane: separation and relative velocity; radii and inverse masses. In solid space: separation and first
    /// component of the relative velocity; the rest of it and the radii, beside which there is no room for masses. Where it does
    /// not count which of the two is which: sums of radii and of inverse masses instead, in the plane by themselves.
    taken: [Quads; 2],
    /// From j to i, m.
    separation: Lanes<V>,
    /// From j to i.
    pub normal: Lanes<V>,
    /// m.
    pub overlap: Scalars,
    pub relative_velocity: Lanes<V>,
    pub reduced_mass: Scalars,
    /// Its root, where the law takes it; else 0.
    pub root: Scalars,
    /// The sum of the radii.
    pub reach: Scalars,
    /// Its inverse, where the law demands radii; else 0.
    pub inverse_reach: Scalars,
    /// The sum of the inverse masses.
    mobility: Scalars,
    /// Where it counts which is which.
    pub radii: [Scalars; 2],
    /// Where the scheme looks ahead.
    pub inverse_masses: [Scalars; 2],
}

impl<V: Space> Bodies<V> {
    /// Takes two into a lane; gives the square of their distance, m^2, and the sum of their radii, m.
    #[inline(always)]
    pub fn take<L: LawRequirements>(
        &mut self,
        lane: usize,
        metric: &impl Metric<V>,
        [i, j]: [&Body<V>; 2],
    ) -> (f64, f64) {
        let [one, two] = &mut self.taken;
        let (x, v) = (|body: &Body<V>, axis| body.position.axis(axis), |body: &Body<V>, axis| body.velocity.axis(axis));
        // Side by side, so one instruction adds both.
        let [reach, mobility] = [i.radius + j.radius, i.inverse_mass + j.inverse_mass];
        let squared = if V::COMPONENTS == 2 {
            let state = |body| [x(body, 0), x(body, 1), v(body, 0), v(body, 1)];
            let (i_state, j_state) = (state(i), state(j));
            let apart = metric.shorten(quad(|axis| i_state[axis] - j_state[axis]));
            one[lane] = apart;
            if L::NUMBERS {
                two[lane] = [i.radius, i.inverse_mass, j.radius, j.inverse_mass];
            } else {
                // What lies beside them nobody reads: a store less.
                (two[lane][0], two[lane][1]) = (reach, mobility);
            }
            apart[0] * apart[0] + apart[1] * apart[1]
        } else {
            let state = |body| [x(body, 0), x(body, 1), x(body, 2), v(body, 0)];
            let (i_state, j_state) = (state(i), state(j));
            let apart = metric.shorten(quad(|axis| i_state[axis] - j_state[axis]));
            one[lane] = apart;
            let [vy, vz] = [v(i, 1) - v(j, 1), v(i, 2) - v(j, 2)];
            if L::NUMBERS {
                two[lane] = [vy, vz, i.radius, j.radius];
                self.mobility[lane] = mobility;
            } else {
                two[lane] = [vy, vz, reach, mobility];
            }
            if L::PREDICTION {
                (self.inverse_masses[0][lane], self.inverse_masses[1][lane]) = (i.inverse_mass, j.inverse_mass);
            }
            apart[0] * apart[0] + apart[1] * apart[1] + apart[2] * apart[2]
        };
        (squared, reach)
    }

    /// Spreads what was taken over so many lanes.
    #[inline(always)]
    fn spread<L: LawRequirements>(&mut self, lanes: usize) {
        let ([one, two], [m_i, m_j]) = (&self.taken, self.inverse_masses.each_mut());
        let ([x, y, z], [vx, vy, vz]) = (self.separation.axes(), self.relative_velocity.axes());
        let ([r_i, r_j], reach, mobility) = (self.radii.each_mut(), &mut self.reach, &mut self.mobility);
        match (V::COMPONENTS, L::NUMBERS) {
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
        if L::NUMBERS {
            for lane in 0..lanes.min(LANES) {
                reach[lane] = r_i[lane] + r_j[lane];
                if V::COMPONENTS == 2 {
                    mobility[lane] = m_i[lane] + m_j[lane];
                }
            }
        }
    }

    /// Finds what follows from separations and masses; gives how many distances are nothing.
    #[inline(always)]
    fn measure_all<L: LawRequirements>(&mut self, lanes: usize, root: bool) -> u32 {
        let mut coincident = 0;
        for lane in 0..lanes.min(LANES) {
            let separation = self.separation.get(lane);
            let line = ContactLine::new(separation, self.mobility[lane]);
            self.normal.set(lane, line.normal);
            self.overlap[lane] = self.reach[lane] - line.distance;
            self.reduced_mass[lane] = line.reduced_mass;
            if L::RADII {
                // Here, where nothing waits for it.
                self.inverse_reach[lane] = 1.0 / self.reach[lane];
            }
            coincident += u32::from(separation.length_squared() < COINCIDENT);
        }
        if root {
            for lane in 0..lanes.min(LANES) {
                self.root[lane] = self.reduced_mass[lane].sqrt();
            }
        }
        coincident
    }

    /// Spreads what was taken over so many lanes, and measures, the root of the reduced mass too if it is asked for. Tells
    /// whether any distance may be nothing.
    pub fn measure<L: LawRequirements>(&mut self, lanes: usize, root: bool, instructions: Instructions) -> bool {
        let coincident = instructions.run(
            #[inline(always)]
            || {
                self.spread::<L>(lanes);
                self.measure_all::<L>(lanes, root)
            },
        );
        coincident > 0
    }

    /// Gives coincident centres a normal: a separation so near to nothing that the overlap stays what it is. `normal` gives
    /// that of a lane.
    #[cold]
    pub fn part_coincident<L: LawRequirements>(&mut self, lanes: usize, normal: impl Fn(usize) -> V) {
        for lane in 0..lanes {
            if self.separation.get(lane).length_squared() < COINCIDENT {
                self.separation.set(lane, normal(lane) * PARTED);
            }
        }
        self.measure_all::<L>(lanes, false);
    }
}

#[cfg(test)]
#[expect(clippy::float_cmp, reason = "exact values")]
mod tests {
    use super::*;
    use crate::periodic::Open;
    use crate::space::{Plane, Solid};

    /// Bodies of unlike numbers, apart by what has its components padded with zeros.
    fn everything_arrives<V: Space, L: LawRequirements>() {
        let body = |lane: usize, side: usize| {
            let number = |what: usize| f64::from(u32::try_from(1000 * side + 10 * lane + what).unwrap());
            let at = |from: usize| V::narrow(Solid::new(number(from), number(from + 1), -number(from + 2)));
            Body { position: at(1), velocity: at(4), radius: number(7), inverse_mass: number(8) }
        };
        for instructions in Instructions::all() {
            let mut bodies = Bodies::<V>::default();
            for lane in 0..LANES {
                let [i, j] = [body(lane, 0), body(lane, 1)];
                let separation = i.position - j.position;
                let measured = (separation.length_squared(), i.radius + j.radius);
                assert_eq!(bodies.take::<L>(lane, &Open, [&i, &j]), measured);
            }
            assert!(!bodies.measure::<L>(LANES, true, instructions));
            for lane in 0..LANES {
                let [i, j] = [body(lane, 0), body(lane, 1)];
                let separation = i.position - j.position;
                assert_eq!(bodies.relative_velocity.get(lane), i.velocity - j.velocity);
                // The inverse root is right to one eps, and up to five roundings follow, of half an eps each.
                let error = 4.0 * f64::EPSILON;
                assert!(bodies.normal.get(lane).distance(separation * (1.0 / separation.length())) < error);
                let reduced_mass = 1.0 / (i.inverse_mass + j.inverse_mass);
                assert!((bodies.reduced_mass[lane] / reduced_mass - 1.0).abs() < error);
                assert!((bodies.root[lane] / reduced_mass.sqrt() - 1.0).abs() < error);
                let overlap = i.radius + j.radius - separation.length();
                assert!((bodies.overlap[lane] - overlap).abs() < error * separation.length());
                if L::RADII {
                    assert!((bodies.inverse_reach[lane] * (i.radius + j.radius) - 1.0).abs() < error);
                }
                if L::NUMBERS {
                    assert_eq!(bodies.radii.map(|radii| radii[lane]), [i.radius, j.radius]);
                }
                if L::PREDICTION {
                    assert_eq!(bodies.inverse_masses.map(|masses| masses[lane]), [i.inverse_mass, j.inverse_mass]);
                }
            }
        }
    }

    /// Without regard to which of the two is which, and with.
    struct Together;
    struct Each;
    struct Foresighted;

    impl LawRequirements for Together {
        const RADII: bool = false;
    }
    impl LawRequirements for Each {}
    impl LawRequirements for Foresighted {
        const PREDICTION: bool = true;
    }

    #[test]
    fn what_is_taken_arrives_in_its_lane() {
        everything_arrives::<Plane, Together>();
        everything_arrives::<Solid, Together>();
        everything_arrives::<Plane, Each>();
        everything_arrives::<Solid, Each>();
        everything_arrives::<Plane, Foresighted>();
        everything_arrives::<Solid, Foresighted>();
    }
}
