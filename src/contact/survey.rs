//! A survey of the contacts as they stand: for measurements and books, not for the hot loop.
//!
//! It looks at the positions of the columns with the neighbour search of the last force pass, so it is right at
//! any time between that pass and the next renumbering.

use crate::columns::Columns;
use crate::contact::kernel::{self, Partners};
use crate::contact::{Pair, PairLaw};
use crate::neighbours::{Method, Search};
use crate::walls::surfaces::{self, Surface};

/// Who is touched.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Partner {
    /// The particle at this index of the columns.
    Particle(usize),
    /// The flat wall of this index.
    Wall(usize),
}

/// Calls `visit` once for each contact, with the index of one particle, its partner, and the pair from its side.
pub fn contacts(columns: &Columns, search: &Search, walls: &[Surface], mut visit: impl FnMut(usize, Partner, &Pair)) {
    match &search.method {
        Method::AllPairs(partners) => pairs(columns, partners, &mut visit),
        Method::Cells(partners) => pairs(columns, partners, &mut visit),
        Method::VerletList(partners) => pairs(columns, partners, &mut visit),
    }
    for i in (0..columns.movable_end).filter(|&i| !columns.is_fixed(i)) {
        for (index, wall) in walls.iter().enumerate() {
            if let Some(pair) = surfaces::touching(columns, i, wall) {
                visit(i, Partner::Wall(index), &pair);
            }
        }
    }
}

fn pairs(columns: &Columns, partners: &impl Partners, visit: &mut impl FnMut(usize, Partner, &Pair)) {
    let mut scratch = Vec::new();
    for i in 0..columns.movable_end {
        for &j in partners.of(columns, i, &mut scratch) {
            let j = j as usize;
            // A full search offers each pair from both sides.
            if j > i
                && let Some(pair) = kernel::touching(columns, i, j)
            {
                visit(i, Partner::Particle(j), &pair);
            }
        }
    }
}

/// Elastic energy of all contacts that `counts` accepts, J.
pub fn elastic_energy(
    columns: &Columns,
    search: &Search,
    walls: &[Surface],
    law: &dyn PairLaw,
    counts: impl Fn(usize, Partner) -> bool,
) -> f64 {
    let mut energy = 0.0;
    contacts(columns, search, walls, |i, partner, pair| {
        if counts(i, partner) {
            energy += law.elastic_energy(pair.overlap);
        }
    });
    energy
}
