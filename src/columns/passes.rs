//! The passes between components and columns, and who makes them.
//!
//! Where no behaviour may look at grains or change them, there are hardly any: columns lead ([`lead`]).

use std::marker::PhantomData;

use bevy_app::{App, Plugin};
use bevy_ecs::change_detection::ContiguousRef;
use bevy_ecs::prelude::*;

use crate::columns::{Columns, Slot, lead, slots};
use crate::contact::ContactForces;
use crate::contact::history::History;
use crate::gravity::Gravity;
use crate::instructions::Instructions;
use crate::particle::{Fixed, Force, Position, Velocity};
use crate::space::Space;
use crate::step::{ForceStage, Phase, Step};

/// Why contiguous iteration cannot fail: every component of a particle's columns is stored in tables.
pub(crate) const DENSE: &str = "table components are contiguous";

/// The longest of many ways: the bits of its square. Those of numbers that are not negative are ordered as the numbers are, and
/// what is no number comes after all of them, where a maximum of numbers would forget it.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Longest(u64);

impl Longest {
    /// Takes another one into account, m.
    #[inline]
    pub(crate) fn raise<V: Space>(&mut self, way: V) {
        self.0 = self.0.max(way.length_squared().to_bits());
    }

    /// The longer of two.
    pub(crate) fn or(self, other: Self) -> Self {
        Self(self.0.max(other.0))
    }

    /// Its length, m; not a number if one of them had none.
    pub(crate) fn length(self) -> f64 {
        let squared = f64::from_bits(self.0);
        if squared.is_finite() { squared.sqrt() } else { f64::NAN }
    }
}

impl<V: Space> Columns<V> {
    /// Copies a position and a velocity, whoever has changed them, and takes note of the way.
    #[inline]
    pub(crate) fn put(&mut self, slot: Slot, x: V, v: V, longest: &mut Longest) {
        if let Some(body) = self.body.get_mut(slot.index()) {
            // Most of what is fixed stands still.
            if x == body.position && v == body.velocity {
                return;
            }
            let way = x - body.position;
            longest.raise(self.periodic.map_or(way, |periodic| periodic.shortest(way)));
            (body.position, body.velocity) = (x, v);
        }
    }

    /// The same of rows of a table.
    fn put_rows(&mut self, slots: &[Slot], xs: &[Position<V>], vs: &[Velocity<V>], longest: &mut Longest) {
        for (slot, (x, v)) in slots.iter().zip(xs.iter().zip(vs)) {
            self.put(*slot, x.0, v.0, longest);
        }
    }
}

/// Copies positions and velocities into the columns.
fn gather<V: Space>(mut columns: ResMut<Columns<V>>, particles: Query<(&Slot, &Position<V>, &Velocity<V>)>) {
    let mut longest = Longest::default();
    for (slots, xs, vs) in particles.contiguous_iter().expect(DENSE) {
        columns.put_rows(slots, xs, vs, &mut longest);
    }
    columns.travel += longest.length();
}

/// Copies those of what is fixed, of tables in which anything has changed: most of it stands still.
fn gather_fixed<V: Space>(
    mut columns: ResMut<Columns<V>>,
    particles: Query<(&Slot, Ref<Position<V>>, Ref<Velocity<V>>), With<Fixed>>,
) {
    let mut longest = Longest::default();
    for (slots, xs, vs) in particles.contiguous_iter().expect(DENSE) {
        let ((xs, moved), (vs, turned)) = (with_changes(xs), with_changes(vs));
        if moved || turned {
            columns.put_rows(slots, xs, vs, &mut longest);
        }
    }
    columns.travel += longest.length();
}

/// A table's column, and whether its summary says that it has changed since the system at hand looked at it.
pub(super) fn with_changes<T>(column: ContiguousRef<'_, T>) -> (&[T], bool) {
    let (rows, ticks) = ContiguousRef::split(column);
    (rows, ticks.summary_tick_is_changed() != Some(false))
}

/// Where behaviours may have changed them.
pub(crate) fn gather_velocities<V: Space>(mut columns: ResMut<Columns<V>>, particles: Query<(&Slot, &Velocity<V>)>) {
    for (slots, vs) in particles.contiguous_iter().expect(DENSE) {
        for (slot, v) in slots.iter().zip(vs.iter()) {
            if let Some(body) = columns.body.get_mut(slot.index()) {
                body.velocity = v.0;
            }
        }
    }
}

