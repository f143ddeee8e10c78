//! Snapshots: `frames/NNNNN.svg` every `pictures.interval` seconds and at the end, and PNGs beside them if asked.
//!
//! Wall grains are red and door grains green, as the assignment wants them; grains are coloured by species, speed,
//! or pressure, the sum of a grain's elastic contact forces over its circumference. A speed or pressure scale is
//! fixed by the scene, so that pictures of a run can be compared.

use std::f64::consts::PI;
use std::path::PathBuf;

use bevy_app::{App, Plugin};
use bevy_ecs::prelude::*;
use serde::{Deserialize, Serialize};

use crate::columns::{Columns, Slot};
use crate::contact::AnyLaw;
use crate::contact::survey::{self, Partner};
use crate::grains::spawner::RadiusLaw;
use crate::ledger::Ledger;
use crate::measure::{ObserveStage, due, observe_every};
use crate::neighbours::Search;
use crate::outcome::{Failure, Outcome};
use crate::output::colour::{self, Rgb};
use crate::output::png;
use crate::output::svg::{Legend, Picture};
use crate::particle::{Door, Fixed, Grain, Position, Radius, Species, Velocity};
use crate::scene::load::Loaded;
use crate::scene::values::{FiniteVector, Positive};
use crate::space::Vector;
use crate::step::{Clock, Step};
use crate::walls::surfaces::{Surface, Surfaces};

/// The scene's `pictures`.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct Pictures {
    /// Time between pictures, s.
    pub interval: Positive,
    /// Width, px.
    pub width: Positive,
    /// What colours the grains.
    pub colour: Colour,
    /// Whether PNGs are written beside the SVGs.
    pub png: bool,
    /// The view, lower left and upper right corner, m; by default, all walls and grains of the start.
    pub view: Option<(FiniteVector, FiniteVector)>,
}

/// What colours the grains.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize, Serialize)]
pub enum Colour {
    /// The species: the sizes of a mixture.
    #[default]
    Species,
    /// The speed, from 0 to this, m/s.
    Speed(Positive),
    /// The pressure, from 0 to this, N/m.
    Pressure(Positive),
}

impl Default for Pictures {
    fn default() -> Self {
        let positive = |number: f64| Positive::try_from(number).expect("positive");
        Self { interval: positive(1.0), width: positive(600.0), colour: Colour::Species, png: false, view: None }
    }
}

/// Where pictures go, and what is the same in all of them.
#[derive(Resource, Clone)]
pub struct Studio {
    /// What the scene says.
    pub pictures: Pictures,
    /// The directory.
    pub directory: PathBuf,
    /// Lower left and upper right corner of the view, m.
    pub view: (Vector, Vector),
    /// The scene's title.
    pub title: String,
    /// Names of the species.
    pub species: Vec<String>,
}

/// Pictures taken so far.
#[derive(Resource, Default)]
struct Taken(u32);

type Bodies<'w, 's> = Query<
    'w,
    's,
    (
        &'static Slot,
        &'static Position,
        &'static Velocity,
        &'static Radius,
        Option<&'static Species>,
        Has<Fixed>,
        Has<Door>,
        Has<Grain>,
    ),
>;

fn take(
    (clock, ledger, columns, search): (Res<Clock>, Res<Ledger>, Res<Columns>, Res<Search>),
    (walls, law, studio): (Res<Surfaces>, Res<AnyLaw>, Res<Studio>),
    bodies: Bodies,
    mut taken: ResMut<Taken>,
    mut outcome: ResMut<Outcome>,
) {
    let pressures = match studio.pictures.colour {
        Colour::Pressure(_) => pressures(&columns, &search, &walls.0, &law),
        _ => Vec::new(),
    };
    let mut rows: Vec<_> = bodies.iter().collect();
    rows.sort_unstable_by_key(|row| row.0.index());
    let discs = rows.into_iter().map(|(slot, x, v, radius, species, _, is_door, is_grain)| {
        let colour: Rgb = match studio.pictures.colour {
            _ if is_door => colour::DOOR,
            _ if !is_grain => colour::WALL,
            Colour::Species => colour::species(species.map_or(0, |species| species.0)),
            Colour::Speed(top) => colour::viridis(v.0.length() / top.get()),
            Colour::Pressure(top) => colour::viridis(pressures.get(slot.index()).map_or(0.0, |p| p / top.get())),
        };
        (x.0, radius.0, colour)
    });
    let picture = Picture {
        low: studio.view.0,
        high: studio.view.1,
        width: studio.pictures.width.get(),
        header: vec![
            studio.title.clone(),
            format!("t = {:.2} s", clock.time()),
            format!("inside {}, out {}, lost {} grains", ledger.inside(), ledger.out(), ledger.lost()),
        ],
        legend: studio.legend(),
        discs: discs.collect(),
        lines: walls.0.iter().map(|wall| studio.line(wall)).collect(),
    };
    if let Err(failure) = studio.save(taken.0, &picture.to_svg()) {
        outcome.fail(failure);
    }
    taken.0 += 1;
}

