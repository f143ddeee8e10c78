//! Grains and fixed discs as atoms: the data file, the box, groups, and the commands that move them.
//!
//! The density of each atom gives it the mass of the scene: LAMMPS computes m = 4/3 pi R^3 rho, in the plane too. Type = species + 1. Ids are
//! those of the scene; fixed discs and spheres have the next ones, those of the door last. Fixed ones are held by `fix freeze`: with it, the
//! effective mass of a contact is that of the grain, as in siloflow.

use std::f64::consts::PI;
use std::fmt::Write as _;

use crate::grains::file::GrainRow;
use crate::lammps::bodies::Bodies;
use crate::lammps::quantities::{all_grains, up};
use crate::lammps::{DATA, motions, number, vector};
use crate::scene::loaded::Loaded;
use siloflow_dem::space::{Dimension, Solid};
use siloflow_dem::spin::InertiaLaw;
use siloflow_dem::walls::config::{Wall, WallGrain};

/// Half of the depth of the box of a planar scene, m.
const HALF_DEPTH: f64 = 0.5;

/// A fixed disc or sphere.
struct FixedAtom {
    position: Solid,
    radius: f64,
    species: usize,
}

/// The atoms of a scene.
pub(super) struct Particles {
    fixed: Vec<FixedAtom>,
    /// Number of fixed atoms, from the end of `fixed`, that are door.
    doors: usize,
    first_fixed: u32,
    low: Solid,
    high: Solid,
    types: usize,
    pub(super) bodies: Bodies,
}

impl Particles {
    /// Collects the atoms of a scene.
    pub(super) fn of(loaded: &Loaded) -> Self {
        let mut fixed: Vec<_> = loaded
            .fixed
            .iter()
            .map(|grain| FixedAtom {
                position: grain.position,
                radius: grain.radius,
                species: usize::from(grain.species.0),
            })
            .collect();
        let own = loaded.scene.walls.iter().filter_map(Wall::wall_grain);
        fixed.extend(own.map(|WallGrain { centre, radius, species }| FixedAtom {
            position: centre.padded(),
            radius,
            species: usize::from(species.0),
        }));
        let species = loaded.scene.silo.as_ref().map_or(0, |silo| usize::from(silo.species));
        fixed.extend(loaded.silo.wall.iter().chain(&loaded.silo.door).map(|disc| FixedAtom {
            position: disc.centre.extend(0.0),
            radius: disc.radius,
            species,
        }));
        let (low, high) = box_of(loaded, &fixed);
        let doors = loaded.silo.door.len();
        let types = loaded.largest_species() + 1;
        let first_fixed = loaded.first_free_id();
        let bodies = Bodies::of(loaded, first_fixed as usize + fixed.len());
        Self { fixed, doors, first_fixed, low, high, types, bodies }
    }

    /// Whether the silo file has a door.
    pub(super) fn has_door(&self) -> bool {
        self.doors > 0
    }

    /// The file of bodies, if there are any.
    pub(super) fn bodies_file(&self) -> Option<String> {
        (!self.bodies.is_empty()).then(|| self.bodies.file.clone())
    }

    /// Grains that are one sphere.
    fn single(loaded: &Loaded) -> impl Iterator<Item = &GrainRow> {
        loaded.grains.iter().filter(|grain| grain.posture.is_none())
    }

    /// The data file.
    pub(super) fn data(&self, loaded: &Loaded) -> String {
        let mut text = format!(
            "Grains written by siloflow {}; columns of Atoms: id type diameter density x y z; of Velocities: id vx vy vz wx wy wz\n\n",
            env!("CARGO_PKG_VERSION")
        );
        let _ = writeln!(
            text,
            "{} atoms\n{} atom types\n",
            Self::single(loaded).count() + self.bodies.spheres.len() + self.fixed.len(),
            self.types
        );
        for (axis, name) in ["x", "y", "z"].into_iter().enumerate() {
            let _ = writeln!(text, "{} {} {name}lo {name}hi", number(self.low[axis]), number(self.high[axis]));
        }
        if loaded.grains.is_empty() && self.fixed.is_empty() {
            return text;
        }
        text.push_str("\nAtoms # sphere\n\n");
        let mut atom = |id: usize, species: usize, radius: f64, mass: f64, position: Solid| {
            let density = mass / (4.0 * PI / 3.0 * radius.powi(3));
            let [diameter, density] = [2.0 * radius, density].map(number);
            let _ = writeln!(text, "{id} {} {diameter} {density} {}", species + 1, vector(position));
        };
        for grain in Self::single(loaded) {
            atom(grain.id.number() as usize, usize::from(grain.species.0), grain.radius, grain.mass, grain.position);
        }
        for sphere in &self.bodies.spheres {
            atom(sphere.id, sphere.species, sphere.radius, sphere.mass, sphere.position);
        }
        for (id, disc) in (self.first_fixed..).zip(&self.fixed) {
            // Any density: a frozen atom has no mass in its contacts.
            let diameter = number(2.0 * disc.radius);
            let _ = writeln!(text, "{id} {} {diameter} 1.0 {}", disc.species + 1, vector(disc.position));
        }
        text.push_str("\nVelocities\n\n");
        for grain in Self::single(loaded) {
            let _ = writeln!(text, "{} {} {}", grain.id.number(), vector(grain.velocity), vector(grain.spin));
        }
        for sphere in &self.bodies.spheres {
            let _ = writeln!(text, "{} {} {}", sphere.id, vector(sphere.velocity), vector(sphere.spin));
        }
        let fixed = || (self.first_fixed as usize..).take(self.fixed.len());
        for id in fixed() {
            let _ = writeln!(text, "{id} 0 0 0 0 0 0");
        }
        let others = Self::single(loaded).map(|grain| grain.id.number() as usize).chain(fixed());
        text + &self.bodies.molecules(others)
    }

