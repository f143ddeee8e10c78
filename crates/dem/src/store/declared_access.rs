//! Access lists: finds the phase of a system, and the mirrored components that it uses.

use bevy_ecs::component::ComponentId;
use bevy_ecs::prelude::*;
use bevy_ecs::query::FilteredAccess;
use bevy_ecs::schedule::graph::Direction;
use bevy_ecs::schedule::{InternedSystemSet, NodeId, ScheduleGraph, SystemKey, SystemSetKey};
use bevy_ecs::system::SystemAccess;

use crate::bodies::Orientation;
use crate::particle::{Fixed, Force, Position, Velocity};
use crate::space::Space;
use crate::spin::{Spin, Torque};
use crate::step::{Part, Phase};
use crate::store::ParticleStore;
use crate::store::access_markers::{PlainCommands, ReadsMotion, ReadsPlaces};
use crate::store::mirror_set::MirrorSet;
use siloflow_text::fault::Fault;

fn no_phase_fault(system: &str) -> Fault {
    let phases: Vec<_> = Phase::ALL.iter().map(|phase| format!("{phase:?}")).collect();
    Fault::new("behaviour::no_phase", format!("the system `{system}` is in no phase of the step"))
        .help(format!("add `.in_set(Phase::...)`; the phases are {}", phases.join(", ")))
}

fn engine_fault(system: &str) -> Fault {
    let message =
        format!("the system `{system}` uses components in a part of the step that works on the particle store");
    Fault::new("behaviour::engine", message)
        .help("put it into a `Phase`; a system that adds a force belongs in `ForceStage::Added`")
}

/// The component use of systems that share their gates.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Need {
    pub(super) reads: MirrorSet,
    pub(super) writes: MirrorSet,
    /// Whether the systems use velocities and spins of grains, as components or in the store.
    pub(super) reads_motion: bool,
    /// The numbers of the gates: the systems run only if all are open.
    pub(super) gates: Vec<usize>,
}

/// All sets that contain a system.
pub(super) fn ancestors(graph: &ScheduleGraph, system: SystemKey) -> Vec<SystemSetKey> {
    let mut sets = Vec::new();
    let mut next = vec![NodeId::System(system)];
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
pub(super) struct PhaseSets {
    phases: Vec<Option<SystemSetKey>>,
    engine: Vec<SystemSetKey>,
    plain: Option<SystemSetKey>,
}

impl PhaseSets {
    pub(super) fn of(graph: &ScheduleGraph) -> Self {
        let key = |set: InternedSystemSet| graph.system_sets.get_key(set);
        let parts = |phase| [Part::Engine(phase), Part::Refresh(phase), Part::WriteBack(phase)];
        let parts =
            Phase::ALL.into_iter().flat_map(parts).chain([Part::Requests, Part::Renumber, Part::Sort, Part::End]);
        Self {
            phases: Phase::ALL.iter().map(|phase| key(phase.intern())).collect(),
            engine: parts.filter_map(|part| key(part.intern())).collect(),
            plain: key(PlainCommands.intern()),
        }
    }

    /// The number of the phase that is among these sets.
    pub(super) fn phase(&self, sets: &[SystemSetKey]) -> Option<usize> {
        self.phases.iter().position(|phase| phase.is_some_and(|phase| sets.contains(&phase)))
    }

    /// Whether commands of a system in these sets add no observer and no hook.
    pub(super) fn has_plain_commands(&self, sets: &[SystemSetKey]) -> bool {
        self.plain.is_some_and(|plain| sets.contains(&plain))
    }

    /// Checks a system that is in no phase.
    ///
    /// # Errors
    /// If the system is in no part of the engine, or if it is in one and uses components.
    pub(super) fn check_engine(
        &self,
        sets: &[SystemSetKey],
        reader: &AccessReader,
        access: Option<&SystemAccess>,
        system: &str,
    ) -> Result<(), Fault> {
        if !self.engine.iter().any(|part| sets.contains(part)) {
            return Err(no_phase_fault(system));
        }
        let shared = access.filter(|access| !access.is_exclusive());
        match reader.need(shared.into_iter(), Vec::new()) {
            Some(need) if !need.reads.is_none() => Err(engine_fault(system)),
            _ => Ok(()),
        }
    }
}

/// Numbers of grains that are half a step old while a kick is pending.
const MOTION: MirrorSet = MirrorSet::VELOCITY.or(MirrorSet::SPIN).and(MirrorSet::FREE);

/// Numbers that must not change while a kick and its energy balance are pending.
const NEEDED_BY_PENDING_KICK: MirrorSet = MirrorSet::ALL.without(MirrorSet::POSITION);

/// Tells whether an access list uses a mirrored component.
struct Probe {
    /// The component, of free or of fixed particles.
    mirrors: MirrorSet,
    /// An access that conflicts with any use of the component.
    uses: FilteredAccess,
    /// An access that conflicts with writes.
    writes: FilteredAccess,
}

/// Finds the mirrored components that an access list contains.
pub(super) struct AccessReader {
    /// One probe for each mirrored component of free particles, and one for each of fixed particles.
    probes: Vec<Probe>,
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
            (MirrorSet::ORIENTATION, world.register_component::<Orientation<V>>()),
        ];
        let probe = |kind: MirrorSet, component: ComponentId, among: MirrorSet| {
            let mut writes = FilteredAccess::matches_everything();
            if among == MirrorSet::FREE {
                writes.and_without(fixed);
            } else {
                writes.and_with(fixed);
            }
            let mut reads = writes.clone();
            // Write access conflicts with every reader and writer; read access conflicts with writers only.
            writes.add_write(component);
            reads.add_read(component);
            Probe { mirrors: kind.and(among), uses: writes, writes: reads }
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

    /// The needs of systems or conditions with this access; `None` if they use neither mirrored components nor
    /// velocities.
    pub(super) fn need<'a>(&self, all: impl Iterator<Item = &'a SystemAccess>, gates: Vec<usize>) -> Option<Need> {
        let mut need = Need { reads: MirrorSet::NONE, writes: MirrorSet::NONE, reads_motion: false, gates };
        for access in all {
            let conflicts_with = |probe: &FilteredAccess| !access.get_conflicts_single(probe).is_empty();
            for Probe { mirrors, uses, writes } in &self.probes {
                if conflicts_with(uses) {
                    need.reads.add(*mirrors);
                }
                if conflicts_with(writes) {
                    need.writes.add(*mirrors);
                }
            }
            // A system that reads the store without a marker resource is assumed to read everything.
            need.reads_motion |=
                conflicts_with(&self.motion) || (conflicts_with(&self.store) && !conflicts_with(&self.places));
        }
        need.reads_motion |= need.reads.meets(MOTION) || need.writes.meets(NEEDED_BY_PENDING_KICK);
        (need.reads_motion || !need.reads.is_none()).then_some(need)
    }
}
