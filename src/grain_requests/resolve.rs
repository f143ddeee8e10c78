//! Turns requests into what will happen to which particle: checks them, computes the pieces of a split and the result of a merger, and decides
//! which requests are dropped.
//!
//! Pieces of masses m_i at p_i from the centre of a grain of velocity v and spin w have the velocities v + w x (p_i - p), where p is the centre of
//! mass of the pieces. A merged grain has M = sum m_i, X = sum m_i x_i / M, V = sum m_i v_i / M, and the spin of the angular momentum
//! sum (L_i + m_i (x_i - X) x (v_i - V)).

use bevy_ecs::prelude::*;
use rustc_hash::{FxHashMap, FxHashSet};

use crate::grain_requests::plan::{Change, Coming, Leaving, Moved, Plan};
use crate::grain_requests::request::{NewGrain, Piece, Request};
use crate::grains::mass::MassLaw;
use crate::ledger::Ledger;
use siloflow_dem::math;
use siloflow_dem::particle::GrainId;
use siloflow_dem::space::{Linear, Space};
use siloflow_dem::store::ParticleStore;

/// The settings of the scene that requests need.
#[derive(Resource)]
pub(super) struct Rules {
    /// The scene's `mass`.
    pub(super) mass: Option<MassLaw>,
}

/// Resolves requests against the present state of the grains.
pub(super) struct Resolver<'a, V: Space> {
    store: &'a ParticleStore<V>,
    ledger: &'a Ledger,
    mass: Option<MassLaw>,
    rows: FxHashMap<GrainId, usize>,
    /// Grains that a request has taken.
    taken: FxHashSet<GrainId>,
    plan: Plan<V>,
}

fn positive(what: &str, value: f64) -> Result<f64, String> {
    if value.is_finite() && value > 0.0 {
        Ok(value)
    } else {
        Err(format!("a {what} of {value}, which is not above zero"))
    }
}

fn finite<T: Linear>(what: &str, vector: T) -> Result<T, String> {
    if vector.is_finite() { Ok(vector) } else { Err(format!("a {what} that is not finite")) }
}

/// Area (volume) of a disc (sphere) up to a factor.
fn size<V: Space>(radius: f64) -> f64 {
    if V::COUNT == 2 { radius * radius } else { radius * radius * radius }
}

impl<'a, V: Space> Resolver<'a, V> {
    pub(super) fn new(store: &'a ParticleStore<V>, ledger: &'a Ledger, mass: Option<MassLaw>) -> Self {
        let is_grain = |&row: &usize| store.is_whole(row) && store.is_present(row) && !store.id[row].is_wall();
        let rows = (0..store.len()).filter(is_grain).map(|row| (store.id[row], row)).collect();
        let plan = Plan { leaving: Vec::new(), changes: Vec::new(), coming: Vec::new(), dropped: Vec::new() };
        Self { store, ledger, mass, rows, taken: FxHashSet::default(), plan }
    }

    /// Resolves sorted requests.
    ///
    /// # Errors
    /// If a request makes no sense: the reason, and what is wrong, in words.
    pub(super) fn resolve(mut self, requests: Vec<Request<V>>) -> Result<Plan<V>, String> {
        for request in requests {
            let reason = request.reason().to_owned();
            let is_letter = |byte: u8| byte.is_ascii_lowercase() || byte.is_ascii_digit() || byte == b'_';
            if reason.is_empty() || reason.len() > 64 || !reason.bytes().all(is_letter) {
                return Err(format!(
                    "`{reason}` is no reason: a reason has 1 to 64 letters from a to z, digits and `_`"
                ));
            }
            self.one(request).map_err(|problem| format!("the request with the reason `{reason}` has {problem}"))?;
        }
        Ok(self.plan)
    }

    fn one(&mut self, request: Request<V>) -> Result<(), String> {
        match request {
            Request::Remove { grain, reason } => match self.free_row(grain)? {
                Some(row) => self.leave(row, reason),
                None => self.plan.dropped.push(reason),
            },
            Request::Merge { grain, others, radius, reason } => self.merge(grain, &others, radius, reason)?,
            Request::Split { grain, pieces, reason } => self.split(grain, &pieces, reason)?,
            Request::Resize { grain, radius, mass, reason } => {
                let radius = positive("radius", radius)?;
                let mass = positive("mass", mass)?;
                match self.inside_row(grain)? {
                    Some(row) => self.change(row, reason, radius, mass, None),
                    None => self.plan.dropped.push(reason),
                }
            }
            Request::Create { grain, reason } => {
                let mass = match (grain.mass, self.mass) {
                    (Some(mass), _) => mass,
                    (None, Some(law)) => law.of(grain.radius),
                    (None, None) => return Err("no mass, and the scene has no `mass`".to_owned()),
                };
                self.come(grain, mass, None, reason)?;
            }
        }
        Ok(())
    }

    /// The row of a grain that no request has taken; `None` if there is none.
    fn free_row(&self, grain: GrainId) -> Result<Option<usize>, String> {
        if grain.is_wall() {
            return Err(format!("{grain}, which is part of a wall"));
        }
        Ok(self.rows.get(&grain).copied().filter(|_| !self.taken.contains(&grain)))
    }