    /// Settings, reading of the data file, and groups.
    pub(super) fn setup(&self, loaded: &Loaded) -> String {
        let planar = loaded.scene.space == Dimension::Plane;
        let sides = loaded.scene.periodic.axes();
        // An atom of a body must not be lost, so the box grows with bodies that fall.
        let open = if self.bodies.is_empty() { "f" } else { "m" };
        let side = |axis: usize| if sides[axis].is_some() || (planar && axis == 2) { "p" } else { open };
        let mut text = format!(
            "\nunits si\n{}boundary {} {} {}\natom_style sphere\nnewton off\ncomm_modify vel yes\n{}read_data {DATA}{}\n",
            if planar { "dimension 2\n" } else { "" },
            side(0),
            side(1),
            side(2),
            self.bodies.before_reading(),
            self.bodies.reading()
        );
        if self.fixed.is_empty() {
            text.push_str("group fixed empty\ngroup grains union all\n");
        } else {
            let last = self.first_fixed as usize + self.fixed.len() - 1;
            let _ = writeln!(text, "group fixed id {}:{last}\ngroup grains subtract all fixed", self.first_fixed);
            if self.has_door() {
                let _ = writeln!(text, "group door id {}:{last}", last + 1 - self.doors);
            }
            text.push_str("neigh_modify exclude group fixed fixed\n");
        }
        text.push_str(&self.bodies.groups(self.first_fixed));
        if loaded.contacts().species > 1 {
            for kind in 1..=self.types {
                let _ =
                    writeln!(text, "group type_{kind} type {kind}\ngroup species_{kind} intersect type_{kind} grains");
            }
        }
        // The list must be renewed before a grain has moved half of the skin: a tenth of the diameter costs few renewals and few candidates.
        let skin = loaded.grain_radii().map_or(0.0, |(smallest, _)| 0.2 * smallest);
        let _ = writeln!(
            text,
            "neighbor {} bin\nneigh_modify every 1 delay 0 check yes\ntimestep {}",
            number(skin),
            number(loaded.step())
        );
        text
    }

    /// The fixes that move grains, and those that hold and remove some.
    pub(super) fn motion(&self, loaded: &Loaded) -> String {
        let scene = &loaded.scene;
        let planar = scene.space == Dimension::Plane;
        let mut text = String::from("\n# Motion.\n");
        let motion = match (scene.contact.spins(), loaded.inertia()) {
            (false, _) => "nve",
            (true, InertiaLaw::Sphere) => "nve/sphere",
            (true, InertiaLaw::Disc) => "nve/sphere disc",
        };
        let single = if self.bodies.is_empty() { "grains" } else { "single" };
        let _ = writeln!(text, "fix motion {single} {motion}");
        let gravity = scene.gravity.padded();
        if gravity != Solid::ZERO {
            let _ =
                writeln!(text, "fix weight {single} gravity {} vector {}", number(gravity.length()), vector(gravity));
        }
        text.push_str(&self.bodies.motion(gravity));
        if let Some(cull) = scene.cull.filter(|_| self.bodies.is_empty()) {
            let below = if planar {
                format!("INF INF INF {} INF INF", number(cull.below.get()))
            } else {
                format!("INF INF INF INF INF {}", number(cull.below.get()))
            };
            let _ = writeln!(text, "region below block {below}\nfix removed grains evaporate 100 1000000000 below 1");
        }
        if !self.fixed.is_empty() {
            text.push_str("fix hold fixed freeze\n");
        }
        if planar {
            text.push_str("fix plane all enforce2d\n");
        }
        let axes = if planar { "xy" } else { "xyz" };
        let _ = writeln!(text, "fix shares all balance 1000 1.1 shift {axes} 10 1.05");
        text
    }

    /// The id that the next atom gets in LAMMPS.
    pub(super) fn next_id(&self) -> usize {
        self.first_fixed as usize + self.fixed.len() + self.bodies.behind()
    }
}

/// Lower and upper corner of the box, m: periodic sides, and around all grains and walls with room to fly.
fn box_of(loaded: &Loaded, fixed: &[FixedAtom]) -> (Solid, Solid) {
    let planar = loaded.scene.space == Dimension::Plane;
    let grains = all_grains(loaded).map(|grain| (grain.position, grain.radius));
    let balls = grains.chain(fixed.iter().map(|disc| (disc.position, disc.radius)));
    let walls = loaded.scene.walls.iter().filter_map(Wall::bounds);
    let around = balls.map(|(x, radius)| [x - radius, x + radius]).chain(walls).chain(motions::ways(loaded));
    let [mut low, mut high] =
        around.reduce(|[a, b], [low, high]| [a.min(low), b.max(high)]).unwrap_or([Solid::ZERO, Solid::ONE]);
    let reach = loaded.contact_range();
    let up = up(loaded);
    let room = 0.5 * (high - low) + 4.0 * reach + motions::shift_of_half_planes(loaded);
    low -= room;
    high += room;
    if let Some(cull) = loaded.scene.cull {
        low[up] = low[up].min(cull.below.get() - 4.0 * reach);
    }
    for (axis, side) in loaded.scene.periodic.axes().into_iter().enumerate() {
        if let Some((lower, upper)) = side {
            (low[axis], high[axis]) = (lower, upper);
        }
    }
    if planar {
        (low.z, high.z) = (-HALF_DEPTH, HALF_DEPTH);
    }
    (low, high)
}
