//! The style of a picture: its quantities, its colours and its direction of looking.

use crate::output::frame_data::{Frame, Header};
use crate::scene::camera::Camera;
use crate::scene::loaded::Loaded;
use crate::scene::outputs::{Colour, Pictures};
use crate::scene::view;
use siloflow_dem::space::{Dimension, Plane, Solid, Space, Vector};

/// Settings that all pictures of a run share. Lengths are in m.
#[derive(Clone, Debug, PartialEq)]
pub struct Style {
    /// Width, px.
    pub width: f64,
    /// The quantity that colours the grains.
    pub colour: Colour,
    /// Force, N, whose bond is as wide as the smallest radius; `None` draws no bonds.
    pub network: Option<f64>,
    /// Direction of looking.
    pub camera: Camera,
    /// Depth in front of which nothing is drawn, from the middle of the scene.
    pub cut: Option<f64>,
    /// Lower left and upper right corner of the view, in the axes of the camera.
    pub view: (Vector, Vector),
    /// Radius of the smallest grain.
    pub smallest_radius: f64,
    /// Decimals of the time.
    pub decimals: usize,
    /// Numbers of the walls without ends.
    pub endless: Vec<u32>,
}

impl Style {
    /// Returns the style of a scene's pictures. `pictures` is its section of that name, maybe changed.
    #[must_use]
    pub fn of(loaded: &Loaded, pictures: &Pictures) -> Self {
        let scene = &loaded.scene;
        let intervals = [scene.pictures.as_ref().map(|own| own.interval.get()), scene.data_frames().map(|(_, s)| s)];
        let interval = intervals.into_iter().flatten().fold(f64::INFINITY, f64::min);
        // Enough decimals to distinguish the times of successive pictures.
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped")]
        let decimals = (1.0 - interval.log10().floor()).clamp(2.0, 9.0) as usize;
        Self {
            width: pictures.width.get(),
            colour: pictures.colour.clone(),
            network: pictures.network.map(siloflow_dem::values::Positive::get),
            camera: Camera::new(scene.space, pictures.direction),
            cut: pictures.cut.map(siloflow_dem::values::Finite::get),
            view: view::of(loaded, pictures),
            smallest_radius: loaded.grain_radii().map_or(0.0, |(smallest, _)| smallest),
            decimals,
            endless: match scene.space {
                Dimension::Plane => endless::<Plane>(loaded),
                Dimension::Solid => endless::<Solid>(loaded),
            },
        }
    }

    /// Returns the depth of the cut along the direction of looking; `None` if nothing is cut.
    pub(super) fn depth_of_cut(&self, header: &Header) -> Option<f64> {
        let [low, high] = header.domain.map(Solid::from_array);
        self.cut.filter(|_| header.dimension == 3).map(|cut| self.camera.depth.dot(0.5 * (low + high)) + cut)
    }

    /// Checks that frames have the column that colours the grains.
    ///
    /// # Errors
    /// If they do not; the message lists the columns.
    pub fn check(&self, frame: &Frame) -> Result<(), String> {
        let Some(grains) = frame.table("grains") else { return Ok(()) };
        let name = match &self.colour {
            Colour::Species | Colour::Speed(_) => return Ok(()),
            Colour::Pressure(_) => "pressure",
            Colour::Column(name, ..) => name,
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

fn endless<V: Space>(loaded: &Loaded) -> Vec<u32> {
    let surfaces = loaded.surfaces::<V>();
    let endless = surfaces.iter().filter(|wall| wall.surface.bounds().is_none());
    endless.map(|wall| u32::try_from(wall.number + 1).unwrap_or(u32::MAX)).collect()
}
