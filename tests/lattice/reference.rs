//! A slow, literal reference of the lattice-gas silo automaton.
//!
//! It is written directly from the rules: the paper of Kozicki and Tejchman, the decisions in the module headers of
//! `siloflow::lattice_silo`, and the random draws of each decision. It is compared bit by bit with the fast implementation.
//! No value is cached that could become outdated. No pass reads a value that the same pass writes at another site.
//! Particles are pushed to their goal, with an assertion that the place is free. The phases carry the letters of the
//! specification.
//!
//! Conventions: a site is `s = column * stride + row`. Direction 0 is rest, 1..=12 are the velocities. Every mask has
//! bit `i` for direction `i`, so a mask of movers has bit 0 clear.

use std::collections::HashMap;

/// A displacement or momentum in the integer coordinates (X, Y). The physical vector is (X sqrt(3)/2, Y/2), y upwards.
pub type Vector = (isize, isize);

/// The rest state, the six nearest bonds clockwise from up, the six second-nearest bonds clockwise.
#[rustfmt::skip]
pub(crate) const VELOCITIES: [Vector; 13] = [
    (0, 0),
    (0, 2), (1, 1), (1, -1), (0, -2), (-1, -1), (-1, 1),
    (1, 3), (2, 0), (1, -3), (-1, -3), (-2, 0), (-1, 3),
];
/// All twelve moving directions.
const ALL: u16 = 0x1FFE;
/// The directions within 30 degrees of the horizontal, {2, 3, 5, 6, 8, 11}.
const HORIZONTAL: u16 = 1 << 2 | 1 << 3 | 1 << 5 | 1 << 6 | 1 << 8 | 1 << 11;
/// The directions that lead downwards, {3, 4, 5, 9, 10}.
const DOWNWARD: [usize; 5] = [3, 4, 5, 9, 10];
/// The unit of gravity, v4.
const GRAVITY: Vector = VELOCITIES[4];

/// The six probabilities, and the choice of wall friction: method 1 (random reflection) or 2 (stopping).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rules {
    pub p: f64,
    pub q: f64,
    pub b: f64,
    pub k: f64,
    pub g: f64,
    pub h: f64,
    pub random_reflection: bool,
}

/// Kind of a site.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    Fluid,
    Wall,
    Sink,
}

/// Returns the direction into which a blocked mover is reflected, given its site and its direction.
pub type Reflections = Box<dyn Fn(usize, usize) -> usize>;

/// Returns the opposite direction (1-4, 2-5, 3-6, 7-10, 8-11, 9-12).
pub(crate) fn opposite(d: usize) -> usize {
    match d {
        1..=3 | 7..=9 => d + 3,
        4..=6 | 10..=12 => d - 3,
        _ => panic!("direction {d} has no opposite"),
    }
}

/// Returns the set bits of a mask, ascending.
fn bits(mask: u16) -> impl Iterator<Item = usize> {
    (0..16).filter(move |&i| mask >> i & 1 == 1)
}

/// Returns the number of set bits.
fn count(mask: u16) -> usize {
    bits(mask).count()
}

fn plus(u: Vector, v: Vector) -> Vector {
    (u.0 + v.0, u.1 + v.1)
}

/// Returns the total momentum of a state or mask.
pub(crate) fn momentum(mask: u16) -> Vector {
    bits(mask).map(|i| VELOCITIES[i]).fold((0, 0), plus)
}

/// The finaliser of splitmix64.
fn mix(mut z: u64) -> u64 {
    z ^= z >> 30;
    z = z.wrapping_mul(0xBF58_476D_1CE4_E5B9);
    z ^= z >> 27;
    z = z.wrapping_mul(0x94D0_49BB_1331_11EB);
    z ^ (z >> 31)
}

/// The random stream of a site in one sub-step of one phase of one time step.
#[derive(Clone, Copy)]
pub(crate) struct Stream {
    pub(crate) key: u64,
}

impl Stream {
    pub(crate) fn new(seed: u64, site: usize, step: u64, phase: u64, sub_step: u64) -> Self {
        let place = (site as u64).wrapping_mul(0xD1B5_4A32_D192_ED03);
        let time = mix(step.wrapping_mul(8).wrapping_add(phase));
        let time = time.wrapping_add(sub_step.wrapping_mul(0x632B_E59B_D9B4_E019));
        Self { key: mix(seed ^ place ^ time) }
    }

