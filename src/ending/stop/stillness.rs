//! Whether the flow has stopped, for the conditions of `stop` and for kicks.

use crate::door::DoorState;
use crate::ending::stop::avalanches::Avalanches;
use crate::ledger::Ledger;
use siloflow_dem::step::Clock;

/// Whether the door is open, and for `still` (s) no grain has left, the door has not begun to open, and no kick has ended.
pub(super) fn is_still(
    clock: &Clock,
    ledger: &Ledger,
    door: Option<&DoorState>,
    avalanches: Option<&Avalanches>,
    still: f64,
) -> bool {
    let last_out = ledger.departures.last();
    let kick = avalanches.and_then(|avalanches| avalanches.kick_end);
    let open = door.and_then(DoorState::open_time);
    open.is_some_and(|open| clock.has_reached(last_out.into_iter().chain(kick).fold(open, f64::max) + still))
}
