//! Integration of the reference: the classical Runge-Kutta scheme, with steps that end where a contact's mode ends.
//!
//! Modes are frozen within a step, so the right-hand side is smooth and the scheme keeps its fourth order. After a step
//! the event functions of each contact are evaluated. If one is positive, its zero is found by bisection on the cubic
//! Hermite polynomial through both ends of the step (x from x, v; v from v, a; error O(h^4), like the scheme). The step
//! is then repeated up to the first of these zeros, and that contact enters its next mode. Samples between the ends of
//! a step are separate steps, so they do not change the path.
//!
//! The forces of Hertz's law begin like roots of time. After such a contact begins, a step is at most a twentieth of the time
//! since then.

use glam::DVec2;

use super::contact::{EVENTS, Link, Meeting, Normal, Other, SLIDERS, Side};
use super::{Clump, INERTIA, Piston, State, System};

/// A state with the springs (m) of friction and rolling of all contacts, or the rate of change of both.
#[derive(Clone, Debug)]
struct Flow {
    state: State,
    springs: Vec<[f64; SLIDERS]>,
}

/// The integrated motion of a system.
pub struct Path<'a> {
    system: &'a System,
    step: f64,
    time: f64,
    /// Time at which the last contact with a varying stiffness began, s.
    began: f64,
    flow: Flow,
    links: Vec<Link>,
    /// Positions of the discs at the last search for pairs, m.
    searched_positions: Vec<DVec2>,
    /// Largest gap of a pair that the search finds, m.
    margin: f64,
    /// Number of mode changes so far.
    pub switches: usize,
    /// Number of mode changes since time last advanced.
    switches_without_advance: u32,
}

impl<'a> Path<'a> {
    /// Begins at the system's start; steps are at most `step`, s.
    #[must_use]
    pub fn new(system: &'a System, step: f64) -> Self {
        let flow = Flow { state: system.start(), springs: Vec::new() };
        let radii = system.discs.iter().map(|disc| disc.radius).filter(|&radius| radius > 0.0);
        let smallest = radii.fold(f64::INFINITY, f64::min);
        let mut path = Self {
            system,
            step,
            time: 0.0,
            began: f64::NEG_INFINITY,
            flow,
            links: Vec::new(),
            searched_positions: Vec::new(),
            margin: 0.5 * smallest,
            switches: 0,
            switches_without_advance: 0,
        };
        path.find_pairs();
        path.close_overlapping_pairs();
        path
    }

    /// Integrates up to the last of `moments` (s, ascending) and returns the states at all of them.
    pub fn sample(&mut self, moments: &[f64]) -> Vec<State> {
        let mut samples = Vec::with_capacity(moments.len());
        while samples.len() < moments.len() {
            let (mut event, mut length, rate) = self.next_event();
            self.switches_without_advance =
                if length > 1e-9 * self.length() { 0 } else { self.switches_without_advance + 1 };
            // If a contact alternates between two modes, both are correct up to round-off: continue in the present one.
            if self.switches_without_advance > 40 {
                (event, length) = (None, self.length());
            }
            while let Some(&moment) = moments.get(samples.len()).filter(|&&moment| moment <= self.time + length) {
                samples.push(self.stepped(&rate, moment - self.time).state);
            }
            self.flow = self.stepped(&rate, length);
            self.time += length;
            if let Some((number, which)) = event {
                let meeting = self.meeting(&self.links[number], &self.flow.state, self.time);
                if self.links[number].varies() && self.links[number].normal == Normal::Open {
                    self.began = self.time;
                }
                self.flow.springs[number] = self.links[number].switch(which, &meeting, self.flow.springs[number]);
                self.switches += 1;
            }
            let mut positions = self.searched_positions.iter().zip(&self.flow.state.x);
            if positions.any(|(searched, x)| searched.distance(*x) > 0.4 * self.margin) {
                self.find_pairs();
            }
        }
        samples
    }

    /// Returns the length of the present step, s.
    fn length(&self) -> f64 {
        self.step.min(0.05 * (self.time - self.began) + 1e-10 * self.step)
    }