    pub(crate) fn word(self, i: usize) -> u64 {
        let turn = (i as u64 + 1).wrapping_mul(0x9E37_79B9_7F4A_7C15);
        mix(self.key.wrapping_add(turn))
    }

    fn lo(self, i: usize) -> u32 {
        (self.word(i) & 0xFFFF_FFFF) as u32
    }

    pub(crate) fn hi(self, i: usize) -> u32 {
        (self.word(i) >> 32) as u32
    }

    /// Returns `how_many` different members of `from`, chosen one after another: pick `i` uses the high half of word
    /// `first + i`.
    fn subset(self, from: u16, how_many: usize, first: usize) -> u16 {
        let mut left = from;
        for i in 0..how_many {
            left &= !(1 << pick(left, self.hi(first + i)));
        }
        from & !left
    }
}

/// Whether an event with the given probability happens. Both numbers are exact in an f64: this is the integer
/// comparison.
pub(crate) fn happens(draw: u32, chance: f64) -> bool {
    f64::from(draw) < (chance * 4_294_967_296.0).round()
}

/// Returns the largest n in 0..=cap with draw < a^n.
fn geometric(draw: u32, a: f64, cap: usize) -> usize {
    let mut n = 0;
    let mut power = a;
    while n < cap && happens(draw, power) {
        n += 1;
        power *= a;
    }
    n
}

/// Returns a number in 0..n.
fn below(draw: u32, n: usize) -> usize {
    usize::try_from((u64::from(draw) * n as u64) >> 32).expect("less than n")
}

/// Returns the `below(draw, count)`-th set bit of a mask that is not empty, counted from the lowest.
fn pick(mask: u16, draw: u32) -> usize {
    bits(mask).nth(below(draw, count(mask))).expect("a pick from an empty mask")
}

/// The collision table: for m movers and momentum V, all masks of m movers with the sum nearest to V, ascending.
pub(crate) struct Table(pub(crate) HashMap<(usize, Vector), Vec<u16>>);

impl Table {
    pub(crate) fn new() -> Self {
        let masks: Vec<u16> = (0..=ALL).step_by(2).collect();
        let sums: Vec<Vector> = masks.iter().map(|&mask| momentum(mask)).collect();
        let mut lists = HashMap::new();
        for m in 0..=12 {
            let of_m: Vec<usize> = (0..masks.len()).filter(|&i| count(masks[i]) == m).collect();
            for v in (-8..=8).flat_map(|x| (-14..=12).map(move |y| (x, y))) {
                let distance = |i: usize| 3 * (sums[i].0 - v.0).pow(2) + (sums[i].1 - v.1).pow(2);
                let least = of_m.iter().map(|&i| distance(i)).min();
                let nearest = of_m.iter().filter(|&&i| Some(distance(i)) == least);
                lists.insert((m, v), nearest.map(|&i| masks[i]).collect());
            }
        }
        Self(lists)
    }

    /// Whether m movers can have exactly the momentum v.
    pub(crate) fn is_exact(&self, m: usize, v: Vector) -> bool {
        momentum(self.0[&(m, v)][0]) == v
    }

    /// Returns one of the masks nearest to v, uniformly.
    fn draw(&self, m: usize, v: Vector, draw: u32) -> u16 {
        let list = &self.0[&(m, v)];
        list[below(draw, list.len())]
    }
}

/// Values that the phases of one step pass to each other, per site.
struct Work {
    /// R: the place at rest is occupied.
    rest: Vec<bool>,
    /// R at the end of phase A.
    own: Vec<bool>,
    /// E: number of stopped particles that need a place at rest in the neighbourhood.
    extras: Vec<usize>,
    /// G: number of these particles that got a place.
    given: Vec<usize>,
    /// M: the moving particles.
    movers: Vec<u16>,
}

/// The automaton.
pub struct Reference {
    rules: Rules,
    seed: u64,
    stride: usize,
    lid_above: isize,
    kinds: Vec<Kind>,
    state: Vec<u16>,
    reflected: Reflections,
    table: Table,
    outflow: u64,
    steps: u64,
}

