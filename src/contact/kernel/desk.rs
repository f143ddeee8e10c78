//! What a thread keeps for itself from pass to pass, so that nothing is allocated in a step; and what it leaves to others.

use std::ops::Range;

use bevy_ecs::prelude::*;

use crate::contact::batch::Batch;
use crate::contact::history::Pages;
use crate::contact::{Demands, Memory};
use crate::neighbours::list::BLOCK;
use crate::neighbours::list::{Candidate, PairList, Task};
use crate::space::Space;
use crate::walls::surfaces::WallLoad;

/// The place where a thread works.
#[derive(Debug, Default)]
pub struct Desk<V: Space> {
    /// The contacts at hand.
    pub batch: Batch<V>,
    /// What contacts of its rows with later ones remember, as it was before this pass.
    pub left: Pages<V>,
    /// The same, as it is after this pass.
    pub leaving: Pages<V>,
    /// Those rows.
    pub rows: Range<usize>,
    /// For pages that are written anew.
    pub spare: Pages<V>,
    /// What each wall gets of each block that has grains near any.
    pub on_walls: Vec<WallLoad<V>>,
}

/// One a thread.
#[derive(Resource, Debug, Default)]
pub struct Desks<V: Space>(pub Vec<Desk<V>>);

/// What contacts across borders remembered after the last pass is what they do before this one: if nobody has changed it since, and
/// the borders are the same, it stands on the desks.
pub(super) fn get_ready<V: Space, L: Demands>(
    desks: &mut [Desk<V>],
    list: &PairList,
    pages: &[Pages<V>],
    goes_on: bool,
) {
    let tasks = list.tasks();
    if !goes_on || tasks.iter().zip(&*desks).any(|(task, desk)| task.rows != desk.rows) {
        for (Task { rows, .. }, desk) in tasks.iter().zip(&mut *desks) {
            let own = &pages[rows.start / BLOCK..rows.end.div_ceil(BLOCK)];
            see_off::<V, L>(rows, list, own, &mut desk.leaving);
        }
    }
    for desk in desks {
        std::mem::swap(&mut desk.left, &mut desk.leaving);
    }
}

/// Copies what contacts of these rows with later ones remember, which stands in these pages.
pub(super) fn see_off<V: Space, L: Demands>(
    rows: &Range<usize>,
    list: &PairList,
    pages: &[Pages<V>],
    leaving: &mut Pages<V>,
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
pub(super) struct Arrivals<'a, V: Space> {
    tasks: &'a [Task],
    left: &'a [&'a Pages<V>],
    /// Where the last one was that was asked for: in what which task has left, and at what place there.
    task: usize,
    at: usize,
}

impl<'a, V: Space> Arrivals<'a, V> {
    pub(super) fn new(tasks: &'a [Task], left: &'a [&'a Pages<V>]) -> Self {
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
