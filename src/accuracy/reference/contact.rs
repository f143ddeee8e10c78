//! One contact of the reference: its modes, its force in each, and what ends them.

use glam::DVec2;

use super::closed::damping_ratio;
use super::{Law, System};

/// Along the normal.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Normal {
    /// Apart.
    Open,
    /// Spring and dashpot act.
    Closed,
    /// Overlapping still, with a force that would pull and may not.
    Cut,
}

/// Along the tangent, while the normal is closed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Tangent {
    /// The spring gathers the slip.
    SpringSlider,
    /// At the cap, with this sign.
    Slip(f64),
}

/// Whom a disc touches.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Other {
    /// Another disc, of higher number.
    Disc(usize),
    /// A floor.
    Floor(usize),
}

/// Position, velocity and spin of one side; of a floor nothing counts but its place.
#[derive(Clone, Copy, Debug)]
pub struct Side {
    pub x: DVec2,
    pub v: DVec2,
    pub w: f64,
}

/// Two sides seen from i.
#[derive(Clone, Copy, Debug)]
pub struct Meeting {
    pub n: DVec2,
    /// Overlap, m; negative apart.
    pub overlap: f64,
    /// v_i - v_j.
    pub v: DVec2,
    /// (v_i - v_j).n
    pub v_n: f64,
    /// Slip.
    pub v_s: f64,
}

/// A contact, or what may become one.
#[derive(Clone, Copy, Debug)]
pub struct Link {
    pub i: usize,
    pub other: Other,
    pub normal: Normal,
    pub tangent: Tangent,
    /// Whether the closed normal force pulls (with friction only: the cap has a kink there).
    pub pulls: bool,
    reduced_mass: f64,
    k: f64,
    c: f64,
    k_t: f64,
    c_t: f64,
    mu: f64,
    full: bool,
    attracts: bool,
}

/// The force on i: N, and its tangential part along z x n.
pub type Push = (DVec2, f64);

impl Link {
    pub fn new(system: &System, i: usize, other: Other) -> Self {
        let m = system.discs[i].mass;
        let reduced_mass = match other {
            Other::Floor(_) => m,
            Other::Disc(j) => m * system.discs[j].mass / (m + system.discs[j].mass),
        };
        let apart = Self {
            i,
            other,
            normal: Normal::Open,
            tangent: Tangent::SpringSlider,
            pulls: false,
            reduced_mass,
            k: 0.0,
            c: 0.0,
            k_t: 0.0,
            c_t: 0.0,
            mu: 0.0,
            full: false,
            attracts: true,
        };
        match system.law {
            Law::Full { k, b } => Self { k, c: b, full: true, ..apart },
            Law::Linear { k, e, attracts, friction } => {
                let c = 2.0 * damping_ratio(e, attracts) * (k * reduced_mass).sqrt();
                let (k_t, c_t, mu) = friction.map_or((0.0, 0.0, 0.0), |f| (f.k, f.share * c, f.mu));
                Self { k, c, k_t, c_t, mu, attracts, ..apart }
            }
        }
    }

    pub fn meeting(&self, system: &System, a: Side, b: Side) -> Meeting {
        let radius = system.discs[self.i].radius;
        let (n, overlap, turning) = match self.other {
            Other::Disc(j) => {
                let (away, other) = (a.x - b.x, system.discs[j].radius);
                let distance = away.length();
                (away / distance, radius + other - distance, radius * a.w + other * b.w)
            }
            Other::Floor(f) => {
                let floor = &system.floors[f];
                (floor.normal, radius - (a.x - floor.point).dot(floor.normal), radius * a.w)
            }
        };
        let v = a.v - b.v;
        Meeting { n, overlap, v, v_n: v.dot(n), v_s: v.dot(n.perp()) - turning }
    }

    fn has_friction(&self) -> bool {
        self.k_t > 0.0
    }

    /// Spring and dashpot along the normal, uncut, N.
    fn normal_force(&self, m: &Meeting) -> f64 {
        self.k * m.overlap - self.c * m.v_n
    }

    fn cap(&self, m: &Meeting) -> f64 {
        self.mu * if self.pulls { -self.normal_force(m) } else { self.normal_force(m) }
    }

    fn uncut(&self, m: &Meeting, s: f64) -> f64 {
        -self.k_t * s - self.c_t * m.v_s
    }

