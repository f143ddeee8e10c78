//! Orders the systems that only add forces and torques ([`added_loads`](crate::added_loads)): in the order in which they were added to
//! the schedule, and so of the names of their behaviours. An order that a program declares stays.

use std::iter;

use bevy_ecs::prelude::*;
use bevy_ecs::query::FilteredAccess;
use bevy_ecs::schedule::graph::{DiGraph, Direction};
use bevy_ecs::schedule::{
    FlattenedDependencies, NodeId, ScheduleBuildError, ScheduleBuildPass, ScheduleGraph, SystemKey, SystemSetKey,
    SystemWithAccess,
};
use bevy_platform::hash::FixedHasher;
use indexmap::IndexSet;

use crate::store::access_markers::AddsLoads;

/// The build pass.
#[derive(Debug)]
pub(super) struct AddersInOrder;

/// Whether a path leads from one system to another.
fn leads_to(graph: &DiGraph<SystemKey>, from: SystemKey, to: SystemKey) -> bool {
    let mut seen = Vec::new();
    let mut next = vec![from];
    while let Some(system) = next.pop() {
        if system == to {
            return true;
        }
        let after = graph.neighbors_directed(system, Direction::Outgoing);
        for system in after {
            if !seen.contains(&system) {
                seen.push(system);
                next.push(system);
            }
        }
    }
    false
}

impl ScheduleBuildPass for AddersInOrder {
    type EdgeOptions = ();

    fn add_dependency(&mut self, _: NodeId, _: NodeId, _: Option<&()>) {}

    fn collapse_set(
        &mut self,
        _: SystemSetKey,
        _: &IndexSet<SystemKey, FixedHasher>,
        _: &DiGraph<NodeId>,
    ) -> impl Iterator<Item = (NodeId, NodeId)> {
        iter::empty()
    }

    fn build(
        &mut self,
        world: &mut World,
        graph: &mut ScheduleGraph,
        mut order: FlattenedDependencies<'_>,
    ) -> Result<(), ScheduleBuildError> {
        let mut writes_marker = FilteredAccess::matches_everything();
        writes_marker.add_write(world.register_component::<AddsLoads>());
        let adds = |key: &SystemKey| {
            let access = graph.systems.get(*key).map(SystemWithAccess::access);
            access
                .is_some_and(|access| !access.is_exclusive() && !access.get_conflicts_single(&writes_marker).is_empty())
        };
        let adders: Vec<_> = graph.systems.iter().map(|(key, ..)| key).filter(adds).collect();
        for (place, &first) in adders.iter().enumerate() {
            for &second in &adders[place + 1..] {
                if !leads_to(order.graph(), first, second) && !leads_to(order.graph(), second, first) {
                    order.add_edge(first, second);
                }
            }
        }
        Ok(())
    }
}
