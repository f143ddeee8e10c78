//! All pairs of species that can meet: two grains, or a grain and a wall. The lightest grains of a species represent it.
//!
//! A pair has a law, a reduced mass m and, with I = q m R^2, three mobilities (acceleration of the contact per unit force):
//! 1/m along the normal, (1 + 1/q)/m along the tangent, and R_eff^2 (1/I_i + 1/I_j) in rolling and twisting. The last is 1/(4 q m) for
//! equal grains and 1/(q m) on a wall surface. Its step limits ([`step`]):
//!
//! * Single contact: each of the four motions by itself.
//! * Dense bed: a grain has z = 6 equal neighbours, in solid space 12. Since (a - b)^2 <= 2 a^2 + 2 b^2 for the motion of two
//!   grains at their contact, the worst motion has every grain move against its neighbours. In d dimensions the contacts
//!   then count with the weights z/d (normal, from sum n n = z/d) and z (d - 1)/d (tangent). If all grains turn alike, the
//!   tangent counts with z/q, in solid space 2/3 of that; if neighbours turn against each other, rolling counts as much and twisting
//!   with the other third. The hexagonal lattice has such motions, so these bounds are reached. A grain may also be held by walls
//!   alone: by z of them, or by two opposite ones if the scene has no more. Then tangents, rolling and twisting take part in the same turn.
//!
//! `scene/check/lightest.rs` finds the bodies.

use crate::scene::check::crowd::{Motion, Pull};
use crate::scene::check::lightest::{Body, lightest, walls};
use crate::scene::check::step;
use crate::scene::loaded::Loaded;
use siloflow_dem::contact::{AnyLaw, Bounce};
use siloflow_dem::integrate::Integrator;
use siloflow_dem::math;
use siloflow_dem::space::{Dimension, Plane};
use siloflow_dem::walls::config::shape::WallShape;

/// Two bodies that can meet.
pub struct SpeciesPair {
    /// Their contact law.
    pub law: AnyLaw<Plane>,
    /// Their head-on impact.
    pub bounce: Bounce,
    /// Their species.
    pub species: (u8, u8),
    /// Whether the second body is a wall.
    pub is_wall: bool,
    /// Whether the scene has at most two walls, which can only hold a grain between them.
    few_walls: bool,
    /// The larger number of springs of the two bodies.
    springs: f64,
    /// I/(m R^2).
    inertia: f64,
    /// m R_eff^2 (1/I_i + 1/I_j).
    rolling: f64,
    /// The law's [`modes`](siloflow_dem::contact::PairLaw::modes) in the impact.
    modes: [[f64; 2]; 4],
}

impl SpeciesPair {
    fn new(loaded: &Loaded, [(a, first), (b, second)]: [(u8, Body); 2], speed: f64) -> Self {
        let reduced = |x: f64, y: f64| 1.0 / (1.0 / x + 1.0 / y);
        let reduced_mass = reduced(first.mass, second.mass);
        let reduced_radius = reduced(first.radius, second.radius);
        // Grains that do not spin have no moment of inertia that a contact could turn.
        let inertia = if loaded.scene.contact.spins() { loaded.inertia().factor() } else { f64::INFINITY };
        let turning = |body: Body| (reduced_radius / body.radius).powi(2) * reduced_mass / body.mass;
        // Estimates use no directions, so the law in the plane serves both spaces.
        let law: AnyLaw<Plane> = loaded.contacts().between(a, b);
        let bounce = Bounce { reduced_mass, reduced_radius, speed };
        Self {
            modes: law.0.modes(&bounce),
            law,
            bounce,
            species: (a, b),
            is_wall: second.mass.is_infinite(),
            few_walls: has_few_walls(loaded),
            springs: first.springs.max(second.springs),
            inertia,
            rolling: (turning(first) + turning(second)) / inertia,
        }
    }

