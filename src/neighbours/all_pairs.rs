//! Every pair: N(N-1)/2 distances a step. The reference that the other searches must equal.

use crate::columns::Columns;
use crate::contact::kernel::Partners;
use crate::space::Space;

/// All particles are candidates of all.
pub struct AllPairs {
    everyone: Vec<u32>,
    full: bool,
}

impl AllPairs {
    pub(super) fn new(full: bool) -> Self {
        Self { everyone: Vec::new(), full }
    }

    pub(super) fn resize(&mut self, particles: usize) {
        self.everyone.truncate(particles);
        let known = self.everyone.len();
        self.everyone.extend((0u32..).skip(known).take(particles - known));
    }
}

impl<V: Space> Partners<V> for AllPairs {
    #[inline]
    fn of<'a>(&'a self, _: &Columns<V>, i: usize, _: &'a mut Vec<u32>) -> &'a [u32] {
        if self.full { &self.everyone } else { &self.everyone[i + 1..] }
    }
}
