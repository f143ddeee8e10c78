//! Images of walls beyond the sides of a periodic box.
//!
//! A grain at a side touches what stands beyond it, so a wall is repeated by whole lengths of the box as far as a grain in the
//! box reaches it: over its way, if it moves. The images belong to the wall: they have its number, its motion and its door.
//!
//! A wall that is the same in every image along an axis is not repeated along it: a half-plane along the axis, or a panel, segment or cylinder that
//! runs along the axis from side to side. Two walls cannot be repeated, and are refused: a half-plane across an axis, because its images would fill the
//! box, and a wall that turns about an axis other than the periodic one and reaches a side, because its images would turn about axes of their own.

use crate::door::DoorMotion;
use crate::scene::loaded::Loaded;
use siloflow_dem::space::{Solid, Space};
use siloflow_dem::values::FiniteVector;
use siloflow_dem::walls::config::Wall;
use siloflow_dem::walls::free::Freedom;
use siloflow_dem::walls::shapes::Planar;
use siloflow_dem::walls::surface::Surface;
use siloflow_dem::walls::surface_wall::SurfaceWall;

/// Most images of a scene. More would take gigabytes.
const MOST_IMAGES: usize = 200_000;

/// A wall runs from side to side if it ends this share of the largest radius before a side at most: a grain there touches its edge
/// where it would touch its face.
const SIDE_GAP: f64 = 1e-3;

/// Reach of a grain beyond a side, in radii: contacts of the scheme of default begin a little before touch.
const REACH: f64 = 1.1;

/// How far a wall moves.
struct Way {
    /// Lowest and highest components of its shift, m.
    shifts: [Solid; 2],
    /// A point of the axis about which it turns, and the unit vector of the axis.
    turn: Option<[Solid; 2]>,
}

impl Way {
    /// Whether a shift along an axis leaves the wall as it moves.
    fn keeps(&self, axis: usize) -> bool {
        self.turn.is_none_or(|[_, turn]| turn.to_array()[axis].abs() > 1.0 - 1e-9)
    }

    /// The lowest and the highest coordinate on an axis that a body in these bounds reaches, m.
    fn swept(&self, [low, high]: [Solid; 2], axis: usize) -> [f64; 2] {
        let [from, to] = self.shifts.map(|shift| shift.to_array()[axis]);
        let ends = match self.turn {
            Some([about, _]) if !self.keeps(axis) => {
                let farthest = (low - about).abs().max((high - about).abs()).length();
                [about.to_array()[axis] - farthest, about.to_array()[axis] + farthest]
            }
            _ => [low, high].map(|corner| corner.to_array()[axis]),
        };
        [ends[0] + from, ends[1] + to]
    }
}

impl Loaded {
    /// Returns the images of the surfaces of a wall that grains of radius up to `largest` (m) reach.
    ///
    /// # Errors
    /// In words, if the wall cannot be repeated.
    pub(crate) fn images<V: Space>(
        &self,
        wall: &Wall,
        surfaces: &[SurfaceWall<V>],
        largest: f64,
    ) -> Result<Vec<SurfaceWall<V>>, String> {
        let axes: Vec<_> = self.scene.periodic.axes().into_iter().take(V::COMPONENTS).enumerate().collect();
        let sides: Vec<_> = axes.into_iter().filter_map(|(axis, side)| Some((axis, side?))).collect();
        let way = self.way(wall);
        let mut images = Vec::new();
        if sides.is_empty() || largest <= 0.0 {
            return Ok(images);
        }
        let reach = REACH * largest + self.adhesive_range();
        for surface in surfaces {
            let mut shifts = vec![V::ZERO];
            for &(axis, side) in &sides {
                let name = ["x", "y", "z"][axis];
                let Some(bounds) = surface.surface.bounds() else {
                    is_along(&surface.surface, &way, axis).map_err(|problem| format!("{problem} {name}"))?;
                    continue;
                };
                let bounds = way.swept(bounds.map(V::spread), axis);
                let moves_along = (way.shifts[1] - way.shifts[0]).to_array()[axis] > 0.0;
                let is_endless = !moves_along && way.keeps(axis) && surface.surface.shape().runs_along(axis);
                if is_endless && bounds[0] <= side.0 + SIDE_GAP * largest && bounds[1] >= side.1 - SIDE_GAP * largest {
                    continue;
                }
                let boxes = boxes(bounds, side, reach);
                if boxes.iter().any(|&number| number != 0.0) && !way.keeps(axis) {
                    return Err(format!(
                        "it turns, and reaches a periodic side along {name}: its image beyond would have to turn about an axis of its own"
                    ));
                }
                let along = V::narrow(Solid::AXES[axis]) * (side.1 - side.0);
                let count = boxes.len().saturating_mul(shifts.len());
                if count.saturating_add(images.len()) > MOST_IMAGES {
                    return Err(format!(
                        "it would need more than {MOST_IMAGES} images beyond the periodic sides along {name}"
                    ));
                }
                shifts =
                    shifts.iter().flat_map(|&shift| boxes.iter().map(move |&number| shift + along * number)).collect();
            }
            images.extend(shifts.into_iter().filter(|&shift| shift != V::ZERO).map(|shift| surface.image(shift)));
        }
        Ok(images)
    }

