//! Bodies: grains that consist of several spheres, and the rows of their spheres.
//!
//! The store has a row for every particle, in this order:
//!
//! | rows | particles | integrated | in contacts |
//! |---|---|---|---|
//! | 0 to [`BodyColumns::free`] | centres of mass of free bodies | yes | |
//! | to `integrated_rows().end` | free grains that are one sphere | yes | yes |
//! | to `free_end` | spheres of free bodies | | yes |
//! | to `contact_rows().end` | fixed particles: spheres alone, and spheres of fixed bodies | | yes |
//! | to the end | centres of mass of fixed bodies | | |
//!
//! So a scene without shapes has the second and the fourth kind alone, and pays for nothing. A body has its row like any grain: its mass,
//! velocity, force and id. Its spheres have rows like grains on which contacts act: place, velocity, spin and radius, and 1/m of the body.
//!
//! `store/body_motion.rs` moves the spheres with their bodies, and sums their loads.

use std::sync::Arc;

use rustc_hash::FxHashMap;
use serde::{Deserialize, Serialize};

use crate::bodies::{RigidShape, Shape};
use crate::particle::GrainId;
use crate::space::{Linear, Plane, Rotor, Space};
use crate::store::ParticleStore;

/// The place of a body among the bodies: free bodies first, each in the order of its row.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct BodySlot(u32);

impl BodySlot {
    /// A row that is no sphere of a body has this body.
    const NONE: Self = Self(u32::MAX);

    pub(super) fn of(index: usize) -> Self {
        u32::try_from(index).map_or(Self::NONE, Self)
    }

    /// The index among the bodies.
    #[must_use]
    pub fn index(self) -> usize {
        self.0 as usize
    }
}

/// A sphere of a body: the body, and the number of the sphere in its shape.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SphereOfBody {
    /// The body.
    pub body: BodySlot,
    /// The number in the shape.
    pub number: u16,
}

/// The number in the sort key of a row that is no sphere of a body.
pub(super) const NO_SPHERE: u16 = u16::MAX;

/// The ends of the kinds of rows, in their order.
#[derive(Clone, Copy, Debug, Deserialize, Serialize)]
pub(super) struct Layout {
    /// Of free bodies.
    pub(super) bodies: usize,
    /// Of free grains that are one sphere.
    pub(super) grains: usize,
    /// Of spheres of free bodies.
    pub(super) free: usize,
    /// Of fixed spheres.
    pub(super) contacts: usize,
    /// Of fixed bodies, and so of all rows.
    pub(super) all: usize,
}

impl Layout {
    /// The rows of bodies, free ones first.
    pub(super) fn bodies(&self) -> impl Iterator<Item = usize> + use<> {
        (0..self.bodies).chain(self.contacts..self.all)
    }

    /// Whether there is a body.
    pub(super) fn has_bodies(&self) -> bool {
        self.bodies > 0 || self.contacts < self.all
    }
}

/// The columns of bodies and of their spheres.
#[derive(Clone, Debug)]
pub struct BodyColumns<V: Space = Plane> {
    /// The shapes of the scene.
    pub shapes: Arc<[RigidShape<V>]>,
    /// The shape of each body.
    pub shape: Vec<Shape>,
    /// The scale of each body.
    pub scale: Vec<f64>,
    /// The orientation of each body.
    pub rotor: Vec<V::Rotor>,
    /// The angular momentum of each body, kg m^2/s, at the same time as the velocity in the middle of the step between the drift and the kick, and
    /// as the velocity elsewhere.
    pub momentum: Vec<V::Spin>,
    /// Inverses of the principal moments of inertia, 1/(kg m^2).
    pub inverse_inertia: Vec<V::Principal>,
    /// Number of free bodies.
    pub free: usize,
    /// The longest move of a centre in the last drift, m.
    pub(crate) drifted: f64,
    /// Start of the spheres of each body in `rows`, and their end.
    pub(super) starts: Vec<u32>,
    /// The rows of the spheres, body by body in the shape's order.
    pub(super) rows: Vec<u32>,
    /// The first row that can be a sphere of a body.
    pub(crate) first_sphere: usize,
    /// The end of the rows of spheres.
    pub(super) contact_end: usize,
    /// The sphere that each row from `first_sphere` on is; of no body if the row is a fixed sphere by itself.
    pub(crate) spheres: Vec<SphereOfBody>,
    /// The place of each of these spheres from the centre of its body, m, in the body's axes.
    pub(crate) in_body: Vec<V>,
    /// The same in the axes of space.
    pub(crate) arm: Vec<V>,
}

