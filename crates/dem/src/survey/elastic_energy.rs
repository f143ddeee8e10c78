//! Elastic energy of contacts, J.

use super::{Partner, Survey};
use crate::contact::memory::Memory;
use crate::contact::pair::Pair;
use crate::neighbours::list::BLOCK;
use crate::space::Space;
use crate::threads::Threads;

impl<V: Space> Survey<'_, V> {
    /// Returns the elastic energy of all contacts that `accepts` returns true for, J.
    pub fn elastic_energy(&self, accepts: impl Fn(usize, Partner) -> bool) -> f64 {
        let mut energy = 0.0;
        self.contacts_among(accepts, |_, _, pair, memory| energy += self.law.elastic_energy(pair, memory));
        energy
    }

    /// Returns the elastic energy of all contacts, J, summed on all threads. Each block of rows has its own sum, and so have the walls, so that
    /// no bit depends on the number of threads.
    #[must_use]
    pub fn whole_elastic_energy(&self, threads: &Threads) -> f64 {
        let blocks = self.search.list.pairs().chunk_by(|a, b| a.row() / BLOCK == b.row() / BLOCK);
        let parts = blocks.map(Some).chain([None]).map(|block| {
            move || {
                let mut energy = 0.0;
                let mut add = |_: usize, _: Partner, pair: &Pair<V>, memory: &Memory| {
                    energy += self.law.elastic_energy(pair, memory);
                };
                match block {
                    Some(candidates) => self.visit_pairs(candidates, &|_, _| true, &mut add),
                    None => self.visit_walls(&|_, _| true, &mut add),
                }
                energy
            }
        });
        threads.share(parts).into_iter().sum()
    }
}
