//! Trimmed surface: a panel or a surface of revolution with a hole, or the part of it that fills the hole.
//!
//! A prism cuts the surface where the prism leaves it: where the outward normal n has n.d > 0, with d the direction of the prism. So a
//! prism across a cylinder makes one hole, not two. The cut is bounded by the rim, a closed curve on the surface: the
//! lines b(t) + s d meet the surface at p(t), with b(t) the circle or rectangle and s' = -n.b'/n.d.
//!
//! The nearest point of the whole surface counts, if it belongs to the part that is left. Otherwise the nearest point is on the rim:
//! |x - p(t)| has its minima where (p - x).p' grows through zero. The minima are searched between 32 places of the rim
//! and refined to rounding.
//!
//! Limits: the rim lies on the surface as a whole, off its edges. A minimum is missed if the distance from the rim has two minima between two samples.

use std::f64::consts::PI;

use crate::math;
use crate::space::{Linear, Plane, Space};
use crate::walls::area::clipped_area;
use crate::walls::clip::{clip, share_edges};
use crate::walls::drawing::{Detail, Drawing};
use crate::walls::pose::Pose;
use crate::walls::shapes::prism::{CurvePoint, FlatSide, Prism};
use crate::walls::shapes::revolved::Exit;
use crate::walls::shapes::whole::Whole;
use crate::walls::shapes::zero::{Value, zero_between};
use crate::walls::shapes::{Nearest, Shape, box_around, parted};

/// Number of places of the rim between which minima of the distance are searched.
const SAMPLES: u32 = 32;

/// Number of flat pieces of the rim, for the bounds.
const RIM_PIECES: u32 = 48;

/// Number of flat pieces about the axis, and of sides of a round hole, where the area is measured.
const AREA_PIECES: u32 = 240;

/// Least cosine of the angle between the normal of the surface and the direction of the prism.
const OBLIQUE: f64 = 0.1;

/// Where the rim of a cut is not on the surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum RimFault<V> {
    /// The rim reaches an edge of the surface, or passes it, near this point, m.
    OffTheSurface(V),
    /// The prism grazes the surface near this point, m.
    Grazing(V),
}

/// A part of a surface.
#[derive(Clone, Debug)]
pub struct Trimmed<V: Space = Plane> {
    /// The whole surface.
    pub whole: Whole<V>,
    prism: Prism<V>,
    /// Whether the part inside the prism is left, or the part outside.
    is_patch: bool,
    /// Places of the rim, side by side, each side with both ends.
    samples: Vec<CurvePoint<V>>,
}

impl<V: Space> Trimmed<V> {
    /// Returns the surface with a hole where the prism leaves it.
    #[must_use]
    pub fn with_hole(whole: Whole<V>, prism: Prism<V>) -> Self {
        let leads_in = whole.outwards(prism.centre).dot(prism.direction) < 0.0;
        let prism = if leads_in { prism.reversed() } else { prism };
        let mut shape = Self { whole, prism, is_patch: false, samples: Vec::new() };
        let samples = shape.samples_of_a_side();
        let places = (0..prism.sides()).flat_map(|side| (0..=samples).map(move |n| (side, n)));
        // A rim that is not on the surface is refused with the scene.
        shape.samples = places.filter_map(|(side, n)| shape.on_rim(side, f64::from(n) / f64::from(samples))).collect();
        shape
    }

    /// Returns the part of the surface where the prism leaves it.
    #[must_use]
    pub fn patch(whole: Whole<V>, prism: Prism<V>) -> Self {
        Self { is_patch: true, ..Self::with_hole(whole, prism) }
    }

    fn samples_of_a_side(&self) -> u32 {
        SAMPLES / self.prism.sides()
    }

    /// Whether a point of the whole surface belongs to the part that is left.
    fn keeps(&self, x: V) -> bool {
        (self.prism.contains(x) && self.whole.outwards(x).dot(self.prism.direction) > 0.0) == self.is_patch
    }

