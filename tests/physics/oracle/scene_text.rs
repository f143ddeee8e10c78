//! Writes a [`Scene`] for siloflow: its keys, and its grains with ids in the order of the bodies.

use std::num::NonZeroUsize;
use std::path::Path;

use glam::DVec3;
use siloflow::dem::store::{ParticleStore, Prediction};
use siloflow::grains::file::GrainRow;
use siloflow::grains::fill::FixedGrain;
use siloflow::prelude::*;
use siloflow_oracle::free_wall::Way;
use siloflow_oracle::simulator::{Body, Part};
use siloflow_oracle::vector::V;
use siloflow_oracle::wall::{Shape, Wall};

use crate::oracle::scene::{DT, RELEASE_EVERY, RELEASES, Scene, Surroundings};
use crate::oracle::shaped;

impl Scene {
    fn wall_text(&self, wall: &Wall) -> String {
        let text = |v: V| v.ron(self.solid);
        let species = wall.species;
        let name = if wall.free.is_some() { ", name: \"free\"" } else { "" };
        match wall.shape {
            Shape::Half { point, normal, velocity } => format!(
                "HalfPlane(point: {}, normal: {}, species: {species}{name}{})",
                text(point),
                text(normal * 3.0),
                if wall.free.is_some() { String::new() } else { format!(", velocity: {}", text(velocity)) }
            ),
            Shape::Segment { from, to } => {
                format!("Segment(from: {}, to: {}, species: {species}{name})", text(from), text(to))
            }
            Shape::Panel { corner, along, across } => format!(
                "Panel(corner: {}, along: {}, across: {}, species: {species}{name})",
                text(corner),
                text(along),
                text(across)
            ),
        }
    }

    /// Returns a text that identifies the scene.
    pub fn title(&self) -> String {
        let space = if self.solid { "Solid" } else { "Plane" };
        format!("{}, {space}, {:?}, {:?}", self.laws[0].ron(), self.around, self.scheme)
    }

    /// Returns the scene file.
    pub fn text(&self, search: &str, energy_balance: bool) -> String {
        let mut walls: Vec<_> = self.walls.iter().map(|wall| self.wall_text(wall)).collect();
        for body in self.bodies.iter().filter(|body| body.is_fixed && body.velocity == V::default()) {
            let centre = body.position.ron(self.solid);
            walls.push(format!("Disc(centre: {centre}, radius: {:?}, species: {})", body.radius, body.species));
        }
        let sides =
            ["x", "y", "z"].iter().zip(self.periodic).filter_map(|(name, side)| Some(format!("{name}: {:?}", side?)));
        let materials = self.materials.iter().map(|m| format!("(young: {:?}, poisson: {:?})", m.young, m.poisson));
        let pairs = self.laws[1..].iter().map(|law| format!("(species: (0, 1), contact: {})", law.ron()));
        let cull = if self.around == Surroundings::Hole {
            format!("cull: (below: {:?}), ", self.cull())
        } else {
            String::new()
        };
        let spawner = self.entering_grain().map_or(String::new(), |Body { position, velocity, radius, .. }| {
            let [point, velocity] = [position, velocity].map(|v| v.ron(self.solid));
            let interval = RELEASE_EVERY as f64 * DT;
            format!(
                "mass: ArealSquare(100.0), spawner: (point: {point}, velocity: {velocity}, interval: {interval:?}, count: {RELEASES}, \
                 radius: Fixed({radius:?})), "
            )
        });
        let inertia = match self.laws[0].friction {
            _ if self.has_shapes => "",
            None => "",
            Some(_) if self.inertia_factor() > 0.45 => "inertia: Disc, ",
            Some(_) => "inertia: Sphere, ",
        };
        let free = self.walls.iter().filter_map(|wall| wall.free).map(|free| {
            let way = match free.way {
                Way::Along(along) => format!("Along({})", (along * 2.0).ron(self.solid)),
                Way::About { point, axis } => {
                    let axis = if self.solid { format!(", axis: {}", (axis * 2.0).ron(true)) } else { String::new() };
                    let [point, centre] = [point, free.centre].map(|v| v.ron(self.solid));
                    format!("About(point: {point}{axis}), inertia: {:?}, centre: {centre}", free.inertia)
                }
            };
            format!(
                "free_walls: [(walls: \"free\", moves: {way}, mass: {:?}, load: {:?}, spring: (stiffness: {:?}), damping: {:?}, \
                 rate: {:?}, stops: (-1.0, 1.0))], ",
                free.mass, free.load, free.stiffness, free.damping, free.rate
            )
        });
        let free: String = free.collect();
        let shapes = if self.has_shapes { format!("shapes: {}, ", shaped::text(self.solid)) } else { String::new() };
        format!(
            "(space: {}, gravity: {}, periodic: ({}), contact: {}, pairs: [{}], materials: [{}], {shapes}{free}{inertia}{cull}{spawner}integrator: {:?}, \
             step: Fixed({DT:?}), neighbours: {search}, walls: [{}], energy_balance: {energy_balance}, watchdog: None, on_loss: Continue, \
             until: 1.0e3, pictures: None)",
            if self.solid { "Solid" } else { "Plane" },
            self.gravity.ron(self.solid),
            sides.collect::<Vec<_>>().join(", "),
            self.laws[0].ron(),
            pairs.collect::<Vec<_>>().join(", "),
            materials.collect::<Vec<_>>().join(", "),
            self.scheme,
            walls.join(", "),
        )
    }

    /// Returns the parameters of the centred scheme that siloflow derives from the scene: beta of velocities and of spins, and whether springs
    /// advance with the velocities in the middle of the step. Unit tests check them.
    pub fn prediction(&self) -> ([f64; 2], bool) {
        let mut simulation = self.simulation("VerletList(skin: 0.01)", 1, false);
        simulation.step();
        match Dimension::of_world(simulation.world()) {
            Dimension::Plane => parameters::<Plane>(&simulation),
            Dimension::Solid => parameters::<Solid>(&simulation),
        }
    }

    /// Returns the scene as a siloflow simulation.
    pub fn simulation(&self, search: &str, threads: usize, energy_balance: bool) -> Simulation {
        let vector = |v: V| DVec3::from_array(v.0);
        let text = self.text(search, energy_balance);
        let mut loaded = load::from_text("oracle.ron", "oracle", Path::new(""), text.clone(), &[])
            .unwrap_or_else(|fault| panic!("{fault}\n{text}"));
        let whole = self.bodies.iter().filter(|body| !body.is_sphere_of_clump());
        for (number, body) in (1..).zip(whole) {
            let Body { radius, mass, .. } = *body;
            let position = vector(body.position);
            let velocity = vector(body.velocity);
            let species = Species(body.species as u8);
            if !body.is_fixed {
                let id = GrainId::grain(number).unwrap();
                loaded.grains.push(GrainRow {
                    id,
                    radius,
                    mass,
                    position,
                    velocity,
                    spin: vector(body.spin),
                    posture: match body.part {
                        Part::Centre(clump) => Some(self.shaped[clump].posture),
                        _ => None,
                    },
                    species,
                });
            } else if body.velocity != V::default() {
                loaded.fixed.push(FixedGrain { position, radius, velocity, species });
            }
        }
        Simulation::new(&loaded, &Registry::default(), NonZeroUsize::new(threads).unwrap()).unwrap()
    }
}

fn parameters<S: Space>(simulation: &Simulation) -> ([f64; 2], bool) {
    let Prediction { share, spin_share, springs_exact, .. } =
        simulation.world().resource::<ParticleStore<S>>().prediction.clone();
    ([share, spin_share], springs_exact)
}
