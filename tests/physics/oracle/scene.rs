//! Random dense beds: bodies, walls and laws for the naive simulator. `scene_text` writes the same bed for siloflow.

use std::collections::BTreeMap;

use siloflow_oracle::clump::Clump;
use siloflow_oracle::free_wall::{FreeWall, Way};
use siloflow_oracle::law::{Law, Material, Terms};
use siloflow_oracle::simulator::{Body, FLAT, Scheme, Simulator};
use siloflow_oracle::vector::V;
use siloflow_oracle::wall::{Shape, Wall};

use crate::oracle::shaped::{Shaped, make_shaped};

/// Mean distance of neighbours, m. With the radii below, some grains overlap by a tenth of a radius and some do not
/// touch.
const SPACING: f64 = 0.08;
const RADII: [f64; 4] = [0.036, 0.038, 0.041, 0.044];
/// The lower end of the box along x and y, m.
const LOW: f64 = -0.1;
/// Time step, s; about a thirtieth of a contact duration.
pub const DT: f64 = 2.0e-4;

/// Number of grains that enter, and the number of steps between two of them.
pub const RELEASES: u64 = 3;
pub const RELEASE_EVERY: u64 = 12;

/// Walls and periodic sides around the bed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Surroundings {
    /// Half-planes on all sides but the top.
    Walls,
    /// Periodic sides, a belt as floor, wall grains at rest and moving; three species.
    Chute,
    /// Oblique half-planes, segments, in solid space a panel; three species.
    Fittings,
    /// Periodic sides along all axes.
    Nothing,
    /// Periodic sides, wall grains, and no floor: a grain that falls is removed; three species.
    Hole,
    /// Periodic sides and a floor. Grains that fly along the surface enter one after the other.
    Rain,
}

impl Surroundings {
    pub const ALL: [Self; 6] = [Self::Walls, Self::Chute, Self::Fittings, Self::Nothing, Self::Hole, Self::Rain];
}

#[derive(Clone, Debug)]
pub struct Scene {
    pub solid: bool,
    pub around: Surroundings,
    pub scheme: Scheme,
    /// The default law and, with three species, the law of species 0 with species 1.
    pub laws: Vec<Law>,
    pub materials: Vec<Material>,
    pub bodies: Vec<Body>,
    pub has_shapes: bool,
    /// Grains of several spheres, the same for the naive simulator and for siloflow.
    pub clumps: Vec<Clump>,
    pub shaped: Vec<Shaped>,
    pub walls: Vec<Wall>,
    pub periodic: [Option<(f64, f64)>; 3],
    pub gravity: V,
}

/// A linear congruential generator (Knuth's MMIX).
struct Random(u64);

impl Random {
    /// Returns a number from -1 to 1.
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / 2f64.powi(52) - 1.0
    }

    fn vector(&mut self, half_width: f64) -> V {
        V([self.next(), self.next(), self.next()]) * half_width
    }
}

impl Scene {
    /// Creates a bed with `sites` lattice sites along each axis.
    pub fn new(law: Law, solid: bool, around: Surroundings, scheme: Scheme, sites: [usize; 3]) -> Self {
        let up = if solid { 2 } else { 1 };
        let mut gravity = V([1.5, 0.0, 0.0]);
        gravity.0[up] = -9.0;
        let is_mixed = matches!(around, Surroundings::Chute | Surroundings::Fittings | Surroundings::Hole);
        let mut laws = vec![law];
        if is_mixed {
            // The default law with other numbers.
            let mut other = law;
            other.numbers().into_iter().for_each(|(_, number)| *number *= 0.8);
            laws.push(other);
        }
        let all = [(3.0e6, 0.3), (4.0e6, 0.2), (2.5e6, 0.4)];
        let materials = all.iter().take(if is_mixed { 3 } else { 1 });
        let materials = materials.map(|&(young, poisson)| Material { young, poisson }).collect();
        let high = |axis: usize| LOW + SPACING * sites[axis] as f64;
        let mut periodic = [None; 3];
        let open_axes = if around == Surroundings::Nothing { up + 1 } else { up };
        if matches!(around, Surroundings::Chute | Surroundings::Nothing | Surroundings::Hole | Surroundings::Rain) {
            (0..open_axes).for_each(|axis| periodic[axis] = Some((LOW, high(axis))));
        }
        let mut scene = Self {
            solid,
            around,
            scheme,
            laws,
            materials,
            bodies: Vec::new(),
            has_shapes: false,
            clumps: Vec::new(),
            shaped: Vec::new(),
            walls: Vec::new(),
            periodic,
            gravity,
        };
        scene.fill(sites);
        scene.surround(up, [high(0), high(1)]);
        scene
    }