    /// Returns the point at this share (0 to 1) of a side of the rim.
    fn on_rim(&self, side: u32, share: f64) -> Option<CurvePoint<V>> {
        let CurvePoint { point: start, slope } = self.prism.on_side(side, share);
        let direction = self.prism.direction;
        let Exit { point, normal } = self.whole.exit(start, direction)?;
        Some(CurvePoint { point, slope: slope - direction * (normal.dot(slope) / normal.dot(direction)) })
    }

    /// Returns the point of the rim that is nearest to `x`, m.
    fn nearest_on_rim(&self, x: V) -> Option<V> {
        let samples = self.samples_of_a_side();
        let slope = |at: CurvePoint<V>| (at.point - x).dot(at.slope);
        let nearer = |a: &V, b: &V| a.distance_squared(x).total_cmp(&b.distance_squared(x));
        // The way along the rim between two samples is at most a tenth longer than the straight one, and no point of it is nearer than this.
        let bound = |a: V, b: V| 0.5 * (a.distance(x) + b.distance(x) - 1.1 * a.distance(b));
        let mut nearest = self.samples.iter().map(|sample| sample.point).min_by(nearer)?;
        for (side, places) in (0..).zip(self.samples.chunks_exact(samples as usize + 1)) {
            for (n, ends) in (0..samples).zip(places.windows(2)) {
                let [before, after] = [ends[0], ends[1]].map(slope);
                if !(before < 0.0 && after > 0.0) || bound(ends[0].point, ends[1].point) > nearest.distance(x) {
                    continue;
                }
                let share = |n: u32| f64::from(n) / f64::from(samples);
                let slope_at = |share| self.on_rim(side, share).map_or(0.0, slope);
                let before = Value { place: share(n), value: before };
                let after = Value { place: share(n + 1), value: after };
                let least = zero_between(slope_at, before, after);
                let point = self.on_rim(side, least).map(|found| found.point);
                nearest = point.filter(|point| nearer(point, &nearest).is_lt()).unwrap_or(nearest);
            }
        }
        Some(nearest)
    }

    /// Returns the fault of the rim, if it has one.
    pub fn rim_fault(&self) -> Option<RimFault<V>> {
        let mut places = (0..self.prism.sides()).flat_map(|side| (0..SAMPLES).map(move |n| (side, n)));
        places.find_map(|(side, n)| {
            let start = self.prism.on_side(side, f64::from(n) / f64::from(SAMPLES)).point;
            let Some(Exit { point, .. }) = self.whole.exit(start, self.prism.direction) else {
                return Some(RimFault::OffTheSurface(start));
            };
            if self.whole.outwards(point).dot(self.prism.direction) < OBLIQUE {
                return Some(RimFault::Grazing(point));
            }
            let (foot, at_edge) = self.whole.foot(point);
            let size = point.distance(self.prism.centre) + start.distance(self.prism.centre);
            (at_edge || foot.distance(point) > 1e-9 * size).then_some(RimFault::OffTheSurface(point))
        })
    }

    /// Returns the part that is left as flat convex polygons, m. A surface of revolution is made of `around` flat pieces, and a circle
    /// is a polygon of as many sides.
    pub fn pieces(&self, around: u32) -> Vec<Vec<V>> {
        let sides = self.prism.flat_sides(around);
        let mut pieces = Vec::new();
        for facet in self.whole.facets(around) {
            let [a, _, c, _] = facet;
            let is_cut = self.whole.outwards((a + c) * 0.5).dot(self.prism.direction) > 0.0;
            let inside = |kept: Vec<V>, side: &FlatSide<V>| clip(&kept, |x| (side.corner - x).dot(side.outwards));
            let within = if is_cut { sides.iter().fold(facet.to_vec(), inside) } else { Vec::new() };
            if self.is_patch {
                pieces.push(within);
            } else if within.len() < 3 {
                pieces.push(facet.to_vec());
            } else {
                // The part outside of each side, and inside of the sides before.
                sides.iter().fold(facet.to_vec(), |kept, side| {
                    pieces.push(clip(&kept, |x| (x - side.corner).dot(side.outwards)));
                    inside(kept, side)
                });
            }
        }
        pieces.retain(|piece| piece.len() > 2);
        pieces
    }
}