    /// The pair of two bodies with their species, pressed together by this overlap (m): the impact that reaches the overlap has its stiffness.
    /// An adhesive contact may be deeper than that in the slowest impact, which is taken then.
    pub(super) fn pressed(loaded: &Loaded, bodies: [(u8, Body); 2], overlap: f64) -> Self {
        let mut pair = Self::new(loaded, bodies, 1.0);
        let deepest = |speed: f64| pair.law.0.deepest(&Bounce { speed, ..pair.bounce });
        let [slow, fast] = [1.0, 2.0].map(deepest);
        // Without adhesion the deepest overlap is a power of the speed.
        let speed = math::pow(overlap / slow, 1.0 / math::log2(fast / slow));
        let is_power = (deepest(speed) / overlap - 1.0).abs() < 1e-6;
        pair.bounce.speed = if is_power { speed } else { speed_to_reach(overlap, deepest) };
        pair.modes = pair.law.0.modes(&pair.bounce);
        pair
    }

    /// The largest overlap of the two after they touch at rest, over twice their reduced radius: 0 without adhesion.
    pub(super) fn adhesive_overlap(&self) -> f64 {
        self.law.0.deepest(&Bounce { speed: 0.0, ..self.bounce }) / (2.0 * self.bounce.reduced_radius)
    }

    /// The four ways to move with the weights of a single contact: normal, tangential, rolling, twisting.
    fn motions(&self) -> [Pull; 4] {
        let mobilities = [1.0, 1.0 + 1.0 / self.inertia, self.rolling, self.rolling];
        std::array::from_fn(|way| {
            let [k, c] = self.modes[way];
            let weight = mobilities[way];
            Pull { weight, k, c, mobility: weight / self.bounce.reduced_mass, gathers: way > 0 }
        })
    }

    /// Contact duration, s, shortened to the share that the half period of the fastest of tangential and rolling spring has in that of
    /// the normal spring, all without drag.
    #[must_use]
    pub fn shortest_swing(&self) -> f64 {
        let [normal, others @ ..] = self.motions().map(|way| (way.k * way.mobility).sqrt());
        let share = others.into_iter().fold(1.0, |share: f64, other| share.min(normal / other));
        self.law.0.contact_duration(&self.bounce) * share
    }

    /// Largest stable step along the normal, s. No cap bounds the force of an unstable normal motion.
    #[must_use]
    pub fn normal_limit(&self, scheme: Integrator) -> f64 {
        self.lone(scheme, &self.motions()[0])
    }

    /// Largest stable step of this contact alone, s.
    #[must_use]
    pub fn lone_limit(&self, scheme: Integrator) -> f64 {
        self.motions().iter().map(|way| self.lone(scheme, way)).fold(f64::INFINITY, f64::min)
    }

    fn lone(&self, scheme: Integrator, &Pull { weight, k, c, .. }: &Pull) -> f64 {
        let weight = self.springs * weight;
        step::limit(scheme, weight * k, weight * c, self.bounce.reduced_mass)
    }

    /// Damping rates of this contact alone: c/(2 m) along the normal, and the same of sliding, rolling and twisting with their
    /// effective masses, whichever is larger, 1/s.
    #[must_use]
    pub fn damping_rates(&self) -> [f64; 2] {
        let [normal, sliding, rolling, twisting] = self.motions().map(|Pull { c, mobility, .. }| 0.5 * c * mobility);
        [normal, sliding.max(rolling).max(twisting)]
    }

    /// The shortest relaxation time c/k of the springs along the tangent, in rolling and in twisting, s; infinite without such
    /// springs. `Centred` lets springs follow the positions in steps longer than that ([`siloflow_dem::contact::centred::velocity_prediction`]).
    #[must_use]
    pub fn relaxation(&self) -> f64 {
        let springs = self.motions().into_iter().filter(|way| way.gathers && way.k > 0.0);
        springs.map(|way| way.c / way.k).fold(f64::INFINITY, f64::min)
    }

