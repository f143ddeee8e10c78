//! The keys of a scene of grains that select pictures, frames of data and rows.

use serde::{Deserialize, Serialize};

use siloflow_dem::values::{Finite, FiniteVector, Positive};
use siloflow_results::export::Format;
use siloflow_results::pictures::camera::Direction;

/// The scene's `pictures`.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct Pictures {
    /// Time between pictures, s. Default 1.
    pub interval: Positive,
    /// Width, px. Default 600.
    pub width: Positive,
    /// The quantity that colours the grains. Default `Species`.
    pub colour: Colour,
    /// Whether each SVG is also written as PNG. Default `false`.
    pub png: bool,
    /// Force whose bond is drawn as wide as the smallest radius, N; forces below a tenth of it are left out. Default: no contact forces are drawn.
    pub network: Option<Positive>,
    /// Lower left and upper right corner of the view, m, to the right and up in the picture; of solid space seen from the front in
    /// x and z. Default: all grains at the start and all walls; where no wall moves, walls up to the highest grain.
    pub view: Option<(FiniteVector, FiniteVector)>,
    /// Where the observer looks; in solid space only. Default `Front`.
    pub direction: Direction,
    /// Depth of the plane in front of which grains and walls are left out, m, along the direction of looking from the middle of the scene;
    /// in solid space only.
    pub cut: Option<Finite>,
}

/// The quantity that colours the grains.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize)]
pub enum Colour {
    /// The species: the sizes of a mixture.
    #[default]
    Species,
    /// The speed, from 0 to this, m/s.
    Speed(Positive),
    /// The pressure, from 0 to this, N/m, in solid space N/m^2.
    Pressure(Positive),
    /// A column of the table `grains` of [`frames.bin`](siloflow_files::frames), and the ends of the scale in the unit of the column.
    Column(String, Finite, Finite),
}

impl Colour {
    /// The columns of grains that frames have, of one number for each grain.
    pub const COLUMNS: [&str; 8] =
        ["id", "kind", "species", "radius", "mass", "pressure", "coordination", Self::INCLINATION];

    /// The column that only frames of scenes with shapes have.
    pub const INCLINATION: &str = "inclination";
}

impl Default for Pictures {
    fn default() -> Self {
        let positive = |number: f64| Positive::try_from(number).expect("positive");
        Self {
            interval: positive(1.0),
            width: positive(600.0),
            colour: Colour::Species,
            png: false,
            network: None,
            view: None,
            direction: Direction::Front,
            cut: None,
        }
    }
}

/// The scene's `data_frames`: what [`frames.bin`](siloflow_files::frames) holds.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct DataFrames {
    /// Time between frames, s. Default: enough frames for a movie wherever the run ends; without pictures there are no frames then.
    pub interval: Option<Positive>,
    /// Whether frames hold contacts. Default `true`.
    pub contacts: bool,
    /// Whether frames hold wall surfaces. Default `true`.
    pub walls: bool,
    /// Formats of other programs in which frames are also written. Default: none.
    pub format: Vec<Format>,
}

impl Default for DataFrames {
    fn default() -> Self {
        Self { interval: None, contacts: true, walls: true, format: Vec::new() }
    }
}

/// The scene's `series`.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Series {
    /// Time between rows of `series.csv`, `walls.csv`, `wall_groups.csv`, `free_walls.csv`, `slopes.csv` and `centres.csv`, s.
    pub interval: Positive,
}

impl Default for Series {
    fn default() -> Self {
        Self { interval: Positive::try_from(0.05).expect("positive") }
    }
}
