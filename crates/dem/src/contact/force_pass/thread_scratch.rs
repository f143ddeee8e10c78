//! Thread scratch: buffers that persist between passes, so that a step allocates little.

use bevy_ecs::prelude::*;

use crate::contact::batch::Batch;
use crate::contact::held_forces::HeldForces;
use crate::contact::history::HistoryBlock;
use crate::space::Space;
use crate::walls::surface_wall::WallLoad;

/// The buffers of one thread.
#[derive(Debug, Default)]
pub struct ThreadScratch<V: Space> {
    /// The current batch of contacts.
    pub batch: Batch<V>,
    /// Forces on particles of earlier tasks.
    pub outgoing: HeldForces<V>,
    /// Forces of walls on particles that wait for forces of later tasks.
    pub of_walls: HeldForces<V>,
    /// Spare history block for blocks that are rewritten.
    pub spare: HistoryBlock,
    /// Loads of the contacts with walls, each with the index of its wall, in ascending order of rows.
    pub on_walls: Vec<(usize, WallLoad<V>)>,
}

/// The scratch of each thread.
#[derive(Resource, Debug, Default)]
pub struct ScratchPerThread<V: Space>(pub Vec<ThreadScratch<V>>);