    /// Largest stable step of a grain surrounded by contacts of this kind, s. `relaxation` is the shortest of all pairs of the scene.
    #[must_use]
    pub fn bed_limit(&self, scheme: Integrator, space: Dimension, relaxation: f64) -> f64 {
        let [normal, tangential, rolling, twisting] = self.motions();
        let weights = self.bed_weights(space);
        let [straight, turning] = self.damping_rates();
        let limit = |pulls: &[(f64, Pull)], rate: f64| {
            let pulls: Vec<_> = pulls.iter().map(|&(weight, pull)| Pull { weight, ..pull }).collect();
            Motion { pulls: &pulls, mass: self.bounce.reduced_mass, rate }.limit(scheme, relaxation)
        };
        let sliding = (weights.turning, tangential);
        let resisted = [(weights.rolling, rolling), (weights.twisting, twisting)];
        let turning = if self.is_wall {
            limit(&[sliding, resisted[0], resisted[1]], turning)
        } else {
            limit(&[sliding], turning).min(limit(&resisted, turning))
        };
        let [normal, sliding] = [(weights.normal, normal), (weights.sliding, tangential)];
        let straight = if self.is_between_two() {
            // The motion along the normals has no tangents.
            limit(&[normal], straight).min(limit(&[sliding], straight))
        } else {
            limit(&[normal, sliding], straight)
        };
        straight.min(turning)
    }

    /// Whether a grain has at most two contacts of this kind, with opposite walls.
    fn is_between_two(&self) -> bool {
        self.is_wall && self.few_walls
    }

    /// Weights of the contacts of a grain surrounded by contacts of this kind, in the worst motions.
    fn bed_weights(&self, space: Dimension) -> BedWeights {
        // Of the z contacts, their sums of (n.e)^2 and of 1 - (n.e)^2 for an axis e: along normals and tangents, in twisting and in turning.
        let [normal, sliding, turning, twisting] = match (self.is_between_two(), space) {
            (true, Dimension::Plane) => [2.0, 2.0, 2.0, 0.0],
            (true, Dimension::Solid) => [2.0, 2.0, 2.0, 2.0],
            (false, Dimension::Plane) => [3.0, 3.0, 6.0, 0.0],
            (false, Dimension::Solid) => [4.0, 8.0, 8.0, 4.0],
        };
        let springs = self.springs;
        BedWeights {
            normal: springs * normal,
            sliding: springs * sliding,
            turning: springs * turning / self.inertia,
            rolling: springs * turning * self.rolling,
            twisting: springs * twisting * self.rolling,
        }
    }
}

/// Returns the speed (m/s) of an impact that is `overlap` (m) deep, by bisection. `deepest` grows with the speed.
fn speed_to_reach(overlap: f64, deepest: impl Fn(f64) -> f64) -> f64 {
    let mut low = 0.0;
    let mut high = 1.0;
    while deepest(high) < overlap && high < 1e12 {
        high *= 2.0;
    }
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if deepest(middle) < overlap { low = middle } else { high = middle }
    }
    high
}

/// Weights of the contacts around a grain: along normals and tangents if neighbours move, along tangents, in rolling and in twisting
/// if they turn.
struct BedWeights {
    normal: f64,
    sliding: f64,
    turning: f64,
    rolling: f64,
    twisting: f64,
}

/// All pairs of the lightest bodies, meeting at this speed (m/s).
#[must_use]
pub fn all(loaded: &Loaded, speed: f64) -> Vec<SpeciesPair> {
    let grains = lightest(loaded);
    let walls = walls(loaded);
    let mut pairs = Vec::new();
    for (number, &(a, first, second)) in grains.iter().enumerate() {
        pairs.extend(second.map(|second| [(a, first), (a, second)]));
        pairs.extend(grains[number + 1..].iter().map(|&(b, other, _)| [(a, first), (b, other)]));
        pairs.extend(walls.iter().map(|&wall| [(a, first), wall]));
    }
    pairs.into_iter().map(|pair| SpeciesPair::new(loaded, pair, speed)).collect()
}

