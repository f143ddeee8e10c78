//! The walls of a loaded scene: discs, surfaces, doors and motions.

use crate::door::DoorMotion;
use crate::measure::wall_bands::BandSampler;
use crate::scene::loaded::Loaded;
use crate::space::{Dimension, Solid, Space};
use crate::walls::config::Wall;
use crate::walls::moving::{Drive, LeafState, Mover};
use crate::walls::silo_file::Disc;
use crate::walls::surfaces::{SurfaceWall, Surfaces};

impl Loaded {
    /// Fixed discs of a planar scene, without the door and without moving discs: from the silo file, from the scene and
    /// from `fill`.
    #[must_use]
    pub fn wall_discs(&self) -> Vec<Disc> {
        if self.scene.space != Dimension::Plane {
            return Vec::new();
        }
        let own = self.scene.walls.iter().filter_map(Wall::wall_grain);
        let own = own.map(|(centre, radius, _)| Disc { centre: centre.get(), radius });
        let still = self.fixed.iter().filter(|grain| grain.velocity == Solid::ZERO);
        let fixed = still.map(|grain| Disc { centre: grain.position.truncate(), radius: grain.radius });
        self.silo.wall.iter().copied().chain(own).chain(fixed).collect()
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
            let (centre, reach) = (disc.centre.extend(0.0), Solid::splat(disc.radius));
            [centre - reach, centre + reach]
        });
        let around = discs.reduce(|[low, high], [lower, higher]| [low.min(lower), high.max(higher)]);
        let of_walls =
            self.scene.walls.iter().filter(|wall| self.scene.door_of(wall).is_some()).filter_map(Wall::bounds);
        around.into_iter().chain(of_walls).collect()
    }

    /// The wall surfaces at the start.
    #[must_use]
    pub fn surfaces<V: Space>(&self) -> Vec<SurfaceWall<V>> {
        if self.scene.motions.is_empty() {
            return self.surfaces_in_scene();
        }
        Surfaces::new(self.surfaces_in_scene(), 0.0).with_movers(self.movers()).all
    }

    /// The wall surfaces at the places that the scene gives, from which motions start.
    #[must_use]
    pub fn surfaces_in_scene<V: Space>(&self) -> Vec<SurfaceWall<V>> {
        let walls = self.scene.walls.iter().filter(|wall| wall.is_surface()).enumerate();
        let surfaces = walls.flat_map(|(number, wall)| {
            let door = self.scene.door_of(wall);
            wall.surfaces(number).into_iter().map(move |surface| SurfaceWall { door, ..surface })
        });
        surfaces.collect()
    }

    /// The wall surfaces without those that a motion moves.
    #[must_use]
    pub fn still_surfaces<V: Space>(&self) -> Vec<SurfaceWall<V>> {
        let walls: Vec<_> = self.scene.walls.iter().filter(|wall| wall.is_surface()).collect();
        let moves = |number: usize| self.scene.motions.iter().any(|motion| walls[number].name() == Some(&motion.walls));
        self.surfaces_in_scene().into_iter().filter(|surface| !moves(surface.number)).collect()
    }

    /// Returns the moving walls: those of `motions`, and doors that move.
    pub(crate) fn movers<V: Space>(&self) -> Vec<Mover<V>> {
        let surfaces: Vec<_> = self.surfaces_in_scene::<V>().into_iter().enumerate().collect();
        let walls: Vec<_> = self.scene.walls.iter().filter(|wall| wall.is_surface()).collect();
        let home = |belongs: &dyn Fn(&SurfaceWall<V>) -> bool| {
            surfaces.iter().filter(|(_, surface)| belongs(surface)).cloned().collect()
        };
        let motions = self.scene.motions.iter().map(|motion| {
            let home = home(&|surface| walls[surface.number].name() == Some(&motion.walls));
            Mover::new(home, Drive::Motion(motion.clone()))
        });
        let leaves = self.scene.door_controls().into_iter().filter_map(|(number, _, control)| {
            let DoorMotion::Move { by, speed } = control.how else { return None };
            let home = home(&|surface| surface.door == Some(number));
            let state = LeafState::default();
            Some(Mover::new(home, Drive::Leaf { door: number, by: by.get(), speed: speed.get(), state }))
        });
        motions.chain(leaves).collect()
    }

    /// The samplers of `wall_bands`.
    #[must_use]
    pub fn wall_bands<V: Space>(&self) -> Vec<BandSampler> {
        let names: Vec<_> = self.scene.walls.iter().filter(|wall| wall.is_surface()).map(Wall::name).collect();
        let surfaces = if self.scene.wall_bands.is_empty() { Vec::new() } else { self.surfaces::<V>() };
        let samplers = self.scene.wall_bands.iter().map(|bands| {
            let walls: Vec<_> = (0..names.len()).filter(|&number| names[number] == Some(&bands.walls)).collect();
            let own = surfaces.iter().filter(|wall| walls.contains(&wall.number)).map(|wall| wall.surface.clone());
            let own: Vec<_> = own.collect();
            BandSampler::new(bands.clone(), walls, &own)
        });
        samplers.collect()
    }

    /// Radii of all fixed discs and spheres, m.
    pub(crate) fn fixed_radii(&self) -> impl Iterator<Item = f64> {
        let own = self.scene.walls.iter().filter_map(Wall::wall_grain).map(|(_, radius, _)| radius);
        let silo = self.silo.wall.iter().chain(&self.silo.door).map(|disc| disc.radius);
        own.chain(silo).chain(self.fixed.iter().map(|grain| grain.radius))
    }
}