    /// As [`Self::free_row`], of a grain that is neither out nor lost.
    fn inside_row(&self, grain: GrainId) -> Result<Option<usize>, String> {
        Ok(self.free_row(grain)?.filter(|_| !self.ledger.is_gone(grain)))
    }

    fn leave(&mut self, row: usize, reason: String) {
        let id = self.store.id[row];
        self.taken.insert(id);
        let is_gone = self.ledger.is_gone(id);
        self.plan.leaving.push(Leaving { row, entity: self.store.entity[row], id, reason, is_gone });
    }

    fn change(&mut self, row: usize, reason: String, radius: f64, mass: f64, moved: Option<Moved<V>>) {
        let id = self.store.id[row];
        self.taken.insert(id);
        self.plan.changes.push(Change { row, entity: self.store.entity[row], id, reason, radius, mass, moved });
    }

    fn come(&mut self, grain: NewGrain<V>, mass: f64, parent: Option<GrainId>, reason: String) -> Result<(), String> {
        positive("radius", grain.radius)?;
        positive("mass", mass)?;
        finite("position", grain.position)?;
        finite("velocity", grain.velocity)?;
        finite("spin", grain.spin)?;
        if let Some((shape, _)) = grain.shape.filter(|(shape, _)| shape.index() >= self.store.bodies.shapes.len()) {
            return Err(format!("shape {}, but the scene has {}", shape.0, self.store.bodies.shapes.len()));
        }
        self.plan.coming.push(Coming { grain, mass, parent, reason });
        Ok(())
    }

    fn split(&mut self, id: GrainId, pieces: &[Piece<V>], reason: String) -> Result<(), String> {
        if pieces.is_empty() {
            return Err("no pieces".to_owned());
        }
        let Some(row) = self.inside_row(id)? else {
            self.plan.dropped.push(reason);
            return Ok(());
        };
        let store = self.store;
        let whole: f64 = pieces.iter().map(|piece| size::<V>(piece.radius)).sum();
        let mass = |piece: &Piece<V>| store.mass[row] * (size::<V>(piece.radius) / whole);
        let middle = pieces.iter().fold(V::ZERO, |sum, piece| sum + piece.place * (size::<V>(piece.radius) / whole));
        let spin = store.spin(row);
        for piece in pieces {
            positive("radius", piece.radius)?;
            let position = store.body[row].position + piece.place;
            let grain = NewGrain {
                position: store.periodic.map_or(position, |periodic| periodic.wrapped(position)),
                velocity: piece
                    .velocity
                    .unwrap_or_else(|| store.body[row].velocity + (piece.place - middle).turned_by(spin)),
                radius: piece.radius,
                mass: None,
                spin: piece.spin.unwrap_or(spin),
                species: piece.species.unwrap_or(store.species[row]),
                shape: piece.shape,
            };
            self.come(grain, mass(piece), Some(id), reason.clone())?;
        }
        self.leave(row, reason);
        Ok(())
    }

    fn merge(&mut self, id: GrainId, others: &[GrainId], radius: Option<f64>, reason: String) -> Result<(), String> {
        let mut ids = vec![id];
        ids.extend(others);
        ids.sort_unstable();
        if others.is_empty() || ids.windows(2).any(|pair| pair[0] == pair[1]) {
            return Err("not two different grains to merge".to_owned());
        }
        let mut rows = Vec::new();
        for &grain in [id].iter().chain(others) {
            let Some(row) = self.inside_row(grain)? else {
                self.plan.dropped.push(reason);
                return Ok(());
            };
            rows.push(row);
        }
        let store = self.store;
        let first = rows[0];
        let all = || rows.iter().copied();
        let mass: f64 = all().map(|row| store.mass[row]).sum();
        let from_first = |row: usize| store.separation(store.body[row].position, store.body[first].position);
        let middle = all().fold(V::ZERO, |sum, row| sum + from_first(row) * (store.mass[row] / mass));
        let velocity = all().fold(V::ZERO, |sum, row| sum + store.body[row].velocity * (store.mass[row] / mass));
        let angular = all().fold(V::Spin::ZERO, |sum, row| {
            let way = from_first(row) - middle;
            sum + store.angular_momentum(row) + way.cross(store.body[row].velocity - velocity) * store.mass[row]
        });
        let default = || {
            let whole: f64 = all().map(|row| size::<V>(store.body[row].radius)).sum();
            if V::COUNT == 2 { whole.sqrt() } else { math::cbrt(whole) }
        };
        let radius = positive("radius", radius.unwrap_or_else(default))?;
        let position = store.body[first].position + middle;
        let moved = Moved {
            position: store.periodic.map_or(position, |periodic| periodic.wrapped(position)),
            velocity,
            spin: store.spin_gain(first, angular) * inertia_ratio(store, first, radius, mass).recip(),
        };
        self.change(first, reason.clone(), radius, mass, Some(moved));
        for &row in &rows[1..] {
            self.leave(row, reason.clone());
        }
        Ok(())
    }
}

/// The moment of inertia of the grain of row `row` with another radius (m) and mass (kg) over its present one.
pub(super) fn inertia_ratio<V: Space>(store: &ParticleStore<V>, row: usize, radius: f64, mass: f64) -> f64 {
    mass * radius * radius / (store.mass[row] * store.body[row].radius * store.body[row].radius)
}
