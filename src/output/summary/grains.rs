//! The results of a run of grains in `summary.json`.
//!
//! Times are in simulated seconds unless the key says `wall`. Energies are in J. `null` marks an event that did not happen or a
//! quantity that the scene does not measure.

use std::ops::Add;

use bevy_ecs::prelude::*;
use serde::Serialize;

use crate::door::DoorState;
use crate::ending::regular::EmptyTime;
use crate::ending::stop::avalanches::{Avalanche, Avalanches};
use crate::energy::{Channels, EnergyFlows};
use crate::grain_requests::{self, RequestFigures};
use crate::grains::feed::FeedFigures;
use crate::grains::spawner::ReleaseDelays;
use crate::ledger::{Ledger, LossRecord};
use crate::measure::bed::BedFigures;
use crate::measure::discharge::Discharge;
use crate::measure::outflow::OutflowFigures;
use crate::measure::outputs::{self, Values};
use crate::measure::totals;
use crate::output::free_walls::{self, FreeWallFigures};
use crate::output::losses::IN_SUMMARY;
use crate::output::parent::Parent;
use crate::output::slopes::{self, SlopeFigures};
use crate::output::summary::{Cost, Results, Summary};
use crate::output::{outflow, state_hash};
use crate::rest::RestDetector;
use crate::scene::loaded::Loaded;
use crate::writers::memory::peak_memory;
use crate::writers::provenance::Provenance;
use siloflow_dem::contact::{Contact, LargestOverlap};
use siloflow_dem::integrate::Integrator;
use siloflow_dem::neighbours::Rebuilds;
use siloflow_dem::outcome::End;
use siloflow_dem::persist::CheckpointFigures;
use siloflow_dem::space::{Dimension, Plane, Solid, Space};
use siloflow_dem::step::Clock;
use siloflow_dem::store::ParticleStore;
use siloflow_dem::threads::Threads;
use siloflow_dem::values::Share;

/// The results of a run of grains.
#[derive(Debug, Serialize)]
pub struct GrainResults {
    /// Simulated time, s.
    pub time_s: f64,
    /// Grain accounting.
    pub grains: Grains,
    /// The condition of the scene's `stop` that ended the run, in words.
    pub stop: Option<String>,
    /// The avalanches that ended with a kick. The key is absent if the scene has no `kick`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub avalanches: Option<Vec<Avalanche>>,
    /// The clog that ended the run. The key is absent if none did.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub clog: Option<Clog>,
    /// Time at which the bed came to rest, s.
    pub rest_time_s: Option<f64>,
    /// Time at which the door began to open, s.
    pub door_open_time_s: Option<f64>,
    /// Time at which the last grain left the inside, s.
    pub empty_time_s: Option<f64>,
    /// Largest overlap of the whole run, over the smaller radius of the pair.
    pub max_overlap_ratio: f64,
    /// Coordination number at the end: mean number of contacts of a grain with grains and walls.
    pub coordination: f64,
    /// The bed at rest, if the scene measures it.
    pub bed: Option<BedFigures>,
    /// Flow through the orifice.
    pub discharge: Option<Discharge>,
    /// Figures of the discharge in the window `outflow`. The key is absent if the scene has none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub outflow: Option<OutflowFigures>,
    /// Figures of each feed. The key is absent if the scene has no feed.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub feed: Option<FeedFigures>,
    /// Delayed releases.
    pub releases: Option<ReleaseDelays>,
    /// The free walls at the end. The key is absent if the scene has none.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub free_walls: Vec<FreeWallFigures>,
    /// Mean slopes of free surfaces. The key is absent if the scene has none.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub slopes: Vec<SlopeFigures>,
    /// Energy balance, J.
    pub energy: Energy,
    /// Values that behaviours register, by behaviour and name. The key is absent without one.
    #[serde(skip_serializing_if = "Values::is_empty")]
    pub behaviours: Values,
    /// Figures of the requests of behaviours, by reason. The key is absent without a request.
    #[serde(skip_serializing_if = "RequestFigures::is_empty")]
    pub requests: RequestFigures,
    /// Contact law.
    pub contact: Contact,
    /// Share by which radii are larger than the scene says, at the same masses. The key is absent if the scene has no `growth`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub growth: Option<f64>,
    /// Cost of the run.
    pub performance: Performance,
    /// Version, command, date and machine; `null` unless `siloflow run` wrote the summary.
    pub provenance: Option<Provenance>,
    /// The run from whose state this run started; `null` if it started by itself.
    pub parent: Option<Parent>,
    /// Checkpoints during the run; `null` if none was taken.
    pub checkpoints: Option<CheckpointFigures>,
    /// Hash of the final state of the grains, as 16 hexadecimal digits.
    pub state_hash: String,
    /// Records of the first hundred lost grains.
    pub losses: Vec<LossRecord>,
}

