//! Contact geometry between two particles, and between a particle and a wall surface.
//!
//! Two particles touch when |x_ij| < R_i + R_j. Overlap R_i + R_j - |x_ij|, normal x_ij/|x_ij|, relative velocity
//! v_i - v_j, reduced mass 1/(1/m_i + 1/m_j).
//!
//! For a wall, x_j is its nearest point, R_j is 0 in the overlap, and 1/m_j = 0. Its curvature is the mean curvature of
//! the surface ([`Nearest`]). A half-space has its own normal, and its distance is negative inside.
//!
//! One inverse root gives all lengths (`ContactLine`), here and in the lanes of a batch (`batch/bodies.rs`). So surveys
//! of contacts and the force pass agree to the last bit.

use crate::contact::facets::{FacetTouch, nearest_facets};
use crate::contact::inverse_root::inverse_root;
use crate::contact::pair::{Pair, VelocityPrediction};
use crate::neighbours::list::Candidate;
use crate::particle::GrainId;
use crate::space::{COINCIDENT, Linear, PARTED, Space};
use crate::store::{Body, ParticleStore};
use crate::walls::seams::{Seams, Touch};
use crate::walls::shapes::{Nearest, Shape as _};
use crate::walls::surface::Surface;
use crate::walls::surface_wall::SurfaceWall;

/// The contact quantities that follow from the separation and the masses alone.
pub(super) struct ContactLine<V> {
    /// Unit vector from j to i.
    pub normal: V,
    /// Distance between the centres, m; for a wall the distance to the wall.
    pub distance: f64,
    /// Reduced mass, kg.
    pub reduced_mass: f64,
}

impl<V: Space> ContactLine<V> {
    /// Computes the line of two particles `separation` (m) apart, at least sqrt([`COINCIDENT`]) long. `mobility` is the
    /// sum of their inverse masses, 1/kg. One inverse root replaces a root and two divisions.
    #[inline(always)]
    pub(super) fn new(separation: V, mobility: f64) -> Self {
        let squared = separation.length_squared();
        // One root gives 1/d and 1/mobility.
        let inverse_product = inverse_root(squared * (mobility * mobility));
        let inverse_distance = inverse_product * mobility;
        let distance = squared * inverse_distance;
        Self { normal: separation * inverse_distance, distance, reduced_mass: inverse_product * distance }
    }
}

/// A particle and the nearest point of a wall.
pub(crate) struct WallLine<V> {
    line: ContactLine<V>,
    /// Mean curvature at the nearest point, 1/m.
    curvature: f64,
    /// Whether the nearest point lies on an edge.
    at_edge: bool,
}

impl<V: Space> WallLine<V> {
    /// The walls of most scenes are evaluated in line, because a result that passes through memory makes the comparison of distances wait.
    #[inline(always)]
    fn new(body: &Body<V>, wall: &SurfaceWall<V>) -> Self {
        match &wall.surface {
            Surface::HalfPlane(shape) => Self::of(body, shape.nearest(body.position)),
            Surface::Segment(shape) => Self::of(body, shape.nearest(body.position)),
            Surface::Panel(shape) => Self::of(body, shape.nearest(body.position)),
            other => Self::of(body, nearest_in_memory(other, body.position)),
        }
    }

    #[inline(always)]
    fn of(body: &Body<V>, nearest: Nearest<V>) -> Self {
        match nearest {
            Nearest::Point { away, curvature, at_edge } => {
                Self { line: ContactLine::new(away, body.inverse_mass), curvature, at_edge }
            }
            Nearest::OfSolid { normal, distance, curvature } => {
                let line = ContactLine { normal, distance, reduced_mass: 1.0 / body.inverse_mass };
                Self { line, curvature, at_edge: false }
            }
        }
    }
}

/// Returns the position of a surface relative to `x`, m. Not inlined, so that the result of a call does not share memory with those in line.
#[inline(never)]
fn nearest_in_memory<V: Space>(surface: &Surface<V>, x: V) -> Nearest<V> {
    surface.nearest(x)
}

