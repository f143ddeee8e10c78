//! A contact law of an external crate that remembers: a bond of two grains that have touched, which hardens with time.
//!
//! F on i = (k delta - c v_n) n - k_b h s, with v_n = (v_i - v_j).n and the overlap delta, which is negative across a gap. Grains that
//! have touched are bonded until the gap between them exceeds the length l: the law reaches beyond touch. It remembers
//!
//! * s, m: the displacement of i against j in the tangent plane since they touched. It is a vector that changes its sign if i and j
//!   are exchanged;
//! * the age of the contact, s, and the largest overlap, m, which are the same from both grains.
//!
//! The bond hardens with h = age/(age + tau) d/(d + l), with the largest overlap d. k and k_b are in N/m, c in N s/m, l in m, tau in s.
//!
//! Limits: the force along s acts between the centres, without torques. The energy balance leaves out the energy that a hardening bond
//! gains, and that of s when a bond breaks.

use std::f64::consts::PI;
use std::sync::Arc;

use serde::Deserialize;
use siloflow::prelude::*;

/// The scene's `behaviours: {"bond": (...)}`, which replaces its `contact`.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Bond {
    /// k, N/m.
    k: f64,
    /// c, N s/m.
    damping: f64,
    /// k_b, N/m.
    shear: f64,
    /// l, m.
    length: f64,
    /// tau, s.
    hardening: f64,
}

/// The memory of a bond.
struct BondMemory<V> {
    /// s, m.
    displacement: V,
    /// Age of the contact, s.
    age: f64,
    /// Largest overlap, m.
    deepest: f64,
}

impl<V: Space> BondMemory<V> {
    /// Takes the numbers of a memory, in the order of [`LawRequirements::MEMORY`].
    fn of(memory: &Memory) -> Self {
        let scalars = V::COMPONENTS;
        Self { displacement: memory.vector(0), age: memory.numbers[scalars], deepest: memory.numbers[scalars + 1] }
    }

    fn store(&self, memory: &mut Memory) {
        let scalars = V::COMPONENTS;
        memory.set_vector(0, self.displacement);
        memory.numbers[scalars] = self.age;
        memory.numbers[scalars + 1] = self.deepest;
    }
}

impl Bond {
    /// Returns k_b h, N/m.
    fn shear_stiffness<V>(&self, bond: &BondMemory<V>) -> f64 {
        self.shear * bond.age / (bond.age + self.hardening) * (bond.deepest / (bond.deepest + self.length))
    }
}

impl LawRequirements for Bond {
    const RADII: bool = false;
    const MEMORY: &'static [MemoryVariable] = &[
        MemoryVariable::vector("displacement", Parity::Odd),
        MemoryVariable::number("age", Parity::Even),
        MemoryVariable::number("deepest", Parity::Even),
    ];
    const REACHES: bool = true;
}

impl<V: Space> PairLaw<V> for Bond {
    fn force(&self, pair: &Pair<V>, memory: &mut Memory) -> PairForce<V> {
        let mut bond = BondMemory::<V>::of(memory);
        let moved = bond.displacement + pair.relative_velocity * pair.dt;
        bond.displacement = moved - pair.normal * moved.dot(pair.normal);
        bond.age += pair.dt;
        bond.deepest = bond.deepest.max(pair.overlap);
        bond.store(memory);
        let elastic = pair.normal * (self.k * pair.overlap) - bond.displacement * self.shear_stiffness(&bond);
        PairForce::new(elastic, pair.normal * (-self.damping * pair.normal_velocity()))
    }

    fn elastic_energy(&self, pair: &Pair<V>, memory: &Memory) -> f64 {
        let bond = BondMemory::<V>::of(memory);
        0.5 * (self.k * pair.overlap * pair.overlap + self.shear_stiffness(&bond) * bond.displacement.length_squared())
    }

    fn largest_range(&self, _: f64) -> f64 {
        self.length
    }

    fn lost_at_break(&self, _: &Pair<V>) -> f64 {
        0.5 * self.k * self.length * self.length
    }

    fn stiffness(&self, _: &Bounce) -> f64 {
        self.k
    }

    fn damping(&self, _: &Bounce) -> f64 {
        self.damping
    }

    // Estimates without the bond.
    fn contact_duration(&self, bounce: &Bounce) -> f64 {
        PI * (bounce.reduced_mass / self.k).sqrt()
    }

    fn restitution(&self, bounce: &Bounce) -> f64 {
        (-0.5 * self.damping / bounce.reduced_mass * <Self as PairLaw<V>>::contact_duration(self, bounce)).exp()
    }
}

