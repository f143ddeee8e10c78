//! The memory of a contact: numbers that a law keeps from one step to the next, and whether the contact exists.
//!
//! A law declares its numbers as [`MemoryVariable`]s ([`LawRequirements::MEMORY`](crate::contact::law::LawRequirements::MEMORY)):
//! a name, a number or a vector, and its parity. The contact history stores them, hands them back in the next step, and gives
//! them to files under their names. It knows nothing else about them.
//!
//! A memory is seen from one of the two particles. Seen from the other one, odd variables have the opposite sign: a displacement
//! of i against j is one. Even variables, such as a duration or a stiffness, are the same from both sides.
//!
//! Whether a contact exists follows from the overlap, except for a law that reaches beyond touch: two bodies at some distance
//! are in contact if they have touched, and not otherwise. For such laws the force pass keeps [`Memory::exists`].
//!
//! Limit: [`MOST_NUMBERS`] numbers a contact. A law that declares more does not compile.

use crate::space::Space;

/// Largest number of numbers in a memory: eight of the law with most springs, and four for a law that is built on it.
pub const MOST_NUMBERS: usize = 12;

/// The sign of a variable seen from the other particle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Parity {
    /// The same from both particles.
    Even,
    /// The opposite sign from the other particle.
    Odd,
}

/// A quantity that a law remembers of a contact.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MemoryVariable {
    /// Name of its column in a file of memories; a vector has three columns, `name_x`, `name_y` and `name_z`.
    pub name: &'static str,
    /// Whether it is a vector of the space, not a single number.
    pub is_vector: bool,
    /// Its sign seen from the other particle.
    pub parity: Parity,
    /// Whether the law keeps it. A variable that is not kept takes no room in a memory and is zero in files.
    pub is_kept: bool,
}

impl MemoryVariable {
    /// Declares a single number.
    #[must_use]
    pub const fn number(name: &'static str, parity: Parity) -> Self {
        Self { name, is_vector: false, parity, is_kept: true }
    }

    /// Declares a vector of the space.
    #[must_use]
    pub const fn vector(name: &'static str, parity: Parity) -> Self {
        Self { name, is_vector: true, parity, is_kept: true }
    }

    /// Returns the variable, kept only if `is_kept` is true.
    #[must_use]
    pub const fn kept_if(self, is_kept: bool) -> Self {
        Self { is_kept, ..self }
    }

    /// Returns the number of numbers that it takes in a memory.
    #[must_use]
    pub const fn width<V: Space>(&self) -> usize {
        match (self.is_kept, self.is_vector) {
            (false, _) => 0,
            (true, false) => 1,
            (true, true) => V::COMPONENTS,
        }
    }
}

/// The numbers that a law remembers of one contact, seen from i.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Memory {
    /// Whether the contact existed at the previous evaluation. The force pass sets it for a law that reaches beyond touch
    /// ([`LawRequirements::REACHES`](crate::contact::law::LawRequirements::REACHES)); for other laws it is always false.
    pub exists: bool,
    /// The numbers of the kept variables in the order of their declaration, then zeros. All are zero in a new contact.
    pub numbers: [f64; MOST_NUMBERS],
}

impl Memory {
    /// Returns whether the memory is that of a contact that begins, or of a gap.
    #[inline]
    #[must_use]
    pub fn is_empty(&self) -> bool {
        *self == Self::default()
    }

    /// Returns the vector whose first component is number `at`.
    #[inline(always)]
    #[must_use]
    pub fn vector<V: Space>(&self, at: usize) -> V {
        V::from_components(
            #[inline(always)]
            |axis| self.numbers[at + axis],
        )
    }

    /// Sets the vector whose first component is number `at`.
    #[inline(always)]
    pub fn set_vector<V: Space>(&mut self, at: usize, vector: V) {
        for axis in 0..V::COMPONENTS {
            self.numbers[at + axis] = vector.component(axis);
        }
    }
}

/// The variables of a law, and the places of their numbers.
#[derive(Clone, Copy, Debug, Default)]
pub struct MemoryLayout {
    /// The variables.
    pub variables: &'static [MemoryVariable],
    /// Number of numbers.
    pub count: usize,
    /// Bits of the numbers that change their sign.
    odd: u64,
    /// Whether [`Memory::exists`] is kept.
    pub keeps_existence: bool,
}

impl MemoryLayout {
    /// The layout of a law without memory.
    pub const NONE: Self = Self { variables: &[], count: 0, odd: 0, keeps_existence: false };