    /// Returns the first event within a step (contact, event function), the time until then (s), and the present rate.
    fn next_event(&self) -> (Option<(usize, usize)>, f64, Flow) {
        let rate = self.rate(&self.flow, self.time);
        let step = self.length();
        let end = self.stepped(&rate, step);
        let end_rate = self.rate(&end, self.time + step);
        let mut first = None;
        let mut length = step;
        for (number, link) in self.links.iter().enumerate() {
            let at = |t: f64| self.between(number, link, [&self.flow, &rate, &end, &end_rate], t);
            let short = 1e-3 * step;
            let events = link.alarms(&at, step, short);
            for which in (0..EVENTS).filter(|&which| events[which] > 0.0) {
                let moment = bisect(|t| link.alarms(&at, t, short)[which], step);
                if moment < length || first.is_none() {
                    (first, length) = (Some((number, which)), moment);
                }
            }
        }
        (first, length, rate)
    }

    /// Returns a contact's meeting and spring at the time `t` (s) after the beginning of a step.
    ///
    /// `ends` has the values and rates at both ends of the step, for cubic Hermite interpolation.
    fn between(&self, number: usize, link: &Link, ends: [&Flow; 4], t: f64) -> (Meeting, [f64; SLIDERS]) {
        let [y0, f0, y1, f1] = ends;
        let h = self.length();
        let u = t / self.length();
        let weights = [
            (1.0 + 2.0 * u) * (1.0 - u).powi(2),
            u * (1.0 - u).powi(2) * h,
            u * u * (3.0 - 2.0 * u),
            u * u * (u - 1.0) * h,
        ];
        let interpolate = |value: &dyn Fn(&Flow) -> DVec2| -> DVec2 {
            weights[0] * value(y0) + weights[1] * value(f0) + weights[2] * value(y1) + weights[3] * value(f1)
        };
        let side = |i: usize| Side {
            x: interpolate(&|flow| flow.state.x[i]),
            v: interpolate(&|flow| flow.state.v[i]),
            w: interpolate(&|flow| DVec2::new(flow.state.w[i], 0.0)).x,
        };
        let other = match link.other {
            Other::Disc(j) => side(j),
            Other::Floor(f) => self.floor(f, self.time + t, side),
        };
        let springs = interpolate(&|flow| DVec2::from_array(flow.springs[number]));
        (link.meeting(self.system, side(link.i), other), springs.to_array())
    }

    /// Returns the shift and the velocity of a floor at a time, s. `disc` has the place and the velocity of each disc then.
    fn floor(&self, number: usize, time: f64, disc: impl Fn(usize) -> Side) -> Side {
        let floor = &self.system.floors[number];
        if let Some(piston) = floor.piston {
            let side = disc(piston.disc);
            return Side { x: side.x - floor.point, ..side };
        }
        let [x, v] = floor.motion(time);
        Side { x, v, w: 0.0 }
    }

    fn meeting(&self, link: &Link, state: &State, time: f64) -> Meeting {
        let side = |i: usize| Side { x: state.x[i], v: state.v[i], w: state.w[i] };
        let other = match link.other {
            Other::Disc(j) => side(j),
            Other::Floor(f) => self.floor(f, time, side),
        };
        link.meeting(self.system, side(link.i), other)
    }

