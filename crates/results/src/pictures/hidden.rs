//! Which spheres can be seen. A dense bed hides most of its spheres, and a picture without them is a fraction as long.
//!
//! Discs cover pixels from front to back. A disc can be seen if it covers the middle of a pixel that no disc in front of it covers,
//! or if it is smaller than a pixel.

use glam::DVec2;
use siloflow_figures::colour::Rgb;

/// Pixels of the check for each pixel of the width: a sliver of less than half a pixel is not seen.
const FINENESS: f64 = 2.0;

/// Most pixels of the check along a side.
const MOST: f64 = 4000.0;

/// Returns for each disc, in an order from back to front, whether it can be seen.
pub(super) fn seen(discs: &[(DVec2, f64, Rgb)], (low, high): (DVec2, DVec2), width: f64) -> Vec<bool> {
    let size = high - low;
    let scale = (FINENESS * width).min(MOST) / size.x;
    let scale = scale.min(MOST / size.y);
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "at most MOST")]
    let [columns, rows] = [size.x, size.y].map(|side| (side * scale).ceil().max(1.0) as usize);
    let mut is_covered = vec![false; columns * rows];
    let mut seen: Vec<bool> = discs
        .iter()
        .rev()
        .map(|&(centre, radius, _)| cover(&mut is_covered, columns, (centre - low) * scale, radius * scale))
        .collect();
    seen.reverse();
    seen
}

/// Covers the pixels whose middles lie in a disc. Returns whether one of them was not covered, or there is no such pixel.
fn cover(is_covered: &mut [bool], columns: usize, centre: DVec2, radius: f64) -> bool {
    let rows = is_covered.len() / columns;
    let mut has_pixels = false;
    let mut is_seen = false;
    for row in middles(centre.y, radius, rows) {
        #[expect(clippy::cast_precision_loss, reason = "a number of pixels")]
        let height = row as f64 + 0.5 - centre.y;
        let half = (radius * radius - height * height).max(0.0).sqrt();
        let line = middles(centre.x, half, columns);
        if line.is_empty() {
            continue;
        }
        has_pixels = true;
        for pixel in &mut is_covered[row * columns + line.start..row * columns + line.end] {
            is_seen |= !*pixel;
            *pixel = true;
        }
    }
    is_seen || !has_pixels
}

/// Returns the pixels of a row of `count` whose middles are at most `reach` from `centre`.
fn middles(centre: f64, reach: f64, count: usize) -> std::ops::Range<usize> {
    #[expect(clippy::cast_precision_loss, reason = "a number of pixels")]
    let most = count as f64;
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped")]
    let [start, end] =
        [(centre - reach - 0.5).ceil(), (centre + reach - 0.5).floor() + 1.0].map(|end| end.clamp(0.0, most) as usize);
    start..end.max(start)
}

#[cfg(test)]
mod tests {
    use super::*;

    const VIEW: (DVec2, DVec2) = (DVec2::ZERO, DVec2::new(10.0, 10.0));

    fn seen_among(discs: &[(f64, f64, f64)]) -> Vec<bool> {
        let discs: Vec<_> = discs.iter().map(|&(x, y, r)| (DVec2::new(x, y), r, [0; 3])).collect();
        seen(&discs, VIEW, 200.0)
    }

    #[test]
    fn only_what_is_wholly_covered_is_hidden() {
        // From back to front: behind the last one, sticking out, apart, in front.
        assert_eq!(
            seen_among(&[(5.0, 5.0, 1.0), (5.0, 6.2, 1.0), (2.0, 2.0, 1.0), (5.0, 5.0, 1.1)]),
            [false, true, true, true]
        );
        // Two discs cover it together.
        let pair = [(5.0, 4.4, 1.0), (5.0, 5.6, 1.0)];
        assert!(!seen_among(&[&[(5.0, 5.0, 0.5)][..], &pair].concat())[0]);
        assert!(seen_among(&[&[(5.0, 5.0, 0.9)][..], &pair].concat())[0]);
    }

    #[test]
    fn discs_below_a_pixel_and_discs_at_the_edge_are_kept() {
        assert_eq!(seen_among(&[(5.01, 5.01, 1e-3), (0.0, 0.0, 1.0), (9.99, 12.0, 2.5)]), [true; 3]);
    }
}
