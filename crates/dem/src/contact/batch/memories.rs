//! The memories of the contacts of a batch, loaded from the history blocks.

use crate::contact::batch::Batch;
use crate::contact::history::HistoryCursor;
use crate::contact::lanes::{LANES, Lanes, Scalars};
use crate::contact::{LawRequirements, Memory};
use crate::neighbours::list::Candidate;
use crate::space::Space;

/// [`Memory`] in lanes.
#[derive(Clone, Debug, Default)]
pub struct MemoryLanes<V: Space> {
    pub(in crate::contact) spring: Lanes<V>,
    pub(in crate::contact) rolling: Lanes<V>,
    pub(in crate::contact) twist: Scalars,
    pub(in crate::contact) stiffness: Scalars,
}

impl<V: Space> MemoryLanes<V> {
    /// Returns the memory in a lane; components that the law `L` does not require are zero.
    #[inline(always)]
    pub fn get<L: LawRequirements>(&self, lane: usize) -> Memory<V> {
        Memory {
            spring: if L::SPRING { self.spring.get(lane) } else { V::ZERO },
            rolling: if L::ROLLING { self.rolling.get(lane) } else { V::ZERO },
            twist: if L::TWISTING { self.twist[lane] } else { 0.0 },
            stiffness: if L::STIFFNESS { self.stiffness[lane] } else { 0.0 },
        }
    }

    /// Sets the components that the law `L` requires.
    #[inline(always)]
    pub fn set<L: LawRequirements>(&mut self, lane: usize, memory: &Memory<V>) {
        if L::SPRING {
            self.spring.set(lane, memory.spring);
        }
        if L::ROLLING {
            self.rolling.set(lane, memory.rolling);
        }
        if L::TWISTING {
            self.twist[lane] = memory.twist;
        }
        if L::STIFFNESS {
            self.stiffness[lane] = memory.stiffness;
        }
    }

    /// Returns the memory in a lane, for any law: components that are never set are zero.
    #[inline]
    pub fn get_all(&self, lane: usize) -> Memory<V> {
        Memory {
            spring: self.spring.get(lane),
            rolling: self.rolling.get(lane),
            twist: self.twist[lane],
            stiffness: self.stiffness[lane],
        }
    }

    /// Sets the memory in a lane, for any law.
    #[inline]
    pub fn set_all(&mut self, lane: usize, memory: &Memory<V>) {
        self.spring.set(lane, memory.spring);
        self.rolling.set(lane, memory.rolling);
        (self.twist[lane], self.stiffness[lane]) = (memory.twist, memory.stiffness);
    }
}

impl<V: Space> Batch<V> {
    /// Loads the memories of all contacts. Contacts that have ended are passed to `on_end` with their memories.
    #[inline]
    pub fn recall(&mut self, cursor: &mut HistoryCursor<'_, V>, mut on_end: impl FnMut(Candidate, &Memory<V>)) {
        let contacts = &self.pairs[..self.len.min(LANES)];
        if cursor.recall_all(contacts, &mut self.memory) {
            return;
        }
        for (lane, &contact) in contacts.iter().enumerate() {
            let memory = cursor.recall(contact, &mut on_end);
            self.memory.set_all(lane, &memory.unwrap_or_default());
        }
    }
}
