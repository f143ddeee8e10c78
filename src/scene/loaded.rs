//! A loaded scene, and what follows from its keys: laws, step, radii, measurements.

mod images;
mod walls;

use crate::grains::feed::Feed;
use crate::grains::file::GrainRow;
use crate::grains::fill::FixedGrain;
use crate::grains::shaped::{ShapeFacts, Shapes, largest_reach, size_ranges};
use crate::grains::sizes::RadiusLaw;
use crate::lattice_silo::loaded::LoadedLattice;
use crate::measure::fields::{Field, FieldSampler, Grid};
use crate::measure::profile::Profile;
use crate::scene::Scene;
use siloflow_dem::contact::config::Contact;
use siloflow_dem::contact::history::remembered::RememberedContacts;
use siloflow_dem::contact::selection::Contacts;
use siloflow_dem::integrate::Integrator;
use siloflow_dem::neighbours::Neighbours;
use siloflow_dem::space::{Dimension, Plane, Solid, Space};
use siloflow_dem::spin::InertiaLaw;
use siloflow_dem::values::Positive;
use siloflow_dem::walls::silo_file::SiloGeometry;
use siloflow_text::fault::{Fault, Warning};
use siloflow_text::source::Source;
use siloflow_text::suggestion::did_you_mean;

/// A scene of grains that is ready to run.
#[derive(Debug)]
pub struct Loaded {
    /// The parsed scene, with `--set` applied.
    pub scene: Scene,
    /// The scene's text.
    pub source: Source,
    /// The discs of the silo file.
    pub silo: SiloGeometry,
    /// The grains at the start.
    pub grains: Vec<GrainRow>,
    /// Memories of contacts at the start.
    pub contacts_at_start: RememberedContacts,
    /// Wall grains of `fill`.
    pub fixed: Vec<FixedGrain>,
    /// For each wall at the end of `scene.walls` that is a sphere of a fixed grain, the number of its fill.
    pub walls_of_fills: Vec<usize>,
    /// Warnings about parts of the state of another run, from which the scene starts, that were left out.
    pub notes: Vec<Warning>,
    /// The shapes of grains.
    pub shapes: Shapes,
}

/// A scene of either method that is ready to run.
#[derive(Debug)]
pub enum AnyScene {
    /// Discrete elements.
    Grains(Box<Loaded>),
    /// The lattice gas.
    Lattice(Box<LoadedLattice>),
}

impl AnyScene {
    /// The scene's text.
    #[must_use]
    pub fn source(&self) -> &Source {
        match self {
            Self::Grains(loaded) => &loaded.source,
            Self::Lattice(loaded) => &loaded.source,
        }
    }
}

impl Loaded {
    /// A fault that points at the value of `key`, or at its nearest parent that stands in the text.
    #[must_use]
    pub fn fault(&self, code: &'static str, key: &str, message: impl Into<String>) -> Fault {
        self.source.fault(code, key, message)
    }