impl<V: Space> Shape<V> for Trimmed<V> {
    fn nearest(&self, x: V) -> Nearest<V> {
        let nearest = self.whole.shape().nearest(x);
        if matches!(nearest, Nearest::Point { away, .. } if self.keeps(x - away)) {
            return nearest;
        }
        let Some(point) = self.nearest_on_rim(x) else { return nearest };
        Nearest::Point { away: parted(x - point, || self.whole.outwards(point)), curvature: 0.0, at_edge: true }
    }

    /// A surface with a hole has the bounds of the whole surface. A patch has the bounds of its flat pieces, with a margin for its curvature.
    fn bounds(&self) -> Option<[V; 2]> {
        if !self.is_patch {
            return self.whole.shape().bounds();
        }
        let [low, high] = box_around(&self.pieces(RIM_PIECES).concat())?;
        // A chord of a circle lies this share of the radius inside, and an oblique cut lengthens it.
        let sagitta = 1.0 - math::cos(PI / f64::from(RIM_PIECES));
        let margin = V::from_components(|_| sagitta * (self.whole.largest_radius() + self.prism.reach() / OBLIQUE));
        Some([low - margin, high + margin])
    }

    fn crossing(&self, from: V, to: V) -> Option<f64> {
        let is_kept = |share: &f64| self.keeps(from + (to - from) * *share);
        // A line crosses the whole surface twice at most, so the last crossing is the first one of the way back.
        let first = || self.whole.shape().crossing(from, to);
        let last = || self.whole.shape().crossing(to, from).map(|share| 1.0 - share);
        first().filter(is_kept).or_else(|| last().filter(is_kept))
    }

    fn placed(&self, pose: &Pose<V>) -> Self {
        let placed = |&CurvePoint { point, slope }: &CurvePoint<V>| CurvePoint {
            point: pose.point(point),
            slope: pose.direction(slope),
        };
        Self {
            whole: self.whole.placed(pose),
            prism: self.prism.placed(pose),
            is_patch: self.is_patch,
            samples: self.samples.iter().map(placed).collect(),
        }
    }

    fn reference(&self) -> V {
        self.whole.shape().reference()
    }

    fn area_between(&self, low: f64, high: f64) -> Option<f64> {
        Some(self.pieces(AREA_PIECES).iter().map(|piece| clipped_area(piece, low, high)).sum())
    }

