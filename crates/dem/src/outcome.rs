//! How a run ends: regularly, or with a failure and its reason. A system that ends the run records the end in
//! [`Outcome`], and the simulation stops after that step.

use bevy_ecs::prelude::*;
use serde::{Serialize, Serializer};
use thiserror::Error;

use crate::particle::GrainId;

/// Why a run ended.
#[derive(Clone, Debug, PartialEq)]
pub enum End {
    /// All grains have been released, and none is inside.
    Empty,
    /// The bed came to rest, and the scene requests nothing after that.
    AtRest,
    /// The door is open, and no grain has left for a time.
    FlowEnded {
        /// The scene's `still`, s.
        still_s: f64,
    },
    /// The door is open, no grain has left for a time, and grains are above the outlet.
    Clogged {
        /// The scene's `still`, s.
        still_s: f64,
        /// Number of grains above the outlet.
        above: u32,
        /// Number of grains that have left since the door began to open.
        avalanche: u32,
    },
    /// A number of grains have left.
    OutReached {
        /// The number that the scene asked for.
        count: u32,
    },
    /// Simulated time reached the scene's `until`.
    TimeReached,
    /// The caller asked for the end, for example because the process received a signal.
    Interrupted,
    /// The run failed.
    Failed(Failure),
}

/// The reason why a run failed.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum Failure {
    /// A number is infinite or NaN.
    #[error("step {step}: the {quantity} of {grain} is not finite; {cause}")]
    NotFinite {
        /// The step at the end of which it was found.
        step: u64,
        /// The particle.
        grain: GrainId,
        /// The quantity that is not finite.
        quantity: &'static str,
        /// The cause, and a remedy.
        cause: String,
    },
    /// Energy grew without a source.
    #[error(
        "step {step}: the energy grew by {created_j:.3e} J without a source, {:.0} % of the {put_in_j:.3e} J put in; \
         the fastest is {grain} at {speed_m_s:.3e} m/s, w0 dt = {stiffness:.2} for it in a single contact (`check` prints \
         the limit): lower `step`, or if a behaviour changes velocities without a force, set `watchdog.energy`",
        100.0 * created_j / put_in_j
    )]
    EnergyGrew {
        /// The step at the end of which it was found.
        step: u64,
        /// The fastest grain.
        grain: GrainId,
        /// Its speed, m/s.
        speed_m_s: f64,
        /// The energy gained, J.
        created_j: f64,
        /// The energy put in, J.
        put_in_j: f64,
        /// w0 dt of one contact of that grain with a wall.
        stiffness: f64,
    },
    /// Two particles overlap so far that the contact law does not hold.
    #[error(
        "step {step}: {grain} and {partner} overlap by {ratio:.2} of the smaller radius, more than `watchdog.overlap`, \
         {limit}: the contact law does not hold there; {remedy}, or set `watchdog.overlap`"
    )]
    TooDeep {
        /// The step.
        step: u64,
        /// The grain.
        grain: GrainId,
        /// The particle or wall that it overlaps with.
        partner: String,
        /// Overlap divided by the smaller radius.
        ratio: f64,
        /// The largest ratio that the scene allows.
        limit: f64,
        /// The remedy.
        remedy: &'static str,
    },
    /// A grain was lost and the scene says `on_loss: Stop`.
    #[error("step {step}: {grain} was lost at {position} m: {way}; `on_loss: Continue` continues the run")]
    GrainLost {
        /// The step.
        step: u64,
        /// The grain.
        grain: GrainId,
        /// Its position, m.
        position: String,
        /// The way by which it left.
        way: String,
    },
    /// The release point stayed occupied.
    #[error(
        "step {step}: the release of {grain} has been blocked for {waited_s:.3} s by {blocker}; the silo may be full: \
         release fewer grains, move the release point up, or raise `spawner.release_timeout`"
    )]
    ReleaseBlocked {
        /// The step in which the time limit was exceeded.
        step: u64,
        /// The grain to be released.
        grain: GrainId,
        /// Duration of the block, s.
        waited_s: f64,
        /// The particle or wall that blocks the release point.
        blocker: String,
    },
    /// A feed found no place for a grain.
    #[error(
        "step {step}: `feed[{feed}]` found no free place for {grain} in {waited_s:.3} s; its region may be full: lower \
         `feed[{feed}].rate` or `total`, enlarge or raise the region, or raise `feed[{feed}].tries` or `timeout`"
    )]
    FeedBlocked {
        /// The step in which the time limit was exceeded.
        step: u64,
        /// Number of the feed.
        feed: usize,
        /// The grain that waits.
        grain: GrainId,
        /// Its waiting time, s.
        waited_s: f64,
    },
    /// A particle is too large for the cells.
    #[error(
        "particles touch at up to {needed} m but cells have side {size} m, so contacts would be missed: the search \
         covers adjacent cells only; raise `neighbours.size`"
    )]
    CellsTooSmall {
        /// Side of a cell, m.
        size: f64,
        /// Largest contact distance, m.
        needed: f64,
    },
    /// Particles of a lattice gas are missing, or there are too many.
    #[error("step {step}: the ledger has {expected} particles inside, but {counted} were counted")]
    Miscounted {
        /// The step at the end of which they were counted.
        step: u64,
        /// The number according to the ledger.
        expected: u64,
        /// The number counted.
        counted: u64,
    },
    /// A file could not be written.
    #[error("could not write {path}: {reason}")]
    Output {
        /// The path.
        path: String,
        /// The reason that the operating system gave.
        reason: String,
    },
    /// A behaviour stopped the run.
    #[error("{0}")]
    Behaviour(String),
}

/// The end of a run, once there is one. The first end that a system records is kept, except that a failure replaces a
/// regular end.
#[derive(Resource, Default, Debug)]
pub struct Outcome(Option<End>);

impl Outcome {
    /// The end of the run, if it has ended.
    #[must_use]
    pub fn end(&self) -> Option<&End> {
        self.0.as_ref()
    }

    /// Ends the run regularly.
    pub fn finish(&mut self, end: End) {
        self.0.get_or_insert(end);
    }

    /// Ends the run with a failure.
    pub fn fail(&mut self, failure: Failure) {
        if !matches!(self.0, Some(End::Failed(_))) {
            self.0 = Some(End::Failed(failure));
        }
    }
}

impl End {
    /// Whether the run ended regularly: it did not fail and was not interrupted.
    #[must_use]
    pub fn is_regular(&self) -> bool {
        !matches!(self, Self::Interrupted | Self::Failed(_))
    }

    /// The name of this end in `summary.json`.
    #[must_use]
    pub fn word(&self) -> &'static str {
        match self {
            Self::Empty => "empty",
            Self::AtRest => "at_rest",
            Self::FlowEnded { .. } => "end_of_flow",
            Self::Clogged { .. } => "clogged",
            Self::OutReached { .. } => "out_reached",
            Self::TimeReached => "time_reached",
            Self::Interrupted => "interrupted",
            Self::Failed(_) => "failed",
        }
    }
}

impl Serialize for End {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.word())
    }
}
