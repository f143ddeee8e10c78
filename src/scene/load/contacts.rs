//! Finds the partners of remembered contacts among the walls and grains of a scene.
//!
//! A scene may list its walls in another order than the one in which a memory was written, may lack some of them, or may divide
//! them into other surfaces. So a row that tells the point of its wall belongs to the surface that the grain touches at this
//! point, first among the surfaces with the row's name. If the named walls stand elsewhere, as walls with a motion do, the row
//! belongs to the nearest of them that the grain touches. A row without a point belongs to the surface with its number.

use rustc_hash::FxHashMap;

use crate::grains::file::GrainRow;
use crate::scene::loaded::Loaded;
use siloflow_dem::contact::history::remembered::{PartnerKind, Remembered};
use siloflow_dem::periodic::Periodic;
use siloflow_dem::space::{Dimension, Plane, Solid, Space};
use siloflow_dem::walls::surface_wall::SurfaceWall;
use siloflow_dem::walls::surfaces::Surfaces;

/// Two bodies are apart if the gap between them is more than this share of the grain's radius. The memory of a contact may be
/// written in the half step in which it ends, so a very small gap counts as a contact.
const APART: f64 = 0.01;

/// Distance, in radii of the grain, up to which two points of a wall are one point of contact. A wall of the same name may
/// have moved or bent a little. Under another name only rounding may part them.
const ONE_POINT: [f64; 2] = [0.1, 1e-3];

/// A row that has no place in a scene.
pub(super) struct Stray {
    /// The missing grain, wall or contact, in words.
    pub reason: String,
    /// Whether it is a wall or a wall grain.
    pub is_wall: bool,
}

impl Loaded {
    /// Gives the memories of contacts at the start the numbers that their partners have in this scene. Rows that have no place in it
    /// are returned with their numbers, from 1.
    pub(super) fn find_partners(&mut self) -> Vec<(usize, Stray)> {
        let rows = std::mem::take(&mut self.contacts_at_start.rows);
        let (found, strays) = match self.scene.space {
            Dimension::Plane => resolve_all::<Plane>(self, rows),
            Dimension::Solid => resolve_all::<Solid>(self, rows),
        };
        self.contacts_at_start.rows = found;
        strays
    }
}

fn resolve_all<V: Space>(loaded: &Loaded, rows: Vec<Remembered>) -> (Vec<Remembered>, Vec<(usize, Stray)>) {
    let mut found = Vec::with_capacity(rows.len());
    let mut strays = Vec::new();
    if !rows.is_empty() {
        let partners = Partners::<V>::of(loaded);
        for (number, row) in (1..).zip(rows) {
            match partners.resolve(row) {
                Ok(row) => found.push(row),
                Err(stray) => strays.push((number, stray)),
            }
        }
    }
    (found, strays)
}

/// The grains and walls of a scene, by their identities.
struct Partners<'a, V: Space> {
    periodic: Option<Periodic<V>>,
    range: f64,
    /// Grains by id, and by the number of a sphere in the shape of a grain: such a grain stands for the sphere.
    grains: FxHashMap<(u32, Option<u16>), GrainRow>,
    /// Centre and radius of each wall grain, m, in the order of their numbers.
    wall_grains: Vec<(V, f64)>,
    surfaces: Surfaces<V>,
    /// For each wall surface of the scene, its name.
    names: Vec<Option<&'a str>>,
}

impl<'a, V: Space> Partners<'a, V> {
    /// Takes the partners of a scene at its start.
    fn of(loaded: &'a Loaded) -> Self {
        let periodic = Periodic::<V>::new(&loaded.scene.periodic);
        let in_box = |x: V| periodic.map_or(x, |periodic| periodic.wrapped(x));
        let largest = loaded.grain_radii().map_or(0.0, |(_, largest)| largest);
        let wall_grains = loaded.wall_grains().map(|(centre, radius)| (in_box(V::narrow(centre)), radius));
        Self {
            periodic,
            range: loaded.adhesive_range(),
            grains: loaded.grains.iter().flat_map(|grain| spheres_of(loaded, grain)).collect(),
            wall_grains: wall_grains.collect(),
            surfaces: Surfaces::new(loaded.surfaces(), largest),
            names: loaded.wall_names(),
        }
    }

