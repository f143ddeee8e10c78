//! The style of a picture: its quantities, its colours and its direction of looking.

use glam::{DVec2, DVec3};

use siloflow_files::frames::{Frame, Header};

use super::camera::Camera;

/// The quantity that colours the grains.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum Colouring {
    /// The species.
    #[default]
    Species,
    /// The speed, from 0 to this, m/s.
    Speed(f64),
    /// The pressure, from 0 to this, N/m, in solid space N/m^2.
    Pressure(f64),
    /// A column of the table `grains`.
    Column {
        /// Name of the column.
        name: String,
        /// Value with the first colour.
        from: f64,
        /// Value with the last colour.
        to: f64,
    },
}

/// Settings that all pictures of a run share. Lengths are in m.
#[derive(Clone, Debug, PartialEq)]
pub struct Style {
    /// Width, px.
    pub width: f64,
    /// The quantity that colours the grains.
    pub colour: Colouring,
    /// Force, N, whose bond is as wide as the smallest radius; `None` draws no bonds.
    pub network: Option<f64>,
    /// Direction of looking.
    pub camera: Camera,
    /// Depth in front of which nothing is drawn, from the middle of the scene.
    pub cut: Option<f64>,
    /// Lower left and upper right corner of the view, in the axes of the camera.
    pub view: (DVec2, DVec2),
    /// Radius of the smallest grain.
    pub smallest_radius: f64,
    /// Decimals of the time.
    pub decimals: usize,
    /// Numbers of the walls without ends.
    pub endless: Vec<u32>,
}

impl Style {
    /// Returns the depth of the cut along the direction of looking; `None` if nothing is cut.
    pub(super) fn depth_of_cut(&self, header: &Header) -> Option<f64> {
        let [low, high] = header.domain.map(DVec3::from_array);
        self.cut.filter(|_| header.dimension == 3).map(|cut| self.camera.depth.dot(0.5 * (low + high)) + cut)
    }

    /// Checks that frames have the column that colours the grains.
    ///
    /// # Errors
    /// If they do not; the message lists the columns.
    pub fn check(&self, frame: &Frame) -> Result<(), String> {
        let Some(grains) = frame.table("grains") else { return Ok(()) };
        let name = match &self.colour {
            Colouring::Species | Colouring::Speed(_) => return Ok(()),
            Colouring::Pressure(_) => "pressure",
            Colouring::Column { name, .. } => name,
        };
        if grains.numbers(name).is_some() {
            return Ok(());
        }
        let columns: Vec<_> = grains.columns.iter().filter(|column| column.components == 1).collect();
        let columns = columns.iter().map(|column| column.name.as_str()).collect::<Vec<_>>().join(", ");
        Err(format!("grains have no column `{name}` of one number; the columns are: {columns}"))
    }
}

/// Returns the speed of each grain, m/s.
#[must_use]
pub fn speeds(header: &Header, frame: &Frame) -> Vec<f64> {
    let velocities = frame.table("grains").and_then(|grains| grains.floats("velocity")).unwrap_or_default();
    velocities
        .chunks(usize::from(header.dimension).max(1))
        .map(|v| v.iter().map(|component| component * component).sum::<f64>().sqrt())
        .collect()
}
