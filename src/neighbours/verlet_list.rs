//! A Verlet list: the pairs closer than R_i + R_j + skin, kept until one of them might touch unlisted.
//!
//! Two particles that were not listed can touch only after they have moved by `skin` between them, so the list
//! holds while nobody has moved by skin/2 since it was made. It is renewed by a search through hashed cells of side
//! (largest contact distance + skin), and holds each particle's partners in ascending order.

use crate::columns::Columns;
use crate::contact::kernel::Partners;
use crate::neighbours::cells::Cells;
use crate::neighbours::contact_range;
use crate::space::Vector;

/// The list, as compressed rows.
pub struct VerletList {
    skin: f64,
    starts: Vec<u32>,
    partners: Vec<u32>,
    made_at: Vec<Vector>,
}

impl VerletList {
    pub(super) fn new(skin: f64) -> Self {
        Self { skin, starts: vec![0], partners: Vec::new(), made_at: Vec::new() }
    }

    /// Whether somebody has moved by half the skin, or is nowhere.
    pub(super) fn is_stale(&self, columns: &Columns) -> bool {
        let limit = 0.25 * self.skin * self.skin;
        let mut largest = 0.0f64;
        for (now, then) in columns.position.iter().zip(&self.made_at) {
            largest = largest.max(now.distance_squared(*then));
        }
        largest >= limit
    }

    pub(super) fn renew(&mut self, columns: &Columns, full: bool) {
        let mut cells = Cells::new((contact_range(columns) + self.skin).max(f64::MIN_POSITIVE), full);
        cells.fill(&columns.position);
        self.partners.clear();
        self.starts.clear();
        self.starts.push(0);
        let mut near = Vec::new();
        let rows = if full { columns.len() } else { columns.movable_end };
        for i in 0..rows {
            cells.near(columns, i, self.skin, full, &mut near);
            self.partners.extend_from_slice(&near);
            self.starts.push(u32::try_from(self.partners.len()).expect("fewer than 2^32 listed pairs"));
        }
        self.made_at.clone_from(&columns.position);
    }
}

impl Partners for VerletList {
    #[inline]
    fn of<'a>(&'a self, _: &Columns, i: usize, _: &'a mut Vec<u32>) -> &'a [u32] {
        &self.partners[self.starts[i] as usize..self.starts[i + 1] as usize]
    }
}