impl Bond {
    fn add<V: Space>(self, app: &mut App) {
        app.add_plugins(ContactPlugin::<V, _>::new(Arc::new(self)).reaching(self.length));
    }
}

impl Behaviour for Bond {
    fn lives_in(&self, _: Dimension) -> bool {
        true
    }

    fn brings_contact_law(&self) -> bool {
        true
    }

    fn build(self: Box<Self>, app: &mut App) {
        match Dimension::of_world(app.world()) {
            Dimension::Plane => self.add::<Plane>(app),
            Dimension::Solid => self.add::<Solid>(app),
        }
    }
}

#[cfg(test)]
mod tests {
    use std::num::NonZeroUsize;
    use std::path::Path;

    use siloflow::dem::contact::VelocityPrediction;
    use siloflow::dem::contact::memory::MemoryLayout;
    use siloflow::output::state_hash;

    use super::*;
    use crate::registry;
    use crate::tests::{overlap, pair};

    const BOND: Bond = Bond { k: 1.0e4, damping: 20.0, shear: 2.0e3, length: 2.0e-3, hardening: 0.01 };

    /// Returns two grains that slide past each other, seen from i.
    fn sliding() -> Pair {
        Pair {
            normal: Vector::new(0.6, 0.8),
            overlap: 1e-3,
            relative_velocity: Vector::new(0.3, -0.1),
            reduced_mass: 0.1,
            mass_root: 0.0,
            radii: [0.04, 0.03],
            inverse_reach: 1.0 / 0.07,
            spins: [0.0; 2],
            species: [Species(0); 2],
            dt: 1e-4,
            springs_ahead: 0.0,
            gathered: None,
            ahead: VelocityPrediction::default(),
        }
    }

    #[test]
    fn both_grains_see_the_same_bond() {
        let layout = MemoryLayout::new::<Plane>(Bond::MEMORY, Bond::REACHES);
        let on_i = sliding();
        let on_j = on_i.seen_from_partner();
        let mut of_i = Memory::default();
        let mut of_j = Memory::default();
        for _ in 0..3 {
            let forces = [BOND.force(&on_i, &mut of_i).normal, BOND.force(&on_j, &mut of_j).normal];
            assert_eq!(forces[0], -forces[1]);
            assert_eq!(of_j, layout.seen_from_partner(&of_i));
        }
        // Displacement, age and largest overlap.
        assert!(of_i.numbers[..4].iter().all(|number| *number != 0.0), "{of_i:?}");
        assert!(of_i.numbers[4..].iter().all(|number| *number == 0.0), "{of_i:?}");
    }

    #[test]
    fn a_bond_holds_across_a_gap_up_to_its_length() {
        for space in [Dimension::Plane, Dimension::Solid] {
            let run = |length: &str| {
                let bond =
                    format!("{{\"bond\": (k: 1.0e4, damping: 2.0, shear: 0.0, length: {length}, hardening: 0.01)}}");
                let mut run = pair(space, &bond, 1.0);
                assert_eq!(run.run(), End::TimeReached);
                overlap(&mut run, space)
            };
            // The overlap of 0.1 mm at the start becomes a gap of nearly 0.1 mm, and the bond pulls the grains together again.
            let bonded = run("2.0e-4");
            assert!(bonded.abs() < 1e-6, "{bonded}");
            let free = run("2.0e-5");
            assert!(free < -1e-3, "{free}");
        }
    }

    #[test]
    fn threads_change_no_bit() {
        let scene = "(gravity: (0.0, -9.81), mass: ArealSquare(100.0), step: Fixed(1.0e-4), until: 1.0, pictures: None, \
                      contact: Linear(k: 1.0e4, damping: B(20.0)), walls: [HalfPlane(point: (0.0, 0.0), normal: (0.0, 1.0))], \
                      fill: [(low: (0.0, 0.0), high: (6.0, 2.0), spacing: 0.0802, radius: Fixed(0.04), count: 1500, \
                      agitation: (0.5, 0.5))], behaviours: {\"bond\": (k: 1.0e4, damping: 20.0, shear: 2.0e3, length: 2.0e-3, \
                      hardening: 0.01)})";
        let hash = |threads: usize| {
            let loaded = load::from_text("bonds", "bonds", Path::new(""), scene.to_owned(), &[]).expect("a scene");
            let threads = NonZeroUsize::new(threads).expect("threads");
            let mut run = Simulation::new(&loaded, &registry(), threads).expect("the behaviour fits the scene");
            run.run_steps(200);
            state_hash::of_world(run.world_mut())
        };
        assert_eq!(hash(1), hash(2));
    }
}
