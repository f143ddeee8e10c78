//! What a thread keeps for itself from pass to pass, so that nothing is allocated in a step.

use bevy_ecs::prelude::*;

use crate::contact::Demands;
use crate::contact::batch::Batch;
use crate::contact::history::{BLOCK, Pages};
use crate::neighbours::list::Candidate;
use crate::space::Space;

/// The place where a thread works.
#[derive(Debug, Default)]
pub struct Desk<V: Space> {
    /// The contacts at hand.
    pub batch: Batch<V>,
    /// What contacts with rows of others remember, as it was before this pass.
    pub arrived: Pages<V>,
    /// For pages that are written anew.
    pub spare: Pages<V>,
}

/// One a thread.
#[derive(Resource, Debug, Default)]
pub struct Desks<V: Space>(pub Vec<Desk<V>>);

impl<V: Space> Desks<V> {
    /// Where the thread works that steps.
    pub(crate) fn first(&mut self) -> &mut Desk<V> {
        if self.0.is_empty() {
            self.0.push(Desk::default());
        }
        &mut self.0[0]
    }
}

impl<V: Space> Desk<V> {
    /// Copies what contacts among those candidates remember.
    pub(super) fn welcome<L: Demands>(&mut self, incoming: &[Candidate], pages: &[Pages<V>]) {
        self.arrived.clear();
        for of_page in incoming.chunk_by(|one, next| one.first() / BLOCK == next.first() / BLOCK) {
            let (page, mut at) = (&pages[of_page[0].first() / BLOCK], 0);
            for &contact in of_page {
                if let Some(memory) = page.look_up_next(&mut at, contact) {
                    self.arrived.push::<L>(contact, &memory);
                }
            }
        }
    }
}
