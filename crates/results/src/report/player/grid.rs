//! Places as whole numbers: multiples of one length, from a corner.
//!
//! The box of the grid holds the scene and all places of grains, as far as they are not further from the scene than its size. A grain
//! outside of the box has no place. The length is the longest side over 65535, the same along all axes.

/// Largest number of a grain's place along an axis.
const STEPS: f64 = 65535.0;

/// Largest number of a wall's point, with its sign.
const REACH: f64 = 1_073_741_823.0;

/// The grid of a run.
#[derive(Clone, Debug)]
pub(super) struct Grid {
    /// Lowest corner, m.
    pub low: [f64; 3],
    /// Highest corner, m.
    pub high: [f64; 3],
    /// Length of a step, m.
    pub step: f64,
}

impl Grid {
    /// Returns the grid of a scene between two corners with grains between two others (infinite and the wrong way round without grains).
    pub fn new(domain: [[f64; 3]; 2], grains: [[f64; 3]; 2]) -> Self {
        let size = (0..3).map(|axis| domain[1][axis] - domain[0][axis]).fold(0.0, f64::max);
        // A scene without a size, such as two grains on one spot, has all grains.
        let room = if size > 0.0 && size.is_finite() { size } else { f64::MAX.sqrt() };
        let finite = |number: f64| if number.is_finite() { number } else { 0.0 };
        let domain = domain.map(|corner| corner.map(finite));
        let low = [0, 1, 2].map(|axis| grains[0][axis].max(domain[0][axis] - room).min(domain[0][axis]));
        let high = [0, 1, 2].map(|axis| grains[1][axis].min(domain[1][axis] + room).max(domain[1][axis]));
        let longest = (0..3).map(|axis| high[axis] - low[axis]).fold(0.0, f64::max);
        let step = if longest > 0.0 { longest / STEPS } else { 1.0 / STEPS };
        Self { low, high, step }
    }

    /// Returns the place of a grain; `None` outside of the box.
    pub fn place(&self, position: &[f64]) -> Option<[u16; 3]> {
        let mut place = [0; 3];
        for (axis, coordinate) in position.iter().enumerate().take(3) {
            let number = ((coordinate - self.low[axis]) / self.step).round();
            if !(0.0..=STEPS).contains(&number) {
                return None;
            }
            place[axis] = whole(number);
        }
        Some(place)
    }

    /// Returns a point that may be outside of the box. A point further away than any scene reaches is moved nearer.
    #[expect(clippy::cast_possible_truncation, reason = "clamped; a number that is none becomes 0")]
    pub fn point(&self, point: [f64; 3]) -> [i32; 3] {
        [0, 1, 2].map(|axis| ((point[axis] - self.low[axis]) / self.step).round().clamp(-REACH, REACH) as i32)
    }
}

#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "the number is between 0 and 65535")]
fn whole(number: f64) -> u16 {
    number as u16
}

#[cfg(test)]
mod tests {
    use super::*;

    const NONE: [[f64; 3]; 2] = [[f64::INFINITY; 3], [f64::NEG_INFINITY; 3]];

    #[test]
    fn the_box_holds_the_scene_and_near_grains() {
        let scene = [[0.0, 0.0, 0.0], [1.0, 4.0, 0.0]];
        let alone = Grid::new(scene, NONE);
        assert_eq!((alone.low, alone.high, alone.step), (scene[0], scene[1], 4.0 / STEPS));
        let below = Grid::new(scene, [[0.5, -1.0, 0.0], [0.6, 3.0, 0.0]]);
        assert_eq!((below.low[1], below.high[1]), (-1.0, 4.0));
        let far = Grid::new(scene, [[0.5, -1000.0, 0.0], [0.6, 3.0, 0.0]]);
        assert!((far.low[1] + 4.0).abs() < 1e-12);
        assert_eq!(far.place(&[0.5, -1000.0]), None);
        assert_eq!(far.place(&[0.0, 4.0]), Some([0, 65535, 0]));
        assert_eq!(far.place(&[f64::NAN, 4.0]), None);
        assert_eq!(far.point([f64::NAN, 1e300, 0.0])[..2], [0, 1_073_741_823]);
    }

    #[test]
    fn a_scene_without_size_has_its_grains() {
        let grid = Grid::new([[2.0; 3]; 2], [[1.0; 3], [3.0; 3]]);
        assert_eq!(grid.place(&[3.0, 1.0]), Some([65535, 0, 0]));
        let still = Grid::new([[2.0; 3]; 2], NONE);
        assert_eq!(still.place(&[2.0, 2.0]), Some([0; 3]));
        let wrong = Grid::new([[f64::NEG_INFINITY; 3], [f64::NAN; 3]], NONE);
        assert!(wrong.step > 0.0 && wrong.step.is_finite());
    }
}
