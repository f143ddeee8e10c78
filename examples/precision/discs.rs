//! Discs of one mass that touch by springs and dashpots: velocity Verlet, pairs from a list, nothing else.

use crate::numbers::{Numbers, Place, Real};

/// What the cases have in common: N/m, kg, m, m/s^2.
pub const STIFFNESS: f64 = 1.0e5;
pub const MASS: f64 = 0.16;
pub const RADIUS: f64 = 0.04;
pub const GRAVITY: f64 = 9.81;
/// How far beyond touching the list of pairs looks, m.
const SKIN: f64 = 0.02;

/// When the drag acts.
#[derive(Clone, Copy, PartialEq)]
pub enum Scheme {
    /// Drag of v(t+dt/2), on or off for the whole step: first order.
    Plain,
    /// Drag of v(t+dt/2) + dt/2 a(t), for the share of the step that the contact lasts: second order.
    Averaged,
}

/// Everything that is not the state.
#[derive(Clone, Copy)]
pub struct Setting {
    /// Drag between two, N s/m.
    pub drag: f64,
    pub gravity: f64,
    /// Height of the floor, m: minus infinity for none.
    pub floor: f64,
    /// Lower corner and sides of the periodic box, m: infinite sides for none.
    pub corner: f64,
    pub periods: [f64; 2],
    pub scheme: Scheme,
    pub dt: f64,
}

/// Drag N s/m and contact duration s of two grains that bounce with restitution `e`.
pub fn damping(e: f64) -> (f64, f64) {
    let (reduced, decrement) = (0.5 * MASS, -e.ln());
    let frequency = (STIFFNESS / reduced).sqrt();
    let zeta = decrement / std::f64::consts::PI.hypot(decrement);
    (2.0 * zeta * (STIFFNESS * reduced).sqrt(), std::f64::consts::PI / (frequency * (1.0 - zeta * zeta).sqrt()))
}

/// A disc as the cases set it out: place, velocity, radius.
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
    /// The velocity that drag sees.
    seen: Vec<[N::Motion; 2]>,
    radius: Vec<N::Force>,
    pairs: Vec<(usize, usize)>,
    /// How far the fastest may have moved since the pairs were listed, m.
    strayed: f64,
}

impl<N: Numbers> Discs<N> {
    /// Laid out, with the forces of the first moment worked out.
    pub fn new(setting: Setting, discs: &[Disc]) -> Self {
        let velocity: Vec<_> = discs.iter().map(|disc| disc.v.map(N::Motion::of)).collect();
        let mut all = Self {
            setting,
            floor: N::Place::at(setting.floor.max(-1.0e9)),
            place: discs.iter().map(|disc| disc.x.map(N::Place::at)).collect(),
            seen: velocity.clone(),
            acceleration: vec![[N::Motion::ZERO; 2]; discs.len()],
            velocity,
            radius: discs.iter().map(|disc| N::Force::of(disc.radius)).collect(),
            pairs: Vec::new(),
            strayed: f64::INFINITY,
        };
        all.list_pairs();
        all.accelerate();
        all
    }

    pub fn step(&mut self) {
        let dt = N::Motion::of(self.setting.dt);
        let half = N::Motion::of(0.5 * self.setting.dt);
        let mut fastest = N::Motion::ZERO;
        for (((x, v), a), seen) in
            self.place.iter_mut().zip(&mut self.velocity).zip(&self.acceleration).zip(&mut self.seen)
        {
            for axis in 0..2 {
                v[axis] += half * a[axis];
                x[axis] = x[axis].moved(dt * v[axis]);
                seen[axis] = match self.setting.scheme {
                    Scheme::Plain => v[axis],
                    Scheme::Averaged => v[axis] + half * a[axis],
                };
                if v[axis].size() > fastest {
                    fastest = v[axis].size();
                }
            }
        }
        // sqrt(2): the larger of two components is known; a tenth for rounding.
        self.strayed += 1.5 * fastest.wide() * self.setting.dt;
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

    /// The state as it is now.
    pub fn discs(&self) -> Vec<Disc> {
        let all = self.place.iter().zip(&self.velocity).zip(&self.radius);
        all.map(|((x, v), r)| Disc { x: x.map(Place::metres), v: v.map(Real::wide), radius: r.wide() }).collect()
    }

    /// Accelerations, m/s^2.
    pub fn accelerations(&self) -> Vec<[f64; 2]> {
        self.acceleration.iter().map(|a| a.map(Real::wide)).collect()
    }

    /// The elastic force of every pair listed that touches, N.
    pub fn forces(&self) -> Vec<((usize, usize), f64)> {
        let touching = self.pairs.iter().map(|&(i, j)| ((i, j), STIFFNESS * self.meet(i, j).1.wide()));
        touching.filter(|pair| pair.1 > 0.0).collect()
    }

    /// Normal from j to i, and overlap.
    fn meet(&self, i: usize, j: usize) -> ([N::Force; 2], N::Force) {
        let (a, b) = (self.place[i], self.place[j]);
        let way: [N::Force; 2] = [0, 1].map(|axis| a[axis].apart(b[axis], self.setting.periods[axis]));
        let distance = (way[0] * way[0] + way[1] * way[1]).root();
        // Rounding may bring two centres together.
        let normal = if distance > N::Force::ZERO {
            [way[0] / distance, way[1] / distance]
        } else {
            [N::Force::ONE, N::Force::ZERO]
        };
        (normal, self.radius[i] + self.radius[j] - distance)
    }

    /// The normal force for an overlap and the speed at which it closes.
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
            let (normal, overlap) = self.meet(i, j);
            let relative = [0, 1].map(|axis| N::Force::of((self.seen[i][axis] - self.seen[j][axis]).wide()));
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
            let closing = N::Force::ZERO - N::Force::of(self.seen[i][1].wide());
            sum[1] += N::Motion::of(self.force(overlap, closing).wide());
            *sum = [sum[0] * inverse, sum[1] * inverse - N::Motion::of(self.setting.gravity)];
        }
        self.acceleration = sums;
    }

    /// Lists the pairs anew if some may have come into reach; brings discs back into the periodic box.
    fn list_pairs(&mut self) {
        if 2.0 * self.strayed < 0.9 * SKIN {
            return;
        }
        self.strayed = 0.0;
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
                let (a, b) = (self.place[i], self.place[j]);
                let d = [0, 1].map(|axis| a[axis].apart::<N::Force>(b[axis], periods[axis]).wide());
                if d[0] * d[0] + d[1] * d[1] < (2.02 * RADIUS + SKIN).powi(2) {
                    self.pairs.push((i, j));
                }
            }
        }
    }
}
