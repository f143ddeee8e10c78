//! Rotation: spin w (rad/s), torque T (N m) and moment of inertia I (kg m^2) of grains, in scenes with friction.
//!
//! w follows velocity Verlet as the velocity does: w(t+dt/2) = w(t) + dt/2 T(t)/I, then T from positions and half-step
//! velocities, then w(t+dt) = w(t+dt/2) + dt/2 T(t+dt)/I. Orientations are not followed: a sphere looks the same from all
//! sides. I = 2/5 m R^2 for a sphere, 1/2 m R^2 for a disc. A behaviour that changes a grain's mass or radius sets its
//! [`Inertia`] as well. Wall grains do not spin; a grain that a behaviour fixes keeps the spin that it has.

use std::marker::PhantomData;

use bevy_app::{App, Plugin};
use bevy_ecs::prelude::*;
use serde::{Deserialize, Serialize};

use crate::columns::{
    self, BOOKED, Columns, DENSE, Gathered, GatheredVelocities, Kicked, PlacesGathered, SecondKick, Slot, SpinsDrifted,
    WHOLE, Walkers, add_second_kick, kick_term,
};
use crate::particle::{Fixed, Grain, Mass, Radius};
use crate::space::{Dimension, Linear, Space};
use crate::step::{Clock, ClockAdvanced, Drifted, ForceStage, Phase, Step};

/// Angular velocity, rad/s; in the plane a number, positive counter-clockwise.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq)]
pub struct Spin<W: Linear = f64>(pub W);

/// Torque about the centre, N m, as of the last evaluation.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq)]
pub struct Torque<W: Linear = f64>(pub W);

/// Moment of inertia about the centre, kg m^2.
#[derive(Component, Clone, Copy, Debug, PartialEq)]
pub struct Inertia(pub f64);

/// The scene's `inertia`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
pub enum InertiaLaw {
    /// I = 2/5 m R^2.
    Sphere,
    /// I = 1/2 m R^2.
    Disc,
}

impl InertiaLaw {
    /// What a scene has that does not say: spheres in solid space, discs in the plane.
    #[must_use]
    pub fn usual(dimension: Dimension) -> Self {
        match dimension {
            Dimension::Plane => Self::Disc,
            Dimension::Solid => Self::Sphere,
        }
    }

    /// I/(m R^2).
    #[must_use]
    pub fn factor(self) -> f64 {
        match self {
            Self::Sphere => 0.4,
            Self::Disc => 0.5,
        }
    }

    /// What a grain of this mass (kg), radius (m) and spin (rad/s) needs to turn.
    pub(crate) fn turning<V: Space>(self, mass: f64, radius: f64, spin: V::Spin) -> TurningBundle<V> {
        (Spin(spin), Torque(V::Spin::ZERO), Inertia(self.factor() * mass * radius * radius))
    }
}

pub(crate) type TurningBundle<V> = (Spin<<V as Space>::Spin>, Torque<<V as Space>::Spin>, Inertia);

/// Every grain that enters gets what it needs to turn, unless it brings all of it.
fn equip<V: Space>(
    added: On<Add<Grain>>,
    columns: Res<Columns<V>>,
    grains: Query<(&Mass, &Radius, Has<Spin<V::Spin>>, Has<Torque<V::Spin>>, Has<Inertia>)>,
    mut commands: Commands,
) {
    let Ok((mass, radius, spins, has_torque, has_inertia)) = grains.get(added.entity) else { return };
    if spins && has_torque && has_inertia {
        return;
    }
    let Some(law) = columns.inertia else { return };
    let (spin, torque, inertia) = law.turning::<V>(mass.0, radius.0, V::Spin::ZERO);
    let mut grain = commands.entity(added.entity);
    grain.insert((torque, inertia));
    if !spins {
        grain.insert(spin);
    }
}

