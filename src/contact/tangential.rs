//! Friction: the force in the tangent plane of a contact, with Coulomb's cap mu |F_n|.
//!
//! With the sliding velocity v_t = v_ij - v_n n - (l_i w_i + l_j w_j) x n of the surfaces:
//!
//! * [`Dashpot`]: F_t = -c_t v_t, without memory. A heap of such grains creeps.
//! * [`Stick`]: a spring S that remembers how far the surfaces have moved against each other while the contact lasts,
//!   F_t = -k_t S - c_t v_t, elastic-plastic as [`Slider`] has it. Source: Cundall and Strack 1979, as in the
//!   soft-particle codes and LAMMPS's `hooke/history`.
//!
//! The force on j is the opposite; each grain gets the torque -l n x F_t. By [`Lever`] the arm l is the radius (simple,
//! and what most codes have: a contact then leaks the angular momentum -delta n x F_t) or reaches to the contact point,
//! which keeps angular momentum. c_t in N s/m by [`TangentialDamping`], k_t in N/m by [`Modulus`].

use serde::{Deserialize, Serialize};

use crate::contact::damping::Coefficient;
use crate::contact::spring::{Event, Slider, Sweep, lost_at_the_end};
use crate::contact::{Ahead, Bounce, Memory, Pair, Turning};
use crate::scene::values::NonNegative;
use crate::space::Space;

/// Where the tangential force acts.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
pub enum Lever {
    /// A radius away from the centre.
    #[default]
    Radius,
    /// At the contact point: l_i = R_i - delta R_j/(R_i + R_j); R - delta on a flat wall.
    ContactPoint,
}

impl Lever {
    /// The arms of i and j, m; none for a flat wall.
    #[inline(always)]
    #[must_use]
    pub fn arms<V: Space>(self, pair: &Pair<V>) -> [f64; 2] {
        let [i, j] = pair.radii;
        match (self, j.is_infinite()) {
            (Self::Radius, false) => pair.radii,
            (Self::Radius, true) => [i, 0.0],
            (Self::ContactPoint, false) => {
                let share = pair.overlap * pair.inverse_reach;
                [i - share * j, j - share * i]
            }
            (Self::ContactPoint, true) => [i - pair.overlap, 0.0],
        }
    }
}

/// The drag coefficient c_t of the tangential force, N s/m.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
pub enum TangentialDamping {
    /// c_t = b, N s/m.
    B(NonNegative),
    /// c_t = gamma_t m_eff, gamma_t in 1/s, as LAMMPS has it.
    PerMass(NonNegative),
    /// c_t is this share of the normal c.
    OfNormal(NonNegative),
}

/// c_t: what it is given besides the effective mass is the normal c.
impl From<TangentialDamping> for Coefficient {
    fn from(damping: TangentialDamping) -> Self {
        match damping {
            TangentialDamping::B(b) => Self { constant: b.get(), ..Self::default() },
            TangentialDamping::PerMass(gamma) => Self { per_mass: gamma.get(), ..Self::default() },
            TangentialDamping::OfNormal(share) => Self { per_other: share.get(), ..Self::default() },
        }
    }
}

/// What the normal force of a centred contact leaves to its tangent plane.
#[derive(Clone, Copy, Debug)]
pub struct Grip {
    /// The normal force of the contact as it stands, N.
    pub whole: f64,
    /// The normal forces averaged over the steps centred on the beginning and on the end, N.
    pub averaged: [f64; 2],
    /// The shares of those steps in which there is a contact.
    pub shares: [f64; 2],
    /// The normal drag coefficient c as it stands, N s/m.
    pub drag: f64,
    /// For how long springs gather, s: from the event on.
    pub gathering: f64,
    /// The moment of this step in which the contact opened or the normal force changed its sign, s before the end, with
    /// the normal force just after, N, and whether it opened.
    pub event: Option<(f64, f64, bool)>,
}

impl Grip {
    /// The step, for a motion with this velocity in its middle and what that gains (m/s), the mobilities (1/kg) of such a
    /// motion, and a coefficient of friction.
    #[inline(always)]
    #[must_use]
    pub fn sweep<V: Space>(&self, motion: [V; 2], mobilities: [f64; 2], friction: f64, dt: f64) -> Sweep<V> {
        let [middle, gained] = motion;
        Sweep {
            middle,
            gained,
            mobilities,
            dt,
            event: self.event.map(|(ago, force, opens)| Event { ago, cap: friction * force.abs(), opens }),
            gathering: self.gathering,
            shares: self.shares,
            averaged_caps: self.averaged.map(|force| friction * force.abs()),
            pulled: V::ZERO,
        }
    }
}