impl Reference {
    /// Creates a lattice with particles. `kinds[s]` and `state[s]` are given per site. Fluid sites have at least 3
    /// columns and rows of other sites around them. `lid_above` is the largest Y = 2 row + (column & 1) of any fluid
    /// site. `reflected` is called for every blocked mover. At each site it must be a bijection from the blocked
    /// directions to their opposites, for the kinds at the time of the step.
    ///
    /// # Panics
    /// If the lengths differ, or a particle is outside the fluid.
    #[must_use]
    pub fn new(
        rules: Rules,
        seed: u64,
        stride: usize,
        lid_above: isize,
        kinds: Vec<Kind>,
        state: Vec<u16>,
        reflected: Reflections,
    ) -> Self {
        assert_eq!(kinds.len(), state.len());
        for (kind, &particles) in kinds.iter().zip(&state) {
            assert!(particles <= 0x1FFF && (particles == 0 || *kind == Kind::Fluid), "a particle has no place");
        }
        let table = Table::new();
        Self { rules, seed, stride, lid_above, kinds, state, reflected, table, outflow: 0, steps: 0 }
    }

    /// Changes the kind of a site without particles: the outlet opens where walls become sinks. Blocked directions
    /// follow from the kinds. Call [`Self::set_reflections`] if the bijections change with them.
    ///
    /// # Panics
    /// If there are particles at the site.
    pub fn set_kind(&mut self, site: usize, kind: Kind) {
        assert_eq!(self.state[site], 0, "site {site} is not empty");
        self.kinds[site] = kind;
    }

    /// Replaces the reflections, which is necessary when the outlet opens.
    pub fn set_reflections(&mut self, reflected: Reflections) {
        self.reflected = reflected;
    }

    /// Returns the particles of every site: bit 0 at rest, bit i with velocity i.
    #[must_use]
    pub fn state(&self) -> &[u16] {
        &self.state
    }

    /// Returns the number of particles that have left through sinks.
    #[must_use]
    pub fn outflow(&self) -> u64 {
        self.outflow
    }

    /// Returns the number of particles.
    #[must_use]
    pub fn resident(&self) -> u64 {
        self.state.iter().map(|particles| u64::from(particles.count_ones())).sum()
    }

    /// Returns the number of time steps done.
    #[must_use]
    pub fn steps(&self) -> u64 {
        self.steps
    }

    /// Returns the site at the end of direction d.
    pub(crate) fn neighbour(&self, site: usize, d: usize) -> usize {
        let (dx, dy) = VELOCITIES[d];
        let parity = (site / self.stride % 2).cast_signed();
        let rows = (dy + parity - (parity + dx).rem_euclid(2)) / 2;
        site.checked_add_signed(dx * self.stride.cast_signed() + rows).expect("a bond leaves the lattice")
    }

    /// Returns the directions of a site that walls block: directions that end at a wall, and second-nearest bonds that
    /// pass between two walls.
    pub(crate) fn blocked(&self, site: usize) -> u16 {
        let is_wall = |d: usize| self.kinds[self.neighbour(site, d)] == Kind::Wall;
        let flanks = |d: usize| if d == 12 { (6, 1) } else { (d - 6, d - 5) };
        let is_blocked = |&d: &usize| is_wall(d) || (d >= 7 && is_wall(flanks(d).0) && is_wall(flanks(d).1));
        (1..=12).filter(is_blocked).fold(0, |mask, d| mask | 1 << d)
    }

    /// Returns the blocked directions with friction: none at a site that touches the smooth lid.
    pub(crate) fn rough(&self, site: usize) -> u16 {
        let column = site / self.stride;
        let row = site % self.stride;
        let y = (2 * row + column % 2).cast_signed();
        let blocked = self.blocked(site);
        let touches_lid = bits(blocked).any(|d| y + VELOCITIES[d].1 > self.lid_above);
        if touches_lid { 0 } else { blocked }
    }

    /// Returns the stream of a site in the current step (the first step has number 1).
    fn stream(&self, site: usize, phase: u64, sub_step: u64) -> Stream {
        Stream::new(self.seed, site, self.steps + 1, phase, sub_step)
    }

    /// Whether a site can take one more particle at rest.
    fn is_free(&self, site: usize, work: &Work) -> bool {
        self.kinds[site] == Kind::Fluid && !work.rest[site]
    }

