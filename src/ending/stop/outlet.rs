//! Which grains are above an outlet.
//!
//! A grain is above an outlet if its centre is inside the silo, higher than the lower end of the door, and between the ends of the door
//! along every horizontal axis. A door in a side wall is higher than it is thick: there the grain is within half the height of the
//! door. Dead zones beside and below the outlet therefore are no clog, and neither is an empty channel above it.

use crate::ledger::Ledger;
use siloflow_dem::particles::Particles;
use siloflow_dem::space::{Solid, Space};

/// Whether a point inside the silo is above an outlet, given by the box around its door, m.
fn is_above<V: Space>(x: Solid, [low, high]: [Solid; 2]) -> bool {
    let up = V::COMPONENTS - 1;
    let least = 0.5 * (high[up] - low[up]);
    let is_within = |axis: usize| {
        let half_width = (0.5 * (high[axis] - low[axis])).max(least);
        (x[axis] - 0.5 * (low[axis] + high[axis])).abs() < half_width
    };
    x[up] > low[up] && (0..up).all(is_within)
}

/// Returns the number of grains inside that are above one of these outlets, given by the boxes around their doors, m.
pub(super) fn count_above<V: Space>(particles: &Particles<V>, ledger: &Ledger, boxes: &[[Solid; 2]]) -> u32 {
    let is_above = |row: usize| boxes.iter().any(|door| is_above::<V>(particles.position(row).spread(), *door));
    let inside = particles.grains().filter(|&row| !ledger.is_gone(particles.id(row)));
    u32::try_from(inside.filter(|&row| is_above(row)).count()).unwrap_or(u32::MAX)
}

#[cfg(test)]
mod tests {
    use super::*;
    use siloflow_dem::space::Plane;

    #[test]
    fn a_grain_is_above_a_door_in_the_floor_or_before_a_door_in_a_side() {
        let floor = [Solid::new(-0.1, -0.2, 0.0), Solid::new(0.1, 0.2, 0.0)];
        let above = |x, y, z| is_above::<Solid>(Solid::new(x, y, z), floor);
        assert!(above(0.09, -0.19, 0.01) && above(0.0, 0.0, 3.0));
        assert!(!above(0.11, 0.0, 0.1) && !above(0.0, 0.21, 0.1));
        let side = [Solid::new(1.0, -0.2, 0.5), Solid::new(1.0, 0.2, 0.7)];
        let before = |x, y, z| is_above::<Solid>(Solid::new(x, y, z), side);
        assert!(before(0.91, 0.0, 0.55) && before(0.95, 0.1, 2.0));
        assert!(!before(0.89, 0.0, 0.6) && !before(0.95, 0.0, 0.49));
        let slit = [Solid::new(1.0, 0.5, 0.0), Solid::new(1.0, 0.7, 0.0)];
        assert!(
            is_above::<Plane>(Solid::new(0.91, 0.6, 0.0), slit) && !is_above::<Plane>(Solid::new(0.91, 0.4, 0.0), slit)
        );
    }
}