impl<V: Space> Default for BodyColumns<V> {
    fn default() -> Self {
        Self {
            shapes: Arc::new([]),
            shape: Vec::new(),
            scale: Vec::new(),
            rotor: Vec::new(),
            momentum: Vec::new(),
            inverse_inertia: Vec::new(),
            free: 0,
            drifted: 0.0,
            starts: vec![0],
            rows: Vec::new(),
            first_sphere: 0,
            contact_end: 0,
            spheres: Vec::new(),
            in_body: Vec::new(),
            arm: Vec::new(),
        }
    }
}

impl<V: Space> BodyColumns<V> {
    /// No bodies, of these shapes.
    pub(super) fn with_shapes(shapes: Arc<[RigidShape<V>]>) -> Self {
        Self { shapes, ..Self::default() }
    }

    /// Number of bodies.
    #[must_use]
    #[inline]
    pub fn len(&self) -> usize {
        self.shape.len()
    }

    /// Whether there is no body of several spheres.
    #[must_use]
    #[inline]
    pub fn is_empty(&self) -> bool {
        self.shape.is_empty()
    }

    /// The rows of the spheres of a body, in the shape's order.
    #[must_use]
    pub fn rows_of(&self, body: BodySlot) -> &[u32] {
        let body = body.index();
        &self.rows[self.starts[body] as usize..self.starts[body + 1] as usize]
    }

    /// The body of which a row is a sphere.
    #[must_use]
    #[inline]
    pub fn sphere(&self, row: usize) -> Option<SphereOfBody> {
        let sphere = *self.spheres.get(row.checked_sub(self.first_sphere)?)?;
        (sphere.body != BodySlot::NONE).then_some(sphere)
    }

    /// The place of the sphere in `row` from the centre of its body, m; zero for other rows.
    #[must_use]
    #[inline]
    pub fn arm(&self, row: usize) -> V {
        row.checked_sub(self.first_sphere).and_then(|place| self.arm.get(place)).copied().unwrap_or(V::ZERO)
    }

    /// The shape of a body.
    #[must_use]
    #[inline]
    pub fn shape_of(&self, body: BodySlot) -> &RigidShape<V> {
        &self.shapes[self.shape[body.index()].index()]
    }

    /// Sets the places of the spheres of a body in its axes, by its shape and scale.
    pub(super) fn renew_places(&mut self, body: BodySlot) {
        for number in 0..self.rows_of(body).len() {
            let place = self.rows_of(body)[number] as usize - self.first_sphere;
            self.in_body[place] = self.shape_of(body).spheres[number].at * self.scale[body.index()];
        }
    }

    /// All bodies.
    pub fn all(&self) -> impl Iterator<Item = BodySlot> + use<V> {
        (0..self.len()).map(BodySlot::of)
    }

    /// Sets the ends of the kinds of rows.
    pub(super) fn take_layout(&mut self, layout: &Layout) {
        self.free = layout.bodies;
        self.first_sphere = layout.grains;
        self.contact_end = layout.contacts;
    }