    /// Returns the rate of change at a time, s.
    fn rate(&self, flow: &Flow, time: f64) -> Flow {
        let discs = &self.system.discs;
        let mut a = vec![self.system.gravity; discs.len()];
        let mut turns = vec![0.0; discs.len()];
        let mut loads = vec![(DVec2::ZERO, 0.0); discs.len()];
        let mut springs = vec![[0.0; SLIDERS]; self.links.len()];
        for (number, link) in self.links.iter().enumerate().filter(|(_, link)| link.normal != Normal::Open) {
            let meeting = self.meeting(link, &flow.state, time);
            let (force, along, rolling) = link.force(&meeting, flow.springs[number]);
            springs[number] = link.spring_rates(&meeting, flow.springs[number]);
            let mut push = |i: usize, force: DVec2, rolling: f64| {
                let radius = discs[i].radius;
                a[i] += force / discs[i].mass;
                let torque = rolling - along * radius;
                turns[i] += torque / (INERTIA * discs[i].mass * radius * radius);
                loads[i] = (loads[i].0 + force, loads[i].1 + torque);
            };
            push(link.i, force, rolling);
            match link.other {
                Other::Disc(j) => push(j, -force, -rolling),
                Other::Floor(f) => {
                    if let Some(piston) = self.system.floors[f].piston {
                        loads[piston.disc].0 -= force;
                    }
                }
            }
        }
        for floor in &self.system.floors {
            let Some(Piston { disc, load, spring }) = floor.piston else { continue };
            let shift = (flow.state.x[disc] - floor.point).dot(floor.normal);
            let of_grains = loads[disc].0.dot(floor.normal);
            let pull = self.system.gravity.dot(floor.normal);
            a[disc] = floor.normal * (pull + (load - spring * shift + of_grains) / discs[disc].mass);
        }
        for clump in &self.system.clumps {
            self.move_rigidly(clump, &flow.state, &loads, (&mut a, &mut turns));
        }
        Flow { state: State { x: flow.state.v.clone(), v: a, w: turns }, springs }
    }

    /// Sets the accelerations of the discs of a clump from the loads (N, N m) on them.
    fn move_rigidly(
        &self,
        clump: &Clump,
        state: &State,
        loads: &[(DVec2, f64)],
        (a, turns): (&mut [DVec2], &mut [f64]),
    ) {
        let arm = |i: usize| state.x[i] - state.x[clump.centre];
        let members = || clump.members.clone();
        let force: DVec2 = members().map(|i| loads[i].0).sum();
        let torque: f64 = members().map(|i| loads[i].1 + arm(i).perp_dot(loads[i].0)).sum();
        let centre = self.system.gravity + force / self.system.discs[clump.centre].mass;
        let turn = torque / clump.inertia;
        (a[clump.centre], turns[clump.centre]) = (centre, turn);
        let spin = state.w[clump.centre];
        for i in members() {
            a[i] = centre + arm(i).perp() * turn - arm(i) * (spin * spin);
            turns[i] = turn;
        }
    }

    /// Returns the result of one Runge-Kutta step of length `h` (s) with frozen modes; `rate` is the rate at its
    /// beginning.
    fn stepped(&self, rate: &Flow, h: f64) -> Flow {
        let middle = self.time + 0.5 * h;
        let r2 = self.rate(&self.flow.plus(&[(0.5 * h, rate)]), middle);
        let r3 = self.rate(&self.flow.plus(&[(0.5 * h, &r2)]), middle);
        let r4 = self.rate(&self.flow.plus(&[(h, &r3)]), self.time + h);
        self.flow.plus(&[(h / 6.0, rate), (h / 3.0, &r2), (h / 3.0, &r3), (h / 6.0, &r4)])
    }

    /// Finds all pairs that may touch before the next search. Pairs that were known before keep their modes and
    /// springs.
    fn find_pairs(&mut self) {
        let discs = &self.system.discs;
        let x = &self.flow.state.x;
        let mut found = Vec::new();
        for i in 0..discs.len() {
            let near = |j: &usize| x[i].distance(x[*j]) < discs[i].radius + discs[*j].radius + self.margin;
            let pairs = (i + 1..discs.len()).filter(|&j| self.system.can_touch(i, j)).filter(near);
            found.extend(pairs.map(|j| (i, Other::Disc(j))));
            let floors = if self.system.touches(i) { self.system.floors.len() } else { 0 };
            found.extend((0..floors).map(|f| (i, Other::Floor(f))));
        }
        let old: Vec<_> =
            std::mem::take(&mut self.links).into_iter().zip(std::mem::take(&mut self.flow.springs)).collect();
        let mut old = old.into_iter().peekable();
        for (i, other) in found {
            let rank = |i: usize, other: Other| {
                (
                    i,
                    match other {
                        Other::Disc(j) => (0, j),
                        Other::Floor(f) => (1, f),
                    },
                )
            };
            while old.next_if(|(link, _)| rank(link.i, link.other) < rank(i, other)).is_some() {}
            let known = old.next_if(|(link, _)| (link.i, link.other) == (i, other));
            let (link, spring) = known.unwrap_or_else(|| (Link::new(self.system, i, other), [0.0; SLIDERS]));
            self.links.push(link);
            self.flow.springs.push(spring);
        }
        self.searched_positions.clone_from(x);
    }