/// Grain accounting: released = inside + out + lost + removed.
#[derive(Debug, Serialize)]
pub struct Grains {
    /// Grains that entered.
    pub released: u32,
    /// Grains that are neither out nor lost.
    pub inside: u32,
    /// Mass of the grains that are neither out nor lost, kg.
    pub inside_kg: f64,
    /// Grains that left through the orifice.
    pub out: u32,
    /// Mass of the grains that left through the orifice, kg.
    pub out_kg: f64,
    /// Grains that left in any other way.
    pub lost: u32,
    /// Grains that requests of behaviours have removed. The key is absent if there were no requests.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub removed: Option<u32>,
}

/// A clog.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Clog {
    /// Grains above the outlet.
    pub grains_above: u32,
    /// Grains that left between the opening of the door and the clog.
    pub avalanche_grains: u32,
}

/// The energy balance, J.
///
/// kinetic + rotational + potential + elastic
/// = released + `wall_work` + lifted + `added_work` - dissipated - removed + `balance_error`.
#[derive(Debug, Serialize)]
pub struct Energy {
    /// Kinetic energy of translation at the end.
    pub kinetic: f64,
    /// Kinetic energy of rotation at the end.
    pub rotational: f64,
    /// Potential energy at the end; 0 at the origin.
    pub potential: f64,
    /// Elastic energy at the end.
    pub elastic: f64,
    /// Energy flows of the whole run. Their keys are absent if the scene does not track the energy balance.
    #[serde(flatten)]
    pub flows: Option<EnergyFlows>,
    /// Parts of `dissipated` due to friction and rolling resistance, if grains spin.
    pub channels: Option<Channels>,
    /// Difference of the two sides, if the scene tracks the energy balance.
    pub balance_error: Option<f64>,
}

/// Cost of a run.
#[derive(Debug, Serialize)]
pub struct Performance {
    /// Wall-clock time of the steps, s.
    pub wall_s: f64,
    /// Sum over all steps of the number of free grains.
    pub particle_steps: u64,
    /// `particle_steps` over `wall_s`, 1/s.
    pub particle_steps_per_s: f64,
    /// Largest resident set of the program up to the end of the last step, bytes.
    ///
    /// It includes set-up and is `null` if the operating system does not report it.
    pub peak_memory_bytes: Option<u64>,
    /// Number of times that the cell grid was filled or the neighbour list was rebuilt.
    pub neighbour_rebuilds: u64,
    /// Number of threads of the force pass.
    pub threads: usize,
    /// Integration scheme.
    pub integrator: Integrator,
}

/// Returns the number of free grains of a world, for [`Cost::updates`].
#[must_use]
pub fn free_grains(world: &World) -> usize {
    match Dimension::of_world(world) {
        Dimension::Plane => world.resource::<ParticleStore<Plane>>().integrated_rows().len(),
        Dimension::Solid => world.resource::<ParticleStore<Solid>>().integrated_rows().len(),
    }
}

/// The condition of `stop` that ended a run, in words.
fn stop_in_words(loaded: &Loaded, end: &End) -> Option<String> {
    match end {
        End::AtRest => Some("the bed is at rest".to_owned()),
        End::FlowEnded { still_s } => Some(format!("no grain has left for {still_s} s")),
        End::Clogged { still_s, above, .. } => {
            Some(format!("the outlet is clogged: no grain has left for {still_s} s, and {above} are above it"))
        }
        End::OutReached { count } => Some(format!("{count} grains have left")),
        _ => None,
    }
    .filter(|_| !loaded.scene.stop_conditions().is_empty())
}

