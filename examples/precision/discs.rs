//! Discs of equal mass with spring-dashpot contacts: velocity Verlet and a pair list.

use crate::numbers::{Numbers, Place, Real};

/// Parameters of all cases: N/m, kg, m, m/s^2.
pub const STIFFNESS: f64 = 1.0e5;
pub const MASS: f64 = 0.16;
pub const RADIUS: f64 = 0.04;
pub const GRAVITY: f64 = 9.81;
/// Distance beyond contact up to which pairs are listed, m.
const SKIN: f64 = 0.02;

/// Evaluation of the damping.
#[derive(Clone, Copy, PartialEq)]
pub enum Scheme {
    /// Damping with v(t+dt/2), on or off for the whole step: first order.
    Plain,
    /// Damping with v(t+dt/2) + dt/2 a(t), for the share of the step that the contact lasts: second order.
    Averaged,
}

/// All parameters that are not part of the state.
#[derive(Clone, Copy)]
pub struct Setting {
    /// Damping coefficient of a pair, N s/m.
    pub drag: f64,
    pub gravity: f64,
    /// Height of the floor, m; minus infinity for no floor.
    pub floor: f64,
    /// Lower corner and sides of the periodic box, m; infinite sides for no box.
    pub corner: f64,
    pub periods: [f64; 2],
    pub scheme: Scheme,
    pub dt: f64,
}

/// Returns the damping coefficient (N s/m) and the contact duration (s) of two grains with restitution `e`.
pub fn damping(e: f64) -> (f64, f64) {
    let reduced = 0.5 * MASS;
    let decrement = -e.ln();
    let frequency = (STIFFNESS / reduced).sqrt();
    let zeta = decrement / std::f64::consts::PI.hypot(decrement);
    (2.0 * zeta * (STIFFNESS * reduced).sqrt(), std::f64::consts::PI / (frequency * (1.0 - zeta * zeta).sqrt()))
}

/// A disc of a case: position, velocity, radius.
#[derive(Clone, Copy)]
pub struct Disc {
    pub x: [f64; 2],
    pub v: [f64; 2],
    pub radius: f64,
}

pub struct Discs<N: Numbers> {
    setting: Setting,
    floor: N::Place,
    place: Vec<[N::Place; 2]>,
    velocity: Vec<[N::Motion; 2]>,
    acceleration: Vec<[N::Motion; 2]>,
    /// Velocity used by the damping.
    damping_velocity: Vec<[N::Motion; 2]>,
    radius: Vec<N::Force>,
    pairs: Vec<(usize, usize)>,
    /// Distance that the fastest disc may have moved since the pairs were listed, m.
    travelled: f64,
}

impl<N: Numbers> Discs<N> {
    /// Creates the discs and evaluates the forces at the start.
    pub fn new(setting: Setting, discs: &[Disc]) -> Self {
        let velocity: Vec<_> = discs.iter().map(|disc| disc.v.map(N::Motion::of)).collect();
        let mut all = Self {
            setting,
            floor: N::Place::at(setting.floor.max(-1.0e9)),
            place: discs.iter().map(|disc| disc.x.map(N::Place::at)).collect(),
            damping_velocity: velocity.clone(),
            acceleration: vec![[N::Motion::ZERO; 2]; discs.len()],
            velocity,
            radius: discs.iter().map(|disc| N::Force::of(disc.radius)).collect(),
            pairs: Vec::new(),
            travelled: f64::INFINITY,
        };
        all.list_pairs();
        all.accelerate();
        all
    }

    pub fn step(&mut self) {
        let dt = N::Motion::of(self.setting.dt);
        let half = N::Motion::of(0.5 * self.setting.dt);
        let mut fastest = N::Motion::ZERO;
        for (((x, v), a), damping_velocity) in
            self.place.iter_mut().zip(&mut self.velocity).zip(&self.acceleration).zip(&mut self.damping_velocity)
        {
            for axis in 0..2 {
                v[axis] += half * a[axis];
                x[axis] = x[axis].moved(dt * v[axis]);
                damping_velocity[axis] = match self.setting.scheme {
                    Scheme::Plain => v[axis],
                    Scheme::Averaged => v[axis] + half * a[axis],
                };
                if v[axis].size() > fastest {
                    fastest = v[axis].size();
                }
            }
        }
        // sqrt(2) because only the larger of two components is known, and a tenth for rounding.
        self.travelled += 1.5 * fastest.wide() * self.setting.dt;
        self.list_pairs();
        self.accelerate();
        for (v, a) in self.velocity.iter_mut().zip(&self.acceleration) {
            for axis in 0..2 {
                v[axis] += half * a[axis];
            }
        }
    }

    pub fn run(&mut self, steps: u64) {
        (0..steps).for_each(|_| self.step());
    }

