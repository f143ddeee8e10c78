//! The longest move of any particle, and the setting of positions that records it.

use crate::space::Space;
use crate::store::ParticleStore;
use crate::store::mirror_set::MirrorSet;

/// The largest length of several displacements, as the bits of its square. For non-negative numbers, bits and numbers
/// have the same order. NaN bits are larger than all of them, so that a NaN survives; a maximum of numbers would
/// discard it.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct LongestMove(u64);

impl LongestMove {
    /// Includes the displacement `displacement`, m. Returns its squared length, m^2.
    #[inline]
    pub(crate) fn raise<V: Space>(&mut self, displacement: V) -> f64 {
        let squared = displacement.length_squared();
        self.0 = self.0.max(squared.to_bits());
        squared
    }

    /// Returns the larger of two.
    pub(crate) fn or(self, other: Self) -> Self {
        Self(self.0.max(other.0))
    }

    /// Returns the length, m; NaN if a displacement was not finite.
    pub(crate) fn length(self) -> f64 {
        let squared = f64::from_bits(self.0);
        if squared.is_finite() { squared.sqrt() } else { f64::NAN }
    }
}

impl<V: Space> ParticleStore<V> {
    /// Sets the position of row `i`, m, to the image of `x` in the box, and includes the displacement in `longest`.
    #[inline]
    pub(crate) fn put(&mut self, i: usize, x: V, longest: &mut LongestMove) {
        let displacement = x - self.body[i].position;
        longest.raise(self.periodic.map_or(displacement, |periodic| periodic.shortest(displacement)));
        self.body[i].position = x;
        if let Some(periodic) = &self.periodic
            && !periodic.contains(x)
        {
            self.body[i].position = periodic.wrapped(x);
            self.stale.add(MirrorSet::POSITION);
        }
        if let Some(body) = self.body_of_row(i) {
            self.place_spheres(body, longest);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::space::Vector;

    /// The largest of these displacements along x, m.
    fn longest(displacements: &[f64]) -> f64 {
        let mut longest = LongestMove::default();
        for &displacement in displacements {
            longest.raise(Vector::new(displacement, 0.0));
        }
        let [one, other] = [longest, LongestMove::default()];
        assert_eq!(one.or(other).length().to_bits(), other.or(one).length().to_bits());
        longest.length()
    }

    #[test]
    fn the_longest_move_is_found_and_nan_is_kept() {
        assert_eq!((longest(&[]), longest(&[1.0, -3.0, 2.0])), (0.0, 3.0));
        for not_finite in [f64::NAN, -f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            assert!(longest(&[not_finite, 1.0]).is_nan() && longest(&[1.0, not_finite]).is_nan(), "{not_finite}");
        }
    }
}
