//! The walls of a loaded scene: discs, surfaces, doors and motions.

use crate::door::DoorMotion;
use crate::measure::wall_bands::BandSampler;
use crate::scene::loaded::Loaded;
use siloflow_dem::space::{Dimension, Plane, Solid, Space};
use siloflow_dem::walls::config::Wall;
use siloflow_dem::walls::motion::Motion;
use siloflow_dem::walls::mover::{Drive, LeafState, Mover};
use siloflow_dem::walls::silo_file::Disc;
use siloflow_dem::walls::surface_wall::SurfaceWall;
use siloflow_dem::walls::surfaces::Surfaces;

impl Loaded {
    /// Fixed discs of a planar scene, without the door and without moving discs: from the silo file, from the scene and
    /// from `fill`.
    #[must_use]
    pub fn wall_discs(&self) -> Vec<Disc> {
        if self.scene.space != Dimension::Plane {
            return Vec::new();
        }
        let own = self.scene.walls.iter().filter_map(Wall::wall_grain);
        let own = own.map(|grain| Disc { centre: grain.centre.get(), radius: grain.radius });
        let still = self.fixed.iter().filter(|grain| grain.velocity == Solid::ZERO);
        let fixed = still.map(|grain| Disc { centre: grain.position.truncate(), radius: grain.radius });
        self.silo.wall.iter().copied().chain(own).chain(fixed).collect()
    }

    /// The key of a wall: its entry in `walls`, or the fill whose grain it is a sphere of.
    #[must_use]
    pub fn key_of_wall(&self, index: usize) -> String {
        let own = self.scene.walls.len() - self.walls_of_fills.len();
        match index.checked_sub(own).and_then(|number| self.walls_of_fills.get(number)) {
            Some(fill) => format!("fill[{fill}]"),
            None => format!("walls[{index}]"),
        }
    }

    /// Whether a wall surface is a door.
    #[must_use]
    pub fn has_door_surface(&self) -> bool {
        self.scene.walls.iter().any(|wall| self.scene.door_of(wall).is_some())
    }

    /// Whether grains can leave through a door: of discs of the silo file, or a wall surface.
    #[must_use]
    pub fn has_outlet(&self) -> bool {
        !self.silo.door.is_empty() || self.has_door_surface()
    }

    /// The boxes around the doors, m: that of the door discs of the silo file, and those of walls; z is 0 in the plane.
    #[must_use]
    pub fn outlets(&self) -> Vec<[Solid; 2]> {
        let discs = self.silo.door.iter().map(|disc| {
            let centre = disc.centre.extend(0.0);
            let reach = Solid::splat(disc.radius);
            [centre - reach, centre + reach]
        });
        let around = discs.reduce(|[low, high], [lower, higher]| [low.min(lower), high.max(higher)]);
        let of_walls =
            self.scene.walls.iter().filter(|wall| self.scene.door_of(wall).is_some()).filter_map(Wall::bounds);
        around.into_iter().chain(of_walls).collect()
    }

    /// The wall surfaces at the start, with their images beyond periodic sides.
    #[must_use]
    pub fn surfaces<V: Space>(&self) -> Vec<SurfaceWall<V>> {
        self.placed(self.surfaces_in_scene())
    }

    /// The wall surfaces at the start, without images.
    #[must_use]
    pub fn own_surfaces<V: Space>(&self) -> Vec<SurfaceWall<V>> {
        self.placed(self.own_surfaces_in_scene())
    }

    fn placed<V: Space>(&self, surfaces: Vec<SurfaceWall<V>>) -> Vec<SurfaceWall<V>> {
        if self.scene.motions.is_empty() && self.scene.free_walls.is_empty() {
            return surfaces;
        }
        let movers = self.movers_of(&surfaces);
        Surfaces::new(surfaces, 0.0).with_movers(movers).all
    }

    /// The wall surfaces at the places that the scene gives, from which motions start, with their images beyond periodic sides.
    #[must_use]
    pub fn surfaces_in_scene<V: Space>(&self) -> Vec<SurfaceWall<V>> {
        self.surfaces_and_images(self.grain_radii().map_or(0.0, |(_, largest)| largest))
    }

    /// The wall surfaces at the start, with the images that grains of radius up to `largest` (m) reach.
    pub(in crate::scene) fn surfaces_for<V: Space>(&self, largest: f64) -> Vec<SurfaceWall<V>> {
        self.placed(self.surfaces_and_images(largest))
    }

    fn surfaces_and_images<V: Space>(&self, largest: f64) -> Vec<SurfaceWall<V>> {
        self.each_wall(|wall, own| {
            // The rules have refused walls that cannot be repeated.
            let images = self.images(wall, &own, largest).unwrap_or_default();
            own.into_iter().chain(images).collect()
        })
    }

    fn own_surfaces_in_scene<V: Space>(&self) -> Vec<SurfaceWall<V>> {
        self.each_wall(|_, own| own)
    }

    /// Calls `surfaces` with the surfaces of each wall of the scene, and returns all its results in the order of the scene.
    fn each_wall<V: Space>(
        &self,
        surfaces: impl Fn(&Wall, Vec<SurfaceWall<V>>) -> Vec<SurfaceWall<V>>,
    ) -> Vec<SurfaceWall<V>> {
        let walls = self.scene.walls.iter().filter(|wall| wall.is_surface()).enumerate();
        let of_walls = walls.flat_map(|(number, wall)| {
            let door = self.scene.door_of(wall);
            let own = wall.surfaces(number).into_iter().map(|surface| SurfaceWall { door, ..surface });
            surfaces(wall, own.collect())
        });
        of_walls.collect()
    }