/// Mass of the grains that are neither out nor lost, kg, summed in the order of slots.
fn mass_inside(world: &World) -> f64 {
    fn of<V: Space>(world: &World) -> f64 {
        let store = world.resource::<ParticleStore<V>>();
        let ledger = world.resource::<Ledger>();
        let is_inside =
            |row: &usize| !store.id[*row].is_wall() && store.is_present(*row) && !ledger.is_gone(store.id[*row]);
        (0..store.id.len()).filter(is_inside).map(|row| store.mass[row]).fold(0.0, Add::add)
    }
    match Dimension::of_world(world) {
        Dimension::Plane => of::<Plane>(world),
        Dimension::Solid => of::<Solid>(world),
    }
}

impl Results for GrainResults {
    const METHOD: Option<&'static str> = None;

    fn lost(&self) -> u32 {
        self.grains.lost
    }
}

impl Summary<GrainResults> {
    /// Returns the summary of a run that ended with `end`.
    pub fn of_grains(
        world: &mut World,
        loaded: &Loaded,
        end: &End,
        cost: Cost,
        provenance: Option<Provenance>,
    ) -> Self {
        let results = GrainResults::of(world, loaded, end, cost, provenance);
        Self::new(world, &loaded.source, &loaded.scene.parameters, end, results)
    }
}

impl GrainResults {
    /// Returns the results of a run that ended with `end`.
    fn of(world: &mut World, loaded: &Loaded, end: &End, cost: Cost, provenance: Option<Provenance>) -> Self {
        let totals = totals::of_world(world);
        let state_hash = format!("{:016x}", state_hash::of_world(world));
        let behaviours = outputs::summary_values(world);
        let requests = grain_requests::figures(world);
        let ledger = world.resource::<Ledger>();
        let flows = world.get_resource::<EnergyFlows>().copied();
        Self {
            time_s: world.resource::<Clock>().time(),
            grains: Grains {
                released: ledger.released,
                inside: ledger.inside(),
                inside_kg: mass_inside(world),
                out: ledger.out(),
                out_kg: ledger.departures.mass(),
                lost: ledger.lost(),
                removed: (!requests.is_empty()).then_some(ledger.removed),
            },
            stop: stop_in_words(loaded, end),
            avalanches: world.get_resource::<Avalanches>().map(|avalanches| avalanches.all.clone()),
            clog: match *end {
                End::Clogged { above, avalanche, .. } => {
                    Some(Clog { grains_above: above, avalanche_grains: avalanche })
                }
                _ => None,
            },
            rest_time_s: world.get_resource::<RestDetector>().and_then(|rest| rest.rest_time),
            door_open_time_s: world.get_resource::<DoorState>().and_then(DoorState::open_time),
            empty_time_s: world.resource::<EmptyTime>().0,
            max_overlap_ratio: world.resource::<LargestOverlap>().0,
            coordination: totals.coordination,
            bed: world.get_resource().copied(),
            discharge: Discharge::of(ledger),
            outflow: outflow::figures(world),
            feed: world.get_resource().cloned(),
            releases: world.get_resource().copied(),
            free_walls: free_walls::figures(world),
            slopes: slopes::figures(world),
            energy: Energy {
                kinetic: totals.kinetic,
                rotational: totals.rotational,
                potential: totals.potential,
                elastic: totals.elastic,
                flows,
                channels: world.get_resource().copied(),
                balance_error: flows.map(|flows| totals.energy() - flows.expected()),
            },
            behaviours,
            requests,
            contact: loaded.scene.contact,
            growth: loaded.scene.growth.map(Share::get),
            performance: Performance {
                wall_s: cost.wall_s,
                particle_steps: cost.updates,
                particle_steps_per_s: cost.updates_per_s(),
                peak_memory_bytes: peak_memory(),
                neighbour_rebuilds: world.resource::<Rebuilds>().0,
                threads: world.resource::<Threads>().count(),
                integrator: loaded.scene.integrator,
            },
            provenance,
            parent: world.get_resource().cloned(),
            checkpoints: world.get_resource().copied(),
            state_hash,
            losses: ledger.lost.iter().take(IN_SUMMARY).cloned().collect(),
        }
    }
}
