//! A law composed of terms: a normal force, a tangential force and rolling resistance.
//!
//! The terms are types, so that the loop over contacts is compiled for each combination of terms. An unused term
//! ([`NoFriction`](super::tangential::NoFriction), [`NoRolling`](super::rolling::NoRolling)) costs no run time.

use crate::contact::centred::normal_load::{LoadEvent, NormalLoad, Unloading};
use crate::contact::centred::window::Window;
use crate::contact::law::{Bounce, LawRequirements, PairLaw};
use crate::contact::memory::{Memory, MemoryVariable};
use crate::contact::pair::{Pair, VelocityPrediction};
use crate::contact::pair_force::PairForce;
use crate::contact::rolling::Rolling;
use crate::contact::spring_memory::{ROLLING, SPRING, STIFFNESS, SpringMemory, TWIST};
use crate::contact::tangential::Tangential;
use crate::lanes::larger;
use crate::space::Space;

/// A force along the normal: (max(spring - c v_n, floor) - pull) n.
///
/// The pull is zero without adhesion. The force without the pull is the normal load, which caps friction.
pub trait Normal: Copy + Send + Sync + 'static {
    /// See [`LawRequirements::RADII`].
    const RADII: bool = true;
    /// The smallest overlap, in half-widths of the step, at which a contact cannot open or close within the step. From it on,
    /// [`Normal::mean_dashpot_without_events`] gives the mean dashpot coefficient.
    const OVERLAP_WITHOUT_EVENTS: f64;
    /// Whether the dashpot coefficient goes to zero with the overlap.
    const FADES: bool = false;
    /// Whether there is a pull.
    const PULLS: bool = false;
    /// Whether a contact exists beyond touch, up to [`Normal::range`], and its forces jump where it begins and ends.
    const REACHES: bool = false;

    /// Returns the spring force, N.
    fn spring<V: Space>(&self, pair: &Pair<V>) -> f64;

    /// Returns the dashpot coefficient c, N s/m.
    fn dashpot<V: Space>(&self, pair: &Pair<V>) -> f64;

    /// Returns the mean of the dashpot coefficient over the step centred on `overlap` (m; negative for a gap), N s/m. The
    /// coefficient is zero where there is no contact.
    fn mean_dashpot<V: Space>(&self, pair: &Pair<V>, window: &Window, overlap: f64) -> f64;

    /// Returns the mean of the dashpot coefficient for an overlap much larger than the half-width of the step, N s/m.
    /// `dashpot` is the coefficient at the evaluation.
    fn mean_dashpot_without_events(&self, dashpot: f64, window: &Window, overlap: f64) -> f64;

    /// Returns the lower bound of the total normal force, N: 0, or minus infinity where the force may pull.
    fn floor(&self) -> f64;

    /// Returns the pull, N. The part of it that acts from touch on is multiplied by `share`, the fraction of a step in
    /// contact.
    #[inline(always)]
    fn pull<V: Space>(&self, _pair: &Pair<V>, _share: f64) -> f64 {
        0.0
    }

    /// Returns the range of a contact beyond touch at a reduced radius (m), m.
    #[inline(always)]
    fn range(&self, _reduced_radius: f64) -> f64 {
        0.0
    }

    /// Returns the mean of the spring force over the overlaps between those of two pairs, N. Called for contacts that reach beyond
    /// touch.
    fn mean_spring<V: Space>(&self, _low: &Pair<V>, high: &Pair<V>) -> f64 {
        self.spring(high)
    }

    /// See [`PairLaw::lost_at_break`].
    fn lost_at_break<V: Space>(&self, _pair: &Pair<V>) -> f64 {
        0.0
    }

    /// See [`PairLaw::needs_mass_root`].
    fn needs_mass_root(&self) -> bool {
        false
    }

    /// Returns the energy stored in the contact by spring and pull, J.
    fn energy<V: Space>(&self, pair: &Pair<V>) -> f64;

    /// See [`PairLaw::stiffness`].
    fn stiffness(&self, bounce: &Bounce) -> f64;

    /// See [`PairLaw::damping`].
    fn damping(&self, bounce: &Bounce) -> f64;

    /// See [`PairLaw::deepest`].
    fn deepest(&self, bounce: &Bounce) -> f64;

    /// See [`PairLaw::contact_duration`].
    fn contact_duration(&self, bounce: &Bounce) -> f64;

    /// See [`PairLaw::restitution`].
    fn restitution(&self, bounce: &Bounce) -> f64;
}

