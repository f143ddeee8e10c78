//! Loads on walls by height: pressure and wall friction in rings of a silo.
//!
//! Every `sample` seconds each contact with a wall of the band's name adds its force on the wall to the bin of the height of its
//! contact point. After `average` seconds, or at the end of the run, the sums become means over the area of the walls in the
//! bin (module `walls::area` of `siloflow_dem`, for walls in the places of the start):
//!
//! * *pressure*: sum of the normal forces, over the area;
//! * *downward traction*: sum of the downward components of the frictional forces on the wall, over the area.
//!
//! Units are Pa; in the plane N/m. Forces are those of the contact law at the end of a step. A bin without walls has no area; its
//! pressure is not a number (`NaN`).

use serde::{Deserialize, Serialize};

use siloflow_dem::persist::Problem;
use siloflow_dem::space::Space;
use siloflow_dem::survey::{Partner, Survey};
use siloflow_dem::values::{Finite, NonNegative, Positive};
use siloflow_dem::walls::surface::Surface;

/// One entry of the scene key `wall_bands`.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct WallBands {
    /// The `name` of the walls.
    pub walls: String,
    /// Lower end of the first bin, m.
    pub low: Finite,
    /// Upper end of the last bin, m.
    pub high: Finite,
    /// Number of bins.
    pub bins: u16,
    /// Time between samples, s.
    pub sample: Positive,
    /// Time of the first sample, s. Default 0.
    #[serde(default)]
    pub from: Option<NonNegative>,
    /// Time over which samples are averaged, s. Default: the whole run.
    #[serde(default)]
    pub average: Option<Positive>,
}

/// Means of one bin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BandMeans {
    /// Lower and upper end of the bin, m.
    pub heights: [f64; 2],
    /// Area of the walls in the bin, m^2; in the plane their length, m.
    pub area: f64,
    /// Contacts in the bin per sample.
    pub contacts: f64,
    /// Normal force over area, Pa; in the plane N/m.
    pub pressure: f64,
    /// Downward frictional force over area, Pa; in the plane N/m.
    pub downward_traction: f64,
}

/// Sums of one bin: number of contacts, normal force and downward friction on the wall, N.
#[derive(Clone, Copy, Debug, Default, Deserialize, Serialize)]
struct Sums {
    contacts: u64,
    normal: f64,
    downward: f64,
}

/// Sums of the loads so far.
#[derive(Clone, Debug)]
pub struct BandSampler {
    /// Configuration.
    pub bands: WallBands,
    /// Numbers of the walls, ascending.
    walls: Vec<usize>,
    areas: Vec<f64>,
    sums: Vec<Sums>,
}

/// The sums of a [`BandSampler`] in a checkpoint.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub(crate) struct SavedBands(Vec<Sums>);

impl BandSampler {
    /// Makes a sampler without samples, of the walls with these numbers and surfaces.
    #[must_use]
    pub fn new<V: Space>(bands: WallBands, walls: Vec<usize>, surfaces: &[Surface<V>]) -> Self {
        let count = usize::from(bands.bins);
        let mut sampler = Self { bands, walls, areas: Vec::new(), sums: vec![Sums::default(); count] };
        let area =
            |[low, high]: [f64; 2]| surfaces.iter().filter_map(|wall| wall.shape().area_between(low, high)).sum();
        sampler.areas = (0..count).map(|bin| area(sampler.heights(bin))).collect();
        sampler
    }

    #[expect(clippy::cast_precision_loss, reason = "a bin number")]
    fn heights(&self, bin: usize) -> [f64; 2] {
        let low = self.bands.low.get();
        let high = self.bands.high.get();
        [bin, bin + 1].map(|bin| low + (high - low) * bin as f64 / f64::from(self.bands.bins))
    }

    /// Adds a sample of all contacts with the walls.
    pub fn add<V: Space>(&mut self, survey: Survey<'_, V>) {
        let low = self.bands.low.get();
        let high = self.bands.high.get();
        for contact in survey.touching_walls() {
            let Partner::Wall(wall) = contact.partner() else { continue };
            if self.walls.binary_search(&survey.walls.all[wall].number).is_err() {
                continue;
            }
            let height = (contact.from() + contact.to_partner()).height();
            let bin = ((height - low) / (high - low) * f64::from(self.bands.bins)).floor();
            if !(0.0..f64::from(self.bands.bins)).contains(&bin) {
                continue;
            }
            #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a valid bin number")]
            let sums = &mut self.sums[bin as usize];
            let force = contact.force();
            sums.contacts += 1;
            sums.normal += force.normal.dot(contact.normal());
            // The friction on the wall is the negative of the friction on the grain, and down is the negative of up.
            sums.downward += force.resistance.friction.height();
        }
    }

    /// Returns the means over this number of samples and resets the sums.
    #[expect(clippy::cast_precision_loss, reason = "counts are far below 2^53")]
    pub fn take(&mut self, samples: u64) -> Vec<BandMeans> {
        let samples = samples.max(1) as f64;
        let means = self.sums.iter().zip(&self.areas).enumerate().map(|(bin, (sums, &area))| BandMeans {
            heights: self.heights(bin),
            area,
            contacts: sums.contacts as f64 / samples,
            pressure: sums.normal / (samples * area),
            downward_traction: sums.downward / (samples * area),
        });
        let means = means.collect();
        self.sums.fill(Sums::default());
        means
    }

    /// Returns the sums so far, for a checkpoint.
    pub(crate) fn saved(&self) -> SavedBands {
        SavedBands(self.sums.clone())
    }

    /// Continues from saved sums.
    pub(crate) fn restore(&mut self, saved: SavedBands) -> Result<(), Problem> {
        if saved.0.len() != self.sums.len() {
            return Err("the number of bins differs".to_owned());
        }
        self.sums = saved.0;
        Ok(())
    }
}