/// Sum of the elastic contact forces over the circumference, for each entry of the columns, N/m.
fn pressures(columns: &Columns, search: &Search, walls: &[Surface], law: &AnyLaw) -> Vec<f64> {
    let mut sums = vec![0.0; columns.len()];
    survey::contacts(columns, search, walls, |i, partner, pair| {
        let force = law.0.force(pair).elastic.length();
        sums[i] += force;
        if let Partner::Particle(j) = partner {
            sums[j] += force;
        }
    });
    sums.iter().zip(&columns.body).map(|(sum, body)| sum / (2.0 * PI * body.radius)).collect()
}

impl Studio {
    /// The studio of a scene, if it wants pictures.
    #[must_use]
    pub fn of(loaded: &Loaded, directory: PathBuf) -> Option<Self> {
        let pictures = loaded.scene.pictures.clone()?;
        let view = pictures.view.map_or_else(|| everything(loaded), |(low, high)| (low.get(), high.get()));
        let title = if loaded.scene.title.is_empty() { loaded.name.clone() } else { loaded.scene.title.clone() };
        let species = match loaded.scene.spawner.as_ref().map(|spawner| &spawner.radius) {
            Some(RadiusLaw::Fixed(radius)) => vec![format!("R = {} m", radius.get())],
            Some(RadiusLaw::Uniform(low, high)) => vec![format!("R = {} to {} m", low.get(), high.get())],
            Some(RadiusLaw::Mixture(sizes)) => {
                sizes.iter().map(|(radius, _)| format!("R = {} m", radius.get())).collect()
            }
            None => Vec::new(),
        };
        Some(Self { pictures, directory, view, title, species })
    }

    fn legend(&self) -> Legend {
        let scale = |to: Positive, title: &str| Legend::Scale { from: 0.0, to: to.get(), title: title.to_owned() };
        match self.pictures.colour {
            Colour::Species => Legend::Classes(
                (0..=u8::MAX)
                    .zip(&self.species)
                    .map(|(number, name)| (name.clone(), colour::species(number)))
                    .collect(),
            ),
            Colour::Speed(top) => scale(top, "speed, m/s"),
            Colour::Pressure(top) => scale(top, "pressure, N/m"),
        }
    }

    /// A wall as a line; that of a half-plane spans the view.
    fn line(&self, wall: &Surface) -> (Vector, Vector) {
        match *wall {
            Surface::Segment { from, to } => (from, to),
            Surface::HalfPlane { point, normal } => {
                let reach = self.view.0.distance(self.view.1) * normal.perp();
                let middle = 0.5 * (self.view.0 + self.view.1);
                let foot = middle - (middle - point).dot(normal) * normal;
                (foot - reach, foot + reach)
            }
        }
    }

    fn save(&self, number: u32, svg: &str) -> Result<(), Failure> {
        let path = self.directory.join(format!("{number:05}.svg"));
        let failed = |path: &PathBuf, reason: String| Failure::Output { path: path.display().to_string(), reason };
        std::fs::write(&path, svg).map_err(|error| failed(&path, error.to_string()))?;
        if self.pictures.png {
            let png_path = path.with_extension("png");
            let bytes = png::encode(svg).map_err(|reason| failed(&png_path, reason))?;
            std::fs::write(&png_path, bytes).map_err(|error| failed(&png_path, error.to_string()))?;
        }
        Ok(())
    }
}

/// A view of all walls, of where grains start, and down to the cull line, m.
fn everything(loaded: &Loaded) -> (Vector, Vector) {
    let disc = |centre: Vector, radius: f64| [centre - Vector::splat(radius), centre + Vector::splat(radius)];
    let mut corners: Vec<Vector> = Vec::new();
    corners.extend(loaded.wall_discs().iter().chain(&loaded.silo.door).flat_map(|d| disc(d.centre, d.radius)));
    corners.extend(loaded.grains.iter().flat_map(|g| disc(g.position, g.radius)));
    if let (Some(spawner), Some((_, largest))) = (&loaded.scene.spawner, loaded.grain_radii()) {
        corners.extend(disc(spawner.point.get(), largest));
    }
    for surface in loaded.surfaces() {
        match surface {
            Surface::Segment { from, to } => corners.extend([from, to]),
            Surface::HalfPlane { point, .. } => corners.push(point),
        }
    }
    if let (Some(cull), Some(any)) = (loaded.scene.cull, corners.first().copied()) {
        corners.push(Vector::new(any.x, cull.below.get()));
    }
    let low = corners.iter().copied().reduce(Vector::min).unwrap_or(Vector::ZERO);
    let high = corners.iter().copied().reduce(Vector::max).unwrap_or(Vector::ONE);
    // A view is at least half as wide as it is high, so that the labels have room.
    let size = high - low;
    let margin = Vector::splat(0.04 * size.max_element().max(1e-6));
    let widen = Vector::new((0.25 * size.y - 0.5 * size.x).max(0.0), 0.0);
    (low - margin - widen, high + margin + widen)
}

/// Takes snapshots.
pub struct FramesPlugin(pub Studio);

impl Plugin for FramesPlugin {
    fn build(&self, app: &mut App) {
        observe_every::<Pictures>(app, self.0.pictures.interval.get());
        app.insert_resource(self.0.clone())
            .init_resource::<Taken>()
            .add_systems(Step, take.in_set(ObserveStage::Write).run_if(due::<Pictures>));
    }
}