    /// Returns the row with the number that its partner has in this scene.
    ///
    /// # Errors
    /// If the grain, its partner, or the contact of the two does not exist.
    fn resolve(&self, row: Remembered) -> Result<Remembered, Stray> {
        let number = row.number;
        let stray = |is_wall, reason| Stray { reason, is_wall };
        let Some(grain) = self.grains.get(&(row.grain, row.spheres[0])) else {
            return Err(stray(false, format!("there is no {}", name(row.grain, row.spheres[0]))));
        };
        match row.with {
            PartnerKind::Grain => match self.grains.get(&(number, row.spheres[1])) {
                None => Err(stray(false, format!("there is no {}", name(number, row.spheres[1])))),
                Some(_) if number == row.grain => Err(stray(false, format!("grain {number} does not touch itself"))),
                Some(other) if self.touch(grain, self.place(other), other.radius) => Ok(row),
                Some(_) => Err(stray(false, format!("grains {} and {number} do not touch", row.grain))),
            },
            PartnerKind::WallGrain => self.wall_grain(grain, row).map_err(|reason| stray(true, reason)),
            PartnerKind::Wall => self.wall(grain, row).map_err(|reason| stray(true, reason)),
        }
    }

    /// The centre of a grain, m; in a periodic box its image there.
    fn place(&self, grain: &GrainRow) -> V {
        let x = V::narrow(grain.position);
        self.periodic.map_or(x, |periodic| periodic.wrapped(x))
    }

    fn separation(&self, a: V, b: V) -> V {
        self.periodic.map_or(a - b, |periodic| periodic.shortest(a - b))
    }

    /// Whether a grain touches a body at `x`, m.
    fn touch(&self, grain: &GrainRow, x: V, radius: f64) -> bool {
        let reach = grain.radius + radius + self.range + APART * grain.radius.min(radius);
        self.separation(self.place(grain), x).length() < reach
    }

    fn wall_grain(&self, grain: &GrainRow, row: Remembered) -> Result<Remembered, String> {
        let numbered = row.number.checked_sub(1).map_or(usize::MAX, |number| number as usize);
        let touches = |number: usize| {
            let body = self.wall_grains.get(number);
            body.is_some_and(|&(centre, radius)| self.touch(grain, centre, radius))
        };
        let at = row.at();
        let placed = at.and_then(|at| {
            let off = |number: usize| self.separation(self.wall_grains[number].0, V::narrow(at)).length();
            let near = (0..self.wall_grains.len()).filter(|&number| off(number) <= ONE_POINT[0] * grain.radius);
            let touching = near.filter(|&number| touches(number));
            touching.min_by(|&a, &b| off(a).total_cmp(&off(b)).then((a != numbered).cmp(&(b != numbered))))
        });
        // Wall grains of a conveyor have left their places.
        if let Some(number) = placed.or_else(|| Some(numbered).filter(|&number| touches(number))) {
            let centre = self.wall_grains[number].0.spread();
            return Ok(row.with_partner_at(one_based(number), centre));
        }
        Err(match at {
            None if numbered >= self.wall_grains.len() => {
                format!("there is no wall grain {}: the scene has {}", row.number, self.wall_grains.len())
            }
            None => format!("grain {} and wall grain {} do not touch", row.grain, row.number),
            Some(at) => format!("grain {} touches no wall grain at {}", row.grain, place(at)),
        })
    }

