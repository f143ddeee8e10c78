//! The pair-force loop over a bed as dense as a settled one, in f64 and in f32.
//!
//! The bed is hexagonal, compressed by 0.1 %, with three listed pairs per grain, in spatial order.
//!
//! * *One by one*: load both grains, compute the force, add it to both.
//! * *In lanes*: load the differences of 256 pairs, compute all forces in a loop that the compiler vectorises (SIMD),
//!   add them one by one in the order of the list.
//! * *Arithmetic*: the middle loop alone, a lower bound for every storage scheme.

use std::hint::black_box;
use std::time::Instant;

use crate::discs::{MASS, RADIUS, STIFFNESS, damping};
use crate::gas::uniform;
use crate::numbers::Real;

/// Data of a grain that a contact needs.
#[derive(Clone, Copy)]
struct Body<S> {
    x: [S; 2],
    v: [S; 2],
    radius: S,
    inverse_mass: S,
}

/// Number of pairs computed together.
const LANES: usize = 256;
/// Smallest number of pairs per timing: about a millisecond, so that some timings run without other load on the core.
const PAIRS: usize = 200_000;
/// Number of timings of each set of number types; the sets take turns.
const TIMINGS: usize = 201;

/// Differences of up to [`LANES`] pairs, and their forces. `F` is the number type of the arithmetic.
struct Chunk<F> {
    d: [[F; LANES]; 2],
    v: [[F; LANES]; 2],
    reach: [F; LANES],
    reduced: [F; LANES],
    force: [[F; LANES]; 2],
}

/// Returns the force on the first grain of a pair: k delta - 2 beta m_eff v_n along the normal, if they touch.
#[inline(always)]
#[expect(clippy::inline_always, reason = "the body of the loops that are timed")]
fn law<F: Real>(d: [F; 2], v: [F; 2], reach: F, reduced: F, stiffness: F, rate: F) -> [F; 2] {
    let distance = (d[0] * d[0] + d[1] * d[1]).root();
    let overlap = reach - distance;
    let inverse = F::ONE / distance;
    let n = [d[0] * inverse, d[1] * inverse];
    let force = stiffness * overlap - rate * reduced * (v[0] * n[0] + v[1] * n[1]);
    let force = if overlap > F::ZERO { force } else { F::ZERO };
    [force * n[0], force * n[1]]
}

struct Bed<S, F> {
    bodies: Vec<Body<S>>,
    pairs: Vec<(u32, u32)>,
    loads: Vec<[S; 2]>,
    chunk: Box<Chunk<F>>,
    stiffness: F,
    rate: F,
}

impl<S: Real, F: Real> Bed<S, F> {
    fn new(store: u32, rows: u32) -> Self {
        let pitch = 2.0 * RADIUS * 0.999;
        let body = |i: u32| {
            let column = f64::from(i % store);
            let row = f64::from(i / store);
            let x = [pitch * (column + 0.5 * (row % 2.0)), pitch * 0.75f64.sqrt() * row].map(S::of);
            let v = [0, 1].map(|axis| S::of(0.001 * uniform(axis, u64::from(i))));
            Body { x, v, radius: S::of(RADIUS), inverse_mass: S::of(1.0 / MASS) }
        };
        let mut pairs = Vec::new();
        for i in 0..store * rows {
            let column = i % store;
            let row = i / store;
            if column + 1 < store {
                pairs.push((i, i + 1));
            }
            let left = i64::from(column) - i64::from(1 - row % 2);
            for above in [left, left + 1] {
                if let Ok(above) = u32::try_from(above)
                    && above < store
                    && row + 1 < rows
                {
                    pairs.push((i, (row + 1) * store + above));
                }
            }
        }
        let none = [F::ZERO; LANES];
        Self {
            bodies: (0..store * rows).map(body).collect(),
            loads: vec![[S::ZERO; 2]; (store * rows) as usize],
            pairs,
            chunk: Box::new(Chunk { d: [none; 2], v: [none; 2], reach: none, reduced: none, force: [none; 2] }),
            stiffness: F::of(STIFFNESS),
            rate: F::of(damping(0.5).0 / (0.5 * MASS)),
        }
    }

    /// Returns the differences of a pair: separation, relative velocity, sum of the radii, reduced mass.
    #[inline(always)]
    #[expect(clippy::inline_always, reason = "as above")]
    fn differences(a: &Body<S>, b: &Body<S>) -> ([F; 2], [F; 2], F, F) {
        let round = |x: S| F::of(x.wide());
        (
            [round(a.x[0] - b.x[0]), round(a.x[1] - b.x[1])],
            [round(a.v[0] - b.v[0]), round(a.v[1] - b.v[1])],
            round(a.radius + b.radius),
            F::ONE / round(a.inverse_mass + b.inverse_mass),
        )
    }

