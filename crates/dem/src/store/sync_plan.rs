//! The sync plan: the mirrored components that the systems of each phase use.
//!
//! It is derived once, when the schedule is built, from the access that systems and run conditions declare. Code
//! without an access list counts as reading and writing everything. This concerns exclusive systems and, in phases with
//! commands, observers and component hooks of other crates. Systems of the engine ([`Part`](crate::step::Part)) work on
//! the store and do not count.

use std::any::TypeId;

use bevy_ecs::change_detection::Tick;
use bevy_ecs::prelude::*;
use bevy_ecs::schedule::{ApplyDeferred, ScheduleGraph, SystemWithAccess};

use crate::space::Space;
use crate::step::Phase;
use crate::store::declared_access::{AccessReader, Need, PhaseSets, ancestors};
use crate::store::foreign_code::{ForeignObservers, have_foreign_hooks};
use crate::store::mirror_set::MirrorSet;
use crate::store::predictable_conditions::PredictableConditions;
use siloflow_text::fault::Fault;

/// The plan of one phase.
#[derive(Debug, Default)]
pub(super) struct PhasePlan {
    pub(super) needs: Vec<Need>,
    /// Whether systems of the phase have commands, which may trigger observers and hooks.
    pub(super) has_commands: bool,
    /// Whether components are synced before and after the phase.
    pub(super) is_synchronised: bool,
}

/// The sync plan, and its result for the present phase.
#[derive(Resource, Debug)]
pub(crate) struct Plan {
    pub(super) phases: [PhasePlan; Phase::ALL.len()],
    /// The gates of each system that reads velocities between the kick and the next drift.
    motion_readers: Vec<Vec<usize>>,
    /// Whether commands are applied between the kick and the next drift.
    has_commands: bool,
    /// Whether observers or hooks of other crates may exist.
    checks_commands: bool,
    /// Components that systems of the present phase may write.
    pub(super) writes: MirrorSet,
    /// The change tick at the phase's beginning: writes of its systems have later ticks.
    pub(super) since: Tick,
    /// Number of component types already searched for hooks.
    searched_components: usize,
    has_hooks: bool,
}

impl Plan {
    /// Whether any ungated system reads a mirrored component of free particles.
    pub(crate) fn mirrors_grains(&self) -> bool {
        let mut needs = self.phases.iter().flat_map(|phase| &phase.needs);
        needs.any(|need| need.gates.is_empty() && need.reads.meets(MirrorSet::FREE))
    }

    /// Whether a system reads or writes one of these components.
    pub(super) fn uses(&self, components: MirrorSet) -> bool {
        self.phases.iter().flat_map(|phase| &phase.needs).any(|need| need.reads.or(need.writes).meets(components))
    }

    /// Whether observers or hooks of other crates may run when commands are applied.
    pub(super) fn foreign_code_may_run(world: &mut World, observers: &mut ForeignObservers) -> bool {
        world.resource::<Self>().checks_commands && Self::has_foreign_code(world, observers)
    }

    /// Whether observers or hooks of other crates exist.
    fn has_foreign_code(world: &mut World, observers: &mut ForeignObservers) -> bool {
        let searched_components = world.resource::<Self>().searched_components;
        let components = world.components();
        if components.len() != searched_components {
            let count = components.len();
            let has_hooks = have_foreign_hooks(components);
            let mut plan = world.resource_mut::<Self>();
            plan.searched_components = count;
            plan.has_hooks = has_hooks;
        }
        world.resource::<Self>().has_hooks || observers.iter(world).next().is_some()
    }

    /// Whether a system will read velocities between the kick and the next drift.
    pub(super) fn motion_will_be_read(world: &mut World, observers: &mut ForeignObservers) -> bool {
        let mut plan = world.resource_mut::<Self>();
        let motion_readers = std::mem::take(&mut plan.motion_readers);
        let has_commands = plan.has_commands;
        let will_be_read = PredictableConditions::any_will_open(world, &motion_readers)
            || has_commands && Self::foreign_code_may_run(world, observers);
        world.resource_mut::<Self>().motion_readers = motion_readers;
        will_be_read
    }

    /// Whether phase number `phase` needs component sync and does not have it yet.
    pub(super) fn needs_sync(&self, phase: usize) -> bool {
        let plan = &self.phases[phase];
        let reads = plan.has_commands && self.checks_commands || plan.needs.iter().any(|need| !need.reads.is_none());
        reads && !plan.is_synchronised
    }

    /// Starts to check commands, if observers or hooks of other crates have been added. Returns whether they have.
    pub(super) fn check_for_foreign_code(world: &mut World, observers: &mut ForeignObservers) -> bool {
        let has_come = !world.resource::<Self>().checks_commands && Self::has_foreign_code(world, observers);
        world.resource_mut::<Self>().checks_commands |= has_come;
        has_come
    }

    /// The plan of a schedule with initialised systems.
    ///
    /// # Errors
    /// If a system is in no phase, or if a system that uses a mirrored component is in a part of the engine.
    pub(super) fn of<V: Space>(graph: &ScheduleGraph, world: &mut World) -> Result<Self, Fault> {
        let reader = AccessReader::of::<V>(world);
        let phase_sets = PhaseSets::of(graph);
        let gates = world.get_resource_or_init::<PredictableConditions>();
        let mut phases = <[PhasePlan; Phase::ALL.len()]>::default();
        let mut checks_commands = false;
        for (key, system, conditions) in graph.systems.iter() {
            if system.system_type() == TypeId::of::<ApplyDeferred>() {
                continue;
            }
            let sets = ancestors(graph, key);
            let access = graph.systems.get(key).map(SystemWithAccess::access);
            let Some(phase) = phase_sets.phase(&sets) else {
                phase_sets.check_engine(&sets, &reader, access, &system.name().to_string())?;
                continue;
            };
            let of_sets = sets.iter().filter_map(|&set| graph.system_sets.get_conditions(set));
            let conditions: Vec<_> = of_sets.flatten().chain(conditions).collect();
            let gates = conditions.iter().filter_map(|one| gates.of(one.condition.system_type())).collect();
            phases[phase].needs.extend(reader.need(access.into_iter(), gates));
            // Conditions are evaluated even if a gate is closed.
            phases[phase].needs.extend(reader.need(conditions.iter().map(|one| &one.access), Vec::new()));
            phases[phase].has_commands |= system.has_deferred();
            checks_commands |= system.has_deferred() && !phase_sets.has_plain_commands(&sets);
        }
        let after_kick = || Phase::ALL.iter().zip(&phases).filter(|(phase, _)| AFTER_KICK.contains(phase));
        let needs = after_kick().flat_map(|(_, phase)| &phase.needs);
        let mut motion_readers: Vec<_> =
            needs.filter(|need| need.reads_motion).map(|need| need.gates.clone()).collect();
        motion_readers.sort_unstable();
        motion_readers.dedup();
        let has_commands = after_kick().any(|(_, phase)| phase.has_commands);
        Ok(Self {
            phases,
            motion_readers,
            has_commands,
            checks_commands,
            writes: MirrorSet::NONE,
            since: world.change_tick(),
            searched_components: 0,
            has_hooks: false,
        })
    }
}

/// The phases from the kick to the next drift.
const AFTER_KICK: [Phase; 5] = [Phase::Kick, Phase::Control, Phase::Cull, Phase::Observe, Phase::Spawn];
