//! The slope of the free surface of a bed: the scene key `slopes`. Angles of heaps, of what stays after a draw-down, of the bed in a drum.
//!
//! 1. *Surface*. The horizontal plane is divided into cells, in the plane the horizontal line, of two mean diameters. The highest point of the spheres in a cell
//!    is a point of the surface. Only grains inside the box count that touch something: grains in flight are no surface.
//! 2. *Part*. Points between two shares of the height of the surface count, such as 0.2 to 0.8 for the flank of a heap without its foot and its
//!    round top. Default: all points.
//! 3. *Fit*. The straight line of least squares through height against the distance s, along a direction (`Along`), or from a vertical axis
//!    (`Outwards`, a cone) or towards it (`Inwards`, a funnel).
//!    The angle is atan(-dh/ds): positive where the surface falls.
//!
//! The highest point of a cell lies above the mean surface, by the same height in all cells, which changes no angle. Cells should be wider than
//! one diameter, or gaps between grains count as surface. A surface that is not straight has the angle of its best line; the scatter tells.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::measure::moment::Moment;
use siloflow_dem::math;
use siloflow_dem::space::{Solid, Space};
use siloflow_dem::values::{FiniteVector, Positive, Share};
use siloflow_figures::statistics::line::Line;

/// One entry of the scene key `slopes`.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Slope {
    /// Name in the results.
    pub name: String,
    /// The way in which the surface falls.
    pub falls: Falls,
    /// Lowest corner of the box in which grains count, m.
    pub low: FiniteVector,
    /// Highest corner, m.
    pub high: FiniteVector,
    /// Shares of the height of the surface between which its points count. Default: (0, 1).
    #[serde(default)]
    pub heights: Option<(Share, Share)>,
    /// Width of a cell, m. Default: two mean diameters of the grains.
    #[serde(default)]
    pub cell: Option<Positive>,
    /// Start of the window of the mean in `summary.json`. Default: the end of the run, which counts alone.
    #[serde(default)]
    pub from: Option<Moment>,
}

/// The way in which a surface falls.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
pub enum Falls {
    /// Along a horizontal direction of any length.
    Along(FiniteVector),
    /// Away from the vertical line through a point, m, as a heap does.
    Outwards(FiniteVector),
    /// Towards the vertical line through a point, m, as the bed above an outlet does.
    Inwards(FiniteVector),
}

/// A measured slope.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Measured {
    /// Angle to the horizontal, degrees.
    pub angle: f64,
    /// Height of the line above the middle of the points, m.
    pub height: f64,
    /// Root-mean-square distance of the points from the line, in height, m.
    pub scatter: f64,
    /// Number of points.
    pub points: usize,
}

/// A sphere that belongs to the bed.
#[derive(Clone, Copy, Debug)]
pub struct Sphere<V> {
    /// Centre, m.
    pub centre: V,
    /// Radius, m.
    pub radius: f64,
}

/// Fewest points of a slope.
const FEWEST: usize = 3;

impl Slope {
    /// Measures the slope of some spheres with cells of this width, m; `None` with fewer than three points, or if all lie at one distance.
    pub fn measure<V: Space>(&self, spheres: impl Iterator<Item = Sphere<V>>, cell: f64) -> Option<Measured> {
        let mut points = self.surface(spheres, cell);
        if let Some((low, high)) = self.heights {
            let lowest = points.iter().map(|point| point.1).fold(f64::INFINITY, f64::min);
            let highest = points.iter().map(|point| point.1).fold(f64::NEG_INFINITY, f64::max);
            let height = |share: Share| lowest + share.get() * (highest - lowest);
            points.retain(|point| (height(low)..=height(high)).contains(&point.1));
        }
        let line = Line::through(&points).filter(|_| points.len() >= FEWEST)?;
        #[expect(clippy::cast_precision_loss, reason = "a number of cells")]
        let count = points.len() as f64;
        let squares: f64 = points.iter().map(|(s, h)| (h - line.intercept - line.slope * s).powi(2)).sum();
        Some(Measured {
            angle: math::atan(-line.slope).to_degrees(),
            height: points.iter().map(|point| point.1).sum::<f64>() / count,
            scatter: (squares / count).sqrt(),
            points: points.len(),
        })
    }

    /// The points of the surface: distance s and height, m.
    fn surface<V: Space>(&self, spheres: impl Iterator<Item = Sphere<V>>, cell: f64) -> Vec<(f64, f64)> {
        let low = self.low.get::<V>();
        let high = self.high.get::<V>();
        let mut highest: BTreeMap<[i64; 2], V> = BTreeMap::new();
        for Sphere { centre, radius } in spheres {
            if (0..V::COMPONENTS).any(|axis| !(low.axis(axis)..=high.axis(axis)).contains(&centre.axis(axis))) {
                continue;
            }
            let top = centre.with_axis(V::COMPONENTS - 1, centre.height() + radius);
            #[expect(clippy::cast_possible_truncation, reason = "a cell of a box; far beyond, the cast saturates")]
            let number = |axis: usize| ((centre.axis(axis) - low.axis(axis)) / cell).floor() as i64;
            let key = [number(0), if V::COMPONENTS == 3 { number(1) } else { 0 }];
            let own = highest.entry(key).or_insert(top);
            // Equal heights do not depend on the order of the spheres.
            let rank = |point: V| (point.height(), point.axis(0), point.axis(1));
            if rank(top) > rank(*own) {
                *own = top;
            }
        }
        highest.into_values().map(|top| (self.distance(top), top.height())).collect()
    }