    /// Lets forces move the floor up and down.
    pub fn with_free_floor(mut self) -> Self {
        let up = self.up();
        let floor = &mut self.walls[0];
        let Shape::Half { normal, .. } = floor.shape else { panic!("the floor is a half-space") };
        assert!(normal.0[up] == 1.0, "the floor is level");
        floor.free = Some(FreeWall {
            way: Way::Along(normal),
            home: floor.shape,
            inertia: 6.0,
            mass: 6.0,
            centre: V::default(),
            load: 150.0,
            stiffness: 3.0e4,
            damping: 40.0,
            place: 0.0,
            rate: 0.3,
            gained: 0.0,
            acceleration: 0.0,
        });
        self
    }

    /// Lets forces turn the last of the fittings, a flap between two layers: in the plane a segment, in solid space a panel.
    pub fn with_flap(mut self) -> Self {
        let solid = self.solid;
        let flap = self.walls.last_mut().unwrap();
        let (point, axis, tip) = match flap.shape {
            Shape::Segment { from, to } => (from, V([0.0, 0.0, 1.0]), to),
            Shape::Panel { corner, along, across } => (corner, across.unit(), corner + along),
            Shape::Half { .. } => panic!("a flap has an edge"),
        };
        // In solid space the axis is not one of the coordinates.
        let axis = if solid { (axis + V([0.1, 0.0, 0.05])).unit() } else { axis };
        flap.free = Some(FreeWall {
            way: Way::About { point, axis },
            home: flap.shape,
            inertia: 0.05,
            mass: 3.0,
            centre: point + (tip - point) * 0.5,
            load: 1.5,
            stiffness: 300.0,
            damping: 0.4,
            place: 0.0,
            rate: 0.8,
            gained: 0.0,
            acceleration: 0.0,
        });
        self
    }

    /// Gives every third grain a shape.
    pub fn with_shapes(mut self) -> Self {
        let mut random = Random(7);
        self.has_shapes = true;
        let factor = self.inertia_factor();
        for body in &mut self.bodies {
            body.inertia = factor * body.mass * body.radius * body.radius;
        }
        make_shaped(&mut self, || random.next());
        self
    }

    /// Places grains and wall grains near the sites of a lattice.
    fn fill(&mut self, sites: [usize; 3]) {
        let mut random = Random(2026);
        let is_mixed = self.materials.len() > 1;
        let has_wall_grains = matches!(self.around, Surroundings::Chute | Surroundings::Hole);
        for site in 0..sites.iter().product::<usize>() {
            let place = [site % sites[0], site / sites[0] % sites[1], site / (sites[0] * sites[1])];
            let centre = V(place.map(|number| LOW + SPACING * (number as f64 + 0.5)));
            let position = self.in_space(centre + random.vector(0.003));
            let [velocity, spin] = [self.in_space(random.vector(0.5)), self.turning(random.vector(20.0))];
            let species = if is_mixed { site * 7 % 3 } else { 0 };
            let grain = self.grain(position, velocity, RADII[site * 5 % 4], species);
            let is_moving = site % 23 == 7;
            self.bodies.push(if has_wall_grains && (is_moving || site % 11 == 5) {
                let velocity = if is_moving { V([0.4, -0.2, 0.0]) } else { V::default() };
                Body { velocity, is_fixed: true, ..grain }
            } else {
                Body { spin, ..grain }
            });
        }
    }

    /// Returns a grain without spin and without forces.
    fn grain(&self, position: V, velocity: V, radius: f64, species: usize) -> Body {
        let mass = 100.0 * radius * radius * [1.0, 1.4, 0.8][species];
        let inertia = self.inertia_factor() * mass * radius * radius;
        Body { position, velocity, radius, mass, inertia, species, is_fixed: false, ..FLAT }
    }

    fn in_space(&self, v: V) -> V {
        if self.solid { v } else { V([v.0[0], v.0[1], 0.0]) }
    }

    /// Returns the part of a spin that grains of this scene can have.
    fn turning(&self, spin: V) -> V {
        match (self.laws[0].friction, self.solid) {
            (None, _) => V::default(),
            (Some(_), true) => spin,
            (Some(_), false) => V([0.0, 0.0, spin.0[2]]),
        }
    }

    /// Returns I/(m R^2). One of the surroundings uses the value that is not the default of its space, unless grains have shapes.
    pub fn inertia_factor(&self) -> f64 {
        let is_other = self.around == Surroundings::Fittings && !self.has_shapes;
        if self.solid == is_other { 0.5 } else { 0.4 }
    }

