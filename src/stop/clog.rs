//! Ends a run when the outlet is clogged: the door is open, no grain has left for a time, and grains are above the outlet.
//!
//! A grain is above an outlet if its centre is inside the silo and between the ends of the door along every horizontal axis. Dead zones
//! beside the outlet therefore are no clog, and neither is an empty channel above it. The avalanche is what has left since the
//! door began to open.
//!
//! Limit: a door in a side wall has no extent along one horizontal axis, so no grain counts as above it.

use std::marker::PhantomData;

use bevy_app::{App, Plugin};
use bevy_ecs::prelude::*;

use crate::door::DoorState;
use crate::ending::{Endings, end_at_time, end_when_empty};
use crate::ledger::{GrainsAccounted, Ledger};
use crate::outcome::{End, Outcome};
use crate::particles::Particles;
use crate::space::{Solid, Space};
use crate::step::{Clock, Phase, Step, time_moves};
use crate::stop::kick::Avalanches;
use crate::stop::{end_by_flow, is_still};

/// The scene's condition, and the boxes around its doors, m.
#[derive(Resource)]
struct Outlets {
    still: f64,
    boxes: Vec<[Solid; 2]>,
}

/// Run condition: the door is open, and no grain has left for a time.
fn has_stopped(
    (clock, outlets, ledger): (Res<Clock>, Res<Outlets>, Res<Ledger>),
    door: Option<Res<DoorState>>,
    avalanches: Option<Res<Avalanches>>,
) -> bool {
    is_still(&clock, &ledger, door.as_deref(), avalanches.as_deref(), outlets.still)
}

/// Returns the number of grains inside that are above one of these outlets, given by the boxes around their doors, m.
pub(super) fn count_above<V: Space>(particles: &Particles<V>, ledger: &Ledger, boxes: &[[Solid; 2]]) -> u32 {
    let is_above = |row: usize| {
        let x = particles.position(row).spread();
        let axes = 0..V::COMPONENTS - 1;
        boxes.iter().any(|[low, high]| axes.clone().all(|axis| low[axis] < x[axis] && x[axis] < high[axis]))
    };
    let inside = particles.grains().filter(|&row| !ledger.is_gone(particles.id(row)));
    u32::try_from(inside.filter(|&row| is_above(row)).count()).unwrap_or(u32::MAX)
}

fn end_by_clog<V: Space>(
    (outlets, ledger): (Res<Outlets>, Res<Ledger>),
    particles: Particles<V>,
    mut outcome: ResMut<Outcome>,
) {
    let above = count_above(&particles, &ledger, &outlets.boxes);
    if above > 0 {
        outcome.finish(End::Clogged { still_s: outlets.still, above, avalanche: ledger.out() });
    }
}

/// Ends the run at a clog.
pub struct ClogPlugin<V: Space> {
    /// Time without a grain that leaves, s.
    pub still: f64,
    /// The boxes around the doors, m.
    pub boxes: Vec<[Solid; 2]>,
    /// The space.
    pub space: PhantomData<V>,
}

impl<V: Space> Plugin for ClogPlugin<V> {
    fn build(&self, app: &mut App) {
        app.insert_resource(Outlets { still: self.still, boxes: self.boxes.clone() }).add_systems(
            Step,
            end_by_clog::<V>
                .in_set(Phase::Cull)
                .in_set(Endings)
                .after(GrainsAccounted)
                .after(end_when_empty)
                .before(end_by_flow)
                .before(end_at_time)
                .run_if(has_stopped)
                .run_if(time_moves),
        );
    }
}
