//! One contact of the reference: its modes, the force in each mode, and the conditions that end a mode.

use glam::DVec2;

use super::closed::damping_ratio;
use super::{Law, System};

/// Mode along the normal.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Normal {
    /// The sides do not overlap.
    Open,
    /// Spring and dashpot act.
    Closed,
    /// The sides still overlap, but the force is set to 0 because it would be attractive.
    Cut,
}

/// Mode along the tangent, while the normal mode is [`Normal::Closed`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Tangent {
    /// Sticking: the tangential spring integrates the slip velocity.
    SpringSlider,
    /// Slipping: the force has the magnitude of the cap and this sign.
    Slip(f64),
}

/// The other side of a contact.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Other {
    /// The disc with this index, which is larger than the index of the first disc.
    Disc(usize),
    /// The floor with this index.
    Floor(usize),
}

/// Position (m), velocity (m/s) and spin (rad/s) of one side. For a floor the values must be 0.
#[derive(Clone, Copy, Debug)]
pub struct Side {
    pub x: DVec2,
    pub v: DVec2,
    pub w: f64,
}

/// Geometry and relative motion of two sides, from the view of disc i.
#[derive(Clone, Copy, Debug)]
pub struct Meeting {
    /// Unit normal from the other side towards disc i.
    pub n: DVec2,
    /// Overlap, m; negative if the sides are apart.
    pub overlap: f64,
    /// Relative velocity v_i - v_j, m/s.
    pub v: DVec2,
    /// Normal relative velocity (v_i - v_j).n, m/s.
    pub v_n: f64,
    /// Slip velocity, m/s.
    pub v_s: f64,
}

/// A contact or a candidate pair.
#[derive(Clone, Copy, Debug)]
pub struct Link {
    /// Index of the first disc.
    pub i: usize,
    /// The other side.
    pub other: Other,
    /// Mode along the normal.
    pub normal: Normal,
    /// Mode along the tangent.
    pub tangent: Tangent,
    /// Whether the closed normal force is attractive. Tracked with friction only, because the cap has a kink at the
    /// change.
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

/// Force on disc i, and the tangential part of it along z x n, both in N.
pub type Push = (DVec2, f64);

impl Link {
    /// Returns the open contact of disc `i` with `other`.
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

    /// Returns geometry and relative motion of this contact, with disc i as `a` and the other side as `b`.
    pub fn meeting(&self, system: &System, a: Side, b: Side) -> Meeting {
        let radius = system.discs[self.i].radius;
        let (n, overlap, rim_speed) = match self.other {
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
        Meeting { n, overlap, v, v_n: v.dot(n), v_s: v.dot(n.perp()) - rim_speed }
    }

    fn has_friction(&self) -> bool {
        self.k_t > 0.0
    }

    /// Returns the force of spring and dashpot along the normal, N; negative is attractive.
    fn normal_force(&self, m: &Meeting) -> f64 {
        self.k * m.overlap - self.c * m.v_n
    }

    /// Returns the friction cap, mu times the magnitude of the normal force, N.
    fn cap(&self, m: &Meeting) -> f64 {
        self.mu * if self.pulls { -self.normal_force(m) } else { self.normal_force(m) }
    }

    /// Returns the tangential force without the cap, N; `s` is the tangential spring, m.
    fn tangential_trial_force(&self, m: &Meeting, s: f64) -> f64 {
        -self.k_t * s - self.c_t * m.v_s
    }

    /// Returns the force in the present mode, a smooth function of the arguments; `s` is the tangential spring, m.
    pub fn force(&self, m: &Meeting, s: f64) -> Push {
        if self.normal != Normal::Closed {
            return (DVec2::ZERO, 0.0);
        }
        if self.full {
            return (m.n * (self.k * m.overlap) - m.v * self.c, 0.0);
        }
        let along = match self.tangent {
            _ if !self.has_friction() => 0.0,
            Tangent::SpringSlider => self.tangential_trial_force(m, s),
            Tangent::Slip(sign) => sign * self.cap(m),
        };
        (m.n * self.normal_force(m) + m.n.perp() * along, along)
    }

    /// Returns the rate of the tangential spring, m/s.
    pub fn spring_rate(&self, m: &Meeting) -> f64 {
        let sticks = self.normal == Normal::Closed && self.tangent == Tangent::SpringSlider && self.has_friction();
        if sticks { m.v_s } else { 0.0 }
    }

    /// Returns the event functions of the present mode. A mode ends as soon as one of its event functions is positive.
    ///
    /// `at` returns the meeting and the tangential spring at a time near `now`. `short` is the time step of the
    /// numerical derivatives, s.
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
                    Tangent::SpringSlider => self.tangential_trial_force(&m, s).abs() - self.cap(&m),
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

    /// Enters the next mode after event `which` and returns the tangential spring of that mode, m.
    pub fn switch(&mut self, which: usize, m: &Meeting, s: f64) -> f64 {
        match (self.normal, which) {
            (Normal::Open, _) => {
                (self.normal, self.pulls) = (Normal::Closed, false);
                self.choose_tangent(m, 0.0)
            }
            (Normal::Cut, 0) => {
                self.normal = Normal::Open;
                0.0
            }
            (Normal::Cut, _) => {
                self.normal = Normal::Closed;
                self.choose_tangent(m, self.spring_for_force(0.0, m))
            }
            (Normal::Closed, 0) => {
                self.normal = if self.full || self.attracts { Normal::Open } else { Normal::Cut };
                0.0
            }
            (Normal::Closed, 1) => match self.tangent {
                Tangent::SpringSlider => {
                    self.tangent = Tangent::Slip(self.tangential_trial_force(m, s).signum());
                    s
                }
                Tangent::Slip(sign) => {
                    self.tangent = Tangent::SpringSlider;
                    self.spring_for_force(sign * self.cap(m), m)
                }
            },
            (Normal::Closed, _) => {
                self.pulls = !self.pulls;
                self.choose_tangent(m, self.spring_for_force(0.0, m))
            }
        }
    }

    /// Returns the tangential spring (m) at which the tangential force is `force` (N).
    fn spring_for_force(&self, force: f64, m: &Meeting) -> f64 {
        if self.has_friction() { -(force + self.c_t * m.v_s) / self.k_t } else { 0.0 }
    }

    /// Chooses between stick and slip and returns `s`.
    ///
    /// The choice compares force and cap a very short time later, because both may begin at zero.
    fn choose_tangent(&mut self, m: &Meeting, s: f64) -> f64 {
        let delay = 1e-6 * (self.reduced_mass / self.k).sqrt();
        let trial = self.tangential_trial_force(m, s + delay * m.v_s);
        let later = Meeting { overlap: m.overlap - delay * m.v_n, ..*m };
        self.tangent =
            if trial.abs() > self.cap(&later) { Tangent::Slip(trial.signum()) } else { Tangent::SpringSlider };
        s
    }
}