    /// Returns the grain that enters, if any. It leaves its place before the next one enters, and hits the bed within
    /// the run.
    pub fn entering_grain(&self) -> Option<Body> {
        let radius = RADII[2];
        let up = self.up();
        let mut position = V::default();
        let mut velocity = V([40.0, 0.0, 0.0]);
        let surface = self.bodies.iter().map(|body| body.position.0[up] + body.radius).fold(f64::MIN, f64::max);
        (position.0[up], velocity.0[up]) = (surface + radius + 1.0e-3, -3.0);
        (self.around == Surroundings::Rain).then(|| self.grain(position, velocity, radius, 0))
    }

    fn up(&self) -> usize {
        if self.solid { 2 } else { 1 }
    }

    /// Returns the height below which grains are removed, m. The lowest layer is centred 4 cm above the low end.
    pub fn cull(&self) -> f64 {
        if self.around == Surroundings::Hole { LOW + 0.037 } else { f64::NEG_INFINITY }
    }

    /// Adds the wall surfaces.
    fn surround(&mut self, up: usize, high: [f64; 2]) {
        let towards = |axis: usize, length: f64| {
            let mut v = V::default();
            v.0[axis] = length;
            v
        };
        let species = self.materials.len() - 1;
        let mut add = |shape: Shape| self.walls.push(Wall::new(shape, species));
        let floor = |velocity: V| Shape::Half { point: towards(up, LOW), normal: towards(up, 1.0), velocity };
        match self.around {
            Surroundings::Nothing | Surroundings::Hole => {}
            Surroundings::Chute => add(floor(towards(0, 0.6))),
            Surroundings::Rain => add(floor(V::default())),
            Surroundings::Walls => {
                add(floor(V::default()));
                for (axis, high) in high.into_iter().enumerate().take(up) {
                    for (at, normal) in [(LOW, 1.0), (high, -1.0)] {
                        let point = towards(axis, at);
                        add(Shape::Half { point, normal: towards(axis, normal), velocity: V::default() });
                    }
                }
            }
            Surroundings::Fittings => {
                let normal = (towards(0, 1.0) + towards(up, 0.05)).unit();
                add(Shape::Half { point: towards(0, LOW) + towards(up, LOW), normal, velocity: V::default() });
                // The segment lies between two layers, so that grains of both touch it. It ends within the bed.
                let from = towards(0, 0.05)
                    + towards(up, LOW + 2.0 * SPACING)
                    + towards(1, if self.solid { 0.1 } else { 0.0 });
                add(Shape::Segment { from, to: from + towards(0, 0.15) + towards(up, 0.004) });
                if self.solid {
                    let corner = V([-0.05, -0.07, LOW + SPACING + 0.001]);
                    add(Shape::Panel { corner, along: V([0.2, 0.0, 0.01]), across: V([0.0, 0.13, 0.0]) });
                }
            }
        }
    }

    /// Returns the scene as a naive simulator.
    pub fn simulator(&self) -> Simulator {
        let species = self.materials.len();
        let law = |pair: [usize; 2]| match pair {
            [0, 1] | [1, 0] => self.laws[self.laws.len() - 1],
            _ => self.laws[0],
        };
        let terms = |pair: [usize; 2]| Terms::new(law(pair), pair.map(|species| self.materials[species]));
        let (prediction, springs_exact) = self.prediction();
        Simulator {
            bodies: self.bodies.clone(),
            clumps: self.clumps.clone(),
            walls: self.walls.clone(),
            periodic: self.periodic,
            gravity: self.gravity,
            cull: self.cull(),
            up: self.up(),
            laws: (0..species).map(|a| (0..species).map(|b| terms([a, b])).collect()).collect(),
            scheme: self.scheme,
            dt: DT,
            prediction,
            springs_exact,
            releases: (0..RELEASES)
                .filter_map(|number| Some((number * RELEASE_EVERY, self.entering_grain()?)))
                .collect(),
            steps: 0,
            memories: BTreeMap::new(),
        }
    }

    /// Returns all numbers of the laws with names; for Hertz's law also the numbers of the materials.
    pub fn numbers(&mut self) -> Vec<(&'static str, &mut f64)> {
        let is_hertz = self.laws[0].is_hertz();
        let of_laws = self.laws.iter_mut().flat_map(Law::numbers);
        let materials = self.materials.iter_mut().filter(|_| is_hertz);
        of_laws.chain(materials.flat_map(|m| [("E", &mut m.young), ("nu", &mut m.poisson)])).collect()
    }
}