/// Returns the contact of the particles in slots `i` and `j` if they overlap or are within the range of a contact beyond touch,
/// and at least one can move. `mass_root` asks for the root of the reduced mass.
// Always inlined: a `Pair` is large, and returning it through memory would make each contact stall on its own stores.
#[inline(always)]
#[must_use]
pub fn touching<V: Space>(store: &ParticleStore<V>, i: usize, j: usize, mass_root: bool) -> Option<Pair<V>> {
    let a = &store.body[i];
    let b = &store.body[j];
    let separation = store.separation(a.position, b.position);
    let reach = a.radius + b.radius + store.prediction.range;
    let squared = separation.length_squared();
    // Written so that a NaN does not touch.
    if squared < reach * reach && !(store.is_fixed(i) && store.is_fixed(j)) {
        Some(pair_at(store, [i, j], separation, mass_root, 0.0))
    } else {
        None
    }
}

/// Returns the geometry of two particles whose contact has ended in this step.
pub(super) fn ended_pair<V: Space>(store: &ParticleStore<V>, contact: Candidate, dt: f64) -> Pair<V> {
    let [i, j] = contact.slots();
    let separation = store.separation(store.body[i].position, store.body[j].position);
    let gathered = store.prediction.springs_exact.then(|| store.gathered(contact));
    Pair { gathered, ..pair_at(store, [i, j], separation, true, dt) }
}

/// Returns the geometry of two particles that are `separation` (m) apart.
// Other crates compile it for their surveys. There `slots.map` would be a call, which moves each pair through memory.
#[inline(always)]
fn pair_at<V: Space>(store: &ParticleStore<V>, [i, j]: [usize; 2], separation: V, mass_root: bool, dt: f64) -> Pair<V> {
    let a = &store.body[i];
    let b = &store.body[j];
    let separation = if separation.length_squared() < COINCIDENT {
        coincident::<V>(store.id[i], store.id[j]) * PARTED
    } else {
        separation
    };
    let ContactLine { normal, distance, reduced_mass } = ContactLine::new(separation, a.inverse_mass + b.inverse_mass);
    Pair {
        normal,
        overlap: a.radius + b.radius - distance,
        relative_velocity: a.velocity - b.velocity,
        reduced_mass,
        mass_root: if mass_root { reduced_mass.sqrt() } else { 0.0 },
        radii: [a.radius, b.radius],
        inverse_reach: 1.0 / (a.radius + b.radius),
        spins: [store.spin(i), store.spin(j)],
        species: [store.species[i], store.species[j]],
        dt,
        springs_ahead: store.springs_ahead(),
        gathered: None,
        ahead: VelocityPrediction::default(),
    }
}

/// Returns the speed along the normal at which the free particle in slot `i` and a wall approach or part, m/s. Not inlined:
/// grains that touch the wall do not need it, and the loop over the walls of a grain is shorter without it.
#[inline(never)]
fn closing_speed<V: Space>(store: &ParticleStore<V>, i: usize, wall: &SurfaceWall<V>, normal: V, distance: f64) -> f64 {
    let of_wall = wall.velocity_at(|| store.body[i].position - normal * distance);
    (store.middle_velocity(i) - of_wall).dot(normal).abs()
}

/// Returns the nearest point of a wall to the free particle in slot `i`, if they touch within the time `ahead`, s, or are within
/// the range of a contact beyond touch.
#[inline(always)]
fn beside_wall<V: Space>(store: &ParticleStore<V>, i: usize, wall: &SurfaceWall<V>, ahead: f64) -> Option<WallLine<V>> {
    let body = &store.body[i];
    let beside = WallLine::new(body, wall);
    let ContactLine { normal, distance, .. } = beside.line;
    let reach = body.radius + store.prediction.range;
    // Written so that a NaN does not touch.
    let touches =
        distance < reach || ahead > 0.0 && distance < reach + ahead * closing_speed(store, i, wall, normal, distance);
    (touches && wall.is_present).then_some(beside)
}