/// A law of normal force, friction and rolling resistance.
#[derive(Clone, Copy, Debug)]
pub struct Composite<N, T, R> {
    /// Force along the normal.
    pub normal: N,
    /// Force in the tangent plane.
    pub tangential: T,
    /// Resistance against rolling.
    pub rolling: R,
}

/// The places of the first numbers of the springs in [`Memory::numbers`].
struct SpringPlaces {
    spring: usize,
    rolling: usize,
    stiffness: usize,
    twist: usize,
}

impl<N: Normal, T: Tangential, R: Rolling> LawRequirements for Composite<N, T, R> {
    const SPIN: bool = T::SPIN;
    const ROLLING: bool = R::ROLLING;
    const RADII: bool = N::RADII || T::SPIN;
    const MEMORY: &'static [MemoryVariable] = &[
        SPRING.kept_if(T::SPRING),
        ROLLING.kept_if(R::ROLLING),
        STIFFNESS.kept_if(T::STIFFNESS),
        TWIST.kept_if(R::TWISTING),
    ];
    const PULLS: bool = N::PULLS;
    const REACHES: bool = N::REACHES;
}

impl<N: Normal, T: Tangential, R: Rolling> Composite<N, T, R> {
    /// Returns the places of the springs in a memory, which has the variables of [`LawRequirements::MEMORY`].
    const fn places<V: Space>() -> SpringPlaces {
        let rolling = SPRING.kept_if(T::SPRING).width::<V>();
        let stiffness = rolling + ROLLING.kept_if(R::ROLLING).width::<V>();
        let twist = stiffness + STIFFNESS.kept_if(T::STIFFNESS).width::<V>();
        SpringPlaces { spring: 0, rolling, stiffness, twist }
    }

    /// Returns the springs in a memory.
    #[inline(always)]
    fn springs<V: Space>(memory: &Memory) -> SpringMemory<V> {
        let places = const { Self::places::<V>() };
        SpringMemory {
            spring: if T::SPRING { memory.vector(places.spring) } else { V::ZERO },
            rolling: if R::ROLLING { memory.vector(places.rolling) } else { V::ZERO },
            stiffness: if T::STIFFNESS { memory.numbers[places.stiffness] } else { 0.0 },
            twist: if R::TWISTING { memory.numbers[places.twist] } else { 0.0 },
        }
    }

    /// Sets the springs in a memory.
    #[inline(always)]
    fn remember<V: Space>(memory: &mut Memory, springs: &SpringMemory<V>) {
        let places = const { Self::places::<V>() };
        if T::SPRING {
            memory.set_vector(places.spring, springs.spring);
        }
        if R::ROLLING {
            memory.set_vector(places.rolling, springs.rolling);
        }
        if T::STIFFNESS {
            memory.numbers[places.stiffness] = springs.stiffness;
        }
        if R::TWISTING {
            memory.numbers[places.twist] = springs.twist;
        }
    }
}

impl<V: Space, N: Normal, T: Tangential, R: Rolling> PairLaw<V> for Composite<N, T, R> {
    #[inline(always)]
    fn force(&self, pair: &Pair<V>, memory: &mut Memory) -> PairForce<V> {
        let mut springs = Self::springs(memory);
        let spring = self.normal.spring(pair);
        let dashpot = self.normal.dashpot(pair);
        let load = larger(spring - dashpot * pair.normal_velocity(), self.normal.floor());
        let pull = self.normal.pull(pair, 1.0);
        let mut force =
            PairForce { load: Some([load, spring]), ..PairForce::along(pair.normal, load - pull, spring - pull) };
        self.tangential.add(pair, load, dashpot, &mut springs, &mut force.resistance);
        self.rolling.add(pair, load, &mut springs, &mut force.resistance);
        Self::remember(memory, &springs);
        force
    }

