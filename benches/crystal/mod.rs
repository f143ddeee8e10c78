//! Crystals under their own weight, created directly: the beds that the benchmarks step.
//!
//! Discs are on a hexagonal lattice, without friction. Spheres are on a face-centred cubic lattice, with friction and
//! contact history. Neighbours overlap by a thousandth of a diameter. The beds have 6 and 12 contacts per grain, at
//! least twice the number in a settled bed.

#![allow(dead_code, reason = "each benchmark uses a part of it")]

use std::fmt::Write as _;
use std::num::NonZeroUsize;

use siloflow::dem::threads::Threads;
use siloflow::prelude::*;

/// Radius, m.
pub const R: f64 = 0.04;
/// Distance of neighbours, m.
const PITCH: f64 = 2.0 * R * 0.999;

/// A crystal on a floor, in a periodic box of matching width.
#[derive(Clone, Copy, Debug)]
pub struct Crystal {
    /// Spheres with friction, or discs without.
    pub is_solid: bool,
    /// Approximate number of grains.
    pub grains: u32,
    /// Number of grains side by side on the floor; for spheres along each of x and y.
    pub wide: u32,
    /// Whether the grains are in scrambled order instead of row by row.
    pub is_mixed: bool,
}

impl Crystal {
    /// Returns a crystal as high as it is wide.
    pub fn of(is_solid: bool, grains: u32) -> Self {
        let power = if is_solid { 3 } else { 2 };
        let wide = (1u32..10_000).find(|side| side.pow(power) >= grains).expect("there is such a side");
        Self { is_solid, grains, wide, is_mixed: false }
    }

    /// Returns the rows of the grains file.
    fn rows(self) -> String {
        let half = PITCH * 0.5;
        let deep = if self.is_solid { self.wide } else { 1 };
        let layers = self.grains.div_ceil(self.wide * deep);
        let mut places = Vec::new();
        for layer in 0..layers {
            // Spheres: square layers, each in the hollows of the layer below.
            let shift = f64::from(layer % 2) * half;
            let up = R + f64::from(layer) * PITCH * if self.is_solid { 0.5f64.sqrt() } else { 0.75f64.sqrt() };
            for row in 0..deep {
                for place in 0..self.wide {
                    let x = f64::from(place).mul_add(PITCH, shift + half);
                    let y = f64::from(row).mul_add(PITCH, shift + half);
                    places.push(if self.is_solid { (x, y, up) } else { (x, up, 0.0) });
                }
            }
        }
        let mut rows = String::from("id,radius,mass,x,y,vx,vy,z,vz\n");
        for id in 0..places.len() {
            // A prime that divides none of the numbers of places used here, so each place occurs once.
            let place = if self.is_mixed { id * 7919 % places.len() } else { id };
            let (x, y, z) = places[place];
            writeln!(rows, "{id},{R},0.16,{x},{y},0,0,{z},0").expect("a string can be written to");
        }
        rows
    }

    /// Loads the scene of the crystal, with `settings` (key, value) applied.
    pub fn load(self, settings: &[(&str, &str)]) -> Loaded {
        let width = f64::from(self.wide) * PITCH;
        let scene = if self.is_solid {
            format!(
                "(space: Solid, gravity: (0.0, 0.0, -9.81), periodic: (x: (0.0, {width:?}), y: (0.0, {width:?})), \
                 walls: [HalfPlane(point: (0.0, 0.0, 0.0), normal: (0.0, 0.0, 1.0))], \
                 contact: Linear(k: 1.0e5, damping: PerMass(400.0), tangential: Spring(k: 2.9e4, \
                 damping: PerMass(200.0), friction: 0.5)), "
            )
        } else {
            format!(
                "(gravity: (0.0, -9.81), periodic: (x: (0.0, {width:?})), \
                 walls: [HalfPlane(point: (0.0, 0.0), normal: (0.0, 1.0))], \
                 contact: Linear(k: 1.0e5, damping: PerMass(400.0)), "
            )
        };
        let directory = tempfile::tempdir().expect("a directory for the scene");
        let path = directory.path().join("crystal.ron");
        std::fs::write(directory.path().join("grains.csv"), self.rows()).expect("the grains can be written");
        let rest = "grains: (file: \"grains.csv\"), integrator: Verlet, step: Fixed(1.0e-4), \
                    neighbours: VerletList(skin: 0.01), pictures: None, until: 1.0e9)";
        std::fs::write(&path, scene + rest).expect("the scene can be written");
        let settings: Vec<_> = settings.iter().map(|&(key, value)| (key.to_owned(), value.to_owned())).collect();
        load::load(&path, &settings).expect("the scene is valid")
    }

    /// Returns the simulation before its first step.
    pub fn fresh(self) -> Simulation {
        Simulation::new(&self.load(&[]), &Registry::default(), NonZeroUsize::MIN)
            .expect("the scene needs no behaviours")
    }

    /// Returns the simulation after a few steps with one thread.
    pub fn simulation(self) -> Simulation {
        self.simulation_with(Threads::one())
    }

    /// Returns the simulation after a few steps with these threads.
    pub fn simulation_with(self, threads: Threads) -> Simulation {
        let mut simulation = self.fresh();
        simulation.world_mut().insert_resource(threads);
        simulation.run_steps(5);
        simulation
    }
}

/// Runs `steps` further steps.
pub fn run_further(simulation: &mut Simulation, steps: u64) {
    let done = simulation.world().resource::<Clock>().steps;
    simulation.run_steps(done + steps);
}
