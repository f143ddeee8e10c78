//! Grains of a frame as discs: their places on the picture, their order and their colours.

use rustc_hash::FxHashMap;

use super::camera::Camera;
use super::style::Style;
use super::{hidden, point, shades};
use glam::{DVec2, DVec3};
use siloflow_figures::colour::{self, Rgb};
use siloflow_files::frames::{Frame, Header, ParticleKey};

/// Grains, wall grains and door grains of a frame.
pub(super) struct Grains {
    all: Vec<Grain>,
    /// Row of each id.
    rows: FxHashMap<ParticleKey, usize>,
}

/// A grain of a frame. Lengths are in m.
#[derive(Clone, Copy, Debug)]
pub(super) struct Grain {
    pub position: DVec3,
    pub radius: f64,
    pub species: u8,
    /// 0 grain, 1 wall grain, 2 door grain.
    pub kind: u8,
    /// Distance along the direction of looking.
    depth: f64,
    /// Whether it is behind the cut, if there is one.
    pub is_shown: bool,
    colour: Rgb,
}

impl Grains {
    pub fn of(header: &Header, frame: &Frame, style: &Style) -> Self {
        let none = Self { all: Vec::new(), rows: FxHashMap::default() };
        let Some(table) = frame.table("grains") else { return none };
        let (Some(positions), Some(radii)) = (table.floats("position"), table.floats("radius")) else { return none };
        let bytes = |name: &str| table.numbers(name).unwrap_or_else(|| vec![0.0; table.rows]);
        let kinds = bytes("kind");
        let species = bytes("species");
        let shades = shades::of(header, frame, style);
        let map = shades::map(header, style);
        let cut = style.depth_of_cut(header).unwrap_or(f64::NEG_INFINITY);
        let mut all = Vec::with_capacity(table.rows);
        for (row, &radius) in radii.iter().enumerate() {
            let Some(position) = point(positions, header.dimension, row) else { break };
            let kind = byte(kinds[row]);
            let species = byte(species[row]);
            let colour = match (kind, shades.get(row)) {
                (2, _) => colour::DOOR,
                (1, _) => colour::WALL,
                (_, None) => colour::species(species),
                (_, Some(&share)) => map(share),
            };
            let depth = style.camera.depth.dot(position);
            all.push(Grain { position, radius, species, kind, depth, is_shown: depth >= cut, colour });
        }
        let keys = table.particles("id", "sphere").filter(|_| style.network.is_some()).unwrap_or_default();
        Self { all, rows: keys.into_iter().enumerate().map(|(row, key)| (key, row)).collect() }
    }

    /// Returns a particle.
    pub fn particle(&self, key: ParticleKey) -> Option<&Grain> {
        self.all.get(*self.rows.get(&key)?)
    }

    /// Returns the species of the grains.
    pub fn species(&self) -> impl Iterator<Item = u8> {
        self.all.iter().filter(|grain| grain.kind == 0 && grain.is_shown).map(|grain| grain.species)
    }

    /// Returns the mean place of the grains, m; `None` if there is none.
    pub fn middle(&self) -> Option<DVec3> {
        let grains = || self.all.iter().filter(|grain| grain.kind == 0);
        #[expect(clippy::cast_precision_loss, reason = "a number of grains")]
        let count = grains().count() as f64;
        (count > 0.0).then(|| grains().map(|grain| grain.position).sum::<DVec3>() / count)
    }

    /// Returns the discs that can be seen, from back to front.
    pub fn discs(&self, style: &Style, is_solid: bool) -> Vec<(DVec2, f64, Rgb)> {
        let mut shown: Vec<&Grain> = self.all.iter().filter(|grain| grain.is_shown).collect();
        // At equal depth in the order of ids.
        shown.sort_by(|a, b| b.depth.total_cmp(&a.depth));
        let mut discs: Vec<_> = shown
            .into_iter()
            .map(|grain| (style.camera.on_paper(grain.position), grain.radius, grain.colour))
            .filter(|&(centre, radius, _)| is_in_view(style, centre, radius))
            .collect();
        if is_solid {
            let seen = hidden::seen(&discs, style.view, style.width);
            let mut seen = seen.into_iter();
            discs.retain(|_| seen.next().unwrap_or(true));
        }
        discs
    }
}

/// Returns lower left and upper right corner of the box around the grains of a frame, without wall grains, m, in the axes of the camera; `None` without grains.
#[must_use]
pub fn box_of_grains(header: &Header, frame: &Frame, camera: &Camera) -> Option<(DVec2, DVec2)> {
    let table = frame.table("grains")?;
    let (positions, kinds) = (table.floats("position")?, table.numbers("kind")?);
    let balls = table.floats("radius")?.iter().zip(kinds).enumerate().filter(|(_, (_, kind))| *kind < 0.5);
    let boxes = balls.filter_map(|(row, (&radius, _))| {
        let centre = camera.on_paper(point(positions, header.dimension, row)?);
        Some((centre - radius, centre + radius))
    });
    boxes.reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)))
}

/// Returns a byte that a column has as a float.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a byte")]
fn byte(number: f64) -> u8 {
    number as u8
}

fn is_in_view(style: &Style, centre: DVec2, radius: f64) -> bool {
    let (low, high) = style.view;
    (centre + radius).cmpge(low).all() && (centre - radius).cmple(high).all()
}
