//! Colours: categories for species, and the perceptually uniform map viridis for numbers.

/// A colour as red, green and blue, each from 0 to 255.
pub type Rgb = [u8; 3];

/// Colour of walls of the plane, and of wall grains.
pub const WALL: Rgb = [0xd0, 0x2b, 0x2b];
/// Colour of wall surfaces of solid space, which are translucent.
pub const SURFACE: Rgb = [0x6b, 0x77, 0x85];
/// Colour of doors and door grains.
pub const DOOR: Rgb = [0x1f, 0x9d, 0x3a];

/// Colours of species, distinguishable with colour blindness (Okabe and Ito, without red and green).
const SPECIES: [Rgb; 5] =
    [[0x00, 0x72, 0xb2], [0xe6, 0x9f, 0x00], [0xcc, 0x79, 0xa7], [0x56, 0xb4, 0xe9], [0xf0, 0xe4, 0x42]];

/// Returns the colour of a species. Colours repeat after five species.
#[must_use]
pub fn species(number: u8) -> Rgb {
    SPECIES[usize::from(number) % SPECIES.len()]
}

/// Viridis (Smith and van der Walt, matplotlib, CC0) at eleven equally spaced values.
const VIRIDIS: [Rgb; 11] = [
    [68, 1, 84],
    [72, 36, 117],
    [65, 68, 135],
    [53, 95, 141],
    [42, 120, 142],
    [33, 145, 140],
    [34, 168, 132],
    [68, 191, 112],
    [122, 209, 81],
    [189, 223, 38],
    [253, 231, 37],
];

/// Returns the viridis colour of a number from 0 to 1. Other numbers are clamped; NaN counts as 0.
#[must_use]
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped to the table and to bytes")]
pub fn viridis(share: f64) -> Rgb {
    let place = if share.is_nan() { 0.0 } else { share.clamp(0.0, 1.0) * 10.0 };
    let below = (place as usize).min(9);
    let part = place - f64::from(below as u8);
    std::array::from_fn(|channel| {
        let a = f64::from(VIRIDIS[below][channel]);
        let b = f64::from(VIRIDIS[below + 1][channel]);
        (a + part * (b - a)).round() as u8
    })
}

/// Returns blue for 0, white for 0.5 and red for 1 (ColorBrewer's RdBu, reversed). Other numbers are clamped; NaN counts as 0.
#[must_use]
pub fn blue_red(share: f64) -> Rgb {
    const ENDS: [Rgb; 3] = [[0x21, 0x66, 0xac], [0xf7, 0xf7, 0xf7], [0xb2, 0x18, 0x2b]];
    let place = if share.is_nan() { 0.0 } else { 2.0 * share.clamp(0.0, 1.0) };
    if place < 1.0 { mix(ENDS[0], ENDS[1], place) } else { mix(ENDS[1], ENDS[2], place - 1.0) }
}

/// Returns the grey of a number from 0 (white) to 1 (black). Other numbers are clamped; NaN counts as 0.
#[must_use]
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped to a byte")]
pub fn grey(share: f64) -> Rgb {
    let share = if share.is_nan() { 0.0 } else { share.clamp(0.0, 1.0) };
    [(255.0 * (1.0 - share)).round() as u8; 3]
}

/// Returns a mixture of two colours: `share` of the second, from 0 to 1.
#[must_use]
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "between two bytes")]
pub fn mix(a: Rgb, b: Rgb, share: f64) -> Rgb {
    std::array::from_fn(|channel| (f64::from(a[channel]) * (1.0 - share) + f64::from(b[channel]) * share).round() as u8)
}

/// Returns a colour in the notation of SVG, `#rrggbb`.
#[must_use]
pub fn hex([r, g, b]: Rgb) -> String {
    format!("#{r:02x}{g:02x}{b:02x}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn map_passes_through_its_table_and_is_clamped() {
        assert_eq!(viridis(0.0), VIRIDIS[0]);
        assert_eq!(viridis(0.5), VIRIDIS[5]);
        assert_eq!(viridis(7.0), VIRIDIS[10]);
        assert_eq!(viridis(f64::NAN), viridis(0.0));
        assert_eq!(hex(DOOR), "#1f9d3a");
        assert_eq!([0.0, 0.5, 1.0].map(blue_red).map(hex), ["#2166ac", "#f7f7f7", "#b2182b"]);
    }
}
