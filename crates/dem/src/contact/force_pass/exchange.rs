//! Exchange of forces between the tasks of a pass.
//!
//! Each task posts the forces of its pairs on particles of earlier tasks as soon as it has evaluated these pairs. They are among its first rows;
//! in a periodic box the last task has some among its last rows. At its end a task takes the forces on its own particles from later tasks. It
//! waits for a later task that has not posted yet, and evaluates its contacts with walls before that. A task posts before it waits, so tasks
//! never wait for each other in a circle, also if one thread begins a task while it waits in another.

use std::sync::OnceLock;

use crate::contact::held_forces::HeldForces;
use crate::neighbours::list::Task;
use crate::space::Space;
use crate::threads::Threads;

/// The place where a task posts.
pub(super) type Post<V> = OnceLock<HeldForces<V>>;

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
    pub(super) fn post(&self, outgoing: &mut HeldForces<V>) {
        self.posts[self.own].get_or_init(|| std::mem::take(outgoing));
    }

    /// Returns whether all tasks have posted for which this one would have to wait.
    pub(super) fn is_complete(&self) -> bool {
        self.later().all(|post| post.get().is_some())
    }

    /// Returns the forces of later tasks on particles of this one, task by task in ascending order. Waits for them.
    pub(super) fn incoming(&self) -> impl Iterator<Item = &'a HeldForces<V>> {
        let threads = self.threads;
        self.later().map(move |post| {
            threads.wait_until(|| post.get().is_some());
            post.get().expect("posted")
        })
    }

    /// The posts of later tasks with forces on particles of this one.
    fn later(&self) -> impl Iterator<Item = &'a Post<V>> {
        let &Self { tasks, posts, own, .. } = self;
        let later = posts.iter().zip(tasks).skip(own + 1);
        later.filter(move |(_, task)| task.lowest < tasks[own].rows.end).map(|(post, _)| post)
    }
}

impl<V: Space> Drop for Exchange<'_, V> {
    /// Posts no forces if the task has ended without a post, by a panic: tasks that wait for it end, and the panic is told.
    fn drop(&mut self) {
        self.posts[self.own].get_or_init(HeldForces::default);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::neighbours::list::Candidate;
    use crate::space::Plane;

    /// Three tasks of ten rows. The second one reaches the first, the third one reaches as far down as `lowest`.
    fn tasks(lowest: usize) -> [Task; 3] {
        [(0..10, 0, 0), (10..20, 4, 20), (20..30, lowest, 30)].map(|(rows, lowest, reaching_end)| Task {
            rows,
            lowest,
            reaching_end,
        })
    }

    fn force(pair: [u32; 2]) -> HeldForces<Plane> {
        HeldForces { pairs: vec![Candidate::from(pair)], ..HeldForces::default() }
    }

    #[test]
    fn a_task_gets_the_posts_of_those_that_reach_it_in_their_order() {
        for (lowest, expected) in [(4, vec![[12, 4], [22, 7]]), (12, vec![[12, 4]])] {
            let tasks = tasks(lowest);
            let threads = Threads::one();
            let posts = [(); 3].map(|()| Post::new());
            let of = |own| Exchange { threads: &threads, tasks: &tasks, posts: &posts, own };
            of(2).post(&mut force([22, 7]));
            assert!(!of(0).is_complete() && of(2).is_complete());
            of(1).post(&mut force([12, 4]));
            assert!(of(0).is_complete());
            // Only the first post counts.
            of(1).post(&mut force([13, 5]));
            let incoming: Vec<_> = of(0)
                .incoming()
                .flat_map(|outgoing| outgoing.pairs.iter().map(|pair| pair.row_and_partner()))
                .collect();
            assert_eq!(incoming, expected);
        }
    }

    #[test]
    fn a_task_that_panics_keeps_no_other_waiting() {
        let tasks = tasks(4);
        let threads = Threads::one();
        let posts = [(); 3].map(|()| Post::<Plane>::new());
        let of = |own| Exchange { threads: &threads, tasks: &tasks, posts: &posts, own };
        drop([of(1), of(2)]);
        assert!(of(0).incoming().all(|outgoing| outgoing.pairs.is_empty()));
    }
}