    fn wall(&self, grain: &GrainRow, row: Remembered) -> Result<Remembered, String> {
        let x = self.place(grain);
        let count = self.surfaces.all.len();
        let numbered = row.number.checked_sub(1).map_or(usize::MAX, |number| number as usize);
        let reach = grain.radius * (1.0 + APART) + self.range;
        let touches = |index: usize| self.surfaces.all[index].surface.distance(x) < reach;
        let is_named = |index: usize| self.names[self.surfaces.all[index].number] == row.wall.as_deref();
        let at = row.at();
        let found = if at.is_none() && row.wall.is_none() {
            Some(numbered).filter(|&index| index < count && touches(index))
        } else {
            let touching: Vec<_> = self.surfaces.near(x, reach).iter().filter(|&index| touches(index)).collect();
            let at_point = at.and_then(|at| self.at_point(grain, x, V::narrow(at), numbered, &touching, &is_named));
            let named = touching.iter().copied().filter(|&index| row.wall.is_some() && is_named(index));
            at_point.or_else(|| {
                named.min_by(|&a, &b| {
                    let distance = |index: usize| self.surfaces.all[index].surface.distance(x);
                    distance(a).total_cmp(&distance(b))
                })
            })
        };
        if let Some(index) = found {
            let at = self.surfaces.all[index].surface.nearest_point(x).spread();
            return Ok(row.with_partner_at(one_based(index), at));
        }
        Err(match (&row.wall, at) {
            (Some(name), _) if !self.names.contains(&Some(name)) => format!("there is no wall `{name}`"),
            (Some(name), _) => format!("grain {} does not touch the wall `{name}`", row.grain),
            (None, Some(at)) => format!("grain {} touches no wall at {}", row.grain, place(at)),
            (None, None) if numbered >= count => {
                format!("there is no wall {}: the scene has {count} wall surfaces", row.number)
            }
            (None, None) => format!("grain {} and wall {} do not touch", row.grain, row.number),
        })
    }

    /// The surface, of those that the grain touches, whose nearest point is the point `at`, m. Among several at one place the one with
    /// the row's number comes first.
    fn at_point(
        &self,
        grain: &GrainRow,
        x: V,
        at: V,
        numbered: usize,
        touching: &[usize],
        is_named: &dyn Fn(usize) -> bool,
    ) -> Option<usize> {
        let surface = |index: usize| -> &SurfaceWall<V> { &self.surfaces.all[index] };
        // A point at a periodic side may be that of an image of the wall.
        let off = |index: usize| self.separation(surface(index).surface.nearest_point(x), at).length() / grain.radius;
        let candidates = touching.iter().filter_map(|&index| {
            let off = off(index);
            let other_name = !is_named(index);
            let limit = ONE_POINT[usize::from(other_name)];
            // Distances that differ by rounding alone are equal.
            (off <= limit).then(|| ((other_name, (off / ONE_POINT[1]).floor(), index != numbered, index), index))
        });
        let ordered = |a: &(bool, f64, bool, usize), b: &(bool, f64, bool, usize)| {
            a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)).then(a.2.cmp(&b.2)).then(a.3.cmp(&b.3))
        };
        candidates.min_by(|(a, _), (b, _)| ordered(a, b)).map(|(_, index)| index)
    }
}

/// Returns the grain by its id; a shaped grain as its spheres, by id and number.
fn spheres_of(loaded: &Loaded, grain: &GrainRow) -> Vec<((u32, Option<u16>), GrainRow)> {
    let id = grain.id.number();
    if grain.posture.is_none() {
        return vec![((id, None), *grain)];
    }
    let spheres = (0..).zip(loaded.spheres_of(grain));
    let sphere =
        |(number, (position, radius))| ((id, Some(number)), GrainRow { position, radius, posture: None, ..*grain });
    spheres.map(sphere).collect()
}

/// The name of a grain, or of a sphere of it.
fn name(grain: u32, sphere: Option<u16>) -> String {
    sphere.map_or_else(|| format!("grain {grain}"), |number| format!("sphere {number} of grain {grain}"))
}

fn one_based(index: usize) -> u32 {
    u32::try_from(index + 1).unwrap_or(u32::MAX)
}

fn place(x: Solid) -> String {
    format!("({}, {}, {}) m", x.x, x.y, x.z)
}
