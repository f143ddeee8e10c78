//! Requests as values, their order, and the message that tells who has come.

use bevy_ecs::prelude::*;
use serde::{Deserialize, Serialize};

use siloflow_dem::bodies::{Orientation, Shape};
use siloflow_dem::particle::{GrainId, Species};
use siloflow_dem::space::{Linear, Plane, Space};

/// A piece of a grain that breaks.
#[derive(Clone, Copy, Debug, Deserialize, Serialize)]
#[serde(bound = "")]
pub struct Piece<V: Space = Plane> {
    /// Its centre, from that of the grain, m.
    pub place: V,
    /// Its radius, m; of a shaped piece that of the sphere (disc) of equal volume (area).
    pub radius: f64,
    /// Its velocity, m/s. Default: that of its place in the turning grain, less what would change the momentum.
    pub velocity: Option<V>,
    /// Its spin, rad/s. Default: that of the grain.
    pub spin: Option<V::Spin>,
    /// Its species. Default: that of the grain.
    pub species: Option<Species>,
    /// Its shape and orientation. Default: a sphere (disc).
    pub shape: Option<(Shape, Orientation<V>)>,
}

impl<V: Space> Piece<V> {
    /// A round piece with the motion and the species of the grain.
    #[must_use]
    pub fn new(place: V, radius: f64) -> Self {
        Self { place, radius, velocity: None, spin: None, species: None, shape: None }
    }
}

/// A grain that comes into being.
#[derive(Clone, Copy, Debug, Deserialize, Serialize)]
#[serde(bound = "")]
pub struct NewGrain<V: Space = Plane> {
    /// Its centre, m.
    pub position: V,
    /// Its velocity, m/s.
    pub velocity: V,
    /// Its radius, m; of a shaped grain that of the sphere (disc) of equal volume (area).
    pub radius: f64,
    /// Its mass, kg. Default: by the scene's `mass`.
    pub mass: Option<f64>,
    /// Its spin, rad/s.
    pub spin: V::Spin,
    /// Its species.
    pub species: Species,
    /// Its shape and orientation; `None` for a sphere (disc).
    pub shape: Option<(Shape, Orientation<V>)>,
}

impl<V: Space> NewGrain<V> {
    /// A round grain of species 0 at rest.
    #[must_use]
    pub fn new(position: V, radius: f64) -> Self {
        Self { position, velocity: V::ZERO, radius, mass: None, spin: V::Spin::ZERO, species: Species(0), shape: None }
    }
}

/// A request.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[serde(bound = "")]
pub(super) enum Request<V: Space> {
    Remove { grain: GrainId, reason: String },
    Merge { grain: GrainId, others: Vec<GrainId>, radius: Option<f64>, reason: String },
    Split { grain: GrainId, pieces: Vec<Piece<V>>, reason: String },
    Resize { grain: GrainId, radius: f64, mass: f64, reason: String },
    Create { grain: NewGrain<V>, reason: String },
}

/// The sort key of a request: its kind, the grain that it names, its reason, and all its numbers.
type Key = (u8, Option<GrainId>, String, Vec<u64>);

impl<V: Space> Request<V> {
    /// Why the grains change.
    pub(super) fn reason(&self) -> &str {
        match self {
            Self::Remove { reason, .. }
            | Self::Merge { reason, .. }
            | Self::Split { reason, .. }
            | Self::Resize { reason, .. }
            | Self::Create { reason, .. } => reason,
        }
    }

    /// Two requests with equal keys are the same request.
    fn key(&self) -> Key {
        let reason = self.reason().to_owned();
        match self {
            Self::Remove { grain, .. } => (0, Some(*grain), reason, Vec::new()),
            Self::Merge { grain, others, radius, .. } => {
                let others = others.iter().map(|other| u64::from(other.number()));
                (1, Some(*grain), reason, others.chain(radius.map(f64::to_bits)).collect())
            }
            Self::Split { grain, pieces, .. } => {
                (2, Some(*grain), reason, pieces.iter().flat_map(Piece::numbers).collect())
            }
            Self::Resize { grain, radius, mass, .. } => {
                (3, Some(*grain), reason, vec![radius.to_bits(), mass.to_bits()])
            }
            Self::Create { grain, .. } => (4, None, reason, grain.numbers()),
        }
    }
}

/// The bits of a vector.
fn bits<T: Linear>(vector: T) -> impl Iterator<Item = u64> {
    (0..T::COUNT).map(move |axis| vector.component(axis).to_bits())
}

/// The bits of an optional shape.
fn of_shape<V: Space>(shape: Option<(Shape, Orientation<V>)>) -> impl Iterator<Item = u64> {
    use siloflow_dem::space::Rotor;
    shape.into_iter().flat_map(|(shape, Orientation(rotor))| {
        let turn = rotor.to_quaternion();
        [u64::from(shape.0)].into_iter().chain([turn.w, turn.x, turn.y, turn.z].map(f64::to_bits))
    })
}

impl<V: Space> Piece<V> {
    fn numbers(&self) -> Vec<u64> {
        let mut all: Vec<_> = bits(self.place).chain([self.radius.to_bits()]).collect();
        all.extend(self.velocity.into_iter().flat_map(bits));
        all.extend(self.spin.into_iter().flat_map(bits));
        all.extend(self.species.map(|species| u64::from(species.0)));
        all.extend(of_shape(self.shape));
        all
    }
}

impl<V: Space> NewGrain<V> {
    fn numbers(&self) -> Vec<u64> {
        let mut all: Vec<_> = bits(self.position).chain(bits(self.velocity)).chain(bits(self.spin)).collect();
        all.extend([self.radius.to_bits(), u64::from(self.species.0)]);
        all.extend(self.mass.map(f64::to_bits));
        all.extend(of_shape(self.shape));
        all
    }
}

/// Sorts requests into the order in which they are carried out.
pub(super) fn sort<V: Space>(requests: &mut [Request<V>]) {
    requests.sort_by_cached_key(Request::key);
}

/// A grain was made by a request. It has its row when systems of [`Phase::Spawn`](siloflow_dem::step::Phase::Spawn) run: a behaviour gives it its own components there.
#[derive(Message, Clone, Debug)]
pub struct GrainMade {
    /// The grain.
    pub id: GrainId,
    /// The grain of which it is a piece.
    pub parent: Option<GrainId>,
    /// The reason of the request.
    pub reason: String,
}