    fn way(&self, wall: &Wall) -> Way {
        let motions: Vec<_> = self.scene.motions.iter().filter(|motion| wall.name() == Some(&motion.walls)).collect();
        if !motions.is_empty() {
            let turn = motions
                .iter()
                .find_map(|motion| motion.rotate.as_ref())
                .map(|turn| [turn.about.padded(), turn.axis.map_or(Solid::Z, FiniteVector::padded).unit_or_zero()]);
            let shifts = motions.iter().map(|motion| motion.shifts(self.scene.until.get()));
            let shifts = shifts.fold([Solid::ZERO; 2], |[low, high], [lower, higher]| [low + lower, high + higher]);
            return Way { shifts, turn };
        }
        if let Some(free) = self.scene.free_walls.iter().find(|free| wall.name() == Some(&free.walls)) {
            let unit = free.moves.unit();
            return match &free.moves {
                Freedom::Along(_) => {
                    let [one, other] = free.range().map(|coordinate| unit * coordinate);
                    Way { shifts: [one.min(other), one.max(other)], turn: None }
                }
                Freedom::About { point, .. } => Way { shifts: [Solid::ZERO; 2], turn: Some([point.padded(), unit]) },
            };
        }
        let controls = self.scene.door_controls().into_iter();
        let of_door = controls.filter(|(number, ..)| self.scene.door_of(wall) == Some(*number));
        let by = of_door.fold(Solid::ZERO, |by, (_, _, control)| match control.how {
            DoorMotion::Move { by, .. } => by.padded(),
            _ => by,
        });
        Way { shifts: [by.min(Solid::ZERO), by.max(Solid::ZERO)], turn: None }
    }
}

/// The numbers of boxes by which a body with these ends along an axis must be shifted to come within reach of the box between `low` and
/// `high`, m. The body as it is, number 0, is always among them. Far too many are cut off.
fn boxes([first, last]: [f64; 2], (low, high): (f64, f64), reach: f64) -> Vec<f64> {
    let length = high - low;
    let from = ((low - reach - last) / length).ceil();
    let to = ((high + reach - first) / length).floor();
    let mut boxes: Vec<_> = std::iter::successors(Some(from), |number| Some(number + 1.0))
        .take_while(|&n| n <= to)
        .take(MOST_IMAGES + 1)
        .collect();
    if !boxes.contains(&0.0) {
        boxes.push(0.0);
    }
    boxes
}

/// Whether a wall without ends is the same in all images along an axis; if not, why not.
fn is_along<V: Space>(surface: &Surface<V>, way: &Way, axis: usize) -> Result<(), &'static str> {
    let Some(Planar::HalfPlane { normal, .. }) = surface.shape().planar() else { return Ok(()) };
    if normal.axis(axis).abs() > 1e-9 {
        return Err("it has no ends, and stands across the periodic axis");
    }
    if !way.keeps(axis) {
        return Err("it has no ends, and turns about another axis than the periodic axis");
    }
    Ok(())
}