    /// Returns the layout in the space `V`. `keeps_existence` states whether [`Memory::exists`] is kept.
    ///
    /// # Panics
    /// If there are more numbers than [`MOST_NUMBERS`]. Layouts of laws are constants, so that such a law does not compile.
    #[must_use]
    pub const fn new<V: Space>(variables: &'static [MemoryVariable], keeps_existence: bool) -> Self {
        let mut count = 0;
        let mut odd = 0;
        let mut next = 0;
        while next < variables.len() {
            let variable = &variables[next];
            let width = variable.width::<V>();
            if matches!(variable.parity, Parity::Odd) {
                odd |= ((1 << width) - 1) << count;
            }
            count += width;
            next += 1;
        }
        assert!(count <= MOST_NUMBERS, "a law remembers more than `MOST_NUMBERS` numbers of a contact");
        Self { variables, count, odd, keeps_existence }
    }

    /// Whether number `at` has the opposite sign seen from the other particle.
    #[must_use]
    pub const fn is_odd(&self, at: usize) -> bool {
        self.odd >> at & 1 == 1
    }

    /// Returns a memory as seen from the other particle.
    #[must_use]
    pub fn seen_from_partner(&self, memory: &Memory) -> Memory {
        let mut turned = *memory;
        for (at, number) in turned.numbers.iter_mut().enumerate() {
            if self.is_odd(at) {
                *number = -*number;
            }
        }
        turned
    }

    /// Returns the names of the columns of all variables, also of those that are not kept.
    #[must_use]
    pub fn columns(&self) -> Vec<String> {
        let names = |variable: &MemoryVariable| {
            if variable.is_vector {
                ["x", "y", "z"].map(|axis| format!("{}_{axis}", variable.name)).to_vec()
            } else {
                vec![variable.name.to_owned()]
            }
        };
        self.variables.iter().flat_map(names).collect()
    }

    /// Returns the numbers of a memory in the order of [`Self::columns`].
    #[must_use]
    pub fn numbers_in_columns<V: Space>(&self, memory: &Memory) -> Vec<f64> {
        let mut columns = Vec::new();
        let mut at = 0;
        for variable in self.variables {
            let width = variable.width::<V>();
            let numbers = &memory.numbers[at..at + width];
            let places = if variable.is_vector { 3 } else { 1 };
            columns.extend((0..places).map(|place| numbers.get(place).copied().unwrap_or(0.0)));
            at += width;
        }
        columns
    }

    /// Returns the memory whose columns have the numbers that `column` returns for their places in [`Self::columns`].
    #[must_use]
    pub fn memory_from_columns<V: Space>(&self, mut column: impl FnMut(usize) -> f64) -> Memory {
        let mut memory = Memory { exists: self.keeps_existence, ..Memory::default() };
        let mut at = 0;
        let mut first = 0;
        for variable in self.variables {
            for place in 0..variable.width::<V>() {
                memory.numbers[at] = column(first + place);
                at += 1;
            }
            first += if variable.is_vector { 3 } else { 1 };
        }
        memory
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::space::{Plane, Solid};

    const VARIABLES: &[MemoryVariable] = &[
        MemoryVariable::vector("spring", Parity::Odd),
        MemoryVariable::vector("unused", Parity::Odd).kept_if(false),
        MemoryVariable::number("age", Parity::Even),
        MemoryVariable::number("turn", Parity::Odd),
    ];

    fn numbers(numbers: &[f64]) -> Memory {
        let mut memory = Memory::default();
        memory.numbers[..numbers.len()].copy_from_slice(numbers);
        memory
    }

    #[test]
    fn odd_variables_change_their_sign() {
        let plane = MemoryLayout::new::<Plane>(VARIABLES, false);
        assert_eq!(plane.count, 4);
        assert_eq!(plane.seen_from_partner(&numbers(&[1.0, 2.0, 3.0, 4.0])), numbers(&[-1.0, -2.0, 3.0, -4.0]));
        let solid = MemoryLayout::new::<Solid>(VARIABLES, false);
        assert_eq!(solid.count, 5);
        let turned = solid.seen_from_partner(&numbers(&[1.0, 2.0, 3.0, 4.0, 5.0]));
        assert_eq!(turned, numbers(&[-1.0, -2.0, -3.0, 4.0, -5.0]));
    }

    #[test]
    fn columns_have_three_components_of_every_vector() {
        let layout = MemoryLayout::new::<Plane>(VARIABLES, false);
        let names = ["spring_x", "spring_y", "spring_z", "unused_x", "unused_y", "unused_z", "age", "turn"];
        assert_eq!(layout.columns(), names);
        let memory = numbers(&[1.0, 2.0, 3.0, 4.0]);
        let columns = layout.numbers_in_columns::<Plane>(&memory);
        assert_eq!(columns, [1.0, 2.0, 0.0, 0.0, 0.0, 0.0, 3.0, 4.0]);
        assert_eq!(layout.memory_from_columns::<Plane>(|column| columns[column]), memory);
    }
}