    /// The distance of a place along the way of the fall, m.
    fn distance<V: Space>(&self, place: V) -> f64 {
        let level = |vector: V| vector.with_axis(V::COMPONENTS - 1, 0.0);
        match &self.falls {
            Falls::Along(direction) => level(direction.get::<V>()).unit_or_zero().dot(place),
            Falls::Outwards(point) => level(place - point.get::<V>()).length(),
            Falls::Inwards(point) => -level(place - point.get::<V>()).length(),
        }
    }

    /// The horizontal part of the direction; `None` for a cone.
    #[must_use]
    pub fn level_direction(&self) -> Option<Solid> {
        let Falls::Along(direction) = &self.falls else { return None };
        let padded = direction.padded();
        Some(if direction.count() == 2 { Solid::new(padded.x, 0.0, 0.0) } else { padded.with_z(0.0) })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use siloflow_dem::space::{Plane, Vector};

    fn slope(text: &str) -> Slope {
        let options = ron::Options::default().with_default_extension(ron::extensions::Extensions::IMPLICIT_SOME);
        options.from_str(text).unwrap()
    }

    /// Rows of discs below a line of 30 degrees that falls to the right.
    fn bank() -> Vec<Sphere<Plane>> {
        let along = Vector::from_angle(-std::f64::consts::FRAC_PI_6);
        let row = |depth: f64| (0..40).map(move |k| along * (0.5 * f64::from(k)) - along.perp() * depth);
        [0.0, 0.5, 1.0].into_iter().flat_map(row).map(|centre| Sphere { centre, radius: 0.25 }).collect()
    }

    #[test]
    fn a_bank_of_discs_has_its_angle() {
        // Away from the ends, where lower rows look out.
        let all = "low: (2.0, -100.0), high: (15.0, 100.0)";
        let to_right = slope(&format!("(name: \"bank\", falls: Along((3.0, 1.0)), {all})"));
        // The highest point of a cell wider than the spacing, 0.43, is that of a disc of the top row, and these lie on a line.
        for cell in [0.5, 0.7, 1.1] {
            let found = to_right.measure(bank().into_iter(), cell).unwrap();
            assert!((found.angle - 30.0).abs() < 1e-9 && found.scatter < 1e-12, "{found:?}");
        }
        let to_left = slope(&format!("(name: \"bank\", falls: Along((-1.0, 0.0)), {all})"));
        assert!((to_left.measure(bank().into_iter(), 0.7).unwrap().angle + 30.0).abs() < 1e-9);
    }

    #[test]
    fn the_flanks_of_a_heap_have_their_angle_without_foot_and_top() {
        // A cone of 20 degrees between r = 3 and r = 8, flat inside and outside.
        let steepness = 20.0_f64.to_radians().tan();
        let height = |r: f64| steepness * (8.0 - r.clamp(3.0, 8.0));
        let places = (-50..=50).flat_map(|i| (-50..=50).map(move |j| (0.2 * f64::from(i), 0.2 * f64::from(j))));
        let heap =
            || places.clone().map(|(x, y)| Sphere { centre: Solid::new(x + 1.0, y, height(x.hypot(y))), radius: 0.1 });
        let text =
            "(name: \"cone\", falls: Outwards((1.0, 0.0, 0.0)), low: (-20.0, -20.0, -1.0), high: (20.0, 20.0, 20.0)";
        let flank = slope(&format!("{text}, heights: (0.1, 0.9))")).measure(heap(), 0.1999).unwrap();
        assert!((flank.angle - 20.0).abs() < 1e-6 && flank.scatter < 1e-9, "{flank:?}");
        assert!((flank.height - 0.1 - steepness * 2.5).abs() < 0.2, "{flank:?}");
        let whole = slope(&format!("{text})")).measure(heap(), 0.4).unwrap();
        assert!(whole.angle < 15.0 && whole.scatter > 0.1, "{whole:?}");
    }

    #[test]
    fn too_few_points_have_no_slope() {
        let text = "(name: \"bank\", falls: Along((1.0, 0.0)), low: (0.0, -9.0), high: (0.8, 9.0))";
        assert_eq!(slope(text).measure(bank().into_iter(), 0.5), None);
        assert_eq!(slope(text).measure(std::iter::empty::<Sphere<Plane>>(), 0.5), None);
    }
}
