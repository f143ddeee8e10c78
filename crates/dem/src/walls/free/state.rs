//! The state of a free wall, and one step of it.

use serde::{Deserialize, Serialize};

use crate::space::Space;
use crate::values::{Finite, NonNegative, Positive};
use crate::walls::free::FreeWall;

/// The state of a free wall. Coordinates are in m or rad, forces in N or N m.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize, Serialize)]
pub struct FreeState {
    /// The coordinate.
    pub coordinate: f64,
    /// The coordinate at the end of the step before.
    pub before: f64,
    /// The rate at the end of the step.
    pub rate: f64,
    /// The rate in the middle of the step.
    middle: f64,
    /// The rate of the surfaces: from the drift to the force pass that with which grains meet them, afterwards that at the end of the step.
    pub(in crate::walls) shown: f64,
    /// The acceleration at the end of the step; 0 for a servo.
    acceleration: f64,
    /// The force of the grains at the end of the step.
    pub of_grains: f64,
    /// All other forces at the end of the step.
    pub applied: f64,
    /// Work of all other forces, J.
    pub work: f64,
    /// Energy that stops have taken, J.
    pub lost: f64,
    /// How often the wall has met a stop.
    pub hits: u32,
}

/// Forces other than that of the grains, at a coordinate, as functions of the rate: `constant` - `damping` rate + motor.
#[derive(Clone, Copy, Debug)]
struct Applied {
    constant: f64,
    damping: f64,
    /// Speed, gain and limit of the motor.
    motor: Option<[f64; 3]>,
}

impl Applied {
    fn of<V: Space>(wall: &FreeWall, coordinate: f64, time: f64, gravity: V) -> Self {
        let spring = wall
            .spring
            .map_or(0.0, |spring| spring.stiffness.get() * (spring.rest.map_or(0.0, Finite::get) - coordinate));
        let load = wall.load.as_ref().map_or(0.0, |load| load.at(time));
        Self {
            constant: load + spring + wall.weight(coordinate, gravity),
            damping: wall.damping.map_or(0.0, NonNegative::get),
            motor: wall.motor.map(|motor| [motor.speed.get(), motor.gain.get(), motor.limit.get()]),
        }
    }

    /// The force at a rate.
    fn at(&self, rate: f64) -> f64 {
        let motor = self.motor.map_or(0.0, |[speed, gain, limit]| (gain * (speed - rate)).clamp(-limit, limit));
        self.constant - self.damping * rate + motor
    }

    /// Solves v = start + h (force + forces at v)/inertia for the rate v.
    fn rate_after(&self, start: f64, force: f64, h: f64, inertia: f64) -> f64 {
        let share = h / inertia;
        let solve = |constant: f64, damping: f64| (start + share * (force + constant)) / (1.0 + share * damping);
        let Some([speed, gain, limit]) = self.motor else { return solve(self.constant, self.damping) };
        let free = solve(self.constant + gain * speed, self.damping + gain);
        let pull = gain * (speed - free);
        if pull.abs() <= limit { free } else { solve(self.constant + limit.copysign(pull), self.damping) }
    }
}

impl FreeState {
    /// The state at the start.
    pub(in crate::walls) fn new(wall: &FreeWall) -> Self {
        let rate = wall.rate.map_or(0.0, Finite::get);
        Self { rate, shown: rate, ..Self::default() }
    }

    /// Whether the walls are held at a time, s.
    fn is_held(wall: &FreeWall, time: f64) -> bool {
        wall.from.is_some_and(|from| time < from.get())
    }

    /// Moves the coordinate by a step of `dt` (s) that ends at `time`, s.
    ///
    /// Grains meet the wall with the rate in the middle of the step, or with the one that `is_predicted` for its end.
    pub(in crate::walls) fn drift(&mut self, wall: &FreeWall, dt: f64, time: f64, is_predicted: bool) {
        self.before = self.coordinate;
        self.middle = 0.0;
        self.shown = 0.0;
        if Self::is_held(wall, time) {
            return;
        }
        self.middle = self.rate + 0.5 * dt * self.acceleration;
        let free = self.coordinate + dt * self.middle;
        let [low, high] = wall.range();
        self.coordinate = free.clamp(low, high);
        if free < low || free > high {
            if self.before > low && self.before < high {
                self.hits = self.hits.saturating_add(1);
            }
            self.lost += 0.5 * wall.moved_inertia().unwrap_or(0.0) * self.middle * self.middle;
            self.middle = 0.0;
        } else {
            self.shown = self.middle + if is_predicted { 0.5 * dt * self.acceleration } else { 0.0 };
        }
    }

    /// The part of the rate with which grains meet the wall that is gained after the middle of the step.
    pub(in crate::walls) fn gained(&self) -> f64 {
        self.shown - self.middle
    }

    /// Takes the force of the grains (N or N m) at the end of a step of `dt` (s), or without `dt` at the start.
    pub(in crate::walls) fn kick<V: Space>(
        &mut self,
        wall: &FreeWall,
        force: f64,
        dt: Option<f64>,
        time: f64,
        gravity: V,
    ) {
        let power = self.applied * self.rate;
        self.of_grains = force;
        let applied = Applied::of(wall, self.coordinate, time, gravity);
        if Self::is_held(wall, time) {
            self.applied = -force;
            self.acceleration = 0.0;
            self.shown = 0.0;
            return;
        }
        match (wall.moved_inertia(), wall.gain.map(Positive::get)) {
            (Some(inertia), _) => {
                if let Some(dt) = dt {
                    self.rate = applied.rate_after(self.middle, force, 0.5 * dt, inertia);
                }
                self.applied = applied.at(self.rate);
                self.acceleration = (force + self.applied) / inertia;
            }
            (None, gain) => {
                self.rate = gain.unwrap_or(0.0) * (force + applied.constant);
                self.applied = applied.constant;
                self.acceleration = 0.0;
            }
        }
        self.rest_at_stops(wall);
        self.shown = self.rate;
        if let Some(dt) = dt {
            self.work += 0.5 * dt * (power + self.applied * self.rate);
        }
    }

    /// Holds the wall at a stop against which it is pushed.
    fn rest_at_stops(&mut self, wall: &FreeWall) {
        let [low, high] = wall.range();
        let is_pushed = |towards: f64| {
            self.rate * towards >= 0.0 && (self.acceleration * towards > 0.0 || self.rate * towards > 0.0)
        };
        let rests = (self.coordinate <= low && is_pushed(-1.0)) || (self.coordinate >= high && is_pushed(1.0));
        if rests {
            self.rate = 0.0;
            self.acceleration = 0.0;
        }
    }

    /// Whether all numbers are finite.
    #[must_use]
    pub fn is_finite(&self) -> bool {
        [self.coordinate, self.rate, self.acceleration].into_iter().all(f64::is_finite)
    }

    /// Kinetic energy, J.
    #[must_use]
    pub fn kinetic(&self, wall: &FreeWall) -> f64 {
        0.5 * wall.moved_inertia().unwrap_or(0.0) * self.rate * self.rate
    }
}
