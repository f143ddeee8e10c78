//! Pictures of a run: `frames/NNNNN.svg` every `pictures.interval` seconds and at the end, and PNGs if the scene wants
//! them.
//!
//! Wall grains are red and door grains green, as the assignment requires. Grains are coloured by species, speed or
//! pressure. The pressure of a grain is the sum of its elastic contact forces (N) over its circumference, or in solid
//! space over its surface. The scene fixes the scale of speed or pressure, so that pictures of a run can be compared.
//! With `network`, each contact is drawn as a bond between the centres. The width of a bond is proportional to the
//! normal force, and bonds of sliding contacts are orange.
//!
//! Solid space is drawn as an orthographic projection along y, with x to the right and z up, from back to front.

use std::f64::consts::PI;
use std::marker::PhantomData;
use std::path::PathBuf;

use bevy_app::{App, Plugin};
use bevy_ecs::prelude::*;

use crate::grains::spawner::RadiusLaw;
use crate::ledger::Ledger;
use crate::measure::{ObserveStage, due, observe_every};
use crate::outcome::Outcome;
use crate::particle::{Door, Grain, Radius, Slot, Species};
use crate::scene::load::Loaded;
use crate::scene::outputs::{Colour, Pictures};
use crate::scene::view;
use crate::space::{Dimension, Space, Vector};
use crate::step::{Clock, Step};
use crate::store::Body;
use crate::survey::{Partner, Survey, SurveyParam};
use crate::values::Positive;
use crate::walls::config::Wall;
use crate::walls::shapes::Shape as _;
use crate::walls::shapes::half_plane::HalfPlane;
use crate::walls::surfaces::{Surface, Surfaces};
use crate::writers::colour::{self, Rgb};
use crate::writers::frame_writer::FrameWriter;
use crate::writers::svg::{Legend, Picture};

/// Settings that all pictures of a run share.
#[derive(Resource, Clone)]
pub struct FrameRenderer {
    /// Section `pictures` of the scene.
    pub pictures: Pictures,
    /// Directory of the pictures.
    pub directory: PathBuf,
    /// Lower left and upper right corner of the view, m.
    pub view: (Vector, Vector),
    /// Title of the scene.
    pub title: String,
    /// Names of the species.
    pub species: Vec<String>,
    /// Radius of the smallest grain, m.
    pub smallest_radius: f64,
    /// Depth of the plane in which triangles are drawn, m: the middle of all walls with ends.
    pub section_depth: f64,
}

