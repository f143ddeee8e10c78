//! One contact of the reference: its modes, the force in each mode, and the conditions that end a mode.

use std::f64::consts::PI;

use glam::DVec2;

use super::moduli::{self, Moduli};
use super::{Law, Rolling, System};

/// Mode along the normal.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Normal {
    /// The sides do not overlap.
    Open,
    /// Spring and dashpot act.
    Closed,
    /// The sides still overlap, but the force of spring and dashpot is set to 0 because it would be attractive.
    Cut,
}

/// Mode of friction or of rolling resistance, while the normal mode is [`Normal::Closed`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Slide {
    /// Sticking: the spring integrates the velocity.
    Stick,
    /// Slipping: the force has the magnitude of the cap and this sign.
    Slip(f64),
}

/// Number of sliders of a contact: friction, then rolling resistance.
pub const SLIDERS: usize = 2;

/// Number of event functions of a contact.
pub const EVENTS: usize = 3 + SLIDERS;

/// The other side of a contact.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Other {
    /// The disc with this index, which is larger than the index of the first disc.
    Disc(usize),
    /// The floor with this index.
    Floor(usize),
}

/// Position (m), velocity (m/s) and spin (rad/s) of one side. Of a floor: its shift and its velocity.
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
    /// Velocities of the sliders: the slip velocity v_s and the rolling velocity v_r, m/s.
    pub slides: [f64; SLIDERS],
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
    /// Modes of friction and rolling resistance.
    pub slides: [Slide; SLIDERS],
    /// Whether the closed normal force is attractive. Tracked with friction only, because the cap has a kink at the
    /// change.
    pub pulls: bool,
    /// Whether the overlap is past its maximum. Tracked if stiffnesses vary, because the rate of the spring has a kink there.
    unloads: bool,
    reduced_radius: f64,
    moduli: Moduli,
    mu: f64,
    rolling: Option<Rolling>,
    attracts: bool,
    /// Constant pull while the sides overlap, N.
    pull: f64,
}

/// Force on disc i (N), the part of it along z x n that makes a torque (N), and the torque of rolling resistance on i (N m).
pub type Push = (DVec2, f64, f64);

impl Link {
    /// Returns the open contact of disc `i` with `other`.
    pub fn new(system: &System, i: usize, other: Other) -> Self {
        let m = system.discs[i].mass;
        let r = system.discs[i].radius;
        let (reduced_mass, reduced_radius) = match other {
            Other::Floor(_) => (m, r),
            Other::Disc(j) => {
                let mass = system.discs[j].mass;
                let radius = system.discs[j].radius;
                (m * mass / (m + mass), r * radius / (r + radius))
            }
        };
        let (mu, rolling) = moduli::sliders(&system.law);
        Self {
            i,
            other,
            normal: Normal::Open,
            slides: [Slide::Stick; SLIDERS],
            pulls: false,
            unloads: false,
            reduced_radius,
            moduli: Moduli::new(&system.law, reduced_mass, reduced_radius),
            mu,
            rolling,
            pull: match system.law {
                Law::Adhesive { work, .. } => 2.0 * PI * work * reduced_radius,
                _ => 0.0,
            },
            attracts: matches!(system.law, Law::Full { .. } | Law::Linear { attracts: true, .. }),
        }
    }

    /// Returns geometry and relative motion of this contact, with disc i as `a` and the other side as `b`.
    pub fn meeting(&self, system: &System, a: Side, b: Side) -> Meeting {
        let radius = system.discs[self.i].radius;
        let (n, overlap, rim_speed) = match self.other {
            Other::Disc(j) => {
                let away = a.x - b.x;
                let other = system.discs[j].radius;
                let distance = away.length();
                (away / distance, radius + other - distance, radius * a.w + other * b.w)
            }
            Other::Floor(f) => {
                let floor = &system.floors[f];
                (floor.normal, radius - (a.x - floor.point - b.x).dot(floor.normal), radius * a.w)
            }
        };
        let v = a.v - b.v;
        let slides = [v.dot(n.perp()) - rim_speed, self.reduced_radius * (a.w - b.w)];
        Meeting { n, overlap, v, v_n: v.dot(n), slides }
    }

    /// Whether stiffnesses depend on the overlap. Then the force begins like a root of time.
    pub fn varies(&self) -> bool {
        self.moduli.vary()
    }

    /// Whether the drag acts on the whole relative velocity.
    fn is_full(&self) -> bool {
        matches!(self.moduli, Moduli::Full(_))
    }