    /// Puts pairs that overlap at the start into the closed mode.
    fn close_overlapping_pairs(&mut self) {
        for number in 0..self.links.len() {
            let meeting = self.meeting(&self.links[number], &self.flow.state, self.time);
            if meeting.overlap > 0.0 {
                self.flow.springs[number] = self.links[number].switch(0, &meeting, [0.0; SLIDERS]);
            }
        }
    }
}

impl Flow {
    /// Returns the sum of this state and multiples of rates.
    fn plus(&self, terms: &[(f64, &Self)]) -> Self {
        let mut sum = self.clone();
        for (factor, rate) in terms {
            let add = |to: &mut [DVec2], from: &[DVec2]| {
                to.iter_mut().zip(from).for_each(|(to, from)| *to += *from * *factor);
            };
            add(&mut sum.state.x, &rate.state.x);
            add(&mut sum.state.v, &rate.state.v);
            let add =
                |to: &mut [f64], from: &[f64]| to.iter_mut().zip(from).for_each(|(to, from)| *to += from * factor);
            add(&mut sum.state.w, &rate.state.w);
            add(sum.springs.as_flattened_mut(), rate.springs.as_flattened());
        }
        sum
    }
}

/// Returns the argument between 0 and `end` at which `value` becomes positive; 0 if it is positive at 0.
///
/// `value(end)` must be positive.
fn bisect(value: impl Fn(f64) -> f64, end: f64) -> f64 {
    if value(0.0) > 0.0 {
        return 0.0;
    }
    let mut low = 0.0;
    let mut high = end;
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if value(middle) > 0.0 { high = middle } else { low = middle }
    }
    high
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::super::closed::{after_bounce, damping_ratio, duration, flight};
    use super::super::{Disc, Floor, Friction, Law, Rolling, Vibration};
    use super::*;

    const K: f64 = 1.0e5;
    const M: [f64; 2] = [0.16, 0.09];

    fn linear(e: f64, attracts: bool) -> Law {
        Law::Linear { k: K, e, attracts, friction: None }
    }

    fn pair(law: Law) -> System {
        let discs = vec![
            Disc { radius: 0.04, mass: M[0], x: DVec2::ZERO, v: DVec2::ZERO },
            Disc { radius: 0.03, mass: M[1], x: DVec2::new(0.0, 0.0705), v: DVec2::NEG_Y },
        ];
        System { clumps: vec![], gravity: DVec2::ZERO, law, discs, floors: vec![] }
    }

    fn rough(v: DVec2) -> System {
        let law = Law::Linear {
            k: K,
            e: 0.5,
            attracts: false,
            friction: Some(Friction { k: 0.3 * K, share: 0.5, mu: 0.3, rolling: None }),
        };
        let discs = vec![Disc { radius: 0.04, mass: M[0], x: DVec2::new(0.0, 0.0405), v }];
        System { clumps: vec![], gravity: DVec2::ZERO, law, discs, floors: vec![Floor::still(DVec2::ZERO, DVec2::Y)] }
    }

    fn last(system: &System, step: f64, end: f64) -> State {
        Path::new(system, step).sample(&[end]).remove(0)
    }

    #[test]
    fn bounce_agrees_with_closed_form() {
        let reduced = M[0] * M[1] / (M[0] + M[1]);
        for attracts in [true, false] {
            for e in [1.0, 0.9, 0.5, 0.2] {
                let contact = duration(K, e, attracts, reduced);
                let system = pair(linear(e, attracts));
                let state = last(&system, contact / 1000.0, 0.0005 + 3.0 * contact);
                let exact = after_bounce(M, [system.discs[0].v, system.discs[1].v], e);
                // Runge-Kutta has an error of (w h)^5/120 per step, and of (w h)^4 w t/120 over a contact. This is
                // 3e-12 here for e = 1, and more for stronger damping. The moments of touch and parting have an error
                // of (w h)^4/384 of a step. The tolerance is ten times 3e-12.
                let error = (state.v[0] - exact[0]).length().max((state.v[1] - exact[1]).length());
                assert!(error < 3e-11, "e = {e}, attraction {attracts}: {error:e}");
            }
        }
    }

    #[test]
    fn sliding_impact_agrees_with_closed_form() {
        // The normal impulse is m (1 + e) v_n, and the friction impulse is mu times the normal impulse. The rim speed
        // of the disc changes by twice the friction impulse over m.
        let system = rough(DVec2::new(3.0, -1.0));
        let contact = duration(K, 0.5, false, M[0]);
        let state = last(&system, contact / 1000.0, 0.0005 + 3.0 * contact);
        let slowed = 0.3 * 1.5;
        assert!((state.v[0] - DVec2::new(3.0 - slowed, 0.5)).length() < 3e-11, "{}", state.v[0]);
        assert!((0.04 * state.w[0] + 2.0 * slowed).abs() < 3e-11, "{}", state.w[0]);
    }

    #[test]
    fn impact_of_hertz_has_the_restitution_of_its_law() {
        // A substitution of time turns the bounce into a linear one, so that e does not depend on the speed.
        for (e, mu) in [(0.9, 0.5), (0.5, 1.0e3), (0.2, 0.1)] {
            let law = Law::Hertz { young: 4.0e6, poisson: 0.3, e, mu };
            let system = System { law, ..rough(DVec2::new(0.5, -1.0)) };
            // The contact lasts 6 ms.
            let state = last(&system, 6e-3 / 400.0, 0.02);
            // Steps of a twentieth of the time since the touch have an error of 1e-10; damping begins with the power 1/4.
            assert!((state.v[0].y - e).abs() < 1e-8, "{e}: {:e}", state.v[0].y - e);
        }
    }

    #[test]
    fn rolling_resistance_stops_a_disc_as_its_torque_does() {
        // The disc hits the floor with v_t = 3, slides throughout and turns in one sense. Its rim speed changes by twice the
        // friction impulse, less twice the impulse of rolling resistance, both proportional to the normal impulse.
        let mut system = rough(DVec2::new(3.0, -1.0));
        let rolling = Some(Rolling { k: 1e3 * K, b: 1e5, mu: 0.1 });
        let friction = Some(Friction { k: 0.3 * K, share: 0.5, mu: 0.3, rolling });
        system.law = Law::Linear { k: K, e: 0.5, attracts: false, friction };
        let contact = duration(K, 0.5, false, M[0]);
        let state = last(&system, contact / 1000.0, 0.0005 + 3.0 * contact);
        let slowed = 0.3 * 1.5;
        let resisted = 0.1 * 1.5;
        // Rolling sticks at first, before the rolling velocity has loaded the stiff spring and dashpot to the cap.
        assert!((0.04 * state.w[0] + 2.0 * (slowed - resisted)).abs() < 2e-3, "{}", 0.04 * state.w[0]);
    }

    #[test]
    fn flight_is_a_parabola_and_sampling_does_not_change_it() {
        let mut system = pair(linear(0.5, true));
        system.gravity = DVec2::new(1.0, -9.81);
        system.discs[0].x = DVec2::new(5.0, 5.0);
        let many: Vec<f64> = (1..=50).map(|n| 0.011 * f64::from(n)).collect();
        let states = Path::new(&system, 1e-3).sample(&many);
        for (t, state) in many.iter().zip(&states) {
            let (x, v) = flight(system.discs[1].x, system.discs[1].v, system.gravity, *t);
            // The tolerance is about a hundred roundings of numbers of size 5.
            assert!((state.x[1] - x).length() + (state.v[1] - v).length() < 1e-12);
        }
        assert_eq!(Path::new(&system, 1e-3).sample(&many[49..])[0], states[49]);
    }

    #[test]
    fn a_disc_on_a_vibrating_floor_is_a_driven_oscillator() {
        // z'' = -w0^2 (z - A sin(w t)), with z the height above the place of touch: without damping, and bound to the floor.
        let amplitude = 1e-3;
        let frequency = 80.0;
        let mut system = rough(DVec2::ZERO);
        system.law = linear(1.0, true);
        system.discs[0].x.y = 0.04 - 5e-3;
        let vibration = Vibration { amplitude: DVec2::new(0.0, amplitude), frequency };
        system.floors[0].vibration = Some(vibration);
        let own = (K / M[0]).sqrt();
        let pulse = TAU * frequency;
        let end = 1.5e-3;
        let driven = amplitude / (1.0 - (pulse / own).powi(2));
        let z = driven * (pulse * end).sin() - 5e-3 * (own * end).cos() - driven * pulse / own * (own * end).sin();
        let state = last(&system, duration(K, 1.0, true, M[0]) / 1000.0, end);
        // As above, (w h)^4 w t/120 = 1e-12 of the amplitude of 5e-3 m. The tolerance is twenty times this.
        assert!(z < -1e-3 && (state.x[0].y - 0.04 - z).abs() < 1e-13, "{} {z}", state.x[0].y - 0.04);
    }

    #[test]
    fn order_is_four_through_touch_slip_stick_and_parting() {
        // Halving the step divides the difference from a much finer run by 16. The difference scatters with the
        // position of the mode changes within a step, so three halvings together must show at least an order of 3.4. A
        // missed kink would leave an order of 3.
        let smooth = pair(linear(0.2, false));
        let mut vibrating = rough(DVec2::new(0.5, -1.0));
        vibrating.floors[0].vibration = Some(Vibration { amplitude: DVec2::new(2e-4, 4e-4), frequency: 60.0 });
        for (name, system) in [
            ("smooth", smooth),
            ("slip", rough(DVec2::new(3.0, -1.0))),
            ("stick", rough(DVec2::new(0.5, -1.0))),
            ("floor that vibrates", vibrating),
        ] {
            let contact = duration(K, 0.5, false, M[0]);
            let end = 0.0005 + 3.0 * contact;
            let exact = last(&system, contact / 3000.0, end);
            let error = |n: f64| {
                let state = last(&system, contact / n, end);
                (state.v[0] - exact.v[0]).length() + 0.04 * (state.w[0] - exact.w[0]).abs()
            };
            let coarse = error(31.3);
            let fine = error(8.0 * 31.3);
            let order = (coarse / fine).log2() / 3.0;
            assert!(order > 3.4, "{name}: {coarse:e}, {fine:e}, order {order:.2}");
        }
    }

    #[test]
    fn oblique_impact_passes_through_all_modes() {
        // Touch, stick, slip near the end where the normal force goes to zero, cut, open: five mode changes with the
        // touch.
        let system = rough(DVec2::new(0.2, -1.0));
        let mut path = Path::new(&system, 1e-5);
        let _ = path.sample(&[0.02]);
        assert!((4..=8).contains(&path.switches), "{}", path.switches);
    }

    #[test]
    fn three_undamped_discs_conserve_energy() {
        let mut system = pair(linear(1.0, true));
        system.discs.push(Disc { radius: 0.04, mass: 0.2, x: DVec2::new(0.05, -0.08), v: DVec2::new(-1.0, 1.0) });
        let before = system.energy(&system.start());
        let step = duration(K, 1.0, true, 0.05) / 1000.0;
        let state = last(&system, step, 0.03);
        // About ten contacts, each with the error of a bounce as above.
        assert!((system.energy(&state) / before - 1.0).abs() < 1e-10);
        assert!(damping_ratio(1.0, true) == 0.0);
    }
}