type Turning<V> = (&'static mut Spin<<V as Space>::Spin>, &'static Torque<<V as Space>::Spin>, &'static Inertia);

/// What a torque (N m) adds to the spin in half a step of `dt` (s), rad/s.
#[inline]
fn gained<W: Linear>(torque: W, dt: f64, inverse_inertia: f64) -> W {
    torque * (0.5 * dt * inverse_inertia)
}

/// Half a step of w, before the drift.
fn half_kick<V: Space>(clock: Res<Clock>, mut grains: Query<Turning<V>, Without<Fixed>>) {
    for (mut spins, torques, inertias) in grains.contiguous_iter_mut().expect(DENSE) {
        let spins = spins.bypass_change_detection().iter_mut();
        for (spin, (torque, inertia)) in spins.zip(torques.iter().zip(inertias.iter())) {
            spin.0 += gained(torque.0, clock.dt, 1.0 / inertia.0);
        }
    }
}

/// The same in the columns, where they lead: the second kick of a step, the first of the next, or both in one pass. The second leaves
/// a sum, which saves a pass ([`Columns::spin_kick_sum`]).
fn kick_columns<V: Space, const SECOND: bool, const FIRST: bool>(dt: f64, walkers: &Walkers, columns: &mut Columns<V>) {
    if columns.has_books {
        kick_by::<V, BOOKED, SECOND, FIRST>(dt, walkers, columns);
    } else {
        kick_by::<V, WHOLE, SECOND, FIRST>(dt, walkers, columns);
    }
}

/// By torques of which so many numbers are kept.
fn kick_by<V: Space, const EACH: usize, const SECOND: bool, const FIRST: bool>(
    dt: f64,
    walkers: &Walkers,
    columns: &mut Columns<V>,
) {
    let Columns { loads, rotation, movable_end: end, .. } = columns;
    let sums = walkers.along(
        &loads.torque.entries::<EACH>()[..*end],
        &mut rotation[..*end],
        #[inline(always)]
        |torque, rotation, sum: &mut V::Spin| {
            let gained = gained(torque[0], dt, rotation.inverse_inertia);
            if SECOND {
                rotation.spin += gained;
                *sum += kick_term(torque, rotation.spin);
            }
            if FIRST {
                rotation.spin += gained;
            }
        },
    );
    if SECOND {
        columns.spin_kick_sum = Some(sums.into_iter().fold(V::Spin::ZERO, |sum, one| sum + one));
    }
}

/// Before the drift; with the second kick of the step before, if it is owed.
fn first_kick<V: Space>(
    (clock, walkers): (Res<Clock>, Walkers),
    second: Option<Res<SecondKick>>,
    mut columns: ResMut<Columns<V>>,
) {
    if second.is_some_and(|kick| kick.is_owed) {
        kick_columns::<V, true, true>(clock.dt, &walkers, &mut columns);
    } else {
        kick_columns::<V, false, true>(clock.dt, &walkers, &mut columns);
    }
}

/// After the forces.
fn second_kick<V: Space>((clock, walkers): (Res<Clock>, Walkers), mut columns: ResMut<Columns<V>>) {
    kick_columns::<V, true, false>(clock.dt, &walkers, &mut columns);
}

/// Copies spins into the columns.
fn gather<V: Space>(mut columns: ResMut<Columns<V>>, grains: Query<(&Slot, &Spin<V::Spin>)>) {
    for (slots, spins) in grains.contiguous_iter().expect(DENSE) {
        for (slot, spin) in slots.iter().zip(spins.iter()) {
            if let Some(rotation) = columns.rotation.get_mut(slot.index()) {
                rotation.spin = spin.0;
            }
        }
    }
}

/// Writes the torques.
fn write<V: Space>(columns: Res<Columns<V>>, mut grains: Query<(&Slot, &mut Torque<V::Spin>)>) {
    for (slots, mut torques) in grains.contiguous_iter_mut().expect(DENSE) {
        for (slot, torque) in slots.iter().zip(torques.bypass_change_detection()) {
            if let Some(sum) = columns.loads.torque.get(slot.index()) {
                torque.0 = sum;
            }
        }
    }
}

/// Rotation of grains.
pub struct SpinPlugin<V: Space> {
    /// What moments of inertia follow from.
    pub inertia: InertiaLaw,
    /// Whether grains are turned in the columns.
    pub columns_lead: bool,
    /// The space.
    pub space: PhantomData<V>,
}

impl<V: Space> Plugin for SpinPlugin<V> {
    fn build(&self, app: &mut App) {
        app.world_mut().resource_mut::<Columns<V>>().inertia = Some(self.inertia);
        app.add_observer(equip::<V>);
        if self.columns_lead {
            app.add_systems(Step, first_kick::<V>.in_set(Phase::Drift).in_set(SpinsDrifted).after(Drifted));
            add_second_kick(app, second_kick::<V>.after(Kicked).before(GatheredVelocities));
        } else {
            let again = gather::<V>.in_set(Phase::Kick).in_set(GatheredVelocities);
            app.add_systems(
                Step,
                (
                    half_kick::<V>.in_set(Phase::Drift).after(ClockAdvanced),
                    gather::<V>.in_set(Phase::Neighbours).in_set(Gathered).after(PlacesGathered),
                    write::<V>.in_set(ForceStage::Written),
                    half_kick::<V>.in_set(Phase::Kick).before(GatheredVelocities),
                    again.after(columns::gather_velocities::<V>),
                ),
            );
        }
    }
}