/// Where no contact pass sets them.
pub(crate) fn clear_forces<V: Space>(gravity: Res<Gravity<V>>, mut columns: ResMut<Columns<V>>) {
    let Columns { loads, mass, has_books, .. } = &mut *columns;
    loads.force.reset(mass.len(), *has_books);
    for (i, mass) in mass.iter().enumerate() {
        loads.force.set(i, gravity.0 * *mass);
    }
}

/// Writes the sums to the forces.
fn write_forces<V: Space>(columns: Res<Columns<V>>, mut particles: Query<(&Slot, &mut Force<V>)>) {
    for (slots, mut forces) in particles.contiguous_iter_mut().expect(DENSE) {
        for (slot, force) in slots.iter().zip(forces.bypass_change_detection()) {
            if let Some(sum) = columns.loads.force.get(slot.index()) {
                force.0 = sum;
            }
        }
    }
}

/// The columns hold x(t+dt), v(t+dt/2) after this set of [`Phase::Neighbours`].
#[derive(SystemSet, Clone, Debug, PartialEq, Eq, Hash)]
pub struct Gathered;

/// The columns hold x(t+dt), v(t+dt/2) after this part of [`Gathered`]; the rest of it is about spins.
#[derive(SystemSet, Clone, Debug, PartialEq, Eq, Hash)]
pub struct PlacesGathered;

/// Spins are w(t+dt/2) after this set of [`Phase::Drift`].
#[derive(SystemSet, Clone, Debug, PartialEq, Eq, Hash)]
pub struct SpinsDrifted;

/// The columns know what a scheme that looks ahead needs after this set, before the neighbour search.
#[derive(SystemSet, Clone, Debug, PartialEq, Eq, Hash)]
pub struct LookedAhead;

/// Velocities are v(t+dt) after this set of [`Phase::Kick`].
#[derive(SystemSet, Clone, Debug, PartialEq, Eq, Hash)]
pub struct Kicked;

/// The columns hold v(t+dt) after this set, at the end of [`Phase::Kick`].
#[derive(SystemSet, Clone, Debug, PartialEq, Eq, Hash)]
pub struct GatheredVelocities;

/// Which passes between components and columns a scene needs.
#[derive(Clone, Copy, Debug)]
pub struct Passes {
    /// Whether columns lead: where no behaviour looks at grains or changes them.
    pub columns_lead: bool,
    /// Whether somebody looks at components in every step all the same.
    pub watched: bool,
    /// Whether the sums of forces may have to be begun here: where a behaviour brings the contacts, and maybe not our pass.
    pub begins_sums: bool,
}

/// The columns and the passes that fill and empty them.
pub struct ColumnsPlugin<V: Space> {
    /// Which passes there are.
    pub passes: Passes,
    /// The space.
    pub space: PhantomData<V>,
}

impl<V: Space> Plugin for ColumnsPlugin<V> {
    fn build(&self, app: &mut App) {
        // Those who walk along the columns need the instructions.
        app.init_resource::<Columns<V>>().init_resource::<Instructions>();
        slots::add::<V>(app);
        if self.passes.begins_sums {
            let clear = clear_forces::<V>.in_set(ForceStage::Contacts).before(ContactForces);
            app.add_systems(Step, clear.run_if(not(resource_exists::<History<V>>)));
        }
        if self.passes.columns_lead {
            lead::add::<V>(app, self.passes.watched);
            let fixed = gather_fixed::<V>.in_set(Phase::Neighbours).in_set(Gathered).in_set(PlacesGathered);
            app.add_systems(Step, fixed);
        } else {
            let all = gather::<V>.in_set(Phase::Neighbours).in_set(Gathered).in_set(PlacesGathered);
            let again = gather_velocities::<V>.in_set(Phase::Kick).in_set(GatheredVelocities);
            app.add_systems(Step, (all, write_forces::<V>.in_set(ForceStage::Written), again));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::space::Vector;

    /// Of ways along x, m.
    fn longest(ways: &[f64]) -> f64 {
        let mut longest = Longest::default();
        for &way in ways {
            longest.raise(Vector::new(way, 0.0));
        }
        let [one, other] = [longest, Longest::default()];
        assert_eq!(one.or(other).length().to_bits(), other.or(one).length().to_bits());
        longest.length()
    }

    #[test]
    fn the_longest_way_is_found_and_what_is_no_number_is_not_forgotten() {
        assert_eq!((longest(&[]), longest(&[1.0, -3.0, 2.0])), (0.0, 3.0));
        for odd in [f64::NAN, -f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            assert!(longest(&[odd, 1.0]).is_nan() && longest(&[1.0, odd]).is_nan(), "{odd}");
        }
    }
}