/// The contacts with walls that a search returns, and their data.
#[derive(Clone, Copy, Debug)]
pub(crate) struct WallReach {
    /// Whether the root of the reduced mass is needed.
    pub(crate) mass_root: bool,
    /// Contacts that begin within this time count, s.
    pub(crate) ahead: f64,
}

/// Returns the contact of the free particle in slot `i` with a wall that no other wall is near, if they touch within the time of
/// `reach`.
#[inline(always)]
#[must_use]
pub(crate) fn touching_wall<V: Space>(
    store: &ParticleStore<V>,
    i: usize,
    wall: &SurfaceWall<V>,
    reach: WallReach,
) -> Option<Pair<V>> {
    beside_wall(store, i, wall, reach.ahead).map(|beside| wall_pair_at(store, i, wall, &beside, reach.mass_root, 0.0))
}

/// The contacts of one particle with walls.
pub(crate) struct WallContacts<V: Space> {
    /// Walls that touch the particle, ascending, with their nearest points.
    touching: Vec<(usize, WallLine<V>)>,
}

impl<V: Space> Default for WallContacts<V> {
    fn default() -> Self {
        Self { touching: Vec::new() }
    }
}

impl<V: Space> WallContacts<V> {
    /// Finds the contacts of the free particle in slot `i` with the walls `near` it, if they touch within the time `ahead`, s. `follow`
    /// receives each wall whose contact passes to another wall at a seam, and that other wall.
    pub(crate) fn find(
        &mut self,
        store: &ParticleStore<V>,
        i: usize,
        (walls, near): (&[SurfaceWall<V>], impl Iterator<Item = usize>),
        ahead: f64,
        mut follow: impl FnMut(usize, usize),
    ) {
        self.touching.clear();
        for index in near {
            if let Some(beside) = beside_wall(store, i, &walls[index], ahead) {
                self.touching.push((index, beside));
            }
        }
        if self.touching.len() < 2 {
            return;
        }
        if walls_repeat(walls, &self.touching) {
            self.keep_nearest_facets(walls, &mut follow);
        }
        if self.may_continue() {
            self.leave_out_continued(walls, (store.body[i].position, store.body[i].radius), &mut follow);
        }
    }

    /// Returns the contacts that [`Self::find`] found, each with the index of its wall, ascending. `mass_root` asks for the root of the
    /// reduced mass.
    #[inline(always)]
    pub(crate) fn pairs(
        &self,
        store: &ParticleStore<V>,
        i: usize,
        walls: &[SurfaceWall<V>],
        mass_root: bool,
    ) -> impl Iterator<Item = (usize, Pair<V>)> {
        let pair = move |index: usize, beside| wall_pair_at(store, i, &walls[index], beside, mass_root, 0.0);
        self.touching.iter().map(move |(index, beside)| (*index, pair(*index, beside)))
    }

    /// Leaves out facets of a smooth surface that are not nearest.
    #[cold]
    fn keep_nearest_facets(&mut self, walls: &[SurfaceWall<V>], follow: &mut impl FnMut(usize, usize)) {
        let touch = |(index, beside): &(usize, WallLine<V>)| FacetTouch {
            index: *index,
            normal: beside.line.normal,
            distance: beside.line.distance,
        };
        let touches: Vec<_> = self.touching.iter().map(touch).collect();
        let holders = nearest_facets(walls, &touches);
        let left_out = |at: &usize| holders[*at] != *at;
        (0..touches.len()).filter(left_out).for_each(|at| follow(touches[at].index, touches[holders[at]].index));
        let mut at = 0..;
        self.touching.retain(|_| at.next().is_some_and(|at| !left_out(&at)));
    }

    /// The walls as [`seams`](crate::walls::seams) sees them.
    fn touches(&self) -> impl Iterator<Item = Touch<V>> {
        self.touching.iter().map(|(index, WallLine { line, at_edge, .. })| Touch {
            index: *index,
            normal: line.normal,
            distance: line.distance,
            at_edge: *at_edge,
        })
    }

