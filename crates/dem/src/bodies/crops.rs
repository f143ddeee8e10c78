//! Sizes of grains, from the literature: means of length, width and thickness.
//!
//! | grain | length, width, thickness, mm | moisture | source |
//! |---|---|---|---|
//! | rice, with its husk (Hashemi) | 10.20, 2.31, 1.85 | 8 % d.b. | Zareiforoush et al., Res. J. Appl. Sci. Eng. Technol. 1, 132 (2009) |
//! | wheat | 7.08, 3.27, 2.98 | 7.4 % d.b. | Tabatabaeefar, Int. Agrophys. 17, 207 (2003) |
//! | maize (dent corn, Simon) | 10.54, 7.26, 4.57 | 12.8 to 17 % d.b. | Sezer et al., Afr. J. Biotechnol. 10 (2011) |
//! | soybean | 7.24, 6.79, 5.78 | 8 % | Kibar and Ozturk, Int. Agrophys. 22, 239 (2008) |
//! | lentil (green Laird) | 6.72, 6.72, 2.58 | 11.4 % d.b. | Isik, Pak. J. Biol. Sci. 10, 474 (2007) |
//!
//! Each is taken as an ellipsoid with these axes. A kernel of maize is a wedge rather than an ellipsoid, and the germ of wheat has a crease: who needs
//! them gives a mesh.

use serde::{Deserialize, Serialize};

use crate::space::Solid;

/// A kind of grain.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
pub enum Crop {
    /// Rice with its husk.
    Rice,
    /// Wheat.
    Wheat,
    /// Maize.
    Maize,
    /// Soybean.
    Soybean,
    /// Lentil.
    Lentil,
}

impl Crop {
    /// All kinds.
    pub const ALL: [Self; 5] = [Self::Rice, Self::Wheat, Self::Maize, Self::Soybean, Self::Lentil];

    /// Returns the full lengths of the axes, m.
    #[must_use]
    pub fn axes(self) -> Solid {
        let [x, y, z] = match self {
            Self::Rice => [10.20, 2.31, 1.85],
            Self::Wheat => [7.08, 3.27, 2.98],
            Self::Maize => [10.54, 7.26, 4.57],
            Self::Soybean => [7.24, 6.79, 5.78],
            Self::Lentil => [6.72, 6.72, 2.58],
        };
        Solid::new(x, y, z) / 1000.0
    }

    /// Returns the number of spheres unless the scene gives one.
    #[must_use]
    pub fn spheres(self) -> u16 {
        match self {
            Self::Rice => 9,
            Self::Wheat => 7,
            Self::Maize => 15,
            Self::Soybean => 5,
            Self::Lentil => 19,
        }
    }
}
