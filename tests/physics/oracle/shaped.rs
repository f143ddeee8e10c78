//! Grains of several spheres in the bed of a [`Scene`]: which grains have a shape, and their numbers for both sides.
//!
//! The naive simulator takes the principal axes, moments of inertia and spheres of a shape from siloflow. Tests of the kernel hold them against
//! closed forms (`crates/dem/src/bodies`). Here the motion is compared.

use std::path::Path;

use glam::{DQuat, DVec3};
use siloflow::grains::shaped::{Posture, Shapes};
use siloflow::prelude::*;
use siloflow_oracle::clump::Clump;
use siloflow_oracle::simulator::{Body, FLAT, Part};
use siloflow_oracle::vector::V;

use crate::oracle::scene::Scene;

/// A dumbbell, which in solid space is a body of revolution, and three spheres with three different moments of inertia. They are as large as the
/// spheres of the bed.
const PLANE: &str = r#"{"pair": Discs([(at: (0.014, 0.0), radius: 0.03), (at: (-0.014, 0.0), radius: 0.03)]),
    "bean": Discs([(at: (0.0, 0.0), radius: 0.029), (at: (0.018, 0.006), radius: 0.022), (at: (-0.014, 0.01), radius: 0.024)])}"#;
const SOLID: &str = r#"{"pair": Spheres([(at: (0.014, 0.0, 0.0), radius: 0.03), (at: (-0.014, 0.0, 0.0), radius: 0.03)]),
    "bean": Spheres([(at: (0.0, 0.0, 0.0), radius: 0.029), (at: (0.018, 0.006, 0.004), radius: 0.022), (at: (-0.014, 0.01, -0.006), radius: 0.024)])}"#;

/// The grain of several spheres whose centre is this body.
#[derive(Clone, Copy, Debug)]
pub struct Shaped {
    pub body: usize,
    pub posture: Posture,
    /// Radius of the sphere (disc) of equal volume (area), m.
    pub radius: f64,
}

/// Returns the value of the scene key `shapes`.
pub fn text(solid: bool) -> &'static str {
    if solid { SOLID } else { PLANE }
}

/// Returns the shapes of the scene.
fn shapes(scene: &Scene) -> Shapes {
    load::from_text("oracle.ron", "oracle", Path::new(""), scene.text("AllPairs", false), &[]).unwrap().shapes
}

/// Makes every third free grain of the bed one of several spheres. `number` gives random numbers from -1 to 1.
pub fn make_shaped(scene: &mut Scene, mut number: impl FnMut() -> f64) {
    let shapes = shapes(scene);
    for centre in (1..scene.bodies.len()).step_by(3) {
        if scene.bodies[centre].is_fixed {
            continue;
        }
        let shape = shapes.named(if centre.is_multiple_of(2) { "pair" } else { "bean" }).unwrap();
        let [x, y, z, w] = [number(), number(), number(), number()];
        let rotor = if scene.solid { DQuat::from_xyzw(x, y, z, w) } else { DQuat::from_xyzw(0.0, 0.0, z, w) };
        let facts = shapes.facts_of(shape).unwrap();
        let posture = Posture { shape, rotor: rotor.normalize(), reach: facts.reach };
        let shaped = Shaped { body: centre, posture, radius: facts.equivalent_radius };
        if scene.solid { add::<Solid>(scene, &shapes, shaped) } else { add::<Plane>(scene, &shapes, shaped) }
    }
}

/// Adds the clump of a shaped grain, with its spheres as bodies behind all others.
fn add<S: Space>(scene: &mut Scene, shapes: &Shapes, shaped: Shaped) {
    let Shaped { body: centre, posture, radius } = shaped;
    let vector = |v: DVec3| V(v.to_array());
    let grain = Body { part: Part::Centre(scene.clumps.len()), radius, ..scene.bodies[centre] };
    let rigid = &shapes.rigid::<S>()[posture.shape.index()];
    let scale = rigid.scale(radius);
    let inverse_inertia = rigid.inverse_inertia(grain.mass, scale);
    let inverse_inertias = std::array::from_fn(|axis| inverse_inertia.component(if scene.solid { axis } else { 0 }));
    let axes = [DVec3::X, DVec3::Y, DVec3::Z].map(|axis| vector(posture.rotor * axis));
    let momentum = (0..3).fold(V::default(), |sum, k| sum + axes[k] * (axes[k].dot(grain.spin) / inverse_inertias[k]));
    let sphere = Body {
        part: Part::Sphere { of: centre, gains: [V::default(); 2] },
        mass: grain.mass,
        inertia: 3.0 / inverse_inertias.iter().sum::<f64>(),
        species: grain.species,
        is_fixed: false,
        ..FLAT
    };
    let mut clump = Clump { centre, momentum, axes, inverse_inertias, spheres: Vec::new() };
    for of_shape in &rigid.spheres {
        clump.spheres.push((scene.bodies.len(), vector((of_shape.at * scale).spread())));
        scene.bodies.push(Body { radius: of_shape.radius * scale, ..sphere });
    }
    scene.bodies[centre] = grain;
    clump.place_spheres(&mut scene.bodies);
    scene.clumps.push(clump);
    scene.shaped.push(shaped);
}
