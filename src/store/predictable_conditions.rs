//! Gates: run conditions whose answer is known before the systems that they gate run.
//!
//! A component is brought up to date for the systems that read it. Where all of them are gated, it need not be brought up to date in steps
//! in which no gate opens; and the second kick of a step can be put off if no gate of a system that reads velocities will open. The
//! condition of the schedule itself is not evaluated for that, for a condition may have a state: whoever registers a gate says how to
//! know its answer.

use std::any::TypeId;

use bevy_app::App;
use bevy_ecs::prelude::*;
use bevy_ecs::schedule::{BoxedCondition, SystemCondition};

/// A run condition whose answer is known beforehand.
struct PredictableCondition {
    /// The type of the condition.
    condition: TypeId,
    /// Its answer, known from the engine's part of the phase on.
    opens: BoxedCondition,
    /// Its answer in this step, known from the kick on.
    will_open: BoxedCondition,
}

/// The registered gates.
#[derive(Resource, Default)]
pub(crate) struct PredictableConditions(Vec<PredictableCondition>);

fn boxed<M>(world: &mut World, condition: impl SystemCondition<M>) -> BoxedCondition {
    let mut condition = IntoSystem::into_system(condition);
    condition.initialize(world);
    Box::new(condition)
}

/// Registers `condition`: its answer is that of `opens` when its phase begins, and that of `will_open` when the kick is due. Both depend
/// on the world alone.
pub(crate) fn register_predictable<M, N>(
    app: &mut App,
    condition: impl SystemCondition<M> + Clone,
    will_open: impl SystemCondition<N>,
) {
    let world = app.world_mut();
    let gate = PredictableCondition {
        condition: IntoSystem::into_system(condition.clone()).system_type(),
        opens: boxed(world, condition),
        will_open: boxed(world, will_open),
    };
    world.get_resource_or_init::<PredictableConditions>().0.push(gate);
}

impl PredictableConditions {
    /// The number of the gate that a condition of this type is.
    pub(super) fn of(&self, condition: TypeId) -> Option<usize> {
        self.0.iter().position(|gate| gate.condition == condition)
    }

    /// Whether all of these gates are open in the present phase.
    pub(super) fn open(world: &mut World, gates: &[usize]) -> bool {
        if gates.is_empty() {
            return true;
        }
        let mut all = Self::take(world);
        let is_open = gates.iter().all(|&gate| answer(&mut all[gate].opens, world));
        world.resource_mut::<Self>().0 = all;
        is_open
    }

    /// Whether all gates of any of these sets will be open, as far as the kick can tell.
    pub(super) fn any_will_open(world: &mut World, sets: &[Vec<usize>]) -> bool {
        let mut all = Self::take(world);
        let will_open = sets.iter().any(|gates| gates.iter().all(|&gate| answer(&mut all[gate].will_open, world)));
        world.resource_mut::<Self>().0 = all;
        will_open
    }

    /// Not with `resource_scope`, which moves an entity.
    fn take(world: &mut World) -> Vec<PredictableCondition> {
        std::mem::take(&mut world.resource_mut::<Self>().0)
    }
}

/// A gate that cannot say is open.
fn answer(condition: &mut BoxedCondition, world: &World) -> bool {
    condition.run_readonly((), world).unwrap_or(true)
}
