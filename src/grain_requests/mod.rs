//! Requests of behaviours to make, unmake and change grains: a grain breaks, two merge, one grows, is eaten, or comes into being.
//!
//! A system writes requests with the parameter [`GrainRequests`], in any phase. They are carried out together at the beginning of the next step,
//! before that step's grains enter, and every one is booked: number, mass, momentum and energy, by its *reason*, a word of the behaviour.
//!
//! ```
//! use siloflow::prelude::*;
//!
//! /// A grain on which more than 5 N act breaks into two halves of its area.
//! fn shatter(particles: Particles, mut requests: GrainRequests) {
//!     for row in particles.grains().filter(|&row| particles.force(row).length() > 5.0) {
//!         let radius = particles.radius(row) * 0.5f64.sqrt();
//!         let pieces = [-1.0, 1.0].map(|side| Piece::new(Plane::new(side * radius, 0.0), radius));
//!         requests.split(particles.id(row), pieces, "breakage");
//!     }
//! }
//! # fn build(app: &mut App) {
//! app.add_systems(Step, shatter.in_set(Phase::Control));
//! # }
//! ```
//!
//! | request | kept | what changes |
//! |---|---|---|
//! | [`split`](GrainRequests::split) | mass, momentum | the grain goes, pieces with new ids come. Area (volume) is that of the radii asked for |
//! | [`merge`](GrainRequests::merge) | mass, momentum, angular momentum | the first grain keeps its id and its contacts, and moves to the common centre of mass; the others go |
//! | [`resize`](GrainRequests::resize) | id, contacts, velocity | radius, mass |
//! | [`remove`](GrainRequests::remove) | | the grain goes |
//! | [`create`](GrainRequests::create) | | a grain comes |
//!
//! # Accounting
//!
//! A grain that goes counts as *removed* in the ledger, and not as lost. `summary.json` has `requests` with the figures of each reason: grains
//! made, removed and resized, the mass (kg), momentum (kg m/s) and energy (J) that they brought into the run, and the part of the energy that is
//! elastic: overlaps of new grains with each other and with their neighbours. The energy balance counts what goes as `removed` and
//! what comes as `released`, so it stays closed.
//!
//! # Order
//!
//! Requests are sorted by what they say, so the same bits come from any order of systems, any number of threads, and after a resume.
//! A grain is part of one request in a step: removal comes before merging, merging before splitting, splitting before resizing. Later requests
//! for it are *dropped* and counted, and so are all but removals for a grain that is already out or lost. A request that makes no sense (a radius below zero, a split
//! without pieces) stops the run.
//!
//! # Own components
//!
//! A grain that comes has the components of siloflow alone. The message [`GrainMade`] names it and the grain of which it is a piece, in time for systems
//! of [`Phase::Spawn`](siloflow_dem::step::Phase::Spawn).
//!
//! # Limits
//!
//! * The force of a new overlap acts from the first force pass on, so it misses half a step: a split or merger under load leaves an error of the energy balance of
//!   the order of the step. Growth leaves none.
//! * A piece has by default the velocity of its place in the turning grain and its spin. Momentum is kept exactly; the part of the angular momentum
//!   that the radii do not hold is not.
//! * A merged grain of several spheres keeps its shape and orientation.

mod accounts;
mod booking;
mod carry_out;
mod contacts;
mod plan;
mod plugin;
mod request;
mod resolve;

use bevy_ecs::prelude::*;
use bevy_ecs::system::SystemParam;
use serde::{Deserialize, Serialize};

pub use self::accounts::{ReasonFigures, RequestFigures, figures};
pub(crate) use self::contacts::find_neighbours;
pub use self::plugin::RequestsPlugin;
use self::request::Request;
pub use self::request::{GrainMade, NewGrain, Piece};
use siloflow_dem::particle::GrainId;
use siloflow_dem::space::{Plane, Space};

/// The requests that wait for the next step.
#[derive(Resource, Deserialize, Serialize)]
#[serde(bound = "")]
struct Waiting<V: Space>(Vec<Request<V>>);

impl<V: Space> Default for Waiting<V> {
    fn default() -> Self {
        Self(Vec::new())
    }
}

/// System parameter: asks to make, unmake and change grains. A reason is a word of letters from a to z, digits and `_`.
#[derive(SystemParam)]
pub struct GrainRequests<'w, V: Space = Plane> {
    waiting: ResMut<'w, Waiting<V>>,
}

impl<V: Space> GrainRequests<'_, V> {
    /// The grain breaks into pieces, of which there is at least one. They share its mass in proportion to their areas (in solid space, volumes).
    pub fn split(&mut self, grain: GrainId, pieces: impl IntoIterator<Item = Piece<V>>, reason: &str) {
        let pieces = pieces.into_iter().collect();
        self.waiting.0.push(Request::Split { grain, pieces, reason: reason.to_owned() });
    }

    /// `others` become part of `grain`, which gets this radius (m). By default areas (in solid space, volumes) add up.
    pub fn merge(
        &mut self,
        grain: GrainId,
        others: impl IntoIterator<Item = GrainId>,
        radius: Option<f64>,
        reason: &str,
    ) {
        let others = others.into_iter().collect();
        self.waiting.0.push(Request::Merge { grain, others, radius, reason: reason.to_owned() });
    }

    /// The grain gets another radius (m) and mass (kg).
    pub fn resize(&mut self, grain: GrainId, radius: f64, mass: f64, reason: &str) {
        self.waiting.0.push(Request::Resize { grain, radius, mass, reason: reason.to_owned() });
    }

    /// The grain goes.
    pub fn remove(&mut self, grain: GrainId, reason: &str) {
        self.waiting.0.push(Request::Remove { grain, reason: reason.to_owned() });
    }

    /// A grain comes into being.
    pub fn create(&mut self, grain: NewGrain<V>, reason: &str) {
        self.waiting.0.push(Request::Create { grain, reason: reason.to_owned() });
    }
}
