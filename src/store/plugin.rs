//! Small passes over the store, and the plugin that sets it up.

use std::marker::PhantomData;

use bevy_app::{App, Plugin};
use bevy_ecs::prelude::*;

use crate::gravity::Gravity;
use crate::instructions::Instructions;
use crate::space::Space;
use crate::store::{MirrorSet, ParticleStore, component_sync, deferred_kick, population, renumbering};

/// Why contiguous iteration cannot fail: every component of a particle's columns is stored in tables.
pub(crate) const DENSE: &str = "table components are contiguous";

/// The longest of many ways: the bits of its square. Those of numbers that are not negative are ordered as the numbers are, and
/// what is no number comes after all of them, where a maximum of numbers would forget it.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct LongestMove(u64);

impl LongestMove {
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

impl<V: Space> ParticleStore<V> {
    /// Sets the position of row `i`, m, to that in the box which `x` stands for, and takes the way there into account.
    #[inline]
    pub(crate) fn put(&mut self, i: usize, x: V, longest: &mut LongestMove) {
        let way = x - self.body[i].position;
        longest.raise(self.periodic.map_or(way, |periodic| periodic.shortest(way)));
        self.body[i].position = x;
        if let Some(periodic) = &self.periodic
            && !periodic.contains(x)
        {
            self.body[i].position = periodic.wrapped(x);
            self.stale.add(MirrorSet::POSITION);
        }
    }
}

/// Begins the sums of forces with the weight, where no contact pass does.
pub(crate) fn clear_forces<V: Space>(gravity: Res<Gravity<V>>, mut store: ResMut<ParticleStore<V>>) {
    store.stale.add(MirrorSet::FORCE);
    let ParticleStore { loads, mass, tracks_energy, .. } = &mut *store;
    loads.force.reset(mass.len(), *tracks_energy);
    for (i, mass) in mass.iter().enumerate() {
        loads.force.set(i, gravity.0 * *mass);
    }
}

/// Spins are w(t+dt/2) after this set of [`Phase::Drift`](crate::step::Phase::Drift).
#[derive(SystemSet, Clone, Debug, PartialEq, Eq, Hash)]
pub struct SpinsDrifted;

/// The columns know what a scheme that looks ahead needs after this set, before the neighbour search.
#[derive(SystemSet, Clone, Debug, PartialEq, Eq, Hash)]
pub struct VelocitiesPredicted;

/// Velocities are v(t+dt) after this set, which kicks.
#[derive(SystemSet, Clone, Debug, PartialEq, Eq, Hash)]
pub struct Kicked;

/// The store, the hooks that tell it who enters and leaves, and the synchronisation with components.
pub struct StorePlugin<V: Space>(pub PhantomData<V>);

impl<V: Space> Plugin for StorePlugin<V> {
    fn build(&self, app: &mut App) {
        // Those who walk along the columns need the instructions.
        app.init_resource::<ParticleStore<V>>().init_resource::<Instructions>();
        population::add::<V>(app.world_mut());
        renumbering::add::<V>(app);
        component_sync::add::<V>(app);
        deferred_kick::add(app);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::space::Vector;

    /// Of ways along x, m.
    fn longest(ways: &[f64]) -> f64 {
        let mut longest = LongestMove::default();
        for &way in ways {
            longest.raise(Vector::new(way, 0.0));
        }
        let [one, other] = [longest, LongestMove::default()];
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