impl<V: Space> Pair<V> {
    /// The sliding velocity in the middle of the step and what it gains until its end, m/s, and how fast a tangential
    /// force changes it, of all and of lone grains, 1/kg: 1/m + l^2/I of i and j.
    #[inline(always)]
    fn sliding(&self, arms: [f64; 2]) -> ([V; 2], [f64; 2]) {
        let middle = self.sliding_velocity(arms);
        let Ahead { inverse_masses: m, inverse_inertias: i, lone, .. } = self.ahead;
        let [a, b] = [m[0] + arms[0] * arms[0] * i[0], m[1] + arms[1] * arms[1] * i[1]];
        ([middle, self.predicted().sliding_velocity(arms) - middle], [a + b, lone[0] * a + lone[1] * b])
    }
}

/// A term in the tangent plane.
pub trait Tangential: Copy + Send + Sync + 'static {
    /// Whether it turns grains.
    const SPIN: bool = true;
    /// Whether it remembers a spring.
    const SPRING: bool = false;
    /// Whether it remembers that spring's stiffness.
    const STIFFNESS: bool = false;

    /// Adds friction; `normal_force` (N) and `normal_drag` (N s/m) are those of the normal force.
    fn add<V: Space>(
        &self,
        pair: &Pair<V>,
        normal_force: f64,
        normal_drag: f64,
        memory: &mut Memory<V>,
        turning: &mut Turning<V>,
    );

    /// Adds friction averaged over the step: [`super::centred`].
    fn add_centred<V: Space>(&self, pair: &Pair<V>, grip: &Grip, memory: &mut Memory<V>, turning: &mut Turning<V>);

    /// Energy stored, J.
    fn energy<V: Space>(&self, _memory: &Memory<V>) -> f64 {
        0.0
    }

    /// See [`PairLaw::forget`](crate::contact::PairLaw::forget), J.
    fn forget<V: Space>(&self, _pair: &Pair<V>, _memory: &Memory<V>) -> f64 {
        0.0
    }

    /// Stiffness (N/m) and drag coefficient (N s/m) at the deepest point of a bounce; `normal_drag` is the normal c.
    fn mode(&self, bounce: &Bounce, normal_drag: f64) -> [f64; 2];

    /// The coefficient mu.
    fn friction(&self) -> f64;
}

/// No friction.
#[derive(Clone, Copy, Debug)]
pub struct Smooth;

impl Tangential for Smooth {
    const SPIN: bool = false;

    #[inline(always)]
    fn add<V: Space>(&self, _: &Pair<V>, _: f64, _: f64, _: &mut Memory<V>, _: &mut Turning<V>) {}

    #[inline(always)]
    fn add_centred<V: Space>(&self, _: &Pair<V>, _: &Grip, _: &mut Memory<V>, _: &mut Turning<V>) {}

    fn mode(&self, _: &Bounce, _: f64) -> [f64; 2] {
        [0.0, 0.0]
    }

    fn friction(&self) -> f64 {
        0.0
    }
}

/// A dashpot cut at mu |F_n|.
#[derive(Clone, Copy, Debug)]
pub struct Dashpot {
    /// c_t, from the effective mass and the normal c.
    pub damping: Coefficient,
    /// mu.
    pub friction: f64,
    /// Where it acts.
    pub lever: Lever,
}

impl Tangential for Dashpot {
    #[inline(always)]
    fn add<V: Space>(
        &self,
        pair: &Pair<V>,
        normal_force: f64,
        normal_drag: f64,
        _: &mut Memory<V>,
        turning: &mut Turning<V>,
    ) {
        turning.arms = self.lever.arms(pair);
        let velocity = pair.sliding_velocity(turning.arms);
        let (drag, cap) = (self.damping.of(pair.reduced_mass, normal_drag), self.friction * normal_force.abs());
        let squared = velocity.length_squared() * drag * drag;
        turning.is_sliding = squared > cap * cap;
        let cut = if turning.is_sliding { cap / squared.sqrt() } else { 1.0 };
        turning.friction = velocity * (-drag * cut);
        turning.friction_drag = turning.friction;
    }

    #[inline(always)]
    fn add_centred<V: Space>(&self, pair: &Pair<V>, grip: &Grip, _: &mut Memory<V>, turning: &mut Turning<V>) {
        turning.arms = self.lever.arms(pair);
        let (motion, mobilities) = pair.sliding(turning.arms);
        let drag = self.damping.of(pair.reduced_mass, grip.drag);
        let slider = Slider { stiffness: 0.0, drag, cap: self.friction * grip.whole.abs() };
        let pull = slider.pull_centred(
            &mut V::default(),
            &grip.sweep(motion, mobilities, self.friction, pair.dt),
            pair.normal,
        );
        turning.is_sliding = pull.is_sliding;
        (turning.friction, turning.friction_drag) = (pull.force, pull.force);
    }

