//! The thirteen velocities of a particle: rest, and one for each of twelve neighbours.
//!
//! The lattice is triangular, with one bond direction vertical. A site has integer coordinates (X, Y) of equal parity.
//! Its position is x = X sqrt(3)/2, y = Y/2, in units of the bond length.
//!
//! | direction | neighbours | speed | order |
//! |---|---|---|---|
//! | 0 | rest | 0 | |
//! | 1 to 6 | nearest | 1 | clockwise from straight up |
//! | 7 to 12 | second-nearest | sqrt 3 | clockwise; 7 is between 1 and 2 |
//!
//! Direction 4 is straight down and 7 points obliquely up. {3, 4, 5, 9, 10} are the downward directions. {2, 3, 5, 6,
//! 8, 11} are the directions within 30 degrees of the horizontal. The numbering agrees with Kozicki and Tejchman, TASK
//! Quarterly 9(1), 2005, figure 1.
//!
//! Bit i of a *state* is set if there is a particle with velocity i. The *movers* of a state are its bits 1 to 12.

use siloflow_dem::math;

/// Steps (dX, dY) of directions 0 to 12.
pub const STEPS: [(i32, i32); 13] =
    [(0, 0), (0, 2), (1, 1), (1, -1), (0, -2), (-1, -1), (-1, 1), (1, 3), (2, 0), (1, -3), (-1, -3), (-2, 0), (-1, 3)];

/// The opposite of each direction.
pub const OPPOSITE: [usize; 13] = [0, 4, 5, 6, 1, 2, 3, 10, 11, 12, 7, 8, 9];

/// For each of directions 7 to 12: the two nearest neighbours (as directions) that its bond passes between.
pub const FLANKS: [(usize, usize); 6] = [(1, 2), (2, 3), (3, 4), (4, 5), (5, 6), (6, 1)];

/// Direction of gravity.
pub const DOWN: usize = 4;

/// Downward directions, as a state.
pub const DESCENDING: u16 = 1 << 3 | 1 << 4 | 1 << 5 | 1 << 9 | 1 << 10;

/// Directions within 30 degrees of the horizontal, as a state.
pub const LEVEL: u16 = 1 << 2 | 1 << 3 | 1 << 5 | 1 << 6 | 1 << 8 | 1 << 11;

/// The bits of all movers of a state.
pub const MOVERS: u16 = 0x1FFE;

/// Converts a displacement or velocity (dX, dY) to (x, y) in bond lengths.
#[must_use]
pub fn in_bonds((dx, dy): (i32, i32)) -> (f64, f64) {
    (f64::from(dx) * 0.75f64.sqrt(), f64::from(dy) * 0.5)
}

/// Returns the angle of a direction from the horizontal, degrees, in (-180, 180].
#[must_use]
pub fn angle(direction: usize) -> f64 {
    let (x, y) = in_bonds(STEPS[direction]);
    math::atan2(y, x).to_degrees()
}

/// Returns the sum (X, Y) of the velocities of a state.
#[must_use]
pub fn momentum(state: u16) -> (i32, i32) {
    directions(state).fold((0, 0), |(x, y), d| (x + STEPS[d].0, y + STEPS[d].1))
}

/// Returns the set bits of a state, ascending.
pub fn directions(mut state: u16) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        (state != 0).then(|| {
            let lowest = state.trailing_zeros() as usize;
            state &= state - 1;
            lowest
        })
    })
}

/// For each set of seven bits: the number of set bits, and their positions in ascending order.
const SET_BITS: [(u8, [u8; 7]); 128] = set_bits();

const fn set_bits() -> [(u8, [u8; 7]); 128] {
    let mut all = [(0, [0; 7]); 128];
    let mut set = 0;
    while set < 128 {
        let mut bit = 0;
        while bit < 7 {
            if set >> bit & 1 == 1 {
                all[set].1[all[set].0 as usize] = bit;
                all[set].0 += 1;
            }
            bit += 1;
        }
        set += 1;
    }
    all
}

/// Returns the position of the `n`-th set bit of a state, counted from 0 at the lowest. The state must have more than
/// `n` set bits.
// Uses no branch, because its outcome would be unpredictable.
#[inline]
#[must_use]
pub fn nth(state: u16, n: u32) -> usize {
    let low = usize::from(state & 0x7F);
    let high = usize::from(state >> 7 & 0x7F);
    let below = u32::from(SET_BITS[low].0);
    let is_high = n >= below;
    let (set, n) = if is_high { (high, n - below) } else { (low, n) };
    usize::from(SET_BITS[set].1[n as usize % 7]) + 7 * usize::from(is_high)
}

/// Returns the opposites of all directions of a state, as a state.
#[must_use]
pub fn turned_round(state: u16) -> u16 {
    directions(state).fold(0, |turned, d| turned | 1 << OPPOSITE[d])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn neighbours_are_at_one_and_root_three_every_thirty_degrees() {
        for d in 1..=12 {
            let (x, y) = in_bonds(STEPS[d]);
            let expected = if d <= 6 { 1.0 } else { 3.0 };
            assert!((x * x + y * y - expected).abs() < 1e-15, "{d}");
            assert_eq!((STEPS[d].0 + STEPS[d].1) % 2, 0, "sites of equal parity");
            assert_eq!(momentum(1 << d | 1 << OPPOSITE[d]), (0, 0));
        }
        let clockwise = [90, 30, -30, -90, -150, 150, 60, 0, -60, -120, 180, 120];
        for (d, degrees) in (1..).zip(clockwise) {
            assert!((angle(d) - f64::from(degrees)).abs() < 1e-12, "{d}");
        }
    }

    #[test]
    fn named_sets_contain_the_right_directions() {
        assert_eq!(
            directions(DESCENDING).collect::<Vec<_>>(),
            (1..=12).filter(|&d| STEPS[d].1 < 0).collect::<Vec<_>>()
        );
        let is_level = |&d: &usize| angle(d).abs() < 31.0 || angle(d).abs() > 149.0;
        assert_eq!(directions(LEVEL).collect::<Vec<_>>(), (1..=12).filter(is_level).collect::<Vec<_>>());
        for (d, (a, b)) in (7..).zip(FLANKS) {
            let between = (STEPS[a].0 + STEPS[b].0, STEPS[a].1 + STEPS[b].1);
            assert_eq!(STEPS[d], between, "the bond of {d} passes between {a} and {b}");
        }
    }

    #[test]
    fn nth_finds_the_set_bits_in_ascending_order() {
        for state in 0..1 << 13 {
            for (n, bit) in (0..).zip(directions(state)) {
                assert_eq!(nth(state, n), bit, "{state:#b}");
            }
        }
        assert_eq!(turned_round(1 << 1 | 1 << 9), 1 << 4 | 1 << 12);
    }
}