/// Whether a grain touches at most two walls at once. It touches a mesh at many triangles.
fn has_few_walls(loaded: &Loaded) -> bool {
    let walls = &loaded.scene.walls;
    let discs = loaded.silo.wall.len() + loaded.silo.door.len() + loaded.fixed.len();
    walls.len() + discs <= 2 && !walls.iter().any(|wall| matches!(wall.shape, WallShape::Mesh { .. }))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::grains::file::GrainRow;
    use crate::random::Stream;
    use crate::scene::check::hardest;
    use crate::scene::load;
    use siloflow_dem::particle::{GrainId, Species};
    use siloflow_dem::space::Solid;
    use siloflow_text::fault::Fault;

    const FLOOR: &str = "walls: [HalfPlane(point: (0.0, 0.0), normal: (0.0, 1.0), species: 1)]";

    fn scene(keys: &str) -> Result<Loaded, Fault> {
        let text = format!("(gravity: (0.0, -9.81), until: 1.0, pictures: None, {keys})");
        load::from_text("test.ron", "test", std::path::Path::new(""), text, &[])
    }

    fn spawner(count: u32, radius: &str) -> String {
        format!("spawner: (point: (0.0, 1.0), velocity: (0.0, 0.0), interval: 0.1, count: {count}, radius: {radius})")
    }

    fn grain(id: u32, species: u8, radius: f64, mass: f64) -> GrainRow {
        let position = Solid::X * f64::from(id);
        let id = GrainId::grain(id).unwrap();
        GrainRow {
            id,
            radius,
            mass,
            position,
            velocity: Solid::ZERO,
            spin: Solid::ZERO,
            posture: None,
            species: Species(species),
        }
    }

    #[test]
    fn only_those_meet_of_whom_there_are_two() {
        let elastic = "contact: Linear(k: 1.0, damping: B(0.0)), mass: ArealSquare(100.0), step: Fixed(1.0e-6)";
        let mixture = spawner(3, "Mixture([(0.1, 0.34), (0.2, 0.66)])");
        let loaded = scene(&format!("{elastic}, {mixture}, {FLOOR}")).unwrap();
        let mut met: Vec<_> = all(&loaded, 1.0).iter().map(|m| (m.species, m.is_wall, m.bounce.reduced_mass)).collect();
        met.sort_by(|a, b| a.2.total_cmp(&b.2));
        // One grain of 1 kg and two of 4 kg.
        let expected = [((0, 1), false, 0.8), ((0, 1), true, 1.0), ((1, 1), false, 2.0), ((1, 1), true, 4.0)];
        for (met, expected) in met.iter().zip(expected) {
            assert!((met.0, met.1) == (expected.0, expected.1) && (met.2 - expected.2).abs() < 1e-14, "{met:?}");
        }
        assert_eq!(met.len(), 4);
        // A single grain has no contact that could be unstable.
        let alone = format!("{elastic}, {}", spawner(1, "Fixed(0.1)"));
        assert!(hardest(&scene(&alone).unwrap()).is_none() && scene(&alone.replace("1.0e-6", "9.0")).is_ok());
    }

    #[test]
    fn a_drawn_radius_is_the_one_that_comes() {
        let elastic = "contact: Linear(k: 1.0, damping: B(0.0)), mass: ArealSquare(100.0), step: Fixed(1.0e-6)";
        let loaded = scene(&format!("{elastic}, {}, {FLOOR}", spawner(3, "Uniform(0.1, 0.2)"))).unwrap();
        let random = Stream::new(0, "spawner");
        // The first of the four random numbers gives the radius.
        let radii = [1, 2, 3].map(|id| 0.1 + 0.1 * random.uniform::<4>(id)[0]);
        let smallest = radii.into_iter().fold(1.0, f64::min);
        let on_the_floor = all(&loaded, 1.0).into_iter().find(|meeting| meeting.is_wall).unwrap();
        assert!((on_the_floor.bounce.reduced_mass - 100.0 * smallest * smallest).abs() < 1e-15);
    }

    #[test]
    fn the_masses_are_those_that_the_grains_have() {
        // A small heavy grain from a file is not representative of the spawner's grains.
        let keys = "contact: Linear(k: 1.0, damping: B(0.0)), mass: ArealSquare(100.0), step: Fixed(1.0e-6)";
        let mut loaded = scene(&format!("{keys}, {}", spawner(2, "Fixed(0.1)"))).unwrap();
        loaded.grains = vec![grain(1, 0, 0.01, 3.0)];
        let (meeting, limit) = hardest(&loaded).unwrap();
        assert!((meeting.bounce.reduced_mass - 0.5).abs() < 1e-15 && (limit - 2.0 * 0.5f64.sqrt()).abs() < 1e-14);
    }

    #[test]
    fn a_law_between_grains_and_wall_is_that_of_grains_and_wall() {
        let keys = "contact: Linear(k: 1.0, damping: B(0.0)), mass: ArealSquare(100.0), \
                    pairs: [(species: (0, 1), contact: Linear(k: 1.0e4, damping: B(0.0)))]";
        let scene = |step: &str| scene(&format!("{keys}, step: Fixed({step}), {}, {FLOOR}", spawner(2, "Fixed(0.1)")));
        // 2/w0 = 2 sqrt(1 kg/1e4 N/m) for the floor; two grains with this law would have 0.0141 s.
        assert!(scene("0.0199").is_ok());
        let fault = scene("0.0201").unwrap_err().to_string();
        assert!(fault.contains("species 0 with a wall of species 1") && fault.contains("2.000e-2 s"), "{fault}");
    }

    #[test]
    fn damping_rates_and_relaxation_times_agree_with_closed_forms() {
        // Two grains of 1 kg, so a reduced mass of 0.5 kg; k = 1e4 N/m, c = 2 N s/m.
        let scene = |tangential: &str| {
            let keys = "contact: Linear(k: 1.0e4, damping: B(2.0), tangential: Spring(k: 4.0e3, friction: 0.5, ";
            let rest = "mass: ArealSquare(100.0), step: Fixed(1.0e-3), inertia: Disc";
            scene(&format!("{keys}damping: {tangential})), {rest}, {}", spawner(2, "Fixed(0.1)"))).unwrap()
        };
        let pair = |tangential: &str| all(&scene(tangential), 1.0).remove(0);
        assert!((pair("B(0.0)").damping_rates()[0] - 2.0).abs() < 1e-14);
        // A disc turns with I = m R^2/2, so the contact slides with a third of the mass.
        assert!((pair("B(1.0)").damping_rates()[1] - 3.0).abs() < 1e-14);
        // c/k: springs with a shorter relaxation time than a step follow the positions.
        assert!((pair("B(1.0)").relaxation() - 1.0 / 4.0e3).abs() < 1e-18 && pair("B(0.0)").relaxation() == 0.0);
    }

    #[test]
    fn a_grain_between_walls_has_the_limit_of_its_normals_and_tangents() {
        let keys = |kt: f64, walls: usize| {
            let wall = "HalfPlane(point: (0.0, 0.0, 0.0), normal: (0.0, 0.0, 1.0))";
            let walls = [wall; 3][..walls].join(", ");
            format!(
                "contact: Linear(k: 1.0e4, damping: B(0.0), tangential: Spring(k: {kt:?}, friction: 0.5, damping: B(0.0))), \
                 step: Fixed(1.0e-4), inertia: Sphere, space: Solid, gravity: (0.0, 0.0, 0.0), \
                 walls: [{walls}]"
            )
        };
        // A sphere of 1 kg: z = 12 walls press it with 4 k along each axis, and hold it with 8 k_t; 8 k_t/(2/5) resist its turn. Two opposite
        // walls press it with 2 k, and 2 k_t/(2/5) resist its turn.
        for (kt, walls, motion) in [(1.0e3, 3, 4.0e4 + 8.0e3), (1.0e4, 3, 20.0e4), (1.0e3, 2, 2.0e4), (1.0e4, 2, 5.0e4)]
        {
            let text = format!("(until: 1.0, pictures: None, {})", keys(kt, walls));
            let mut loaded = load::from_text("test.ron", "test", std::path::Path::new(""), text, &[]).unwrap();
            loaded.grains = vec![grain(1, 0, 0.1, 1.0)];
            let pair = all(&loaded, 1.0).remove(0);
            for scheme in [Integrator::Centred, Integrator::Verlet] {
                let limit = pair.bed_limit(scheme, Dimension::Solid, pair.relaxation());
                assert!((limit / (2.0 / f64::sqrt(motion)) - 1.0).abs() < 1e-9, "{scheme:?}: {limit}");
            }
        }
    }

    #[test]
    fn a_pressed_pair_has_the_stiffness_at_its_overlap() {
        let scene = |contact: &str| {
            let keys = format!("contact: {contact}, mass: Sphere(2500.0), step: Fixed(1.0e-7)");
            scene(&format!("{keys}, {}", spawner(2, "Fixed(0.1)"))).unwrap()
        };
        let bodies = [(0, Body::sphere(1.0, 0.1)), (0, Body::sphere(3.0, 0.3))];
        let stiffness = |contact: &str, overlap: f64| {
            let pair = SpeciesPair::pressed(&scene(contact), bodies, overlap);
            pair.law.0.stiffness(&pair.bounce)
        };
        // 2 E* sqrt(R* d) with E* = E/(2 (1 - nu^2)) and R* = 0.1 x 0.3/0.4 m; the second overlap is deeper than the smaller grain.
        let hertz = "Hertz(restitution: 0.5), materials: [(young: 1.0e7, poisson: 0.3)]";
        for overlap in [1e-4, 0.15] {
            let closed: f64 = 2.0 * (1e7 / (2.0 * 0.91)) * f64::sqrt(0.075 * overlap);
            let found = stiffness(hertz, overlap);
            assert!((found / closed - 1.0).abs() < 1e-12, "{found} {closed}");
        }
        assert!((stiffness("Linear(k: 1.0e4, damping: B(2.0))", 0.15) - 1e4).abs() < 1e-9);
    }

    #[test]
    fn drag_on_the_whole_relative_velocity_counts_along_tangents_too() {
        // Discs of m = 0.16 kg, so m_eff = 0.08 kg; z = 6 neighbours: springs count 3 times, drag 6 times.
        let keys = "contact: Assignment(k: 1.0e4, b: 5.0), mass: ArealSquare(100.0), step: Fixed(1.0e-4)";
        let pair = all(&scene(&format!("{keys}, {}", spawner(2, "Fixed(0.04)"))).unwrap(), 1.0).remove(0);
        let [verlet, centred] = [Integrator::Verlet, Integrator::Centred]
            .map(|scheme| pair.bed_limit(scheme, Dimension::Plane, f64::INFINITY));
        assert!((3.0e4 * verlet * verlet + 60.0 * verlet - 0.32).abs() < 1e-12, "{verlet}");
        let drag = 120.0 * centred / (1.0 + 5.0 * centred / 0.16);
        assert!((3.0e4 * centred * centred + drag - 0.32).abs() < 1e-9, "{centred}");
    }

    #[test]
    fn behaviours_may_bring_what_the_scene_does_not_know() {
        let keys = "contact: Linear(k: 1.0e4, damping: B(0.0)), mass: ArealSquare(100.0), step: Fixed(1.0)";
        let keys = format!("{keys}, {}", spawner(2, "Fixed(0.1)"));
        assert!(scene(&keys).is_err());
        let loaded = scene(&format!("{keys}, behaviours: {{\"law\": ()}}")).unwrap();
        let warnings = crate::scene::check::warnings(&loaded);
        assert!(warnings.iter().any(|warning| warning.code == "check::unstable_step"), "{warnings:?}");
    }

    #[test]
    fn rolling_is_as_light_as_the_inertias_and_is_not_refused() {
        let keys = "contact: Linear(k: 1.0, damping: B(0.0), tangential: Spring(k: 1.0, damping: B(0.0), friction: 0.5), \
                    rolling: (k: 1.0e4, damping: B(0.0), friction: 0.1)), inertia: Sphere";
        let mut loaded = scene(&format!("{keys}, step: Fixed(0.1), {FLOOR}")).unwrap();
        loaded.grains = vec![grain(1, 0, 0.1, 1.0), grain(2, 0, 0.3, 2.0)];
        let arm = |other: f64| 0.1 * other / (0.1 + other);
        let [light, heavy] = [0.4 * 0.01, 0.4 * 2.0 * 0.09].map(|inertia: f64| 1.0 / inertia);
        let pair = arm(0.3).powi(2) * (light + heavy);
        let wall = 0.01 * light;
        for meeting in all(&loaded, 1.0) {
            let mobility = if meeting.is_wall { wall } else { pair };
            let limit = meeting.lone_limit(Integrator::Verlet);
            assert!((limit / (2.0 / (1.0e4 * mobility).sqrt()) - 1.0).abs() < 1e-13, "{limit}");
        }
        // This step is stable along the normal (2/w0 = 1.6 s). The tangential motion is unstable but capped: a warning.
        assert!(hardest(&loaded).unwrap().1 > 1.0);
        let warnings = crate::scene::check::warnings(&loaded);
        assert!(warnings.iter().any(|warning| warning.code == "check::unstable_step"), "{warnings:?}");
    }
}