    fn has_friction(&self) -> bool {
        self.mu > 0.0
    }

    /// Returns stiffness (N/m), damping (N s/m) and friction coefficient of a slider; `None` if the law does not have it.
    fn slider(&self, number: usize, overlap: f64) -> Option<[f64; 3]> {
        if number == 0 {
            let [k, c] = self.moduli.friction(overlap);
            self.has_friction().then_some([k, c, self.mu])
        } else {
            self.rolling.map(|Rolling { k, b, mu }| [k, b, mu])
        }
    }

    /// Returns the force of spring and dashpot along the normal, N; negative is attractive.
    fn normal_force(&self, m: &Meeting) -> f64 {
        self.moduli.spring(m.overlap) - self.moduli.damping(m.overlap) * m.v_n
    }

    /// Returns the magnitude of the normal force, N.
    fn load(&self, m: &Meeting) -> f64 {
        if self.pulls { -self.normal_force(m) } else { self.normal_force(m) }
    }

    /// Returns the force of a slider without the cap, N; `s` is its spring, m.
    fn trial(&self, number: usize, m: &Meeting, s: f64) -> f64 {
        self.slider(number, m.overlap).map_or(0.0, |[k, c, _]| -k * s - c * m.slides[number])
    }

    /// Returns the cap of a slider, N.
    fn cap(&self, number: usize, m: &Meeting) -> f64 {
        self.slider(number, m.overlap).map_or(0.0, |[.., mu]| mu * self.load(m))
    }

    /// Returns the force in the present mode, a smooth function of the arguments; `s` are the springs of the sliders, m.
    pub fn force(&self, m: &Meeting, s: [f64; SLIDERS]) -> Push {
        match self.normal {
            Normal::Open => return (DVec2::ZERO, 0.0, 0.0),
            Normal::Cut => return (m.n * -self.pull, 0.0, 0.0),
            Normal::Closed => {}
        }
        if self.is_full() {
            return (m.n * self.moduli.spring(m.overlap) - m.v * self.moduli.damping(m.overlap), 0.0, 0.0);
        }
        let [along, rolling] = [0, 1].map(|number| match self.slides[number] {
            Slide::Stick => self.trial(number, m, s[number]),
            Slide::Slip(sign) => sign * self.cap(number, m),
        });
        (m.n * (self.normal_force(m) - self.pull) + m.n.perp() * along, along, self.reduced_radius * rolling)
    }

    /// Returns k_t'/k_t of friction if the contact is unloading as `unloads` says, else 0, 1/s. k_t goes with the root of the
    /// overlap.
    fn stiffening(&self, number: usize, m: &Meeting, unloads: bool) -> f64 {
        // The floor is far below the overlap after the first step of a contact.
        let overlap = m.overlap.max(1e-14 * self.reduced_radius);
        if number == 0 && self.varies() && self.unloads == unloads { -m.v_n / (2.0 * overlap) } else { 0.0 }
    }

    /// Returns the rates of the springs, m/s.
    pub fn spring_rates(&self, m: &Meeting, s: [f64; SLIDERS]) -> [f64; SLIDERS] {
        [0, 1].map(|number| {
            let sticks = self.normal == Normal::Closed && self.slides[number] == Slide::Stick;
            let exists = sticks && self.slider(number, m.overlap).is_some();
            if exists { m.slides[number] - s[number] * self.stiffening(number, m, false) } else { 0.0 }
        })
    }

    /// Returns the event functions of the present mode. A mode ends as soon as one of its event functions is positive.
    ///
    /// `at` returns the meeting and the springs at a time near `now`. `short` is the time step of the numerical derivatives,
    /// s.
    pub fn alarms(&self, at: &impl Fn(f64) -> (Meeting, [f64; SLIDERS]), now: f64, short: f64) -> [f64; EVENTS] {
        const NEVER: f64 = f64::NEG_INFINITY;
        let (m, s) = at(now);
        let mut events = [NEVER; EVENTS];
        match self.normal {
            Normal::Open => events[0] = m.overlap,
            Normal::Cut => [events[0], events[1]] = [-m.overlap, self.normal_force(&m)],
            Normal::Closed => {
                events[0] = if self.attracts { -m.overlap } else { -self.normal_force(&m) };
                if self.attracts && self.has_friction() && !self.is_full() {
                    events[1] = -self.load(&m);
                }
                if self.varies() {
                    events[2] = if self.unloads { -m.v_n } else { m.v_n };
                }
                for number in 0..SLIDERS {
                    if self.slider(number, m.overlap).is_some() {
                        events[3 + number] = match self.slides[number] {
                            Slide::Stick => self.trial(number, &m, s[number]).abs() - self.cap(number, &m),
                            Slide::Slip(sign) => {
                                self.stick_alarm(number, sign, &m, [at(now - short).0, at(now + short).0], short)
                            }
                        };
                    }
                }
            }
        }
        events
    }

