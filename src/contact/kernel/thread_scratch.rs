//! What a thread keeps for itself from pass to pass, so that nothing is allocated in a step; and what it leaves to others.

use std::ops::Range;

use bevy_ecs::prelude::*;

use crate::contact::batch::Batch;
use crate::contact::history::HistoryBlock;
use crate::contact::{LawRequirements, Memory};
use crate::neighbours::list::BLOCK;
use crate::neighbours::list::{Candidate, PairList, Task};
use crate::space::Space;
use crate::walls::surfaces::WallLoad;

/// The place where a thread works.
#[derive(Debug, Default)]
pub struct ThreadScratch<V: Space> {
    /// The contacts at hand.
    pub batch: Batch<V>,
    /// What contacts of its rows with later ones remember, as it was before this pass.
    pub left: HistoryBlock<V>,
    /// The same, as it is after this pass.
    pub leaving: HistoryBlock<V>,
    /// Those rows.
    pub rows: Range<usize>,
    /// For pages that are written anew.
    pub spare: HistoryBlock<V>,
    /// What each wall gets of each block that has grains near any.
    pub on_walls: Vec<WallLoad<V>>,
}

/// One a thread.
#[derive(Resource, Debug, Default)]
pub struct ScratchPerThread<V: Space>(pub Vec<ThreadScratch<V>>);

/// What contacts across borders remembered after the last pass is what they do before this one: if nobody has changed it since, and
/// the borders are the same, it stands on the desks.
pub(super) fn exchange_halos<V: Space, L: LawRequirements>(
    scratches: &mut [ThreadScratch<V>],
    list: &PairList,
    pages: &[HistoryBlock<V>],
    goes_on: bool,
) {
    let tasks = list.tasks();
    if !goes_on || tasks.iter().zip(&*scratches).any(|(task, scratch)| task.rows != scratch.rows) {
        for (Task { rows, .. }, scratch) in tasks.iter().zip(&mut *scratches) {
            let own = &pages[rows.start / BLOCK..rows.end.div_ceil(BLOCK)];
            export_halo::<V, L>(rows, list, own, &mut scratch.leaving);
        }
    }
    for scratch in scratches {
        std::mem::swap(&mut scratch.left, &mut scratch.leaving);
    }
}

/// Copies what contacts of these rows with later ones remember, which stands in these pages.
pub(super) fn export_halo<V: Space, L: LawRequirements>(
    rows: &Range<usize>,
    list: &PairList,
    pages: &[HistoryBlock<V>],
    leaving: &mut HistoryBlock<V>,
) {
    leaving.clear();
    for (page, first) in pages.iter().zip(rows.clone().step_by(BLOCK)) {
        // In most blocks nobody has partners so far away.
        if list.block(first / BLOCK).1 > rows.end {
            leaving.copy::<L>(page, |contact| contact.second() >= rows.end);
        }
    }
}

/// What contacts with earlier rows remember: what the tasks of those have left.
#[derive(Clone)]
pub(super) struct HaloImport<'a, V: Space> {
    tasks: &'a [Task],
    left: &'a [&'a HistoryBlock<V>],
    /// Where the last one was that was asked for: in what which task has left, and at what place there.
    task: usize,
    at: usize,
}

impl<'a, V: Space> HaloImport<'a, V> {
    pub(super) fn new(tasks: &'a [Task], left: &'a [&'a HistoryBlock<V>]) -> Self {
        Self { tasks, left, task: 0, at: 0 }
    }

    /// The memory of a contact; they are asked for in ascending order.
    pub(super) fn next(&mut self, contact: Candidate) -> Option<Memory<V>> {
        while self.tasks[self.task].rows.end <= contact.first() {
            (self.task, self.at) = (self.task + 1, 0);
        }
        self.left[self.task].look_up_next(&mut self.at, contact)
    }
}