    #[inline(always)]
    fn centred(&self, pair: &Pair<V>, memory: &mut Memory) -> PairForce<V> {
        let window = Window::of(pair);
        let mut springs = Self::springs::<V>(memory);
        // Measured from where the contact breaks, if it exists beyond touch.
        let range = if N::REACHES { self.range_of(pair, memory) } else { 0.0 };
        let overlap = if N::REACHES { pair.overlap + range } else { pair.overlap };
        let before = overlap - window.moved;
        let at = |overlap: f64| {
            let mut pair = pair.at_overlap(overlap);
            if N::REACHES {
                pair.overlap -= range;
            }
            pair
        };
        let now = at(overlap);
        let then = at(before);
        let spring = self.normal.spring(&now);
        let dashpot = self.normal.dashpot(&now);
        let [mean, mean_before] = if overlap >= N::OVERLAP_WITHOUT_EVENTS * window.half_width {
            [self.normal.mean_dashpot_without_events(dashpot, &window, overlap); 2]
        } else if N::REACHES {
            [(&now, overlap), (&then, before)].map(|(pair, overlap)| self.normal.mean_dashpot(pair, &window, overlap))
        } else {
            [overlap, before].map(|overlap| self.normal.mean_dashpot(pair, &window, overlap))
        };
        let VelocityPrediction { velocity: gained, inverse_masses, .. } = &pair.ahead;
        let gained = -gained.dot(pair.normal);
        // h times the mobility (1/kg) of the pair, and of its lone grains.
        let [half, half_lone] =
            [inverse_masses[0] + inverse_masses[1], pair.ahead.lone_mobility()].map(|m| 0.5 * pair.dt * m);
        let spring_before = self.normal.spring(&then);
        let [pull, pull_before] = if N::PULLS {
            [(&now, overlap), (&then, before)].map(|(pair, overlap)| self.normal.pull(pair, window.share(overlap)))
        } else {
            [0.0; 2]
        };
        // The force of a contact that reaches beyond touch jumps, and is steep where the contact breaks.
        let w = window.half_width;
        let [mean_spring, mean_spring_before] = if !N::REACHES || overlap >= N::OVERLAP_WITHOUT_EVENTS * w {
            [spring, spring_before]
        } else {
            let mean = |overlap: f64| self.normal.mean_spring(&at(overlap - w), &at(overlap + w));
            [overlap, before].map(|overlap| window.share(overlap) * mean(overlap))
        };
        let floor = self.normal.floor();
        let force_before = (mean_spring_before + mean_before * (window.closing - gained)).max(floor);
        let change = half_lone * ((mean_spring_before - pull_before) - (mean_spring - pull))
            + half * (force_before - mean_spring_before);
        let closing = (window.closing + gained + change) / (1.0 + half * mean);
        let total = (mean_spring + mean * closing).max(floor);
        let mut force = PairForce::along(pair.normal, total - pull, mean_spring - pull);
        if T::SPIN {
            let whole = (spring + dashpot * closing).max(floor);
            // Resistance normals and rounding may give a new contact a positive overlap at the beginning of the step. A
            // contact without a spring is treated as new.
            let is_new = if N::REACHES {
                !memory.exists
            } else {
                before <= 0.0 || T::SPRING && before < window.moved && springs.spring == V::ZERO
            };
            let dashpot_at = |overlap: f64| self.normal.dashpot(&at(overlap));
            // The normal force at the beginning of the step, without its lower bound.
            let begins = spring_before + dashpot_at(before) * (window.closing - gained);
            let event = if is_new {
                (overlap > 0.0).then(|| (overlap / window.closing).min(pair.dt)).map(|ago| {
                    // As for the spring, without the velocity that the averaged force of this contact took before the
                    // contact opened.
                    let own = half * force_before;
                    let speed = window.closing + (gained + own) * (1.0 - 2.0 * ago / pair.dt) + 2.0 * own;
                    let dashpot = dashpot_at(0.0);
                    let load = dashpot * speed;
                    let force = if N::REACHES { load + self.normal.spring(&at(0.0)) } else { load }.max(floor);
                    LoadEvent { ago, force, dashpot, opens: true }
                })
            } else {
                let earlier = begins.max(floor);
                (overlap > 0.0 && earlier * whole < 0.0).then(|| LoadEvent {
                    ago: pair.dt * whole / (whole - earlier),
                    force: 0.0,
                    dashpot: 0.0,
                    opens: false,
                })
            };
            let gathering = if overlap > 0.0 { event.map_or(pair.dt, |event| event.ago) } else { 0.0 };
            let shares = [before, overlap].map(|overlap| window.share(overlap));
            // The load of a contact beyond touch does not fall to zero before it breaks.
            let unloading = if is_new || N::REACHES {
                None
            } else if overlap > 0.0 {
                Unloading::of([begins, spring + dashpot * closing], pair.dt, &window, overlap, pair.dt)
            } else {
                let parted = dashpot_at(0.0) * (window.closing + gained);
                Unloading::of([begins, parted], before / -window.closing, &window, overlap, pair.dt)
            };
            let averaged = [force_before, total];
            let mean_dashpots = [mean_before, mean];
            let fades = N::FADES;
            let load =
                NormalLoad { whole, averaged, shares, dashpot, mean_dashpots, fades, gathering, event, unloading };
            self.tangential.add_centred(pair, &load, &mut springs, &mut force.resistance);
            self.rolling.add_centred(pair, &load, &mut springs, &mut force.resistance);
            Self::remember(memory, &springs);
        }
        force
    }

