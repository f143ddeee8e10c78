//! A law put together from terms: a normal force, a tangential one, rolling resistance.
//!
//! The terms are types, so each combination that a scene can ask for is compiled into a kernel of its own, and a term
//! that is not asked for ([`NoFriction`](super::tangential::Smooth), [`NoRolling`](super::rolling::Free)) leaves nothing behind.

use crate::contact::centred::{CentredLaw, VelocityPrediction, Window};
use crate::contact::rolling::Rolling;
use crate::contact::tangential::{NormalLoad, Tangential};
use crate::contact::{Bounce, LawRequirements, Memory, Pair, PairForce, PairLaw};
use crate::space::Space;

/// A force along the normal: max(spring - c v_n, floor) n.
pub trait Normal: Copy + Send + Sync + 'static {
    /// See [`LawRequirements::RADII`].
    const RADII: bool = true;
    /// Where the overlap is at least this many times the half-width of a step, [`Normal::even_drag`] is its mean there.
    const EVEN: f64;

    /// The spring's force, N.
    fn spring<V: Space>(&self, pair: &Pair<V>) -> f64;

    /// The drag coefficient c, N s/m.
    fn drag<V: Space>(&self, pair: &Pair<V>) -> f64;

    /// The mean of that coefficient over the step around an overlap (m, or a gap), none where there is no contact, N s/m.
    fn mean_drag<V: Space>(&self, pair: &Pair<V>, window: &Window, overlap: f64) -> f64;

    /// That mean for an overlap far beyond the step, from the coefficient as it stands, N s/m.
    fn even_drag(&self, drag: f64, window: &Window, overlap: f64) -> f64;

    /// The lower bound of the whole force, N: 0, or minus infinity where it may pull.
    fn floor(&self) -> f64;

    /// See [`PairLaw::needs_mass_root`].
    fn needs_mass_root(&self) -> bool {
        false
    }

    /// Energy stored in the spring, J.
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

/// Normal force, friction and rolling resistance together.
#[derive(Clone, Copy, Debug)]
pub struct Composite<N, T, R> {
    /// Along the normal.
    pub normal: N,
    /// In the tangent plane.
    pub tangential: T,
    /// Against rolling.
    pub rolling: R,
}

impl<N: Normal, T: Tangential, R: Rolling> LawRequirements for Composite<N, T, R> {
    const SPIN: bool = T::SPIN;
    const RADII: bool = N::RADII || T::SPIN;
    const SPRING: bool = T::SPRING;
    const STIFFNESS: bool = T::STIFFNESS;
    const ROLLING: bool = R::ROLLING;
}

impl<V: Space, N: Normal, T: Tangential, R: Rolling> PairLaw<V> for Composite<N, T, R> {
    #[inline(always)]
    fn force(&self, pair: &Pair<V>, memory: &mut Memory<V>) -> PairForce<V> {
        let spring = self.normal.spring(pair);
        let drag = self.normal.drag(pair);
        let total = (spring - drag * pair.normal_velocity()).max(self.normal.floor());
        let mut force = PairForce::along(pair.normal, total, spring);
        self.tangential.add(pair, total, drag, memory, &mut force.turning);
        self.rolling.add(pair, total, memory, &mut force.turning);
        force
    }

    fn elastic_energy(&self, pair: &Pair<V>, memory: &Memory<V>) -> f64 {
        self.normal.energy(pair) + self.tangential.energy(memory) + self.rolling.energy(memory)
    }

    fn on_contact_end(&self, pair: &Pair<V>, memory: &Memory<V>) -> [f64; 2] {
        [self.tangential.on_contact_end(pair, memory), self.rolling.on_contact_end(pair, memory)]
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

    fn modes(&self, bounce: &Bounce) -> [[f64; 2]; 3] {
        let normal = [self.normal.stiffness(bounce), self.normal.damping(bounce)];
        [normal, self.tangential.mode(bounce, normal[1]), self.rolling.mode(bounce)]
    }
}

impl<V: Space, N: Normal, T: Tangential, R: Rolling> CentredLaw<V> for Composite<N, T, R> {
    #[inline(always)]
    fn centred(&self, pair: &Pair<V>, memory: &mut Memory<V>) -> PairForce<V> {
        let window = Window::of(pair);
        let (overlap, before) = (pair.overlap, pair.overlap - window.moved);
        let now = pair.at_overlap(overlap);
        let (spring, drag) = (self.normal.spring(&now), self.normal.drag(&now));
        let [mean, mean_before] = if overlap >= N::EVEN * window.half_width {
            [self.normal.even_drag(drag, &window, overlap); 2]
        } else {
            [overlap, before].map(|overlap| self.normal.mean_drag(pair, &window, overlap))
        };
        let VelocityPrediction { velocity: gained, inverse_masses, .. } = &pair.ahead;
        let gained = -gained.dot(pair.normal);
        // h/m of the pair, and of its lone grains.
        let [half, half_lone] =
            [inverse_masses[0] + inverse_masses[1], pair.ahead.lone_mobility()].map(|m| 0.5 * pair.dt * m);
        let spring_before = self.normal.spring(&pair.at_overlap(before));
        let floor = self.normal.floor();
        let force_before = (spring_before + mean_before * (window.closing - gained)).max(floor);
        let change = half_lone * (spring_before - spring) + half * (force_before - spring_before);
        let closing = (window.closing + gained + change) / (1.0 + half * mean);
        let total = (spring + mean * closing).max(floor);
        let mut force = PairForce::along(pair.normal, total, spring);
        if T::SPIN {
            let whole = (spring + drag * closing).max(floor);
            // Turning normals and rounding may put the beginning of the step into a contact that was not there: it holds nothing.
            let is_new = before <= 0.0 || T::SPRING && before < window.moved && memory.spring == V::ZERO;
            let event = if is_new {
                (overlap > 0.0).then(|| (overlap / window.closing).min(pair.dt)).map(|ago| {
                    // As the spring's: without what this contact's averaged force has taken before its time.
                    let own = half * force_before;
                    let speed = window.closing + (gained + own) * (1.0 - 2.0 * ago / pair.dt) + 2.0 * own;
                    (ago, (self.normal.drag(&pair.at_overlap(0.0)) * speed).max(floor), true)
                })
            } else {
                let earlier = (spring_before + drag * (window.closing - gained)).max(floor);
                (overlap > 0.0 && earlier * whole < 0.0).then(|| (pair.dt * whole / (whole - earlier), 0.0, false))
            };
            let gathering = if overlap > 0.0 { event.map_or(pair.dt, |(ago, ..)| ago) } else { 0.0 };
            let shares = [before, overlap].map(|overlap| window.share(overlap));
            let load = NormalLoad { whole, averaged: [force_before, total], shares, drag, gathering, event };
            self.tangential.add_centred(pair, &load, memory, &mut force.turning);
            self.rolling.add_centred(pair, &load, memory, &mut force.turning);
        }
        force
    }
}