    /// Performs one time step. Every pass visits the sites in the given order, which may contain other sites than fluid
    /// ones.
    ///
    /// # Panics
    /// If the order does not visit each fluid site once, or two particles get the same place.
    pub fn step(&mut self, order: &[usize]) {
        let order: Vec<usize> = order.iter().copied().filter(|&s| self.kinds[s] == Kind::Fluid).collect();
        self.check_order(&order);
        let sites = self.kinds.len();
        let mut work = Work {
            rest: vec![false; sites],
            own: vec![false; sites],
            extras: vec![0; sites],
            given: vec![0; sites],
            movers: vec![0; sites],
        };
        for &s in &order {
            self.stop(s, &mut work);
        }
        let occupancy: Vec<usize> = self.state.iter().map(|&particles| count(particles)).collect();
        self.scatter(&order, 2, &occupancy, &mut work);
        for &s in &order {
            work.movers[s] = self.collide(s, work.own[s], work.given[s]);
        }
        if self.rules.b > 0.0 && !self.rules.random_reflection {
            self.rub(&order, &mut work);
        }
        let mut left = self.fall(&order, &mut work);
        left += self.propagate(&order, &work);
        self.outflow += left;
        self.steps += 1;
    }

    /// Panics unless the order visits each fluid site once.
    fn check_order(&self, order: &[usize]) {
        let mut visits = vec![0; self.kinds.len()];
        for &s in order {
            visits[s] += 1;
        }
        for (s, &kind) in self.kinds.iter().enumerate() {
            assert_eq!(visits[s], i32::from(kind == Kind::Fluid), "visits of site {s}");
        }
    }

    /// Phase A: determines how many particles of a site stop.
    fn stop(&self, s: usize, work: &mut Work) {
        let at_rest = self.state[s] & 1 == 1;
        let moving = self.state[s] & ALL;
        let all = count(self.state[s]);
        let stopped = if moving == 0 {
            usize::from(at_rest)
        } else if all == 1 {
            0
        } else {
            let drawn = geometric(self.stream(s, 1, 0).hi(0), self.rules.p, all).max(all.saturating_sub(12));
            let elastic = self.rules.p == 0.0 && drawn == 0 && at_rest;
            if elastic && !self.table.is_exact(all, momentum(moving)) { 1 } else { drawn }
        };
        work.own[s] = stopped > 0;
        work.rest[s] = stopped > 0;
        work.extras[s] = stopped.saturating_sub(1);
    }

    /// Phase B; phase D uses it too. Extra particles go to rest at nearest neighbours, lowest occupancy first.
    fn scatter(&self, order: &[usize], phase: u64, occupancy: &[usize], work: &mut Work) {
        for round in 0..2 {
            let mut proposals = vec![0u16; self.kinds.len()];
            for &s in order {
                let stream = self.stream(s, phase, 2 * round);
                let mut goals: Vec<(usize, u64, usize)> = (1..=6)
                    .filter(|&d| self.is_free(self.neighbour(s, d), work))
                    .map(|d| (occupancy[self.neighbour(s, d)], stream.word(d), d))
                    .collect();
                goals.sort_unstable();
                for &(_, _, d) in goals.iter().take(work.extras[s] - work.given[s]) {
                    proposals[self.neighbour(s, d)] |= 1 << d;
                }
            }
            for (_, goal, from) in self.accept(order, phase, 2 * round + 1, &proposals) {
                work.rest[goal] = true;
                work.given[from] += 1;
            }
        }
    }

    /// Returns the accepted proposals, one for each site that has any: (direction, receiver, donor).
    fn accept(&self, order: &[usize], phase: u64, sub_step: u64, proposals: &[u16]) -> Vec<(usize, usize, usize)> {
        let choose = |&s: &usize| {
            let d = pick(proposals[s], self.stream(s, phase, sub_step).hi(0));
            (d, s, self.neighbour(s, opposite(d)))
        };
        order.iter().filter(|&&s| proposals[s] != 0).map(choose).collect()
    }

    /// Phase C: returns the movers of a site after the collision; `own` and `given` count the particles that came to
    /// rest.
    fn collide(&self, s: usize, own: bool, given: usize) -> u16 {
        let Rules { q, k, g, .. } = self.rules;
        let particles = self.state[s];
        let all = count(particles);
        if particles & ALL == 0 {
            return 0;
        }
        let stream = self.stream(s, 3, 0);
        let kicked = |v: Vector| if happens(stream.lo(1), g) { plus(v, GRAVITY) } else { v };
        if all == 1 {
            return self.table.draw(1, kicked(momentum(particles)), stream.hi(1));
        }
        let at_rest = usize::from(own) + given;
        let m = all - at_rest;
        if m == 0 {
            return 0;
        }
        let lost = stream.subset(particles, geometric(stream.lo(0), q, all), 2);
        let mut v = momentum(particles & !lost);
        if happens(stream.hi(0), k) {
            v = momentum(stream.subset(HORIZONTAL, m.min(6), 14));
        }
        if at_rest >= 2 && !self.table.is_exact(m, v) {
            return stream.subset(ALL, m, 26);
        }
        self.table.draw(m, kicked(v), stream.hi(1))
    }

