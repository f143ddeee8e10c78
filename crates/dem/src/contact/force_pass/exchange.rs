//! Exchange of forces between the tasks of a pass.
//!
//! Each task posts the forces of its pairs on particles of earlier tasks as soon as it has evaluated these pairs, which are among its first
//! rows. At its end a task takes the forces on its own particles from later tasks. It waits for a later task that has not posted yet. A task
//! posts before it waits, so tasks never wait for each other in a circle, also if one thread begins a task while it waits in another.

use std::sync::OnceLock;

use crate::contact::outgoing::Outgoing;
use crate::neighbours::list::Task;
use crate::space::Space;
use crate::threads::Threads;

/// The place where a task posts.
pub(super) type Post<V> = OnceLock<Outgoing<V>>;

/// The exchange, seen from one task.
pub(super) struct Exchange<'a, V: Space> {
    pub(super) threads: &'a Threads,
    pub(super) tasks: &'a [Task],
    pub(super) posts: &'a [Post<V>],
    /// The number of the task.
    pub(super) own: usize,
}

impl<'a, V: Space> Exchange<'a, V> {
    /// Returns the task.
    pub(super) fn task(&self) -> &'a Task {
        &self.tasks[self.own]
    }

    /// Posts all forces of the task on particles of earlier tasks. Only the first call counts.
    pub(super) fn post(&self, outgoing: &mut Outgoing<V>) {
        self.posts[self.own].get_or_init(|| std::mem::take(outgoing));
    }

    /// Returns the forces of later tasks on particles of this one, task by task in ascending order. Waits for them.
    pub(super) fn incoming(&self) -> impl Iterator<Item = &'a Outgoing<V>> {
        let &Self { threads, tasks, posts, own } = self;
        let later = posts.iter().zip(tasks).skip(own + 1);
        later.filter(move |(_, task)| task.lowest < tasks[own].rows.end).map(move |(post, _)| {
            threads.wait_until(|| post.get().is_some());
            post.get().expect("posted")
        })
    }
}

impl<V: Space> Drop for Exchange<'_, V> {
    /// Posts nothing if the task has ended without a post, by a panic: tasks that wait for it end, and the panic is told.
    fn drop(&mut self) {
        self.posts[self.own].get_or_init(Outgoing::default);
    }
}
