//! Test cases: systems with a known solution, and the error of a state against it.

use glam::DVec2;

use super::reference::closed::flight;
use super::reference::path::Path;
use super::reference::{Disc, Law, State, System};

/// Source of a case's exact solution.
#[derive(Clone, Copy, Debug)]
pub enum Truth {
    /// Closed form of the state at a time (s) after the system's start. No discs touch before a copy begins.
    Closed(fn(&System, f64) -> State),
    /// Integration by the independent [reference](super::reference).
    Integrated,
    /// Conservation of energy; the motion is chaotic and has no reference solution.
    Energy,
}

/// Definition of a case's error.
#[derive(Clone, Copy, Debug)]
pub enum Measure {
    /// Rms velocity error over discs, including the error of the rim speed R w, divided by this speed (m/s).
    Velocity(f64),
    /// Error of the relative velocity of the first two discs, divided by this speed (m/s). For a head-on bounce it is
    /// the error of the restitution e.
    Parting(f64),
    /// Rms position error over discs, divided by this length (m).
    Place(f64),
    /// Relative change of the energy.
    Energy,
}

/// A test case. Copies of its system stand side by side in one scene; each copy begins at a different phase of a step.
#[derive(Clone, Debug)]
pub struct Case {
    /// Name on the command line.
    pub name: &'static str,
    /// Title in tables and figures.
    pub title: &'static str,
    /// The systems. A single system is copied to [`PHASES`] phases of a step; several systems run once each.
    pub systems: Vec<System>,
    /// Contact duration t_c, s.
    pub contact_duration: f64,
    /// Time at which the error is evaluated, s. The evaluation is late by less than one step.
    pub end: f64,
    /// Source of the exact solution.
    pub truth: Truth,
    /// Definition of the error.
    pub measure: Measure,
    /// Finest t_c/dt of the ladder of steps.
    pub finest: f64,
    /// Time of the first contact, s, if the copies begin within half a step before it. Otherwise they begin within a step
    /// after the system's start.
    pub touch: Option<f64>,
}

/// Number of phases of a step at which copies of a system begin.
pub const PHASES: u32 = 40;

impl Case {
    /// Returns a case of one system whose exact solution is integrated: four contact durations, with errors of velocity over 1 m/s.
    #[must_use]
    pub(super) fn integrated(name: &'static str, title: &'static str, system: System, contact_duration: f64) -> Self {
        Self {
            name,
            title,
            systems: vec![system],
            contact_duration,
            end: 4.0 * contact_duration,
            truth: Truth::Integrated,
            measure: Measure::Velocity(1.0),
            finest: 1000.0,
            touch: None,
        }
    }

    /// Returns the number of copies of each system.
    #[must_use]
    pub fn phases(&self) -> u32 {
        if self.systems.len() == 1 { PHASES } else { 1 }
    }

    /// Returns the number of steps of `dt` (s) until the end.
    #[must_use]
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a small positive number")]
    pub fn steps(&self, dt: f64) -> u64 {
        (self.end / dt).ceil() as u64
    }

    /// Returns the delay of each copy against the system's start, s.
    fn start_delays(&self, dt: f64) -> Vec<f64> {
        let phases = self.phases();
        let part = |phase: u32| f64::from(phase) / f64::from(phases);
        let delay = |phase| match self.touch {
            Some(touch) => touch - 0.5 * dt * (1.0 - part(phase)),
            None => part(phase) * dt,
        };
        (0..phases).map(delay).collect()
    }

    /// Returns the start state and the exact end state of each copy for each of `steps` (s), and an estimate of the
    /// reference's own error.
    ///
    /// The estimate is the largest difference, by [`Case::error`], between the reference and the reference at twice its
    /// step.
    #[must_use]
    pub fn answers(&self, steps: &[f64]) -> (Vec<Vec<Answer>>, f64) {
        let mut answers = vec![Vec::new(); steps.len()];
        let mut error = 0.0f64;
        for system in &self.systems {
            // Moments at which the solution is needed: (time, step, copy, whether it is the end).
            let mut moments = Vec::new();
            for (number, &dt) in steps.iter().enumerate() {
                for (copy, start) in self.start_delays(dt).into_iter().enumerate() {
                    #[expect(clippy::cast_precision_loss, reason = "a small number")]
                    let end = start + self.steps(dt) as f64 * dt;
                    moments.extend([(start, number, copy, false), (end, number, copy, true)]);
                }
            }
            moments.sort_by(|a, b| a.0.total_cmp(&b.0));
            let times: Vec<f64> = moments.iter().map(|moment| moment.0).collect();
            let states = self.states(system, &times, &mut error);
            for (number, answers) in answers.iter_mut().enumerate() {
                for (copy, began) in self.start_delays(steps[number]).into_iter().enumerate() {
                    let find = |is_end| moments.iter().position(|m| (m.1, m.2, m.3) == (number, copy, is_end));
                    let state = |is_end| find(is_end).map_or_else(|| system.start(), |at| states[at].clone());
                    answers.push(Answer { system: system.clone(), began, start: state(false), end: state(true) });
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
        if t < 0.5 * self.end { state_in_flight(system, t) } else { form(system, t) }
    }

    /// Returns the error of `state` against the solution `answer`.
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

/// One copy of a system with its start and its solution.
#[derive(Clone, Debug)]
pub struct Answer {
    /// The copied system.
    pub system: System,
    /// Time of the system at the start of the run, s.
    pub began: f64,
    /// State at the start of the run.
    pub start: State,
    /// Exact state at the end of the run.
    pub end: State,
}

/// Returns the state after a time `t` (s) without contacts.
fn state_in_flight(system: &System, t: f64) -> State {
    let (x, v) = system.discs.iter().map(|disc| flight(disc.x, disc.v, system.gravity, t)).unzip();
    State { x, v, w: vec![0.0; system.discs.len()] }
}

/// Returns a disc at the position `x` (m) with the velocity `v` (m/s).
#[must_use]
pub fn disc(radius: f64, mass: f64, x: DVec2, v: DVec2) -> Disc {
    Disc { radius, mass, x, v }
}

/// Returns the linear law without friction.
#[must_use]
pub fn linear(k: f64, e: f64, attracts: bool) -> Law {
    Law::Linear { k, e, attracts, friction: None }
}