    /// Returns the current state.
    pub fn discs(&self) -> Vec<Disc> {
        let all = self.place.iter().zip(&self.velocity).zip(&self.radius);
        all.map(|((x, v), r)| Disc { x: x.map(Place::metres), v: v.map(Real::wide), radius: r.wide() }).collect()
    }

    /// Returns the accelerations, m/s^2.
    pub fn accelerations(&self) -> Vec<[f64; 2]> {
        self.acceleration.iter().map(|a| a.map(Real::wide)).collect()
    }

    /// Returns the elastic force of every listed pair in contact, N.
    pub fn forces(&self) -> Vec<((usize, usize), f64)> {
        let touching = self.pairs.iter().map(|&(i, j)| ((i, j), STIFFNESS * self.geometry(i, j).1.wide()));
        touching.filter(|pair| pair.1 > 0.0).collect()
    }

    /// Returns the normal from j to i, and the overlap.
    fn geometry(&self, i: usize, j: usize) -> ([N::Force; 2], N::Force) {
        let a = self.place[i];
        let b = self.place[j];
        let separation: [N::Force; 2] = [0, 1].map(|axis| a[axis].apart(b[axis], self.setting.periods[axis]));
        let distance = (separation[0] * separation[0] + separation[1] * separation[1]).root();
        // Rounding may make two centres coincide.
        let normal = if distance > N::Force::ZERO {
            [separation[0] / distance, separation[1] / distance]
        } else {
            [N::Force::ONE, N::Force::ZERO]
        };
        (normal, self.radius[i] + self.radius[j] - distance)
    }

    /// Returns the normal force for an overlap and a closing speed.
    fn force(&self, overlap: N::Force, closing: N::Force) -> N::Force {
        let zero = N::Force::ZERO;
        let reach = match self.setting.scheme {
            Scheme::Plain => zero,
            Scheme::Averaged => closing.size() * N::Force::of(0.5 * self.setting.dt),
        };
        let spring = if overlap > zero { N::Force::of(STIFFNESS) * overlap } else { zero };
        let share = if overlap > reach {
            N::Force::ONE
        } else if overlap + reach > zero {
            (overlap + reach) / (reach + reach)
        } else {
            zero
        };
        spring + share * (N::Force::of(self.setting.drag) * closing)
    }

    fn accelerate(&mut self) {
        let inverse = N::Motion::of(1.0 / MASS);
        let mut sums = std::mem::take(&mut self.acceleration);
        sums.fill([N::Motion::ZERO; 2]);
        for &(i, j) in &self.pairs {
            let (normal, overlap) = self.geometry(i, j);
            let relative = [0, 1]
                .map(|axis| N::Force::of((self.damping_velocity[i][axis] - self.damping_velocity[j][axis]).wide()));
            let closing = N::Force::ZERO - (relative[0] * normal[0] + relative[1] * normal[1]);
            let force = self.force(overlap, closing);
            for axis in 0..2 {
                let part = N::Motion::of((force * normal[axis]).wide());
                sums[i][axis] += part;
                sums[j][axis] -= part;
            }
        }
        for (i, sum) in sums.iter_mut().enumerate() {
            let overlap = self.radius[i] - self.place[i][1].apart(self.floor, f64::INFINITY);
            let closing = N::Force::ZERO - N::Force::of(self.damping_velocity[i][1].wide());
            sum[1] += N::Motion::of(self.force(overlap, closing).wide());
            *sum = [sum[0] * inverse, sum[1] * inverse - N::Motion::of(self.setting.gravity)];
        }
        self.acceleration = sums;
    }

    /// Lists the pairs again if new ones may be in range, and moves discs back into the periodic box.
    fn list_pairs(&mut self) {
        if 2.0 * self.travelled < 0.9 * SKIN {
            return;
        }
        self.travelled = 0.0;
        let Setting { corner, periods, .. } = self.setting;
        for x in &mut self.place {
            for axis in 0..2 {
                if x[axis].metres() >= corner + periods[axis] {
                    x[axis] = x[axis].shifted(-periods[axis]);
                } else if periods[axis].is_finite() && x[axis].metres() < corner {
                    x[axis] = x[axis].shifted(periods[axis]);
                }
            }
        }
        self.pairs.clear();
        for i in 0..self.place.len() {
            for j in i + 1..self.place.len() {
                let a = self.place[i];
                let b = self.place[j];
                let d = [0, 1].map(|axis| a[axis].apart::<N::Force>(b[axis], periods[axis]).wide());
                if d[0] * d[0] + d[1] * d[1] < (2.02 * RADIUS + SKIN).powi(2) {
                    self.pairs.push((i, j));
                }
            }
        }
    }
}