    /// Whether `spheres`, as [`Self::set_spheres`] takes them, have each sphere of each body once.
    pub(super) fn has_all_spheres(&self, spheres: &[(GrainId, u16)], ids: &[GrainId]) -> bool {
        let mut present: Vec<_> = spheres.iter().filter(|(_, number)| *number != NO_SPHERE).copied().collect();
        present.sort_unstable();
        let spheres_of = |shape: &Shape| (0u16..).take(self.shapes[shape.index()].spheres.len());
        let wanted = ids.iter().zip(&self.shape);
        let mut wanted: Vec<_> = wanted.flat_map(|(id, shape)| spheres_of(shape).map(|number| (*id, number))).collect();
        wanted.sort_unstable();
        present == wanted
    }

    /// Sets which rows are spheres. `spheres` are the id of the body and the number in the shape for each row from the first sphere to the
    /// end of contact rows; `ids` are the ids of the bodies.
    pub(super) fn set_spheres(&mut self, spheres: &[(GrainId, u16)], ids: &[GrainId]) {
        let bodies: FxHashMap<GrainId, u32> = ids.iter().copied().zip(0u32..).collect();
        let sphere = |&(id, number): &(GrainId, u16)| match bodies.get(&id).filter(|_| number != NO_SPHERE) {
            Some(&body) => SphereOfBody { body: BodySlot(body), number },
            None => SphereOfBody { body: BodySlot::NONE, number: NO_SPHERE },
        };
        self.spheres = spheres.iter().map(sphere).collect();
        self.starts.clear();
        self.starts.push(0);
        let mut end = 0;
        for shape in &self.shape {
            end += u32::try_from(self.shapes[shape.index()].spheres.len()).unwrap_or(u32::MAX);
            self.starts.push(end);
        }
        self.rows = vec![u32::MAX; end as usize];
        for (sphere, row) in self.spheres.iter().zip(self.first_sphere..) {
            if sphere.body != BodySlot::NONE {
                let place = self.starts[sphere.body.index()] as usize + usize::from(sphere.number);
                self.rows[place] = u32::try_from(row).unwrap_or(u32::MAX);
            }
        }
        self.in_body = vec![V::ZERO; self.spheres.len()];
        self.arm = vec![V::ZERO; self.spheres.len()];
    }
}

impl<V: Space> ParticleStore<V> {
    /// The row of a body.
    #[must_use]
    #[inline]
    pub fn row_of_body(&self, body: BodySlot) -> usize {
        let body = body.index();
        if body < self.bodies.free { body } else { self.contact_rows().end + (body - self.bodies.free) }
    }

    /// The body whose centre of mass is row `i`.
    #[must_use]
    #[inline]
    pub fn body_of_row(&self, i: usize) -> Option<BodySlot> {
        if i < self.bodies.free {
            return Some(BodySlot::of(i));
        }
        let beyond = i.checked_sub(self.contact_rows().end)?;
        (i < self.len()).then(|| BodySlot::of(self.bodies.free + beyond))
    }

    /// The [director](RigidShape::director) of the grain in row `i`, which may be one of its spheres; `None` if the grain has none.
    #[must_use]
    pub fn director(&self, i: usize) -> Option<V> {
        let body = self.body_of_row(i).or_else(|| self.bodies.sphere(i).map(|sphere| sphere.body))?;
        Some(self.bodies.rotor[body.index()].turn(self.bodies.shape_of(body).director?))
    }

    /// Whether row `i` is one grain or one fixed particle: not a sphere of a body.
    #[must_use]
    #[inline]
    pub fn is_whole(&self, i: usize) -> bool {
        self.bodies.is_empty() || self.bodies.sphere(i).is_none()
    }

    /// Whether two rows can touch: both are spheres, and not of one body.
    #[inline]
    pub(crate) fn can_touch(&self, i: usize, j: usize) -> bool {
        self.bodies.is_empty() || self.are_spheres_of_two_grains(i, j)
    }

    /// A call, so that searches without bodies stay small.
    #[inline(never)]
    fn are_spheres_of_two_grains(&self, i: usize, j: usize) -> bool {
        let rows = self.contact_rows();
        rows.contains(&i) && rows.contains(&j) && self.id[i] != self.id[j]
    }