    fn overlap_without_events(&self) -> f64 {
        N::OVERLAP_WITHOUT_EVENTS
    }

    fn elastic_energy(&self, pair: &Pair<V>, memory: &Memory) -> f64 {
        let springs = Self::springs(memory);
        self.normal.energy(pair) + self.tangential.energy(pair, &springs) + self.rolling.energy(pair, &springs)
    }

    fn on_contact_end(&self, pair: &Pair<V>, memory: &Memory) -> [f64; 2] {
        let springs = Self::springs(memory);
        [self.tangential.on_contact_end(pair, &springs), self.rolling.on_contact_end(pair, &springs)]
    }

    #[inline(always)]
    fn largest_range(&self, reduced_radius: f64) -> f64 {
        self.normal.range(reduced_radius)
    }

    fn lost_at_break(&self, pair: &Pair<V>) -> f64 {
        self.normal.lost_at_break(pair)
    }

    #[inline(always)]
    fn pull(&self, pair: &Pair<V>) -> f64 {
        self.normal.pull(pair, 1.0)
    }

    fn needs_mass_root(&self) -> bool {
        self.normal.needs_mass_root()
    }

    fn friction(&self, _: &Pair<V>) -> f64 {
        self.tangential.friction()
    }

    fn stiffness(&self, bounce: &Bounce) -> f64 {
        self.normal.stiffness(bounce)
    }

    fn damping(&self, bounce: &Bounce) -> f64 {
        self.normal.damping(bounce)
    }

    fn deepest(&self, bounce: &Bounce) -> f64 {
        self.normal.deepest(bounce)
    }

    fn contact_duration(&self, bounce: &Bounce) -> f64 {
        self.normal.contact_duration(bounce)
    }

    fn restitution(&self, bounce: &Bounce) -> f64 {
        self.normal.restitution(bounce)
    }

    fn modes(&self, bounce: &Bounce) -> [[f64; 2]; 4] {
        let normal = [self.normal.stiffness(bounce), self.normal.damping(bounce)];
        let tangential = self.tangential.mode(bounce, normal[1]);
        let [rolling, twisting] = self.rolling.modes(bounce, tangential[0]);
        [normal, tangential, rolling, twisting]
    }
}
