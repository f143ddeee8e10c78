//! A line of the plane that no path of a grain may cross.

use crate::space::Vector;
use crate::walls::shapes::Shape as _;
use crate::walls::shapes::segment::Segment;

/// A line that encloses grains.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Link {
    /// One end, m.
    pub from: Vector,
    /// The other end, m.
    pub to: Vector,
}

impl Link {
    /// Returns where the path crosses this line, as a share of the path (0 to 1).
    pub(super) fn crossed_at(&self, from: Vector, to: Vector) -> Option<f64> {
        Segment { from: self.from, to: self.to }.crossing(from, to)
    }
}