    fn mode(&self, bounce: &Bounce, normal_drag: f64) -> [f64; 2] {
        [0.0, self.damping.of(bounce.reduced_mass, normal_drag)]
    }

    fn friction(&self) -> f64 {
        self.friction
    }
}

/// The tangential stiffness and drag of a contact.
pub trait Modulus: Copy + Send + Sync + 'static {
    /// Whether the stiffness changes while a contact lasts.
    const VARIES: bool;

    /// k_t (N/m) and c_t (N s/m); `normal_drag` is the normal c, N s/m.
    fn of<V: Space>(&self, pair: &Pair<V>, normal_drag: f64) -> (f64, f64);

    /// The k_t that a spring was last used with, N/m, of which `memory` has a note if it varies.
    fn remembered(&self, memory: f64) -> f64;

    /// k_t (N/m) and c_t (N s/m) at the deepest point of a bounce.
    fn at(&self, bounce: &Bounce, normal_drag: f64) -> [f64; 2];
}

/// The same k_t in every contact.
#[derive(Clone, Copy, Debug)]
pub struct Constant {
    /// k_t, N/m.
    pub k: f64,
    /// c_t, from the effective mass and the normal c.
    pub damping: Coefficient,
}

impl Modulus for Constant {
    const VARIES: bool = false;

    #[inline(always)]
    fn of<V: Space>(&self, pair: &Pair<V>, normal_drag: f64) -> (f64, f64) {
        (self.k, self.damping.of(pair.reduced_mass, normal_drag))
    }

    fn remembered(&self, _: f64) -> f64 {
        self.k
    }

    fn at(&self, bounce: &Bounce, normal_drag: f64) -> [f64; 2] {
        [self.k, self.damping.of(bounce.reduced_mass, normal_drag)]
    }
}

/// A spring with memory and a dashpot, cut together at mu |F_n|. Where the stiffness varies, a stiffening spring keeps
/// its force and a softening one its displacement, so that neither gains energy (Thornton, Cummins and Cleary, Powder
/// Technology 233, 30, 2013); what it loses is booked with sliding.
#[derive(Clone, Copy, Debug)]
pub struct Stick<M> {
    /// k_t and c_t.
    pub modulus: M,
    /// mu.
    pub friction: f64,
    /// Where it acts.
    pub lever: Lever,
}

impl<M: Modulus> Stick<M> {
    /// The mean stiffness of a step over that of its end: what is gathered while a spring stiffens keeps its force. From
    /// nothing it grows like the root of time.
    #[inline(always)]
    fn mean_stiffness(before: f64, now: f64) -> f64 {
        if before >= now {
            1.0
        } else if before == 0.0 {
            2.0 / 3.0
        } else {
            0.5 * (1.0 + before / now)
        }
    }

    /// Adapts the spring to a changed stiffness; gives what it loses, J.
    #[inline(always)]
    fn adapt<V: Space>(k: f64, memory: &mut Memory<V>) -> f64 {
        let before = memory.stiffness * memory.spring.length_squared();
        if k > memory.stiffness {
            memory.spring = memory.spring * (memory.stiffness / k);
        }
        memory.stiffness = k;
        0.5 * (before - k * memory.spring.length_squared())
    }
}

impl<M: Modulus> Tangential for Stick<M> {
    const SPRING: bool = true;
    const STIFFNESS: bool = M::VARIES;

    #[inline(always)]
    fn add<V: Space>(
        &self,
        pair: &Pair<V>,
        normal_force: f64,
        normal_drag: f64,
        memory: &mut Memory<V>,
        turning: &mut Turning<V>,
    ) {
        let (stiffness, drag) = self.modulus.of(pair, normal_drag);
        if M::VARIES {
            turning.lost_by_sliding = Self::adapt(stiffness, memory);
        }
        turning.arms = self.lever.arms(pair);
        let velocity = pair.sliding_velocity(turning.arms);
        let slider = Slider { stiffness, drag, cap: self.friction * normal_force.abs() };
        let pull = slider.pull(&mut memory.spring, velocity, pair.normal, pair.dt);
        turning.friction = pull.force;
        turning.friction_drag = pull.drag;
        turning.lost_by_sliding += pull.lost;
        turning.is_sliding = pull.is_sliding;
    }