    /// Phase D, method 2: movers stop at rough walls.
    fn rub(&self, order: &[usize], work: &mut Work) {
        let mut stopped = vec![0u16; self.kinds.len()];
        for &s in order {
            let stream = self.stream(s, 6, 0);
            for d in bits(work.movers[s] & self.rough(s)) {
                if happens(stream.hi(d), self.rules.b) {
                    stopped[s] |= 1 << d;
                }
            }
            if stopped[s] != 0 && !work.rest[s] {
                let first = 1 << pick(stopped[s], stream.hi(0));
                stopped[s] &= !first;
                work.movers[s] &= !first;
                work.rest[s] = true;
            }
            work.extras[s] = count(stopped[s]);
            work.given[s] = 0;
        }
        let occupancy: Vec<usize> = work.movers.iter().map(|&movers| count(movers)).collect();
        self.scatter(order, 7, &occupancy, work);
        for &s in order {
            work.movers[s] &= !self.stream(s, 6, 0).subset(stopped[s], work.given[s], 13);
        }
    }

    /// Phase E: particles at rest fall. Returns the number of particles that fell into sinks.
    fn fall(&self, order: &[usize], work: &mut Work) -> u64 {
        let mut proposals = vec![0u16; self.kinds.len()];
        let mut gone = Vec::new();
        for &s in order.iter().filter(|&&s| work.rest[s]) {
            let stream = self.stream(s, 4, 0);
            let blocked = self.blocked(s);
            let is_open = |goal: usize| self.is_free(goal, work) || self.kinds[goal] == Kind::Sink;
            let ways = DOWNWARD.into_iter().filter(|&d| blocked >> d & 1 == 0 && is_open(self.neighbour(s, d)));
            let ways = ways.fold(0, |mask, d| mask | 1 << d);
            if ways != 0 && happens(stream.hi(0), self.rules.h) {
                let d = pick(ways, stream.hi(1));
                let goal = self.neighbour(s, d);
                match self.kinds[goal] {
                    Kind::Sink => gone.push(s),
                    _ => proposals[goal] |= 1 << d,
                }
            }
        }
        for &s in &gone {
            work.rest[s] = false;
        }
        for (_, goal, from) in self.accept(order, 4, 1, &proposals) {
            work.rest[goal] = true;
            work.rest[from] = false;
        }
        gone.len() as u64
    }

    /// Phase F: the movers move or are reflected, which completes the new state. Returns the number that moved into
    /// sinks.
    fn propagate(&mut self, order: &[usize], work: &Work) -> u64 {
        let mut next = vec![0u16; self.kinds.len()];
        let mut put = |site: usize, i: usize| {
            assert_eq!(next[site] >> i & 1, 0, "two particles in state {i} of site {site}");
            next[site] |= 1 << i;
        };
        let mut gone = 0;
        for &s in order {
            if work.rest[s] {
                put(s, 0);
            }
            let blocked = self.blocked(s);
            let at_random = self.rules.random_reflection && self.rules.b > 0.0 && self.rough(s) != 0;
            let mut slots = bits(blocked).fold(0, |mask, d| mask | 1 << opposite(d));
            for d in bits(work.movers[s]) {
                let goal = self.neighbour(s, d);
                if blocked >> d & 1 == 1 {
                    let draw = self.stream(s, 5, 0).hi(d);
                    let new = if at_random { pick(slots, draw) } else { (self.reflected)(s, d) };
                    assert_eq!(slots >> new & 1, 1, "site {s}: direction {d} reflected into {new}");
                    slots &= !(1 << new);
                    put(s, new);
                } else if self.kinds[goal] == Kind::Sink {
                    gone += 1;
                } else {
                    put(goal, d);
                }
            }
        }
        self.state = next;
        gone
    }
}
