//! Predictable conditions: run conditions whose result is known before the phase of the systems that they control. Such a condition
//! is called a gate here, and it is open where it holds.
//!
//! A component is refreshed for the systems that read it. If all of these systems are gated, a step in which no gate
//! opens needs no refresh. The second kick of a step can be deferred if no gate of a system that reads velocities will
//! open.
//!
//! The condition in the schedule itself is not evaluated for these predictions, because a condition may have state. The
//! code that registers a gate supplies conditions that predict its result.

use std::any::TypeId;

use bevy_app::App;
use bevy_ecs::prelude::*;
use bevy_ecs::schedule::{BoxedCondition, SystemCondition};

/// A run condition with a result that is known in advance.
struct PredictableCondition {
    /// The type of the condition.
    condition: TypeId,
    /// Gives its result; valid from the engine's part of the phase on.
    opens: BoxedCondition,
    /// Predicts its result in this step; valid from the kick on.
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

/// Registers `condition` as a gate. A copy of it is evaluated when the phase begins; `will_open` predicts it when the
/// kick is due. The results must depend on the world alone.
pub fn register_predictable<M, N>(
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
    /// The number of the gate with a condition of this type.
    pub(super) fn of(&self, condition: TypeId) -> Option<usize> {
        self.0.iter().position(|gate| gate.condition == condition)
    }

    /// Whether all of these gates are open in the present phase.
    pub(super) fn are_open(world: &mut World, gates: &[usize]) -> bool {
        if gates.is_empty() {
            return true;
        }
        let mut all = Self::take(world);
        let is_open = gates.iter().all(|&gate| evaluate(&mut all[gate].opens, world));
        world.resource_mut::<Self>().0 = all;
        is_open
    }

    /// Whether, in any of these sets, all gates will open, as predicted at the kick.
    pub(super) fn any_will_open(world: &mut World, sets: &[Vec<usize>]) -> bool {
        let mut all = Self::take(world);
        let will_open = sets.iter().any(|gates| gates.iter().all(|&gate| evaluate(&mut all[gate].will_open, world)));
        world.resource_mut::<Self>().0 = all;
        will_open
    }

    /// `resource_scope` would move an entity.
    fn take(world: &mut World) -> Vec<PredictableCondition> {
        std::mem::take(&mut world.resource_mut::<Self>().0)
    }
}

/// Evaluates a condition. A condition that cannot be evaluated counts as true.
fn evaluate(condition: &mut BoxedCondition, world: &World) -> bool {
    condition.run_readonly((), world).unwrap_or(true)
}