    #[inline(always)]
    #[expect(clippy::inline_always, reason = "as above")]
    fn add(loads: &mut [[S; 2]], (i, j): (u32, u32), force: [F; 2]) {
        for axis in 0..2 {
            let part = S::of(force[axis].wide());
            loads[i as usize][axis] += part;
            loads[j as usize][axis] -= part;
        }
    }

    fn one_by_one(&mut self) {
        for &(i, j) in &self.pairs {
            let (d, v, reach, reduced) = Self::differences(&self.bodies[i as usize], &self.bodies[j as usize]);
            Self::add(&mut self.loads, (i, j), law(d, v, reach, reduced, self.stiffness, self.rate));
        }
    }

    fn in_lanes(&mut self) {
        for pairs in self.pairs.chunks(LANES) {
            let chunk = &mut *self.chunk;
            for (lane, &(i, j)) in pairs.iter().enumerate() {
                let (d, v, reach, reduced) = Self::differences(&self.bodies[i as usize], &self.bodies[j as usize]);
                [chunk.d[0][lane], chunk.d[1][lane]] = d;
                [chunk.v[0][lane], chunk.v[1][lane]] = v;
                (chunk.reach[lane], chunk.reduced[lane]) = (reach, reduced);
            }
            compute_forces(chunk, self.stiffness, self.rate);
            for (lane, &pair) in pairs.iter().enumerate() {
                Self::add(&mut self.loads, pair, [chunk.force[0][lane], chunk.force[1][lane]]);
            }
        }
    }

    fn arithmetic(&mut self) {
        for _ in self.pairs.chunks(LANES) {
            compute_forces(black_box(&mut *self.chunk), self.stiffness, self.rate);
        }
    }

    /// Returns the time, ns per pair.
    fn time(&mut self, work: fn(&mut Self)) -> f64 {
        let passes = PAIRS.div_ceil(self.pairs.len());
        let start = Instant::now();
        for _ in 0..passes {
            work(black_box(self));
        }
        #[expect(clippy::cast_precision_loss, reason = "at most 1e6")]
        let pairs = (passes * self.pairs.len()) as f64;
        start.elapsed().as_secs_f64() * 1.0e9 / pairs
    }
}

#[inline(never)]
fn compute_forces<F: Real>(chunk: &mut Chunk<F>, stiffness: F, rate: F) {
    for lane in 0..LANES {
        let d = [chunk.d[0][lane], chunk.d[1][lane]];
        let v = [chunk.v[0][lane], chunk.v[1][lane]];
        let force = law(d, v, chunk.reach[lane], chunk.reduced[lane], stiffness, rate);
        [chunk.force[0][lane], chunk.force[1][lane]] = force;
    }
}

/// Returns the smallest value and the median.
fn smallest_and_median(mut times: Vec<f64>) -> [f64; 2] {
    times.sort_by(f64::total_cmp);
    [times[0], times[times.len() / 2]]
}

pub fn rows(print_line: &mut impl FnMut(String)) {
    print_line(format!(
        "{:>8}  {:20}{:>8}{:>14}{:>8}{:>16}",
        "discs", "ns per pair", "f64", "f32 forces", "f32", "f64 over each"
    ));
    for (store, rows) in [(100, 100), (400, 250)] {
        let (mut double, mut mixed, mut single) =
            (Bed::<f64, f64>::new(store, rows), Bed::<f64, f32>::new(store, rows), Bed::<f32, f32>::new(store, rows));
        for kind in ["one by one", "in lanes", "arithmetic"] {
            let mut times = [Vec::new(), Vec::new(), Vec::new()];
            for _ in 0..TIMINGS {
                let [a, b, c] = match kind {
                    "one by one" => {
                        [double.time(Bed::one_by_one), mixed.time(Bed::one_by_one), single.time(Bed::one_by_one)]
                    }
                    "in lanes" => [double.time(Bed::in_lanes), mixed.time(Bed::in_lanes), single.time(Bed::in_lanes)],
                    _ => [double.time(Bed::arithmetic), mixed.time(Bed::arithmetic), single.time(Bed::arithmetic)],
                };
                times[0].push(a);
                times[1].push(b);
                times[2].push(c);
            }
            let times = times.map(smallest_and_median);
            for (which, name) in ["least", "median"].into_iter().enumerate() {
                let [a, b, c] = times.map(|time| time[which]);
                let gain = format!("{:.2}, {:.2}", a / b, a / c);
                print_line(format!("{:>8}  {kind:12}{name:8}{a:>8.2}{b:>14.2}{c:>8.2}{gain:>16}", store * rows));
            }
        }
    }
    let bytes = |body: usize, load: usize| body + load + 3 * size_of::<(u32, u32)>();
    print_line(format!(
        "smallest number of bytes per grain that a pass loads (body, load, three pairs): f64 {}, f32 {}",
        bytes(size_of::<Body<f64>>(), size_of::<[f64; 2]>()),
        bytes(size_of::<Body<f32>>(), size_of::<[f32; 2]>())
    ));
}
