//! The memories of the contacts of a batch, loaded from the history blocks.

use crate::contact::law::{LawRequirements, memory_layout};
use crate::contact::memory::{MOST_NUMBERS, Memory, MemoryLayout};
use crate::lanes::Scalars;
use crate::space::Space;

/// [`Memory`] in lanes.
#[derive(Clone, Debug, Default)]
pub struct MemoryLanes {
    /// Bits of the lanes whose contact exists, for a law that reaches beyond touch.
    pub exists: u64,
    /// The numbers. Those that the law does not remember are never set.
    pub numbers: [Scalars; MOST_NUMBERS],
}

impl MemoryLanes {
    /// Returns the memory in a lane, for the law `L`.
    #[inline(always)]
    pub fn get<L: LawRequirements, V: Space>(&self, lane: usize) -> Memory {
        let count = const { memory_layout::<L, V>().count };
        Memory {
            exists: L::REACHES && self.exists >> lane & 1 == 1,
            numbers: each_number(
                #[inline(always)]
                |at| if at < count { self.numbers[at][lane] } else { 0.0 },
            ),
        }
    }

    /// Sets the memory in a lane, for the law `L`.
    #[inline(always)]
    pub fn set<L: LawRequirements, V: Space>(&mut self, lane: usize, memory: &Memory) {
        let count = const { memory_layout::<L, V>().count };
        for (lanes, number) in self.numbers.iter_mut().zip(memory.numbers).take(count) {
            lanes[lane] = number;
        }
        if L::REACHES {
            self.set_exists(lane, memory.exists);
        }
    }

    /// Sets whether the contact in a lane exists.
    #[inline(always)]
    pub fn set_exists(&mut self, lane: usize, exists: bool) {
        self.exists = self.exists & !(1 << lane) | u64::from(exists) << lane;
    }

    /// Returns the memory in a lane, for a law with the memories of `layout`.
    #[inline]
    pub fn memory(&self, layout: &MemoryLayout, lane: usize) -> Memory {
        let mut memory = Memory { exists: layout.keeps_existence && self.exists >> lane & 1 == 1, ..Memory::default() };
        for (number, lanes) in memory.numbers.iter_mut().zip(&self.numbers).take(layout.count) {
            *number = lanes[lane];
        }
        memory
    }

    /// Makes the memory in a lane that of a new contact.
    #[inline]
    pub fn clear(&mut self, layout: &MemoryLayout, lane: usize) {
        self.set_exists(lane, false);
        self.numbers.iter_mut().take(layout.count).for_each(|lanes| lanes[lane] = 0.0);
    }
}

/// Builds the numbers of a memory from their indices. Not a loop: the numbers have to become registers before the loop over the lanes is
/// vectorised.
#[inline(always)]
fn each_number(number: impl Fn(usize) -> f64) -> [f64; MOST_NUMBERS] {
    [
        number(0),
        number(1),
        number(2),
        number(3),
        number(4),
        number(5),
        number(6),
        number(7),
        number(8),
        number(9),
        number(10),
        number(11),
    ]
}
