//! What a case is: a system with a known answer, and how far off a state is.

use glam::DVec2;

use super::reference::closed::flight;
use super::reference::path::Path;
use super::reference::{Disc, Law, State, System};

/// Where the right answer comes from.
#[derive(Clone, Copy, Debug)]
pub enum Truth {
    /// A closed form of the state after a time (s) from the system's start; nothing touches before the first step is over.
    Closed(fn(&System, f64) -> State),
    /// The independent integration.
    Integrated,
    /// Energy is kept; motion is chaotic and has no answer of its own.
    Energy,
}

/// What counts as error.
#[derive(Clone, Copy, Debug)]
pub enum Measure {
    /// Rms over discs of the error of the velocity, that of the rim, R w, included, over this speed, m/s.
    Velocity(f64),
    /// Error of the relative velocity of the first two discs over this speed, m/s: for a head-on bounce, that of e.
    Parting(f64),
    /// Rms over discs of the error of the place over this length, m.
    Place(f64),
    /// Change of the energy, over the energy.
    Energy,
}

/// A case. Copies of its system stand side by side in one scene, so each begins at another moment of a step.
#[derive(Clone, Debug)]
pub struct Case {
    /// On the command line.
    pub name: &'static str,
    /// For people.
    pub title: &'static str,
    /// The systems: copies of one at different phases of a step, or different ones.
    pub systems: Vec<System>,
    /// t_c, s.
    pub contact_duration: f64,
    /// When the error is looked at, s; a step later at most.
    pub end: f64,
    /// Where the answer comes from.
    pub truth: Truth,
    /// What counts.
    pub measure: Measure,
    /// The finest t_c/dt at which it is run by default.
    pub finest: f64,
}

/// Phases of the step at which copies of a case begin.
pub const PHASES: u32 = 40;

impl Case {
    /// How many copies of each system run.
    #[must_use]
    pub fn phases(&self) -> u32 {
        if self.systems.len() == 1 { PHASES } else { 1 }
    }

    /// Steps of `dt` until the end.
    #[must_use]
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a small positive number")]
    pub fn steps(&self, dt: f64) -> u64 {
        (self.end / dt).ceil() as u64
    }

    /// By how much the copies start later than the system, s.
    fn starts(&self, dt: f64) -> Vec<f64> {
        let phases = self.phases();
        (0..phases).map(|phase| f64::from(phase) / f64::from(phases) * dt).collect()
    }

    /// Where each copy begins and where it should end, for each of `steps` (s), and how far off the reference says it is at
    /// most: the difference from itself at twice the step, as [`Case::error`] has it.
    #[must_use]
    pub fn answers(&self, steps: &[f64]) -> (Vec<Vec<Answer>>, f64) {
        let mut answers = vec![Vec::new(); steps.len()];
        let mut error = 0.0f64;
        for system in &self.systems {
            // Every moment that is asked for, (step, copy, whether it is the end).
            let mut moments = Vec::new();
            for (number, &dt) in steps.iter().enumerate() {
                for (copy, start) in self.starts(dt).into_iter().enumerate() {
                    #[expect(clippy::cast_precision_loss, reason = "a small number")]
                    let end = start + self.steps(dt) as f64 * dt;
                    moments.extend([(start, number, copy, false), (end, number, copy, true)]);
                }
            }
            moments.sort_by(|a, b| a.0.total_cmp(&b.0));
            let times: Vec<f64> = moments.iter().map(|moment| moment.0).collect();
            let states = self.states(system, &times, &mut error);
            for (number, answers) in answers.iter_mut().enumerate() {
                for copy in 0..self.phases() as usize {
                    let find = |is_end| moments.iter().position(|m| (m.1, m.2, m.3) == (number, copy, is_end));
                    let state = |is_end| find(is_end).map_or_else(|| system.start(), |at| states[at].clone());
                    answers.push(Answer { system: system.clone(), start: state(false), end: state(true) });
                }
            }
        }
        (answers, error)
    }

    fn states(&self, system: &System, times: &[f64], error: &mut f64) -> Vec<State> {
        match self.truth {
            Truth::Closed(form) => times.iter().map(|&t| self.closed(system, t, form)).collect(),
            Truth::Energy => times.iter().map(|_| system.start()).collect(),
            Truth::Integrated => {
                let step = self.contact_duration / 400.0;
                let fine = Path::new(system, step).sample(times);
                let coarse = Path::new(system, 2.0 * step).sample(times);
                let differences = fine.iter().zip(&coarse).map(|(fine, coarse)| self.error(system, coarse, fine));
                *error = differences.fold(*error, f64::max);
                fine
            }
        }
    }

    fn closed(&self, system: &System, t: f64, form: fn(&System, f64) -> State) -> State {
        if t < 0.5 * self.end { flown(system, t) } else { form(system, t) }
    }

    /// How far `state` is from `answer`.
    #[must_use]
    pub fn error(&self, system: &System, state: &State, answer: &State) -> f64 {
        #[expect(clippy::cast_precision_loss, reason = "a small number")]
        let count = system.discs.len() as f64;
        let mean = |square: &dyn Fn(usize, &Disc) -> f64| {
            (system.discs.iter().enumerate().map(|(i, disc)| square(i, disc)).sum::<f64>() / count).sqrt()
        };
        match self.measure {
            Measure::Velocity(scale) => {
                let square = |i: usize, disc: &Disc| {
                    let rim = disc.radius * (state.w[i] - answer.w[i]);
                    (state.v[i] - answer.v[i]).length_squared() + rim * rim
                };
                mean(&square) / scale
            }
            Measure::Parting(scale) => ((state.v[1] - state.v[0]) - (answer.v[1] - answer.v[0])).length() / scale,
            Measure::Place(scale) => mean(&|i, _| (state.x[i] - answer.x[i]).length_squared()) / scale,
            Measure::Energy => {
                let before = system.energy(answer);
                (system.energy(state) - before).abs() / before.abs()
            }
        }
    }
}

/// One copy: where it begins and where it should end.
#[derive(Clone, Debug)]
pub struct Answer {
    /// Whose.
    pub system: System,
    /// At the first moment of the run.
    pub start: State,
    /// At its end.
    pub end: State,
}

/// The state after `t` if nothing touches.
fn flown(system: &System, t: f64) -> State {
    let (x, v) = system.discs.iter().map(|disc| flight(disc.x, disc.v, system.gravity, t)).unzip();
    State { x, v, w: vec![0.0; system.discs.len()] }
}

/// A disc at (x, y) with velocity v.
#[must_use]
pub fn disc(radius: f64, mass: f64, x: DVec2, v: DVec2) -> Disc {
    Disc { radius, mass, x, v }
}

/// The linear law without friction.
#[must_use]
pub fn linear(k: f64, e: f64, attracts: bool) -> Law {
    Law::Linear { k, e, attracts, friction: None }
}