    /// Whether a wall may continue another: if a nearest point is on an edge, or two lie in one direction.
    fn may_continue(&self) -> bool {
        let mut touches = self.touches();
        touches.any(|touch| {
            touch.at_edge || self.touches().any(|other| other.index > touch.index && touch.is_towards(&other))
        })
    }

    /// Leaves out contacts with walls that another wall continues.
    #[cold]
    fn leave_out_continued(
        &mut self,
        walls: &[SurfaceWall<V>],
        grain: (V, f64),
        follow: &mut impl FnMut(usize, usize),
    ) {
        let touches: Vec<_> = self.touches().collect();
        let holders = Seams::new(walls, &touches, grain).holders();
        let left_out = |at: usize| holders[at] != at;
        (0..touches.len())
            .filter(|&at| left_out(at))
            .for_each(|at| follow(touches[at].index, touches[holders[at]].index));
        let mut at = 0..;
        self.touching.retain(|_| at.next().is_some_and(|at| !left_out(at)));
    }
}

/// Whether several surfaces in a list, ascending, belong to one wall of the scene.
fn walls_repeat<V: Space>(walls: &[SurfaceWall<V>], beside: &[(usize, WallLine<V>)]) -> bool {
    beside.windows(2).any(|pair| walls[pair[0].0].number == walls[pair[1].0].number)
}

/// Returns the geometry of the free particle in slot `i` and a wall that it has just left.
pub(super) fn ended_wall_pair<V: Space>(store: &ParticleStore<V>, i: usize, wall: &SurfaceWall<V>, dt: f64) -> Pair<V> {
    let pair = wall_pair_at(store, i, wall, &WallLine::new(&store.body[i], wall), true, dt);
    Pair { gathered: store.prediction.springs_exact.then(|| store.gathered_with_wall(i, wall, &pair)), ..pair }
}

/// Returns the geometry of the free particle in slot `i` and a wall beside it.
#[inline(always)]
fn wall_pair_at<V: Space>(
    store: &ParticleStore<V>,
    i: usize,
    wall: &SurfaceWall<V>,
    beside: &WallLine<V>,
    mass_root: bool,
    dt: f64,
) -> Pair<V> {
    let body = &store.body[i];
    let ContactLine { normal, distance, reduced_mass } = beside.line;
    Pair {
        normal,
        overlap: body.radius - distance,
        relative_velocity: body.velocity - wall.velocity_at(|| body.position - normal * distance),
        reduced_mass,
        mass_root: if mass_root { reduced_mass.sqrt() } else { 0.0 },
        radii: [body.radius, f64::INFINITY],
        inverse_reach: inverse_reach(body.radius, beside.curvature),
        spins: [store.spin(i), V::Spin::ZERO],
        species: [store.species[i], wall.species],
        dt,
        springs_ahead: store.springs_ahead(),
        gathered: None,
        ahead: VelocityPrediction::default(),
    }
}

/// Returns H/(1 + R H), 1/m, for a particle of radius R (m) and a wall of mean curvature H (1/m): see [`Pair::inverse_reach`].
#[inline(always)]
fn inverse_reach(radius: f64, curvature: f64) -> f64 {
    // Most walls are flat, and a division takes longer than the comparison.
    if curvature == 0.0 { 0.0 } else { curvature / (1.0 + radius * curvature) }
}

/// Returns a normal for coincident centres. The two ids determine it, and it changes sign when they are exchanged.
#[cold]
pub(super) fn coincident<V: Space>(i: GrainId, j: GrainId) -> V {
    let (low, high) = if i < j { (i, j) } else { (j, i) };
    let mixed = low.number().wrapping_mul(0x9E37_79B1) ^ high.number().wrapping_mul(0x85EB_CA77);
    let direction = V::direction(mixed);
    if i < j { direction } else { -direction }
}