type Bodies<'w, 's> = Query<'w, 's, (&'static Slot, &'static Radius, Option<&'static Species>, Has<Door>, Has<Grain>)>;

/// Bond colours of sticking and of sliding contacts.
const BONDS: [Rgb; 2] = [[0x22, 0x22, 0x22], [0xff, 0x7f, 0x0e]];

fn draw_frame<V: Space>(
    (clock, ledger, survey_param): (Res<Clock>, Res<Ledger>, SurveyParam<V>),
    (walls, renderer): (Res<Surfaces<V>>, Res<FrameRenderer>),
    bodies: Bodies,
    mut frame_writer: ResMut<FrameWriter>,
    mut outcome: ResMut<Outcome>,
) {
    let survey = survey_param.survey();
    let pressures = match renderer.pictures.colour {
        Colour::Pressure(_) => pressures(&survey),
        _ => Vec::new(),
    };
    // A particle that has no slot yet is not drawn.
    let visible = bodies.iter().filter_map(|(slot, radius, species, is_door, is_grain)| {
        let Body { position: x, velocity: v, .. } = *survey.store.body.get(slot.index())?;
        Some((slot.index(), x, v, radius.0, species.copied().unwrap_or_default(), is_door, is_grain))
    });
    let mut rows: Vec<_> = visible.collect();
    // Sorted from back to front, and at equal depth by slot.
    rows.sort_unstable_by(|a, b| b.1.depth().total_cmp(&a.1.depth()).then(a.0.cmp(&b.0)));
    let discs = rows.into_iter().map(|(slot, x, v, radius, species, is_door, is_grain)| {
        let colour: Rgb = match renderer.pictures.colour {
            _ if is_door => colour::DOOR,
            _ if !is_grain => colour::WALL,
            Colour::Species => colour::species(species.0),
            Colour::Speed(top) => colour::viridis(v.length() / top.get()),
            Colour::Pressure(top) => colour::viridis(pressures.get(slot).map_or(0.0, |p| p / top.get())),
        };
        (x.on_paper(), radius, colour)
    });
    let picture = Picture {
        low: renderer.view.0,
        high: renderer.view.1,
        width: renderer.pictures.width.get(),
        header: renderer.header(clock.time(), &ledger),
        legend: renderer.legend(V::DIMENSION),
        discs: discs.collect(),
        outlined: V::DIMENSION == Dimension::Solid,
        bonds: renderer.bonds(&survey, clock.dt),
        lines: walls
            .all
            .iter()
            .filter(|wall| wall.is_present)
            .flat_map(|wall| renderer.lines(&wall.surface))
            .map(|(a, b)| (a, b, colour::WALL))
            .collect(),
        ..Picture::default()
    };
    frame_writer.add(picture, &mut outcome);
}

/// Returns the sum of the elastic contact forces over circumference (N/m) or surface (N/m^2) for each slot.
pub(crate) fn pressures<V: Space>(survey: &Survey<V>) -> Vec<f64> {
    let mut sums = vec![0.0; survey.store.len()];
    survey.contacts(|i, partner, pair, memory| {
        let force = survey.law.force(pair, &mut memory.clone()).elastic().length();
        sums[i] += force;
        if let Partner::Particle(j) = partner {
            sums[j] += force;
        }
    });
    let surface = |radius: f64| match V::DIMENSION {
        Dimension::Plane => 2.0 * PI * radius,
        Dimension::Solid => 4.0 * PI * radius * radius,
    };
    sums.iter().zip(&survey.store.body).map(|(sum, body)| sum / surface(body.radius)).collect()
}

/// Returns the names of the species that the first source of grains releases.
pub(crate) fn species_names(loaded: &Loaded) -> Vec<String> {
    let feed = loaded.scene.feed.first().map(|feed| &feed.radius);
    match loaded.scene.spawner.as_ref().map(|spawner| &spawner.radius).or(feed) {
        Some(RadiusLaw::Fixed(radius)) => vec![format!("R = {} m", radius.get())],
        Some(RadiusLaw::Uniform(low, high)) => vec![format!("R = {} to {} m", low.get(), high.get())],
        Some(RadiusLaw::Mixture(sizes)) => sizes.iter().map(|(radius, _)| format!("R = {} m", radius.get())).collect(),
        None => Vec::new(),
    }
}

impl FrameRenderer {
    /// Returns the renderer of a scene; `None` if the scene wants no pictures.
    #[must_use]
    pub fn of(loaded: &Loaded, directory: PathBuf) -> Option<Self> {
        let pictures = loaded.scene.pictures.clone()?;
        let view = view::of(loaded, &pictures);
        let title = if loaded.scene.title.is_empty() { loaded.source.name.clone() } else { loaded.scene.title.clone() };
        let species = species_names(loaded);
        let smallest_radius = loaded.grain_radii().map_or(0.0, |(smallest, _)| smallest);
        let depths = loaded.scene.walls.iter().filter_map(Wall::bounds).map(|ends| ends.map(Space::depth));
        let ends = depths.reduce(|[low, high], [from, to]| [low.min(from), high.max(to)]);
        let section_depth = ends.map_or(0.0, |[low, high]| 0.5 * (low + high));
        Some(Self { pictures, directory, view, title, species, smallest_radius, section_depth })
    }

    fn header(&self, time: f64, ledger: &Ledger) -> Vec<String> {
        // Enough decimals to distinguish the times of successive pictures.
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped")]
        let decimals = (1.0 - self.pictures.interval.get().log10().floor()).clamp(2.0, 9.0) as usize;
        let mut lines = vec![
            self.title.clone(),
            format!("t = {time:.decimals$} s"),
            format!("inside {}, out {}, lost {} grains", ledger.inside(), ledger.out(), ledger.lost()),
        ];
        if let Some(full) = self.pictures.network {
            lines.push(format!("bond as wide as a radius: {} N; sliding: orange", full.get()));
        }
        lines
    }

    /// Returns contact forces as bonds, if the scene wants them.
    ///
    /// A bond starts at the grain and ends at the nearest image of its partner, so a bond through a periodic side
    /// extends beyond that side.
    fn bonds<V: Space>(&self, survey: &Survey<V>, dt: f64) -> Vec<(Vector, Vector, f64, Rgb)> {
        let Some(full) = self.pictures.network else { return Vec::new() };
        let contacts = survey.view(dt).into_iter().filter(|contact| contact.normal_force > 0.0);
        contacts
            .map(|contact| {
                let width = (contact.normal_force / full.get()).min(1.0) * self.smallest_radius;
                let to = contact.from + contact.to_partner;
                (contact.from.on_paper(), to.on_paper(), width, BONDS[usize::from(contact.is_sliding)])
            })
            .collect()
    }

    fn legend(&self, dimension: Dimension) -> Legend {
        let scale = |to: Positive, title: &str| Legend::Scale {
            from: 0.0,
            to: to.get(),
            title: title.to_owned(),
            map: colour::viridis,
        };
        match self.pictures.colour {
            Colour::Species => Legend::Classes(
                (0..=u8::MAX)
                    .zip(&self.species)
                    .map(|(number, name)| (name.clone(), colour::species(number)))
                    .collect(),
            ),
            Colour::Speed(top) => scale(top, "speed, m/s"),
            Colour::Pressure(top) => {
                scale(top, if dimension == Dimension::Plane { "pressure, N/m" } else { "pressure, N/m²" })
            }
        }
    }

    /// Returns a wall as lines.
    ///
    /// A half-plane parallel to the direction of projection is drawn as a line through the whole view. Other
    /// half-planes are left out.
    fn lines<V: Space>(&self, wall: &Surface<V>) -> Vec<(Vector, Vector)> {
        let Surface::HalfPlane(HalfPlane { point, normal }) = *wall else {
            return wall.lines(self.section_depth).into_iter().map(|[a, b]| (a.on_paper(), b.on_paper())).collect();
        };
        if normal.depth().abs() > 1e-9 {
            return Vec::new();
        }
        let (point, normal) = (point.on_paper(), normal.on_paper());
        let reach = self.view.0.distance(self.view.1) * normal.perp();
        let middle = 0.5 * (self.view.0 + self.view.1);
        let foot = middle - (middle - point).dot(normal) * normal;
        vec![(foot - reach, foot + reach)]
    }
}

/// Draws the pictures of a run.
pub struct FramesPlugin<V: Space>(pub FrameRenderer, pub PhantomData<V>);

impl<V: Space> Plugin for FramesPlugin<V> {
    fn build(&self, app: &mut App) {
        observe_every::<Pictures>(app, self.0.pictures.interval.get());
        FrameWriter::persist(app);
        app.insert_resource(self.0.clone())
            .insert_resource(FrameWriter::new(self.0.directory.clone(), self.0.pictures.png))
            .add_systems(Step, draw_frame::<V>.in_set(ObserveStage::Write).run_if(due::<Pictures>));
    }
}