    /// The wall surfaces without those that a motion moves, and without images.
    #[must_use]
    pub fn still_surfaces<V: Space>(&self) -> Vec<SurfaceWall<V>> {
        self.without_moving(self.own_surfaces_in_scene())
    }

    /// The wall surfaces without those that a motion moves, with their images beyond periodic sides.
    #[must_use]
    pub fn still_surfaces_and_images<V: Space>(&self) -> Vec<SurfaceWall<V>> {
        self.without_moving(self.surfaces_in_scene())
    }

    fn without_moving<V: Space>(&self, surfaces: Vec<SurfaceWall<V>>) -> Vec<SurfaceWall<V>> {
        let walls: Vec<_> = self.scene.walls.iter().filter(|wall| wall.is_surface()).collect();
        let named = |number: usize, name: &String| walls[number].name() == Some(name);
        let moves = |number: usize| {
            self.scene.motions.iter().any(|motion| named(number, &motion.walls))
                || self.scene.free_walls.iter().any(|free| named(number, &free.walls))
        };
        surfaces.into_iter().filter(|surface| !moves(surface.number)).collect()
    }

    /// Returns the moving walls among the surfaces of the scene: those of `motions`, and doors that move.
    pub(crate) fn movers_of<V: Space>(&self, surfaces: &[SurfaceWall<V>]) -> Vec<Mover<V>> {
        let surfaces: Vec<_> = surfaces.iter().cloned().enumerate().collect();
        let walls: Vec<_> = self.scene.walls.iter().filter(|wall| wall.is_surface()).collect();
        let home = |belongs: &dyn Fn(&SurfaceWall<V>) -> bool| {
            surfaces.iter().filter(|(_, surface)| belongs(surface)).cloned().collect()
        };
        let mut by_name: Vec<(&String, Vec<Motion>)> = Vec::new();
        for motion in &self.scene.motions {
            match by_name.iter_mut().find(|(name, _)| **name == motion.walls) {
                Some((_, motions)) => motions.push(motion.clone()),
                None => by_name.push((&motion.walls, vec![motion.clone()])),
            }
        }
        let motions = by_name.into_iter().map(|(name, motions)| {
            let home = home(&|surface| walls[surface.number].name() == Some(name));
            Mover::new(home, Drive::Motions(motions))
        });
        let free = self.scene.free_walls.iter().map(|free| {
            let home = home(&|surface| walls[surface.number].name() == Some(&free.walls));
            Mover::new(home, Drive::free(free.clone()))
        });
        let leaves = self.scene.door_controls().into_iter().filter_map(|(number, _, control)| {
            let DoorMotion::Move { by, speed } = control.how else { return None };
            let home = home(&|surface| surface.door == Some(number));
            let state = LeafState::default();
            Some(Mover::new(home, Drive::Leaf { door: number, by: by.get(), speed: speed.get(), state }))
        });
        motions.chain(free).chain(leaves).collect()
    }

    /// The samplers of `wall_bands`.
    #[must_use]
    pub fn wall_bands<V: Space>(&self) -> Vec<BandSampler> {
        let names: Vec<_> = self.scene.walls.iter().filter(|wall| wall.is_surface()).map(Wall::name).collect();
        let surfaces = if self.scene.wall_bands.is_empty() { Vec::new() } else { self.own_surfaces::<V>() };
        let samplers = self.scene.wall_bands.iter().map(|bands| {
            let walls: Vec<_> = (0..names.len()).filter(|&number| names[number] == Some(&bands.walls)).collect();
            let own = surfaces.iter().filter(|wall| walls.contains(&wall.number)).map(|wall| wall.surface.clone());
            let own: Vec<_> = own.collect();
            BandSampler::new(bands.clone(), walls, &own)
        });
        samplers.collect()
    }

    /// For each wall of the scene that is a surface, its name: entry `n` is that of the surfaces with the number `n`.
    #[must_use]
    pub fn wall_names(&self) -> Vec<Option<&str>> {
        self.scene.walls.iter().filter(|wall| wall.is_surface()).map(Wall::name).collect()
    }

    /// Whether walls have images beyond periodic sides.
    pub(crate) fn have_walls_images(&self) -> bool {
        match self.scene.space {
            Dimension::Plane => self.surfaces::<Plane>().len() > self.own_surfaces::<Plane>().len(),
            Dimension::Solid => self.surfaces::<Solid>().len() > self.own_surfaces::<Solid>().len(),
        }
    }

    /// Centres and radii of all fixed discs and spheres (m), in the order of their numbers: of the silo file, walls then door, of the
    /// scene, and of `fill`.
    pub(crate) fn wall_grains(&self) -> impl Iterator<Item = (Solid, f64)> {
        let silo = self.silo.wall.iter().chain(&self.silo.door).map(|disc| (disc.centre.extend(0.0), disc.radius));
        let own = self.scene.walls.iter().filter_map(Wall::wall_grain);
        let own = own.map(|grain| (grain.centre.padded(), grain.radius));
        silo.chain(own).chain(self.fixed.iter().map(|grain| (grain.position, grain.radius)))
    }

    /// Radii of all fixed discs and spheres, m.
    pub(crate) fn fixed_radii(&self) -> impl Iterator<Item = f64> {
        self.wall_grains().map(|(_, radius)| radius)
    }
}