    /// The contact laws of the scene, for all species that it names.
    #[must_use]
    pub fn contacts(&self) -> Contacts<'_> {
        let Scene { contact, pairs, materials, .. } = &self.scene;
        let species = if pairs.is_empty() && materials.len() <= 1 { 1 } else { self.largest_species() + 1 };
        Contacts { usual: *contact, pairs, materials, species, only: None }
    }

    /// The law of moments of inertia: the scene's, or the default of its space.
    #[must_use]
    pub fn inertia(&self) -> InertiaLaw {
        self.scene.inertia.unwrap_or(InertiaLaw::usual(self.scene.space))
    }

    /// Whether contact forces are centred: the scheme is `Centred`, and at least one contact has drag or friction.
    #[must_use]
    pub fn is_centred(&self) -> bool {
        self.scene.integrator == Integrator::Centred && !self.is_elastic()
    }

    /// Whether no contact has drag or friction.
    #[must_use]
    pub fn is_elastic(&self) -> bool {
        let mut laws = std::iter::once(&self.scene.contact).chain(self.scene.pairs.iter().map(|pair| &pair.contact));
        laws.all(Contact::is_elastic)
    }

    /// The profiles, each with the area of its cross-section (m^2; in the plane its length, m): from the scene, or from the
    /// periodic box.
    #[must_use]
    pub fn profiles(&self) -> Vec<(Profile, f64)> {
        let with_section = |profile: &Profile| profile.section.map(Positive::get).or(self.periodic_section(profile));
        self.scene.profiles.iter().filter_map(|profile| Some((*profile, with_section(profile)?))).collect()
    }

    /// The cross-section of the periodic box at right angles to a profile, if the box bounds every other axis.
    #[must_use]
    pub fn periodic_section(&self, profile: &Profile) -> Option<f64> {
        let axes = 0..self.scene.space.count();
        let sides = axes.filter(|&axis| axis != profile.axis.number()).map(|axis| self.scene.periodic.axes()[axis]);
        sides.map(|side| side.map(|(low, high)| high - low)).product()
    }

    /// The samplers of the scene's fields.
    #[must_use]
    pub fn fields<V: Space>(&self) -> Vec<FieldSampler<V>> {
        let sampler = |field: &Field| {
            let grid = Grid::new(&field.grid, field.kernel, self.scene.periodic.y);
            FieldSampler::new(*field, grid, self.field_species())
        };
        self.scene.fields.iter().map(sampler).collect()
    }

    /// Number of species whose shares fields measure: none if there is only one.
    #[must_use]
    pub fn field_species(&self) -> usize {
        let largest = self.largest_species();
        if largest > 0 { largest + 1 } else { 0 }
    }

    /// The largest species of all grains and walls.
    #[must_use]
    pub fn largest_species(&self) -> usize {
        let sizes = |law: &RadiusLaw| match law {
            RadiusLaw::Mixture(sizes) => sizes.len().saturating_sub(1),
            _ => 0,
        };
        let spawner = self.scene.spawner.iter().map(|spawner| sizes(&spawner.radius));
        let feeds = self.scene.feed.iter().map(|feed| usize::from(feed.species) + sizes(&feed.radius));
        let mixture = spawner.chain(feeds).max().unwrap_or(0);
        let walls = self.scene.walls.iter().map(|wall| usize::from(wall.species));
        let silo = self.scene.silo.iter().map(|silo| usize::from(silo.species));
        let grains = self.grains.iter().map(|grain| usize::from(grain.species.0));
        let fixed = self.fixed.iter().map(|grain| usize::from(grain.species.0));
        let pairs = self.scene.pairs.iter().flat_map(|pair| [pair.species.0, pair.species.1]).map(usize::from);
        walls.chain(silo).chain(grains).chain(fixed).chain(pairs).fold(mixture, usize::max)
    }

    /// The help for a name that no wall has: the name that is most like it, or all names.
    #[must_use]
    pub fn help_for_wall(&self, name: &str) -> String {
        let mut names: Vec<_> = self.scene.walls.iter().filter_map(|wall| wall.name()).collect();
        names.sort_unstable();
        names.dedup();
        if names.is_empty() {
            "give a wall of `walls` this `name`".to_owned()
        } else {
            did_you_mean("names", name, &names)
        }
    }

    /// Smallest and largest radius of all spheres of grains, present and to be released, m; `None` without grains.
    #[must_use]
    pub fn grain_radii(&self) -> Option<(f64, f64)> {
        let start = self.grains.iter().map(|grain| {
            let factors = grain
                .posture
                .and_then(|posture| self.shapes.facts_of(posture.shape))
                .map_or([1.0; 2], ShapeFacts::factors);
            (grain.radius * factors[1], grain.radius * factors[0])
        });
        let spawner = self.scene.spawner.iter().filter(|s| s.count > 0);
        let to_come = spawner.flat_map(|spawner| size_ranges(&spawner.radius, spawner.shaped.as_ref()));
        let feeds = self.scene.feed.iter().flat_map(|feed| size_ranges(&feed.radius, feed.shaped.as_ref()));
        let to_come = to_come.chain(feeds).map(|range| range.spheres());
        start.chain(to_come).reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)))
    }

    /// The largest distance (m) of a grain's surface from its centre, of all grains, present and to be released.
    #[must_use]
    pub fn largest_reach(&self) -> f64 {
        let start = self.grains.iter().map(GrainRow::reach);
        let spawner = self.scene.spawner.iter();
        let to_come = spawner.map(|spawner| largest_reach(&spawner.radius, spawner.shaped.as_ref()));
        let feeds = self.scene.feed.iter().map(Feed::largest_reach);
        start.chain(to_come).chain(feeds).fold(0.0, f64::max)
    }

    /// The spheres of a grain of the start: centres and radii, m.
    #[must_use]
    pub fn spheres_of(&self, grain: &GrainRow) -> Vec<(Solid, f64)> {
        let spheres = grain.posture.map(|posture| match self.scene.space {
            Dimension::Plane => self.shapes.spheres_of::<Plane>(&posture, grain.radius),
            Dimension::Solid => self.shapes.spheres_of::<Solid>(&posture, grain.radius),
        });
        let spheres = spheres.unwrap_or_else(|| vec![(Solid::ZERO, grain.radius)]);
        spheres.into_iter().map(|(arm, radius)| (grain.position + arm, radius)).collect()
    }

    /// Whether grains of the scene spin: its contact law has friction, or it has shapes.
    #[must_use]
    pub fn grains_spin(&self) -> bool {
        self.scene.contact.spins() || !self.shapes.is_empty()
    }

    /// The largest range of a contact beyond touch, m, for the largest grain in a hollow of the wall that multiplies its reduced radius
    /// by up to 8.
    #[must_use]
    pub fn adhesive_range(&self) -> f64 {
        self.grain_radii().map_or(0.0, |(_, largest)| self.contacts().range(8.0 * largest))
    }

    /// The largest centre distance, m, at which a grain touches another particle.
    #[must_use]
    pub fn contact_range(&self) -> f64 {
        let largest_fixed = self.fixed_radii().fold(0.0, f64::max);
        self.grain_radii().map_or(0.0, |(_, largest)| largest + largest.max(largest_fixed))
    }

    /// The lowest id that is free for grains to be released.
    #[must_use]
    pub fn first_free_id(&self) -> u32 {
        self.grains.iter().map(|grain| grain.id.number()).max().map_or(1, |largest| largest.saturating_add(1))
    }

    /// The neighbour search: the scene's, or a Verlet list with a skin of the smallest radius, in solid space a
    /// fifth of it: there, a thicker skin costs more candidates than it saves list renewals.
    #[must_use]
    pub fn neighbours(&self) -> Neighbours {
        let share = if self.scene.space == Dimension::Solid { 0.2 } else { 1.0 };
        self.scene.neighbours.unwrap_or_else(|| {
            let skin = self.grain_radii().and_then(|(smallest, _)| Positive::try_from(share * smallest).ok());
            skin.map_or(Neighbours::AllPairs, |skin| Neighbours::VerletList { skin })
        })
    }
}