    fn drawing(&self, &Detail { sectors, domain }: &Detail) -> Drawing {
        let spread = |piece: Vec<V>| piece.into_iter().map(Linear::spread).collect();
        let mut pieces: Vec<Vec<_>> = self.pieces(sectors).into_iter().map(spread).collect();
        share_edges(&mut pieces, 1e-9 * (domain[1] - domain[0]).length());
        Drawing::fans(pieces)
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use proptest::prelude::*;

    use super::*;
    use crate::space::Solid;
    use crate::walls::clip::area;
    use crate::walls::shapes::panel::Panel;
    use crate::walls::shapes::revolved::Revolved;

    fn cylinder() -> Whole<Solid> {
        Whole::Revolved(Revolved::between(Solid::new(0.0, 0.0, -1.0), Solid::Z, [0.5, 0.5]))
    }

    fn cone(radii: [f64; 2]) -> Whole<Solid> {
        Whole::Revolved(Revolved::between(Solid::ZERO, Solid::Z, radii))
    }

    fn panel() -> Whole<Solid> {
        let along = Solid::new(1.2, 0.0, 0.9);
        let across = Solid::new(0.0, 1.5, 0.0);
        Whole::Panel(Panel { corner: -0.5 * (along + across), along, across })
    }

    /// Surfaces with a figure that lies on each of them.
    fn cuts() -> Vec<(Whole<Solid>, Prism<Solid>)> {
        let square = |centre, size| Prism::rectangle(centre, Solid::X * size, Solid::Y * size * 0.6);
        let side = Solid::new(0.48, 0.1, 0.2);
        vec![
            (panel(), Prism::circle(Solid::new(0.1, -0.1, 0.0), Solid::Z, 0.3)),
            (panel(), square(Solid::new(0.1, 0.2, 0.0), 0.5)),
            (cylinder(), Prism::circle(side, Solid::new(1.0, 0.2, 0.1), 0.25)),
            (cylinder(), Prism::rectangle(side, Solid::new(0.1, -0.4, 0.0), Solid::new(0.0, 0.0, 0.5))),
            (cone([0.0, 0.8]), square(Solid::ZERO, 0.5)),
            (cone([0.0, 0.8]), square(Solid::new(0.1, 0.15, 1.0), 0.6)),
            (cone([0.1, 0.8]), Prism::circle(Solid::new(0.4, 0.1, 0.5), Solid::new(0.8, 0.1, -0.7), 0.2)),
            (
                Whole::Revolved(Revolved::ring(Solid::ZERO, Solid::Z, [0.0, 1.0])),
                square(Solid::new(0.2, 0.3, 0.1), 0.5),
            ),
        ]
    }

    /// Points of a fine grid on the part that is left, and the largest distance of any of its points from one of them.
    fn grid(shape: &Trimmed<Solid>) -> (Vec<Solid>, f64) {
        let steps = 240;
        let part = |n: u32| f64::from(n) / f64::from(steps);
        let all = (0..=steps).flat_map(|i| (0..=steps).map(move |j| (i, j)));
        let (points, cell): (Vec<_>, _) = match shape.whole {
            Whole::Panel(panel) => (
                all.map(|(i, j)| panel.corner + panel.along * part(i) + panel.across * part(j)).collect(),
                (panel.along.length() + panel.across.length()) / f64::from(steps),
            ),
            Whole::Revolved(wall) => {
                let [(r_0, z_0), (r_1, z_1)] = [wall.from, wall.to].map(|[r, z]| (r, z));
                let point = |(i, j): (u32, u32)| {
                    let r = r_0 + part(i) * (r_1 - r_0);
                    let z = z_0 + part(i) * (z_1 - z_0);
                    let angle = TAU * part(j);
                    wall.base + Solid::new(r * angle.cos(), r * angle.sin(), z)
                };
                (all.map(point).collect(), ((r_1 - r_0).hypot(z_1 - z_0) + TAU * r_0.max(r_1)) / f64::from(steps))
            }
        };
        (points.into_iter().filter(|&point| shape.keeps(point)).collect(), cell)
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(48))]

        #[test]
        fn the_nearest_point_is_nearest_and_on_the_part_that_is_left(x in (-1.0..1.0, -1.0..1.0, -0.6..1.4)) {
            let x = Solid::new(x.0, x.1, x.2);
            for (number, (whole, prism)) in cuts().into_iter().enumerate() {
                for shape in [Trimmed::with_hole(whole, prism), Trimmed::patch(whole, prism)] {
                    prop_assert_eq!(shape.rim_fault(), None);
                    let (points, cell) = grid(&shape);
                    let by_points = points.iter().map(|point| point.distance(x)).fold(f64::INFINITY, f64::min);
                    let nearest = shape.nearest(x);
                    let Nearest::Point { away, at_edge, .. } = nearest else { panic!("a thin surface") };
                    prop_assert!(away.length() <= by_points + 1e-12, "{number}: {} m, not {by_points} m", away.length());
                    prop_assert!(by_points <= away.length() + cell, "{number}: {} m, not {by_points} m", away.length());
                    prop_assert!(whole.foot(x - away).0.distance(x - away) < 1e-12);
                    prop_assert!(shape.nearest(x - away).distance() < 1e-9);
                    // Off any edge, the centre is straight above the surface.
                    let aslant = Linear::length(away.cross(whole.outwards(x - away)));
                    prop_assert!(at_edge || aslant < 1e-9, "{number}: {aslant}");
                }
            }
        }

