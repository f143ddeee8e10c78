//! What a batch takes of the bodies of each pair, and what follows from that alone.
//!
//! What takes time here is storing. So numbers are taken side by side, by fours that an instruction loads, subtracts and stores
//! at once, and spread over the lanes when the batch is full: a transposition, four lanes at a time.

use crate::columns::Body;
use crate::contact::lanes::{LANES, Lanes, Quads, Scalars, quad, spread};
use crate::instructions::Instructions;
use crate::periodic::Metric;
use crate::space::Space;

/// The bodies of contacts i, j side by side; SI.
#[derive(Clone, Debug, Default)]
pub struct Bodies<V: Space> {
    /// As taken: in the plane separation and relative velocity; radii and inverse masses. In solid space separation and
    /// first component of the velocity; what else is held of the first; and of the second.
    taken: [Quads; 3],
    /// From j to i, m.
    separation: Lanes<V>,
    distance: Scalars,
    /// From j to i.
    pub normal: Lanes<V>,
    /// m.
    pub overlap: Scalars,
    pub relative_velocity: Lanes<V>,
    pub reduced_mass: Scalars,
    pub radii: [Scalars; 2],
    pub inverse_masses: [Scalars; 2],
}

impl<V: Space> Bodies<V> {
    /// Takes two into a lane; gives the square of their distance, m^2.
    #[inline(always)]
    pub fn take(&mut self, lane: usize, metric: &impl Metric<V>, [i, j]: [&Body<V>; 2]) -> f64 {
        let [one, two, three] = &mut self.taken;
        let (x, v) = (|body: &Body<V>, axis| body.position.axis(axis), |body: &Body<V>, axis| body.velocity.axis(axis));
        if V::COMPONENTS == 2 {
            let state = |body| [x(body, 0), x(body, 1), v(body, 0), v(body, 1)];
            let (i_state, j_state) = (state(i), state(j));
            let apart = metric.shorten(quad(|axis| i_state[axis] - j_state[axis]));
            one[lane] = apart;
            two[lane] = [i.radius, i.inverse_mass, j.radius, j.inverse_mass];
            apart[0] * apart[0] + apart[1] * apart[1]
        } else {
            let state = |body| [x(body, 0), x(body, 1), x(body, 2), v(body, 0)];
            let rest = |body: &Body<V>| [v(body, 1), v(body, 2), body.radius, body.inverse_mass];
            let (i_state, j_state) = (state(i), state(j));
            let apart = metric.shorten(quad(|axis| i_state[axis] - j_state[axis]));
            one[lane] = apart;
            (two[lane], three[lane]) = (rest(i), rest(j));
            apart[0] * apart[0] + apart[1] * apart[1] + apart[2] * apart[2]
        }
    }

    /// Spreads what was taken over so many lanes.
    #[inline(always)]
    fn spread(&mut self, lanes: usize) {
        let ([one, two, three], [m_i, m_j]) = (&self.taken, self.inverse_masses.each_mut());
        let ([x, y, z], [vx, vy, vz]) = (self.separation.axes(), self.relative_velocity.axes());
        let [r_i, r_j] = self.radii.each_mut();
        if V::COMPONENTS == 2 {
            spread(one, lanes, x, y, vx, vy);
            spread(two, lanes, r_i, m_i, r_j, m_j);
        } else {
            spread(one, lanes, x, y, z, vx);
            spread(two, lanes, vy, vz, r_i, m_i);
            for lane in 0..lanes.min(LANES) {
                let second = three[lane];
                vy[lane] -= second[0];
                vz[lane] -= second[1];
                (r_j[lane], m_j[lane]) = (second[2], second[3]);
            }
        }
    }

    /// Finds what takes a root or a division, so that no law has to wait for it; gives how many distances are nothing.
    #[inline(always)]
    fn measure_all(&mut self, lanes: usize) -> u32 {
        let mut coincident = 0;
        for lane in 0..lanes.min(LANES) {
            let separation = self.separation.get(lane);
            let distance = separation.length_squared().sqrt();
            self.distance[lane] = distance;
            self.normal.set(lane, separation * (1.0 / distance));
            self.overlap[lane] = self.radii[0][lane] + self.radii[1][lane] - distance;
            self.reduced_mass[lane] = 1.0 / (self.inverse_masses[0][lane] + self.inverse_masses[1][lane]);
            coincident += u32::from(distance <= 0.0);
        }
        coincident
    }

    /// Spreads what was taken over so many lanes, and measures. Tells whether any distance may be nothing.
    pub fn measure(&mut self, lanes: usize, instructions: Instructions) -> bool {
        let coincident = instructions.run(
            #[inline(always)]
            || {
                self.spread(lanes);
                self.measure_all(lanes)
            },
        );
        coincident > 0
    }

    /// Gives coincident centres a normal: a separation so near to nothing that the overlap stays what it is. `normal` gives
    /// that of a lane.
    #[cold]
    pub fn part_coincident(&mut self, lanes: usize, normal: impl Fn(usize) -> V) {
        for lane in (0..lanes).filter(|&lane| self.distance[lane] <= 0.0) {
            self.separation.set(lane, normal(lane) * 1e-150);
        }
        self.measure_all(lanes);
    }

    /// The overlap of a lane over the smaller radius.
    pub fn relative_overlap(&self, lane: usize) -> f64 {
        self.overlap[lane] / self.radii[0][lane].min(self.radii[1][lane])
    }
}

#[cfg(test)]
#[expect(clippy::float_cmp, reason = "exact values")]
mod tests {
    use super::*;
    use crate::periodic::Open;
    use crate::space::{Plane, Solid};

    /// Bodies of unlike numbers, apart by what has its components padded with zeros.
    fn everything_arrives<V: Space>() {
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
                assert_eq!(bodies.take(lane, &Open, [&i, &j]), separation.length_squared());
            }
            assert!(!bodies.measure(LANES, instructions));
            for lane in 0..LANES {
                let [i, j] = [body(lane, 0), body(lane, 1)];
                let separation = i.position - j.position;
                // The same operations on the same numbers, so the same bits.
                assert_eq!(bodies.normal.get(lane), separation * (1.0 / separation.length()));
                assert_eq!(bodies.relative_velocity.get(lane), i.velocity - j.velocity);
                let numbers = [bodies.overlap[lane], bodies.reduced_mass[lane]];
                assert_eq!(
                    numbers,
                    [i.radius + j.radius - separation.length(), 1.0 / (i.inverse_mass + j.inverse_mass)]
                );
                assert_eq!(bodies.radii.map(|radii| radii[lane]), [i.radius, j.radius]);
                assert_eq!(bodies.inverse_masses.map(|masses| masses[lane]), [i.inverse_mass, j.inverse_mass]);
            }
        }
    }

    #[test]
    fn what_is_taken_arrives_in_its_lane() {
        everything_arrives::<Plane>();
        everything_arrives::<Solid>();
    }
}
