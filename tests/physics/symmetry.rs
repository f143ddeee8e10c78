//! Symmetries: rotation of the axes, shift of the origin, and reflection do not change the physics.

use glam::{DMat3, DVec3};

use crate::{Motion, motion, simulation, sphere};
use siloflow::grains::file::GrainRow;
use siloflow::random::Stream;

pub const R: f64 = 0.04;
const SPEED: f64 = 1.0;
const STEPS: u64 = 5000;

/// A linear law with tangential and rolling terms.
pub const LINEAR: &str = "Linear(k: 1.0e4, damping: Restitution(0.8), attraction: Allowed, \
    tangential: Spring(k: 2.9e3, damping: PerMass(20.0), friction: 0.4), \
    rolling: (k: 1.0e3, damping: PerMass(20.0), friction: 0.1))";
pub const HERTZ: &str = "Hertz(restitution: 0.8, attraction: Allowed, tangential: Mindlin(friction: 0.4))";

pub const ADHESIVE: &str = "Hertz(restitution: 0.8, attraction: Allowed, tangential: Mindlin(friction: 0.4, damping: \
    OfNormal(0.6)), rolling: (kind: Elastic, damping: B(0.02), friction: 0.1), adhesion: Dmt(0.5))";
pub const STICKY: &str = "Linear(k: 1.0e4, damping: Restitution(0.8), tangential: Spring(k: 2.9e3, damping: PerMass(20.0), \
    friction: 0.4), rolling: (kind: Torque, friction: 0.1), adhesion: Area(5.0e3))";
pub const JKR: &str = "Hertz(restitution: 0.8, tangential: Mindlin(friction: 0.4), rolling: (kind: Elastic, friction: 0.1), \
    adhesion: Jkr(0.5))";
pub const TWISTING: &str = "Linear(k: 1.0e4, damping: Restitution(0.8), tangential: Spring(k: 2.9e3, damping: PerMass(20.0), \
    friction: 0.4), twisting: (k: 1.0e3, damping: PerMass(20.0), friction: 0.1))";
/// All laws, each in both spaces; discs of the plane cannot twist.
const LAWS: [(bool, &str); 11] = [
    (true, TWISTING),
    (true, JKR),
    (false, JKR),
    (true, LINEAR),
    (true, HERTZ),
    (true, ADHESIVE),
    (true, STICKY),
    (false, LINEAR),
    (false, HERTZ),
    (false, ADHESIVE),
    (false, STICKY),
];

/// Returns the keys of free grains: no gravity, no walls.
fn keys(solid: bool, contact: &str) -> String {
    let (space, gravity) = if solid { ("Solid", "(0.0, 0.0, 0.0)") } else { ("Plane", "(0.0, 0.0)") };
    format!(
        "space: {space}, gravity: {gravity}, contact: {contact}, materials: [(young: 1.0e6, poisson: 0.3)], \
         step: Fixed(1.0e-4), until: 100.0"
    )
}

/// Returns numbers from -1 to 1.
pub fn random_vector(name: &str, counter: u32) -> DVec3 {
    DVec3::from(Stream::new(3, name).uniform(u64::from(counter)).map(|u: f64| 2.0 * u - 1.0))
}

/// Returns six spinning grains that come from six sides and collide near the origin.
fn colliding_grains(solid: bool) -> Vec<GrainRow> {
    let (flat, axis) = if solid { (DVec3::ONE, DVec3::ONE) } else { (DVec3::new(1.0, 1.0, 0.0), DVec3::Z) };
    let grain = |i: u32| {
        let side = if solid {
            [DVec3::X, DVec3::Y, DVec3::Z][i as usize / 2] * if i.is_multiple_of(2) { 1.0 } else { -1.0 }
        } else {
            DVec3::new((f64::from(i) * 1.05).cos(), (f64::from(i) * 1.05).sin(), 0.0)
        };
        let place = flat * (4.0 * R * side + 0.5 * R * random_vector("place", i));
        let velocity = flat * SPEED * (0.2 * random_vector("velocity", i) - side);
        let radius = if i.is_multiple_of(2) { R } else { 0.8 * R };
        let mut grain = sphere(i + 1, place, velocity, radius, 100.0 * radius * radius);
        grain.spin = axis * random_vector("spin", i) * SPEED / R;
        grain
    };
    (0..6).map(grain).collect()
}

/// A rotation or reflection, then a shift. A spin is a pseudovector, so it also gets the sign of the determinant.
#[derive(Clone, Copy)]
struct Image {
    turn: DMat3,
    shift: DVec3,
}

impl Image {
    fn of(self, x: DVec3, v: DVec3, w: DVec3) -> Motion {
        let spin = self.turn.determinant().round() * (self.turn * w);
        Motion { position: self.turn * x + self.shift, velocity: self.turn * v, spin }
    }