        /// The hole and its lid together are the whole surface.
        #[test]
        fn a_hole_and_its_patch_share_the_crossings_of_the_whole(
            from in (-1.0..1.0, -1.0..1.0, -0.6..1.4), way in (-0.3..0.3, -0.3..0.3, -0.3..0.3),
        ) {
            let from = Solid::new(from.0, from.1, from.2);
            let to = from + Solid::new(way.0, way.1, way.2);
            for (whole, prism) in cuts() {
                let [hole, patch] =
                    [Trimmed::with_hole(whole, prism), Trimmed::patch(whole, prism)].map(|shape| shape.crossing(from, to));
                let first = match (hole, patch) {
                    (Some(a), Some(b)) => Some(a.min(b)),
                    (one, other) => one.or(other),
                };
                let expected = whole.shape().crossing(from, to);
                prop_assert!(first == expected || (first.unwrap() - expected.unwrap()).abs() < 1e-9, "{first:?}, {expected:?}");
            }
        }
    }

    #[test]
    fn a_round_hole_about_the_axis_of_a_cone_makes_a_frustum() {
        // The hole of radius 0.2 about the axis cuts the cone of slope 0.8 at z = 0.25.
        let cut = Trimmed::with_hole(cone([0.0, 0.8]), Prism::circle(Solid::ZERO, Solid::Z, 0.2));
        let frustum = Revolved::between(Solid::Z * 0.25, Solid::Z, [0.2, 0.8]);
        for n in 0..200u32 {
            let x =
                Solid::new((f64::from(n) * 0.7).sin() * 0.5, (f64::from(n) * 1.3).cos() * 0.5, f64::from(n) / 200.0);
            let [Nearest::Point { away, .. }, Nearest::Point { away: other, .. }] =
                [cut.nearest(x), frustum.nearest(x)]
            else {
                panic!("thin surfaces")
            };
            // The rim of the hole is a circle about the axis, too.
            assert!(away.distance(other) < 1e-12, "{x}: {away}, {other}");
        }
    }

    #[test]
    fn an_eccentric_round_hole_in_a_plate_has_the_distances_of_its_circle() {
        let plate = Whole::Revolved(Revolved::ring(Solid::ZERO, Solid::Z, [0.0, 1.0]));
        let centre = Solid::new(0.3, -0.2, 0.0);
        let shape = Trimmed::with_hole(plate, Prism::circle(centre, Solid::Z, 0.25));
        for n in 0..50u32 {
            let r = 0.005 * f64::from(n);
            let angle = f64::from(n) * 0.9;
            let z = 0.1 - 0.004 * f64::from(n);
            let x = centre + Solid::new(r * angle.cos(), r * angle.sin(), z);
            let expected = (0.25 - r).hypot(z);
            assert!((shape.nearest(x).distance() - expected).abs() < 1e-14, "{n}");
        }
    }

    #[test]
    fn a_side_hole_is_on_the_side_of_its_centre_alone() {
        let shape = Trimmed::with_hole(cylinder(), Prism::circle(Solid::new(0.45, 0.0, 0.0), Solid::X, 0.1));
        let out = |x: f64| shape.crossing(Solid::ZERO, Solid::new(x, 0.0, 0.0));
        assert_eq!((out(1.0), out(-1.0)), (None, Some(0.5)));
        assert_eq!(shape.crossing(-Solid::X, Solid::X), Some(0.25));
        assert_eq!(shape.crossing(Solid::X, -Solid::X), Some(0.75));
    }

    #[test]
    fn pieces_have_the_areas_of_the_parts() {
        let sum = |shape: &Trimmed<Solid>| shape.pieces(240).iter().map(|piece| area(piece)).sum::<f64>();
        for (whole, prism) in cuts() {
            let expected: f64 = whole.facets(240).iter().map(|facet| area(facet)).sum();
            let found = sum(&Trimmed::with_hole(whole, prism)) + sum(&Trimmed::patch(whole, prism));
            assert!((found - expected).abs() < 1e-12 * expected, "{found}, not {expected}");
        }
        // Seen along the normal of the figure, both areas are equal; a slope of 0.8 stretches it by sqrt(1 + 1/0.64).
        let lid = |whole, prism| sum(&Trimmed::patch(whole, prism));
        let round = lid(cuts()[0].0, cuts()[0].1);
        assert!((round / (PI * 0.09 * 1.25) - 1.0).abs() < 2e-4, "{round}");
        let square = lid(cuts()[4].0, cuts()[4].1);
        assert!((square / (0.5 * 0.3 * (1.0 + 1.0 / 0.64f64).sqrt()) - 1.0).abs() < 2e-4, "{square}");
    }

    #[test]
    fn bounds_of_a_patch_hold_its_points_and_little_more() {
        for (whole, prism) in cuts() {
            let patch = Trimmed::patch(whole, prism);
            let (points, cell) = grid(&patch);
            let [low, high] = patch.bounds().unwrap();
            let [least, most] = [Solid::min, Solid::max].map(|join| points.iter().copied().reduce(join).unwrap());
            assert!(
                (least - low).min_element() > -1e-12 && (high - most).min_element() > -1e-12,
                "{low} {least} {most} {high}"
            );
            assert!((least - low).max_element() < cell + 0.02 && (high - most).max_element() < cell + 0.02);
        }
    }

    #[test]
    fn rims_off_the_surface_and_grazing_prisms_are_found() {
        let fault = |whole, prism| Trimmed::with_hole(whole, prism).rim_fault();
        let on_side = |radius| Prism::circle(Solid::X * 0.5, Solid::X, radius);
        assert_eq!(fault(cylinder(), on_side(0.45)), None);
        assert!(matches!(fault(cylinder(), on_side(0.499)), Some(RimFault::Grazing(_))));
        assert!(fault(cylinder(), on_side(0.6)).is_some());
        let beyond_the_end = Prism::circle(Solid::new(0.5, 0.0, 1.5), Solid::X, 0.1);
        assert!(matches!(fault(cylinder(), beyond_the_end), Some(RimFault::OffTheSurface(_))));
        let at = |x| Prism::circle(Solid::new(x, 0.0, 0.0), Solid::Z, 0.2);
        assert_eq!(fault(panel(), at(0.35)), None);
        assert!(matches!(fault(panel(), at(0.5)), Some(RimFault::OffTheSurface(_))));
        assert!(matches!(fault(cone([0.3, 0.8]), at(0.0)), Some(RimFault::OffTheSurface(_))));
    }

    #[test]
    fn a_turned_cut_is_the_cut_of_the_turned_surface() {
        let pose =
            Pose { about: Solid::new(0.1, 0.2, 0.3), axis: Solid::Y, angle: 0.7, shift: Solid::new(0.3, 0.0, -0.1) };
        for (whole, prism) in cuts() {
            let shape = Trimmed::with_hole(whole, prism);
            let placed = shape.placed(&pose);
            for n in 0..20u32 {
                let x = Solid::new((f64::from(n) * 0.7).sin(), (f64::from(n) * 1.3).cos(), f64::from(n) / 20.0) * 0.6;
                let apart = placed.nearest(pose.point(x)).distance() - shape.nearest(x).distance();
                assert!(apart.abs() < 1e-12, "{apart:e}");
            }
        }
    }
}
