//! The normal load of a contact near an event, as input of its friction and rolling resistance.

use crate::contact::centred::slider::{Event, Release, TangentialMotion, TangentialStep};
use crate::contact::centred::window::Window;
use crate::contact::pair::Pair;
use crate::space::Space;

/// Normal load: the normal force of a centred contact, as input of its tangential terms.
#[derive(Clone, Copy, Debug)]
pub struct NormalLoad {
    /// The normal force at the evaluation, N.
    pub whole: f64,
    /// The normal forces averaged over the steps centred on the beginning and on the end, N.
    pub averaged: [f64; 2],
    /// The fractions of these two steps in which the contact exists.
    pub shares: [f64; 2],
    /// The normal dashpot coefficient c at the evaluation, N s/m.
    pub dashpot: f64,
    /// The means of c over these two steps, N s/m.
    pub mean_dashpots: [f64; 2],
    /// Whether c goes to zero with the overlap.
    pub fades: bool,
    /// Time during which springs accumulate, s: the whole step, or from the event to its end, or 0 across a gap.
    pub gathering: f64,
    /// The event of this step at which the contact opened or the normal force changed sign.
    pub event: Option<LoadEvent>,
    /// The end of the normal force in the step centred on the end.
    pub unloading: Option<Unloading>,
}

/// A moment within a step at which a contact opens or its normal force changes its sign.
#[derive(Clone, Copy, Debug)]
pub struct LoadEvent {
    /// Time from the event to the end of the step, s.
    pub ago: f64,
    /// Normal force just after the event, N.
    pub force: f64,
    /// The force just after the event per closing speed, N s/m.
    pub dashpot: f64,
    /// Whether the contact opens.
    pub opens: bool,
}

/// The end of a falling normal force within the step centred on the evaluation.
#[derive(Clone, Copy, Debug)]
pub struct Unloading {
    /// Share of the centred step before this moment.
    share: f64,
    /// Time from the middle of that share to the evaluation, s.
    ago: f64,
    /// Overlap in the middle of that share, m.
    overlap: f64,
    /// Normal force averaged over the centred step, N.
    averaged: f64,
}

impl Unloading {
    /// Returns the end of a normal force that falls from the first of `forces` to the second (N) within `span` (s) from the
    /// beginning of the step, if it falls to zero before the end of the centred step. `overlap` (m) is the overlap at
    /// the evaluation.
    #[must_use]
    pub fn of([before, after]: [f64; 2], span: f64, window: &Window, overlap: f64, dt: f64) -> Option<Self> {
        if before <= 0.0 || after >= before {
            return None;
        }
        // Time from the beginning of the centred step, half a step after that of the step.
        let lasts = (span * before / (before - after) - 0.5 * dt).max(0.0);
        let ago = 0.5 * (dt - lasts);
        (lasts < dt).then(|| Self {
            share: lasts / dt,
            ago,
            overlap: overlap - window.closing * ago,
            averaged: 0.5 * (before - after) / span * lasts * (lasts / dt),
        })
    }

    /// Returns the release of a slider. `friction` is the coefficient of friction; `modulus` returns stiffness (N/m) and dashpot
    /// coefficient (N s/m) at an overlap.
    #[inline(always)]
    #[must_use]
    pub fn release<V: Space>(
        &self,
        pair: &Pair<V>,
        friction: f64,
        modulus: impl Fn(&Pair<V>) -> (f64, f64),
    ) -> Release {
        let Self { share, ago, overlap, averaged } = *self;
        Release { share, ago, modulus: modulus(&pair.at_overlap(overlap)).into(), cap: friction * averaged }
    }
}

impl NormalLoad {
    /// Returns the tangential step for a motion with coefficient of friction `friction`. The dashpot coefficients are set to zero.
    #[inline(always)]
    #[must_use]
    pub fn sweep<V: Space>(
        &self,
        motion: TangentialMotion<V>,
        friction: f64,
        [dt, springs_ahead]: [f64; 2],
    ) -> TangentialStep<V> {
        TangentialStep {
            motion,
            dt,
            springs_ahead,
            event: self.event.map(|LoadEvent { ago, force, dashpot, opens }| Event {
                ago,
                cap: friction * force.abs(),
                cap_per_speed: friction * dashpot,
                opens,
            }),
            gathering: self.gathering,
            shares: self.shares,
            spring_shares: self.shares,
            mean_dashpots: [0.0; 2],
            averaged_caps: self.averaged.map(|force| friction * force.abs()),
            averaged_loads: self.averaged,
            normal_fades: self.fades,
            pulled: V::ZERO,
            release: None,
        }
    }

    /// Returns the means of the dashpot coefficient of friction over the two steps, N s/m. `mean` returns it from the fraction of a
    /// step in contact and the mean of the normal dashpot coefficient, N s/m.
    #[inline(always)]
    #[must_use]
    pub fn mean_dashpots(&self, mean: impl Fn(f64, f64) -> f64) -> [f64; 2] {
        [0, 1].map(|step| mean(self.shares[step], self.mean_dashpots[step]))
    }
}
