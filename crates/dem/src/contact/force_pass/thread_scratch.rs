//! Thread scratch: buffers that persist between passes, so that a step allocates nothing; and the halo export, import
//! and exchange of memories between threads.

use std::ops::Range;

use bevy_ecs::prelude::*;

use crate::contact::batch::{Batch, MemoryLanes};
use crate::contact::history::HistoryBlock;
use crate::contact::memory::MemoryLayout;
use crate::neighbours::list::BLOCK;
use crate::neighbours::list::{Candidate, PairList, Task};
use crate::space::Space;
use crate::walls::surface_wall::WallLoad;

/// The buffers of one thread.
#[derive(Debug, Default)]
pub struct ThreadScratch<V: Space> {
    /// The current batch of contacts.
    pub batch: Batch<V>,
    /// Memories of the contacts of own rows with later rows, as before this pass. Other threads import them.
    pub halo: HistoryBlock,
    /// Memories of the contacts of own rows with later rows, as after this pass.
    pub next_halo: HistoryBlock,
    /// Own rows in the last pass.
    pub rows: Range<usize>,
    /// Spare history block for blocks that are rewritten.
    pub spare: HistoryBlock,
    /// Loads of the contacts with walls, each with the index of its wall, in ascending order of rows.
    pub on_walls: Vec<(usize, WallLoad<V>)>,
}

/// The scratch of each thread.
#[derive(Resource, Debug, Default)]
pub struct ScratchPerThread<V: Space>(pub Vec<ThreadScratch<V>>);

/// The scratch that a pass takes over from the last one.
pub struct KeptScratches<'a, V: Space> {
    /// The scratch of each thread.
    pub scratches: &'a mut Vec<ThreadScratch<V>>,
    /// Whether the contact history is as the last pass with this scratch has left it.
    pub history_unchanged: bool,
}

/// Makes the exports of the last pass the imports of this pass. The exports are made again if the history has changed
/// since (`history_unchanged` is false) or the rows of the tasks have changed.
pub(super) fn exchange_halos<V: Space>(
    scratches: &mut [ThreadScratch<V>],
    list: &PairList,
    histories: &[HistoryBlock],
    layout: &MemoryLayout,
    history_unchanged: bool,
) {
    let tasks = list.tasks();
    if !history_unchanged || tasks.iter().zip(&*scratches).any(|(task, scratch)| task.rows != scratch.rows) {
        for (Task { rows, .. }, scratch) in tasks.iter().zip(&mut *scratches) {
            let own = &histories[rows.start / BLOCK..rows.end.div_ceil(BLOCK)];
            export_halo(rows, list, own, layout, &mut scratch.next_halo);
        }
    }
    for scratch in scratches {
        std::mem::swap(&mut scratch.halo, &mut scratch.next_halo);
    }
}

/// Copies the memories of contacts of `rows` with later rows from the history blocks of `rows` into `next_halo`.
pub(super) fn export_halo(
    rows: &Range<usize>,
    list: &PairList,
    histories: &[HistoryBlock],
    layout: &MemoryLayout,
    next_halo: &mut HistoryBlock,
) {
    next_halo.clear();
    for (history, first) in histories.iter().zip(rows.clone().step_by(BLOCK)) {
        // In most blocks no particle has a partner in later rows.
        if list.block(first / BLOCK).1 > rows.end {
            next_halo.copy(layout, history, |contact| contact.second() >= rows.end);
        }
    }
}

/// Halo import: memories of contacts with earlier rows, from the exports of the tasks that own the earlier rows.
#[derive(Clone)]
pub(super) struct HaloImport<'a> {
    tasks: &'a [Task],
    halo: &'a [&'a HistoryBlock],
    /// Position of the last look-up: the exporting task and the place in its export.
    task: usize,
    at: usize,
}

impl<'a> HaloImport<'a> {
    pub(super) fn new(tasks: &'a [Task], halo: &'a [&'a HistoryBlock]) -> Self {
        Self { tasks, halo, task: 0, at: 0 }
    }

    /// Loads the memory of a contact into a lane; that of a new contact is empty. Calls must be in ascending order of contacts.
    pub(super) fn load(&mut self, contact: Candidate, layout: &MemoryLayout, lane: usize, memories: &mut MemoryLanes) {
        while self.tasks[self.task].rows.end <= contact.first() {
            self.task += 1;
            self.at = 0;
        }
        let halo = self.halo[self.task];
        match halo.next_position(&mut self.at, contact) {
            Some(at) => halo.read_one(layout, at, lane, memories),
            None => memories.clear(layout, lane),
        }
    }
}
