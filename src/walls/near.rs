//! Which grains are near which walls: all others are spared the look at every wall in every step.
//!
//! A grain is near a wall if its surface is less than a radius of the largest grain away from it: of a packing those are mostly
//! the ones that touch it. The list holds until somebody can have gone that far, or a wall has changed.

use crate::columns::Columns;
use crate::neighbours::list::Candidate;
use crate::space::Space;
use crate::wait::Wait;
use crate::walls::surfaces::FlatWall;

/// Pairs of an entry of the columns and a wall's index, ascending.
#[derive(Debug, Default)]
pub struct NearWalls {
    pairs: Vec<Candidate>,
    wait: Wait,
}

impl NearWalls {
    /// Those of now.
    pub fn of<V: Space>(&mut self, columns: &Columns<V>, walls: &[FlatWall<V>], has_changed: bool) -> &[Candidate] {
        if walls.is_empty() {
            return &[];
        }
        if has_changed || self.wait.is_over(columns.odometer(), columns.margin) {
            let grains = &columns.body[..columns.movable_end];
            let slack = grains.iter().map(|body| body.radius).fold(0.0, f64::max);
            self.pairs.clear();
            for (i, body) in (0u32..).zip(grains) {
                for (number, wall) in (0u32..).zip(walls) {
                    // Written so that a NaN is near nothing.
                    if wall.surface.distance(body.position) < body.radius + slack {
                        self.pairs.push(Candidate::new(i, number));
                    }
                }
            }
            self.wait = Wait::for_distance(columns.odometer(), slack);
        }
        &self.pairs
    }
}