    /// The force in the present mode, smooth in its arguments; `s` is the tangential spring, m.
    pub fn force(&self, m: &Meeting, s: f64) -> Push {
        if self.normal != Normal::Closed {
            return (DVec2::ZERO, 0.0);
        }
        if self.full {
            return (m.n * (self.k * m.overlap) - m.v * self.c, 0.0);
        }
        let along = match self.tangent {
            _ if !self.has_friction() => 0.0,
            Tangent::SpringSlider => self.uncut(m, s),
            Tangent::Slip(sign) => sign * self.cap(m),
        };
        (m.n * self.normal_force(m) + m.n.perp() * along, along)
    }

    /// How the tangential spring grows, m/s.
    pub fn spring_rate(&self, m: &Meeting) -> f64 {
        let sticks = self.normal == Normal::Closed && self.tangent == Tangent::SpringSlider && self.has_friction();
        if sticks { m.v_s } else { 0.0 }
    }

    /// Values that are positive once a mode has outlived itself; `at` gives the meeting and the spring around now, `short` is a
    /// time in which little changes, s.
    pub fn alarms(&self, at: &impl Fn(f64) -> (Meeting, f64), now: f64, short: f64) -> [f64; 3] {
        const NEVER: f64 = f64::NEG_INFINITY;
        let (m, s) = at(now);
        match self.normal {
            Normal::Open => [m.overlap, NEVER, NEVER],
            Normal::Cut => [-m.overlap, self.normal_force(&m), NEVER],
            Normal::Closed => {
                let end = if self.full || self.attracts { -m.overlap } else { -self.normal_force(&m) };
                if !self.has_friction() {
                    return [end, NEVER, NEVER];
                }
                let kink = if self.attracts { -self.cap(&m) } else { NEVER };
                let tangent = match self.tangent {
                    Tangent::SpringSlider => self.uncut(&m, s).abs() - self.cap(&m),
                    Tangent::Slip(sign) => {
                        let (before, after) = (at(now - short).0, at(now + short).0);
                        let cap_rate = (self.cap(&after) - self.cap(&before)) / (2.0 * short);
                        let slip_rate = (after.v_s - before.v_s) / (2.0 * short);
                        cap_rate - sign * (-self.k_t * m.v_s - self.c_t * slip_rate)
                    }
                };
                [end, tangent, kink]
            }
        }
    }

    /// Goes on in the next mode after alarm `which`; gives the spring there.
    pub fn switch(&mut self, which: usize, m: &Meeting, s: f64) -> f64 {
        match (self.normal, which) {
            (Normal::Open, _) => {
                (self.normal, self.pulls) = (Normal::Closed, false);
                self.choose(m, 0.0)
            }
            (Normal::Cut, 0) => {
                self.normal = Normal::Open;
                0.0
            }
            (Normal::Cut, _) => {
                self.normal = Normal::Closed;
                self.choose(m, self.relaxed(0.0, m))
            }
            (Normal::Closed, 0) => {
                self.normal = if self.full || self.attracts { Normal::Open } else { Normal::Cut };
                0.0
            }
            (Normal::Closed, 1) => match self.tangent {
                Tangent::SpringSlider => {
                    self.tangent = Tangent::Slip(self.uncut(m, s).signum());
                    s
                }
                Tangent::Slip(sign) => {
                    self.tangent = Tangent::SpringSlider;
                    self.relaxed(sign * self.cap(m), m)
                }
            },
            (Normal::Closed, _) => {
                self.pulls = !self.pulls;
                self.choose(m, self.relaxed(0.0, m))
            }
        }
    }

    /// The spring that gives this force, m.
    fn relaxed(&self, force: f64, m: &Meeting) -> f64 {
        if self.has_friction() { -(force + self.c_t * m.v_s) / self.k_t } else { 0.0 }
    }

    /// Stick or slip, by a look a hair ahead, because force and cap may both begin at zero.
    fn choose(&mut self, m: &Meeting, s: f64) -> f64 {
        let hair = 1e-6 * (self.reduced_mass / self.k).sqrt();
        let uncut = self.uncut(m, s + hair * m.v_s);
        let ahead = Meeting { overlap: m.overlap - hair * m.v_n, ..*m };
        self.tangent =
            if uncut.abs() > self.cap(&ahead) { Tangent::Slip(uncut.signum()) } else { Tangent::SpringSlider };
        s
    }
}