    /// The ends of the kinds of rows.
    pub(super) fn layout(&self) -> Layout {
        Layout {
            bodies: self.bodies.free,
            grains: self.integrated_rows().end,
            free: self.free_end,
            contacts: self.contact_rows().end,
            all: self.len(),
        }
    }

    /// Returns the angular momentum (kg m^2/s) of row `i` about its centre; zero for a row that does not spin.
    #[must_use]
    pub fn angular_momentum(&self, i: usize) -> V::Spin {
        match (self.body_of_row(i), self.rotation.get(i)) {
            (Some(body), _) => self.bodies.momentum[body.index()],
            (None, Some(rotation)) if rotation.inverse_inertia > 0.0 => {
                rotation.spin * (1.0 / rotation.inverse_inertia)
            }
            _ => V::Spin::ZERO,
        }
    }

    /// Returns the gain of spin (rad/s) of row `i` by an angular impulse, N m s.
    #[must_use]
    pub fn spin_gain(&self, i: usize, impulse: V::Spin) -> V::Spin {
        match self.body_of_row(i) {
            Some(body) => self.bodies.rotor[body.index()].spin(impulse, self.bodies.inverse_inertia[body.index()]),
            None => impulse * self.rotation.get(i).map_or(0.0, |rotation| rotation.inverse_inertia),
        }
    }

    /// Returns 1/m (1/kg) of the grain of row `i` for a force along the unit vector `normal` at a contact of that sphere.
    #[must_use]
    pub(crate) fn inverse_mass_along(&self, i: usize, normal: V) -> f64 {
        let inverse_mass = self.body[i].inverse_mass;
        match self.bodies.sphere(i) {
            Some(SphereOfBody { body, .. }) if inverse_mass > 0.0 => {
                let turn = self.bodies.arm(i).cross(normal);
                let b = body.index();
                inverse_mass + turn.dot(self.bodies.rotor[b].spin(turn, self.bodies.inverse_inertia[b]))
            }
            _ => inverse_mass,
        }
    }

    /// Moves the columns of bodies to the rows of a new layout. Bodies without a former row are blank.
    pub(super) fn rearrange_bodies(&mut self, layout: &Layout) {
        let rows = layout.bodies();
        let former: Vec<_> = rows.map(|row| self.body_of_row(self.former[row].index()).map(BodySlot::index)).collect();
        let old = std::mem::take(&mut self.bodies);
        let mut new = BodyColumns { shapes: old.shapes.clone(), drifted: old.drifted, ..BodyColumns::default() };
        new.take_layout(layout);
        for before in former {
            new.shape.push(before.map_or(Shape(0), |b| old.shape[b]));
            new.scale.push(before.map_or(1.0, |b| old.scale[b]));
            new.rotor.push(before.map_or(V::Rotor::IDENTITY, |b| old.rotor[b]));
            new.momentum.push(before.map_or(V::Spin::ZERO, |b| old.momentum[b]));
            new.inverse_inertia.push(before.map_or_else(V::Principal::default, |b| old.inverse_inertia[b]));
        }
        self.bodies = new;
    }

    /// Sets the scale and the inertia of the body in row `i`, if it is one, by its mass (kg) and equivalent radius (m).
    pub(super) fn set_size(&mut self, i: usize, mass: f64, radius: f64) {
        let Some(body) = self.body_of_row(i) else { return };
        let shape = self.bodies.shape_of(body);
        let scale = shape.scale(radius);
        // A body without mass is fixed: it never turns.
        let inverse_inertia =
            if mass > 0.0 { shape.inverse_inertia(mass, scale) } else { V::Principal::from_components(|_| 1.0) };
        self.bodies.scale[body.index()] = scale;
        self.bodies.inverse_inertia[body.index()] = inverse_inertia;
    }
}
