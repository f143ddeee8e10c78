//! The present numbers of a run, for curves.

use serde::Serialize;
use siloflow::cli::sliced::Slice;
use siloflow::dem::outcome::{End, Outcome};
use siloflow::dem::step::Clock;
use siloflow::door::DoorState;
use siloflow::lattice::gas::Gas;
use siloflow::lattice_silo;
use siloflow::ledger::Ledger;
use siloflow::measure::totals::{self, Totals};
use siloflow::prelude::World;
use siloflow::rest::RestDetector;

/// The events of a run so far.
#[derive(Clone, Copy, PartialEq, Eq, Serialize)]
pub struct Events {
    /// Whether grains have come to rest.
    is_at_rest: bool,
    /// How often a door has begun to open or to shut.
    doors: usize,
    /// Whether a grain has left.
    is_flowing: bool,
}

impl Events {
    pub fn of(world: &World) -> Self {
        match world.get_resource::<Gas>() {
            Some(gas) => Self {
                is_at_rest: world
                    .get_resource::<lattice_silo::rest::RestDetector>()
                    .is_some_and(|rest| rest.rest_step.is_some()),
                doors: world
                    .get_resource::<lattice_silo::door::DoorState>()
                    .map_or(0, |door| door.open_step.is_some().into()),
                is_flowing: gas.out() > 0,
            },
            None => Self {
                is_at_rest: world.get_resource::<RestDetector>().is_some_and(|rest| rest.rest_time.is_some()),
                doors: world.get_resource::<DoorState>().map_or(0, DoorState::turns),
                is_flowing: world.resource::<Ledger>().out() > 0,
            },
        }
    }
}

/// Grains whose departures give the present outflow, and the fewest: of two alone it would be one over a chance interval.
const WINDOW: u32 = 20;
const FEWEST: u32 = 10;

/// The outflow since the last [`WINDOW`] departures, grains/s; 0 before there are [`FEWEST`].
fn outflow(ledger: &Ledger, now: f64) -> f64 {
    let departures = &ledger.departures;
    let last = departures.count().saturating_sub(1);
    let since = departures
        .nearest(last.saturating_sub(WINDOW))
        .filter(|departure| departure.number + FEWEST <= last && departure.time < now);
    since.map_or(0.0, |since| f64::from(last - since.number) / (now - since.time))
}

/// The present numbers, SI. Of the lattice gas `time` counts steps, and there are no totals.
#[derive(Serialize)]
pub struct Sample {
    time: f64,
    steps: u64,
    released: u64,
    inside: u64,
    out: u64,
    lost: u64,
    /// Grains/s.
    outflow: Option<f64>,
    totals: Option<Totals>,
    events: Events,
    is_reached: bool,
    /// Why the run has ended, as `status` in `summary.json`.
    status: Option<&'static str>,
    failure: Option<String>,
}

impl Sample {
    pub fn of(world: &World, slice: Slice) -> Self {
        let clock = world.resource::<Clock>();
        let end = world.resource::<Outcome>().end();
        let counts = if let Some(gas) = world.get_resource::<Gas>() {
            [gas.entered(), gas.inside(), gas.out(), 0]
        } else {
            let ledger = world.resource::<Ledger>();
            [ledger.released, ledger.inside(), ledger.out(), ledger.lost()].map(u64::from)
        };
        let [released, inside, out, lost] = counts;
        let is_lattice = world.contains_resource::<Gas>();
        Self {
            time: clock.time(),
            steps: clock.steps,
            released,
            inside,
            out,
            lost,
            outflow: world.get_resource::<Ledger>().map(|ledger| outflow(ledger, clock.time())),
            totals: (!is_lattice).then(|| totals::of_world(world)),
            events: Events::of(world),
            is_reached: slice == Slice::Reached,
            status: end.map(End::word),
            failure: match end {
                Some(End::Failed(failure)) => Some(failure.to_string()),
                _ => None,
            },
        }
    }
}