    fn start(self, grains: &[GrainRow]) -> Vec<GrainRow> {
        let image = |grain: &GrainRow| {
            let Motion { position, velocity, spin } = self.of(grain.position, grain.velocity, grain.spin);
            GrainRow { position, velocity, spin, ..*grain }
        };
        grains.iter().map(image).collect()
    }
}

/// Returns the state after [`STEPS`] steps.
pub fn end(keys: &str, grains: &[GrainRow]) -> Vec<Motion> {
    let mut simulation = simulation(keys, grains.to_vec());
    simulation.run_steps(STEPS);
    motion(&mut simulation)
}

/// Returns the largest difference of positions, velocities and spins, in units of R, of the speed, and of speed over R.
fn apart(a: &[Motion], b: &[Motion]) -> f64 {
    let difference = |(a, b): (&Motion, &Motion)| {
        let way = a.position.distance(b.position) / R;
        let spin = a.spin.distance(b.spin) * R / SPEED;
        way.max(spin).max(a.velocity.distance(b.velocity) / SPEED)
    };
    a.iter().zip(b).map(difference).fold(0.0, f64::max)
}

fn images(solid: bool) -> Vec<(&'static str, Image)> {
    let about = if solid { DVec3::new(2.0, -1.0, 0.5).normalize() } else { DVec3::Z };
    let turn = DMat3::from_axis_angle(about, 0.7);
    let mirrored = turn * DMat3::from_diagonal(DVec3::new(-1.0, 1.0, 1.0)) * turn.transpose();
    let far = 300.0 * R * if solid { DVec3::new(1.0, -2.0, 2.0) } else { DVec3::new(3.0, -4.0, 0.0) } / 3.0;
    vec![
        ("rotated", Image { turn, shift: DVec3::ZERO }),
        ("mirrored", Image { turn: mirrored, shift: DVec3::ZERO }),
        ("shifted", Image { turn: DMat3::IDENTITY, shift: far }),
        ("all three", Image { turn: mirrored * turn, shift: far }),
    ]
}

#[test]
fn rotated_mirrored_or_shifted_run_is_the_image_of_the_run() {
    for (solid, contact) in LAWS {
        let keys = keys(solid, contact);
        let grains = colliding_grains(solid);
        let reference = end(&keys, &grains);
        // A second run with positions off by 1e-7 R measures how collisions amplify a small difference. Each collision
        // turns a normal by delta/2R, so it multiplies a distance by about 1 + l/R over the next flight l. Round-off is
        // such a difference. A position is a multiple of its ulp and a flight adds the same dt v in each step, so the
        // error is the same in each step: at most half an ulp of the largest coordinate. The errors of all steps add
        // up.
        let flat = if solid { DVec3::ONE } else { DVec3::new(1.0, 1.0, 0.0) };
        let mut twin = grains.clone();
        for (i, grain) in (0..).zip(&mut twin) {
            grain.position += 1e-7 * R * flat * random_vector("twin", i);
        }
        let growth = apart(&end(&keys, &twin), &reference) / 1e-7;
        assert!((10.0..1e5).contains(&growth), "{contact}, solid {solid}: errors grow {growth}-fold");
        for (name, image) in images(solid) {
            let expected: Vec<_> = reference.iter().map(|now| image.of(now.position, now.velocity, now.spin)).collect();
            let farthest = expected.iter().map(|now| now.position.length()).fold(0.0, f64::max);
            let error = apart(&end(&keys, &image.start(&grains)), &expected);
            let tolerance = STEPS as f64 * 0.5 * f64::EPSILON * farthest / R * growth;
            assert!(error < tolerance, "{contact}, solid {solid}, {name}: {error:e}, tolerance {tolerance:e}");
        }
    }
}

#[test]
fn mirror_across_an_axis_changes_no_bit() {
    // Rounding does not depend on signs. Changing the sign of all x, of v_x and of the two other components of spins
    // must therefore change no other bit. Only two grains: more forces are summed in the order of positions, which a
    // mirror reverses.
    let mirror = Image { turn: DMat3::from_diagonal(DVec3::new(-1.0, 1.0, 1.0)), shift: DVec3::ZERO };
    for (solid, contact) in LAWS {
        let keys = keys(solid, contact);
        let mut grains = colliding_grains(solid);
        grains.truncate(2);
        // The first grain rests, and the second flies at it.
        grains[1].velocity = (grains[0].position - grains[1].position).normalize() * SPEED + 0.1 * SPEED * DVec3::Y;
        grains[0].velocity = DVec3::ZERO;
        let free = grains[1].velocity;
        let after = end(&keys, &grains);
        assert!(after[1].velocity.distance(free) > 0.1 * SPEED, "the two have not collided");
        for (a, b) in after.iter().zip(end(&keys, &mirror.start(&grains))) {
            let a = mirror.of(a.position, a.velocity, a.spin);
            assert_eq!((a.position, a.velocity, a.spin), (b.position, b.velocity, b.spin), "{contact}, solid {solid}");
        }
    }
}