    #[inline(always)]
    fn add_centred<V: Space>(&self, pair: &Pair<V>, grip: &Grip, memory: &mut Memory<V>, turning: &mut Turning<V>) {
        // Across a gap too the arms meet: what the contact point's keep of the angular momentum, they keep there.
        let (stiffness, drag) = self.modulus.of(&pair.at_overlap(pair.overlap), grip.drag);
        turning.arms = self.lever.arms(pair);
        let (motion, mobilities) = pair.sliding(turning.arms);
        let mut sweep = grip.sweep(motion, mobilities, self.friction, pair.dt);
        sweep.pulled = memory.spring * -self.modulus.remembered(memory.stiffness);
        if M::VARIES {
            sweep.gathering *= Self::mean_stiffness(memory.stiffness, stiffness);
            // Where a contact opens there is neither stiffness nor drag.
            sweep.event = sweep.event.filter(|_| memory.stiffness > 0.0);
            turning.lost_by_sliding = Self::adapt(stiffness, memory);
        }
        let slider = Slider { stiffness, drag, cap: self.friction * grip.whole.abs() };
        let pull = slider.pull_centred(&mut memory.spring, &sweep, pair.normal);
        turning.friction = pull.force;
        turning.friction_drag = pull.drag;
        turning.lost_by_sliding += pull.lost;
        turning.is_sliding = pull.is_sliding;
    }

    fn energy<V: Space>(&self, memory: &Memory<V>) -> f64 {
        0.5 * self.modulus.remembered(memory.stiffness) * memory.spring.length_squared()
    }

    fn forget<V: Space>(&self, pair: &Pair<V>, memory: &Memory<V>) -> f64 {
        let velocity = pair.sliding_velocity(self.lever.arms(pair));
        lost_at_the_end(self.modulus.remembered(memory.stiffness), memory.spring, velocity, pair.dt)
    }

    fn mode(&self, bounce: &Bounce, normal_drag: f64) -> [f64; 2] {
        self.modulus.at(bounce, normal_drag)
    }

    fn friction(&self) -> f64 {
        self.friction
    }
}

#[cfg(test)]
#[expect(clippy::float_cmp, reason = "exact values")]
mod tests {
    use super::*;
    use crate::contact::tests::pair;
    use crate::space::Vector;

    #[test]
    fn arms_reach_to_the_contact_point_and_meet_there() {
        let pair = Pair { radii: [0.03, 0.05], inverse_reach: 12.5, overlap: 0.004, ..pair() };
        let [i, j] = Lever::ContactPoint.arms(&pair);
        // Both arms together span the distance of the centres, and split the overlap in the other one's proportion.
        assert!((i + j - 0.076).abs() < 1e-16 && (i - 0.0275).abs() < 1e-16, "{i} {j}");
        assert_eq!(Lever::Radius.arms(&pair), [0.03, 0.05]);
        assert_eq!(
            Lever::ContactPoint.arms(&Pair { radii: [0.03, f64::INFINITY], inverse_reach: 0.0, ..pair }),
            [0.026, 0.0]
        );
    }

    #[test]
    fn a_rolling_contact_does_not_slide() {
        // Over a floor below, a disc that rolls to the right turns clockwise.
        let pair = Pair {
            normal: Vector::Y,
            relative_velocity: Vector::new(0.6, -0.2),
            radii: [0.04, f64::INFINITY],
            inverse_reach: 0.0,
            spins: [-15.0, 0.0],
            ..pair()
        };
        assert!(pair.sliding_velocity(Lever::Radius.arms(&pair)).length() < 1e-16);
    }

    #[test]
    fn a_dashpot_is_cut_at_the_cap() {
        let zero = NonNegative::try_from(2.0).unwrap();
        let law = Dashpot { damping: TangentialDamping::B(zero).into(), friction: 0.5, lever: Lever::Radius };
        let slow = Pair { relative_velocity: Vector::new(0.0, 1.0), ..pair() };
        let fast = Pair { relative_velocity: Vector::new(0.0, 10.0), ..pair() };
        let mut turning = Turning::default();
        law.add(&slow, 10.0, 0.0, &mut Memory::default(), &mut turning);
        assert_eq!((turning.friction, turning.is_sliding), (Vector::new(0.0, -2.0), false));
        law.add(&fast, -10.0, 0.0, &mut Memory::default(), &mut turning);
        assert_eq!((turning.friction, turning.is_sliding), (Vector::new(0.0, -5.0), true));
    }

    #[test]
    fn a_spring_of_changing_stiffness_gains_no_energy() {
        let mut memory = Memory { spring: Vector::new(0.0, 1e-5), stiffness: 1e4, ..Memory::default() };
        let stiffer = Stick::<Constant>::adapt(2e4, &mut memory);
        assert_eq!((memory.spring.y, memory.stiffness), (5e-6, 2e4));
        let softer = Stick::<Constant>::adapt(1e4, &mut memory);
        assert_eq!(memory.spring.y, 5e-6);
        assert!(stiffer > 0.0 && softer > 0.0);
        assert!((stiffer + softer - 0.5e4 * (1e-10 - 0.25e-10)).abs() < 1e-21);
    }
}
