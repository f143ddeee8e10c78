//! Access lists: in which phase a system stands, and which mirrored components it uses.

use bevy_ecs::component::ComponentId;
use bevy_ecs::prelude::*;
use bevy_ecs::query::FilteredAccess;
use bevy_ecs::schedule::graph::Direction;
use bevy_ecs::schedule::{InternedSystemSet, NodeId, ScheduleGraph, SystemKey, SystemSetKey};
use bevy_ecs::system::SystemAccess;

use crate::fault::Fault;
use crate::particle::{Fixed, Force, Position, Velocity};
use crate::space::Space;
use crate::spin::{Spin, Torque};
use crate::step::{Part, Phase};
use crate::store::ParticleStore;
use crate::store::mirror::MirrorSet;
use crate::store::sync_plan::{Need, PlainCommands, ReadsMotion, ReadsPlaces};

fn in_no_phase(system: &str) -> Fault {
    let phases: Vec<_> = Phase::ALL.iter().map(|phase| format!("{phase:?}")).collect();
    Fault::new("behaviour::no_phase", format!("the system `{system}` stands in no phase of the step"))
        .help(format!("add `.in_set(Phase::...)`; the phases are {}", phases.join(", ")))
}

fn in_the_engine(system: &str) -> Fault {
    let message = format!("the system `{system}` uses components in a part of the step that works on the store");
    Fault::new("behaviour::engine", message)
        .help("put it into a `Phase`; a system that adds a force belongs in `ForceStage::Added`")
}

/// All sets that a system is in.
pub(super) fn ancestors(graph: &ScheduleGraph, system: SystemKey) -> Vec<SystemSetKey> {
    let (mut sets, mut next) = (Vec::new(), vec![NodeId::System(system)]);
    while let Some(node) = next.pop() {
        for parent in graph.hierarchy().neighbors_directed(node, Direction::Incoming) {
            if let NodeId::Set(set) = parent
                && !sets.contains(&set)
            {
                sets.push(set);
                next.push(parent);
            }
        }
    }
    sets
}

/// The sets of the phases and of the engine.
pub(super) struct Places {
    phases: Vec<Option<SystemSetKey>>,
    engine: Vec<SystemSetKey>,
    plain: Option<SystemSetKey>,
}

impl Places {
    pub(super) fn of(graph: &ScheduleGraph) -> Self {
        let key = |set: InternedSystemSet| graph.system_sets.get_key(set);
        let parts = |phase| [Part::Engine(phase), Part::Refresh(phase), Part::WriteBack(phase)];
        let parts = Phase::ALL.into_iter().flat_map(parts).chain([Part::Renumber, Part::Sort, Part::End]);
        Self {
            phases: Phase::ALL.iter().map(|phase| key(phase.intern())).collect(),
            engine: parts.filter_map(|part| key(part.intern())).collect(),
            plain: key(PlainCommands.intern()),
        }
    }

    /// The number of the phase that a system in these sets stands in.
    pub(super) fn phase(&self, sets: &[SystemSetKey]) -> Option<usize> {
        self.phases.iter().position(|phase| phase.is_some_and(|phase| sets.contains(&phase)))
    }

    /// Whether commands of a system in these sets add no observer and no hook.
    pub(super) fn has_plain_commands(&self, sets: &[SystemSetKey]) -> bool {
        self.plain.is_some_and(|plain| sets.contains(&plain))
    }

    /// Checks a system that stands in no phase.
    ///
    /// # Errors
    /// If it stands in no part of the engine either, or does and uses components.
    pub(super) fn check_engine(
        &self,
        sets: &[SystemSetKey],
        reader: &AccessReader,
        access: Option<&SystemAccess>,
        system: &str,
    ) -> Result<(), Fault> {
        if !self.engine.iter().any(|part| sets.contains(part)) {
            return Err(in_no_phase(system));
        }
        let shared = access.filter(|access| !access.is_exclusive());
        match reader.need(shared.into_iter(), Vec::new()) {
            Some(need) if !need.reads.is_none() => Err(in_the_engine(system)),
            _ => Ok(()),
        }
    }
}

/// Numbers of grains that a kick which is put off leaves half a step old.
const MOTION: MirrorSet = MirrorSet::VELOCITY.or(MirrorSet::SPIN).and(MirrorSet::FREE);

/// Numbers that must not change before a kick that was put off and its books are done.
const DUE: MirrorSet = MirrorSet::ALL.without(MirrorSet::POSITION);

/// What tells which components an access list contains.
pub(super) struct AccessReader {
    /// Reading and writing each component of free and of fixed particles.
    probes: Vec<(MirrorSet, FilteredAccess, FilteredAccess)>,
    store: FilteredAccess,
    places: FilteredAccess,
    motion: FilteredAccess,
}

impl AccessReader {
    pub(super) fn of<V: Space>(world: &mut World) -> Self {
        let fixed = world.register_component::<Fixed>();
        let components = [
            (MirrorSet::POSITION, world.register_component::<Position<V>>()),
            (MirrorSet::VELOCITY, world.register_component::<Velocity<V>>()),
            (MirrorSet::FORCE, world.register_component::<Force<V>>()),
            (MirrorSet::SPIN, world.register_component::<Spin<V::Spin>>()),
            (MirrorSet::TORQUE, world.register_component::<Torque<V::Spin>>()),
        ];
        let probe = |kind: MirrorSet, component: ComponentId, among: MirrorSet| {
            let mut writes = FilteredAccess::matches_everything();
            if among == MirrorSet::FREE {
                writes.and_without(fixed);
            } else {
                writes.and_with(fixed);
            }
            let mut reads = writes.clone();
            // A write meets all that read or write, a read all that write.
            writes.add_write(component);
            reads.add_read(component);
            (kind.and(among), writes, reads)
        };
        let both = [MirrorSet::FREE, MirrorSet::FIXED];
        let probes = components
            .into_iter()
            .flat_map(|(kind, component)| both.map(|among| probe(kind, component, among)))
            .collect();
        let resource = |component: ComponentId| {
            let mut writes = FilteredAccess::matches_everything();
            writes.add_write(component);
            writes
        };
        Self {
            probes,
            store: resource(world.register_component::<ParticleStore<V>>()),
            places: resource(world.register_component::<ReadsPlaces>()),
            motion: resource(world.register_component::<ReadsMotion>()),
        }
    }

    /// What systems or conditions with this access need, if anything.
    pub(super) fn need<'a>(&self, all: impl Iterator<Item = &'a SystemAccess>, gates: Vec<usize>) -> Option<Need> {
        let mut need = Need { reads: MirrorSet::NONE, writes: MirrorSet::NONE, looks_at_motion: false, gates };
        for access in all {
            let meets = |probe: &FilteredAccess| !access.get_conflicts_single(probe).is_empty();
            for (mirrors, uses, writes) in &self.probes {
                if meets(uses) {
                    need.reads.add(*mirrors);
                }
                if meets(writes) {
                    need.writes.add(*mirrors);
                }
            }
            // Who reads the store without saying what for looks at everything.
            need.looks_at_motion |= meets(&self.motion) || (meets(&self.store) && !meets(&self.places));
        }
        need.looks_at_motion |= need.reads.meets(MOTION) || need.writes.meets(DUE);
        (need.looks_at_motion || !need.reads.is_none()).then_some(need)
    }
}
