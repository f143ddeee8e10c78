//! How many threads share the force pass ([`crate::contact::kernel`]), and those over the rows of many grains
//! ([`crate::columns`]). One needs no pool; on several the bits are the same.

use std::num::NonZeroUsize;
use std::sync::Arc;

use bevy_ecs::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuildError, ThreadPoolBuilder};

/// The threads of a run.
#[derive(Resource)]
pub struct Threads(Option<Arc<ThreadPool>>);

impl Threads {
    /// `count` threads.
    ///
    /// # Errors
    /// If the system refuses to start them.
    pub fn new(count: NonZeroUsize) -> Result<Self, ThreadPoolBuildError> {
        if count.get() == 1 {
            return Ok(Self(None));
        }
        ThreadPoolBuilder::new().num_threads(count.get()).build().map(|pool| Self(Some(Arc::new(pool))))
    }

    /// The pool, if there are several threads.
    #[must_use]
    pub fn pool(&self) -> Option<&ThreadPool> {
        self.0.as_deref()
    }

    /// How many threads there are.
    #[must_use]
    pub fn count(&self) -> usize {
        self.pool().map_or(1, ThreadPool::current_num_threads)
    }

    /// Runs `work` on one of them, so that passes within it share with the others what they do, instead of waking all and waiting.
    pub(crate) fn run<R: Send>(world: &mut World, work: impl FnOnce(&mut World) -> R + Send) -> R {
        match world.resource::<Self>().0.clone() {
            None => work(world),
            Some(pool) => pool.install(|| work(world)),
        }
    }
}
