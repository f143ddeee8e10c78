//! Creates the grains of `fill` while a scene is loaded.

use crate::grains::file::GrainRow;
use crate::grains::fill::{Fill, FillStream, FixedGrain, MOST_TRIES, Placement};
use crate::grains::occupied::Occupied;
use crate::scene::Scene;
use crate::scene::loaded::Loaded;
use siloflow_dem::periodic::Periodic;
use siloflow_dem::space::{Dimension, Plane, Solid, Space};
use siloflow_dem::values::{FiniteVector, Positive};
use siloflow_dem::walls::config::shape::WallShape;
use siloflow_dem::walls::config::{Wall, WallGrain};
use siloflow_dem::walls::surfaces::Surfaces;
use siloflow_text::fault::Fault;

impl Loaded {
    /// Creates the grains of `fill`.
    pub(super) fn fill(&mut self) -> Result<(), Fault> {
        let Scene { space, mass, seed, .. } = self.scene;
        let fills = std::mem::take(&mut self.scene.fill);
        for (number, fill) in fills.iter().enumerate() {
            let first_id = self.first_free_id();
            let rows = match (fill.place, space) {
                (Placement::Lattice, _) => fill.grains(space, mass, seed, number, first_id),
                (Placement::Random, Dimension::Plane) => self.random_fill::<Plane>(fill, number)?,
                (Placement::Random, Dimension::Solid) => self.random_fill::<Solid>(fill, number)?,
            };
            if !fill.fixed {
                self.grains.extend(rows);
            } else if fill.makes_walls() {
                let walls: Vec<_> =
                    self.spheres_of_all(&rows).filter_map(|sphere| self.wall_of(&sphere, fill)).collect();
                self.walls_of_fills.extend(walls.iter().map(|_| number));
                self.scene.walls.extend(walls);
            } else {
                let spheres: Vec<_> = self.spheres_of_all(&rows).collect();
                self.fixed.extend(spheres);
            }
        }
        self.scene.fill = fills;
        Ok(())
    }

    /// All spheres of fixed grains, grain by grain in the order of the shape.
    fn spheres_of_all(&self, rows: &[GrainRow]) -> impl Iterator<Item = FixedGrain> {
        rows.iter().flat_map(|row| {
            let sphere =
                |(position, radius)| FixedGrain { position, radius, velocity: row.velocity, species: row.species };
            self.spheres_of(row).into_iter().map(sphere)
        })
    }

    /// The wall that a sphere of a fixed grain is. `None` if it has no radius or no place that a double can hold.
    fn wall_of(&self, sphere: &FixedGrain, fill: &Fill) -> Option<Wall> {
        let FixedGrain { position, radius, species, .. } = *sphere;
        let centre = FiniteVector::of(position, self.scene.space)?;
        let shape = WallShape::Disc { centre, radius: Positive::try_from(radius).ok()? };
        Some(Wall { shape, species: species.0, name: fill.name.clone(), door: fill.door })
    }

    /// Creates the grains of a random fill: free of all grains and walls so far.
    fn random_fill<V: Space>(&self, fill: &Fill, number: usize) -> Result<Vec<GrainRow>, Fault> {
        let Scene { space, mass, seed, periodic, .. } = &self.scene;
        let largest = fill.largest_reach();
        let mut occupied = Occupied::new(largest, periodic);
        self.grains.iter().for_each(|grain| occupied.add(grain.position, grain.reach()));
        self.fixed.iter().for_each(|grain| occupied.add(grain.position, grain.radius));
        self.silo
            .wall
            .iter()
            .chain(&self.silo.door)
            .for_each(|disc| occupied.add(disc.centre.extend(0.0), disc.radius));
        for wall in &self.scene.walls {
            if let Some(WallGrain { centre, radius, .. }) = wall.wall_grain() {
                occupied.add(centre.padded(), radius);
            }
        }
        let walls = Surfaces::<V>::new(self.surfaces_for(largest), largest);
        // A place beyond a periodic side counts as the one that it enters at.
        let periodic_box = Periodic::<V>::new(periodic);
        let is_clear = |x: Solid, radius: f64| {
            let x = periodic_box.map_or(V::narrow(x), |periodic| periodic.wrapped(V::narrow(x)));
            walls.near(x, radius).iter().all(|number| walls.all[number].surface.distance(x) >= radius)
        };
        let first_id = self.first_free_id();
        let stream = FillStream { seed: *seed, number };
        let rows = fill.random_grains(*space, *mass, stream, first_id, &mut occupied, is_clear);
        let wanted = fill.count.unwrap_or(0) as usize;
        if rows.len() == wanted {
            return Ok(rows);
        }
        let message = format!(
            "{wanted} random grains are wanted, and {} found a place: the next one found none in {MOST_TRIES} tries",
            rows.len()
        );
        Err(self.fault("scene::no_room", &format!("fill[{number}].count"), message).help(
            "lower the count or raise the box; equal grains at random fill at most 0.54 of an area, 0.38 of a volume",
        ))
    }
}
