//! How many threads share the force pass ([`crate::contact::kernel`]), and those over the rows of many grains
//! ([`crate::columns`]). One needs no pool; on several the bits are the same.

use std::num::NonZeroUsize;

use bevy_ecs::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuildError, ThreadPoolBuilder};

/// The threads of a run.
#[derive(Resource)]
pub struct Threads(Option<ThreadPool>);

impl Threads {
    /// `count` threads.
    ///
    /// # Errors
    /// If the system refuses to start them.
    pub fn new(count: NonZeroUsize) -> Result<Self, ThreadPoolBuildError> {
        if count.get() == 1 {
            return Ok(Self(None));
        }
        ThreadPoolBuilder::new().num_threads(count.get()).build().map(|pool| Self(Some(pool)))
    }

    /// The pool, if there are several threads.
    #[must_use]
    pub fn pool(&self) -> Option<&ThreadPool> {
        self.0.as_ref()
    }

    /// How many threads there are.
    #[must_use]
    pub fn count(&self) -> usize {
        self.0.as_ref().map_or(1, ThreadPool::current_num_threads)
    }
}