    /// Returns the rate of the cap minus the rate of the force if the slider stuck, N/s: positive where slip ends. `around` are
    /// the meetings `short` (s) before and after.
    fn stick_alarm(&self, number: usize, sign: f64, m: &Meeting, around: [Meeting; 2], short: f64) -> f64 {
        let Some([k, ..]) = self.slider(number, m.overlap) else { return f64::NEG_INFINITY };
        let dashpot = |m: &Meeting| self.slider(number, m.overlap).map_or(0.0, |[_, c, _]| c * m.slides[number]);
        let rate = |of: &dyn Fn(&Meeting) -> f64| (of(&around[1]) - of(&around[0])) / (2.0 * short);
        let cap_rate = rate(&|m| self.cap(number, m));
        let dashpot_rate = rate(&dashpot);
        // A softening spring keeps its displacement.
        let softening = self.stiffening(number, m, true);
        let elastic = sign * self.cap(number, m) + dashpot(m);
        cap_rate - sign * (-k * m.slides[number] + softening * elastic - dashpot_rate)
    }

    /// Enters the next mode after event `which` and returns the springs of that mode, m.
    pub fn switch(&mut self, which: usize, m: &Meeting, s: [f64; SLIDERS]) -> [f64; SLIDERS] {
        match (self.normal, which) {
            (Normal::Open, _) => {
                (self.normal, self.pulls, self.unloads) = (Normal::Closed, false, false);
                self.choose_modes(m, [0.0; SLIDERS])
            }
            (Normal::Cut, 0) => {
                self.normal = Normal::Open;
                [0.0; SLIDERS]
            }
            (Normal::Cut, _) => {
                (self.normal, self.unloads) = (Normal::Closed, m.v_n > 0.0);
                self.choose_modes(m, self.springs_without_force(m))
            }
            (Normal::Closed, 0) => {
                self.normal = if self.attracts { Normal::Open } else { Normal::Cut };
                [0.0; SLIDERS]
            }
            (Normal::Closed, 1) => {
                self.pulls = !self.pulls;
                self.choose_modes(m, self.springs_without_force(m))
            }
            (Normal::Closed, 2) => {
                self.unloads = !self.unloads;
                s
            }
            (Normal::Closed, which) => {
                let number = which - 3;
                let mut s = s;
                match self.slides[number] {
                    Slide::Stick => self.slides[number] = Slide::Slip(self.trial(number, m, s[number]).signum()),
                    Slide::Slip(sign) => {
                        self.slides[number] = Slide::Stick;
                        s[number] = self.spring_for_force(number, sign * self.cap(number, m), m);
                    }
                }
                s
            }
        }
    }

    /// Returns the spring (m) at which the force of a slider is `force` (N).
    fn spring_for_force(&self, number: usize, force: f64, m: &Meeting) -> f64 {
        self.slider(number, m.overlap).map_or(0.0, |[k, c, _]| -(force + c * m.slides[number]) / k)
    }

    fn springs_without_force(&self, m: &Meeting) -> [f64; SLIDERS] {
        [0, 1].map(|number| self.spring_for_force(number, 0.0, m))
    }

    /// Chooses between stick and slip and returns `s`.
    ///
    /// The choice compares force and cap a very short time later, because both may begin at zero.
    fn choose_modes(&mut self, m: &Meeting, s: [f64; SLIDERS]) -> [f64; SLIDERS] {
        let delay = 3e-8 * self.reduced_radius / m.v.length().max(f64::MIN_POSITIVE);
        let later = Meeting { overlap: m.overlap - delay * m.v_n, ..*m };
        for (number, spring) in s.iter().enumerate() {
            let trial = self.trial(number, &later, spring + delay * m.slides[number]);
            self.slides[number] =
                if trial.abs() > self.cap(number, &later) { Slide::Slip(trial.signum()) } else { Slide::Stick };
        }
        s
    }
}
