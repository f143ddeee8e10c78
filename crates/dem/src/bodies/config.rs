//! The scene key `shapes`: shapes of grains by name.

use std::path::PathBuf;
use std::sync::Arc;

use serde::{Deserialize, Serialize};

use crate::bodies::cover::{Cover, SurfacePoint, cover};
use crate::bodies::crops::Crop;
use crate::bodies::makers::{Deviation, Link, Profile};
use crate::bodies::shape::{RigidShape, SIZES};
use crate::bodies::surfaces;
use crate::space::{Dimension, Solid, Space as _};
use crate::values::{FiniteVector, LengthUnit, Positive};

/// A sphere (disc) of a shape.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct SphereConfig {
    /// Centre, m, from any point of the shape.
    pub at: FiniteVector,
    /// Radius, m.
    pub radius: Positive,
}

/// An entry of the scene key `shapes`.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub enum ShapeConfig {
    /// Spheres in solid space.
    Spheres(Vec<SphereConfig>),
    /// Discs in the plane.
    Discs(Vec<SphereConfig>),
    /// An ellipsoid along x, y and z, in solid space.
    Ellipsoid {
        /// Full lengths of the axes, m.
        axes: (Positive, Positive, Positive),
        /// Number of spheres.
        spheres: u16,
    },
    /// A grain of a published size, in solid space: an ellipsoid.
    Crop {
        /// The crop.
        kind: Crop,
        /// Number of spheres. Default: that of the crop.
        #[serde(default)]
        spheres: Option<u16>,
    },
    /// A cuboid along x, y and z, in solid space.
    Cuboid {
        /// Lengths of the edges, m.
        size: (Positive, Positive, Positive),
        /// Number of spheres.
        spheres: u16,
    },
    /// The body inside a closed mesh, in solid space.
    Mesh {
        /// Path of the STL or OBJ file, relative to the scene file.
        file: PathBuf,
        /// Unit of the numbers in the file.
        unit: LengthUnit,
        /// Number of spheres.
        spheres: u16,
        /// The triangles, m; read from the file after the scene.
        #[serde(skip)]
        triangles: Arc<[[Solid; 3]]>,
    },
    /// A polygon, in the plane.
    Polygon {
        /// The corners in their order, m.
        points: Vec<FiniteVector>,
        /// Number of discs.
        discs: u16,
    },
    /// An ellipse along x and y, in the plane.
    Ellipse {
        /// Full lengths of the axes, m.
        axes: (Positive, Positive),
        /// Number of discs.
        discs: u16,
    },
    /// A cylinder with round ends, along x; in the plane a strip with round ends.
    Capsule {
        /// The whole length, m.
        length: Positive,
        /// Diameter, m.
        diameter: Positive,
        /// Number of spheres (discs).
        #[serde(alias = "discs")]
        spheres: u16,
    },
}

/// The spheres of an entry, and how far they are from the surface asked for.
#[derive(Clone, Debug, PartialEq)]
pub struct MadeShape {
    /// Centres and radii, m; in the plane z is 0.
    pub spheres: Vec<(Solid, f64)>,
    /// The distance to the surface asked for; `None` if the entry lists its spheres.
    pub deviation: Option<Deviation>,
}

impl ShapeConfig {
    /// Returns the space that the shape needs; `None` if it serves both.
    #[must_use]
    pub fn space(&self) -> Option<Dimension> {
        match self {
            Self::Spheres(_) | Self::Ellipsoid { .. } | Self::Crop { .. } | Self::Cuboid { .. } | Self::Mesh { .. } => {
                Some(Dimension::Solid)
            }
            Self::Discs(_) | Self::Ellipse { .. } | Self::Polygon { .. } => Some(Dimension::Plane),
            Self::Capsule { .. } => None,
        }
    }

    /// Returns the vectors of the entry with their keys.
    #[must_use]
    pub fn vectors(&self) -> Vec<(String, FiniteVector)> {
        match self {
            Self::Spheres(spheres) | Self::Discs(spheres) => {
                spheres.iter().enumerate().map(|(number, sphere)| (format!("[{number}].at"), sphere.at)).collect()
            }
            Self::Polygon { points, .. } => {
                points.iter().enumerate().map(|(number, point)| (format!(".points[{number}]"), *point)).collect()
            }
            _ => Vec::new(),
        }
    }

    /// Refuses lengths outside [`SIZES`] and bodies that are too slender for [`MOST_SPHERES`](RigidShape::MOST_SPHERES) in a row.
    fn check_lengths(&self) -> Result<(), String> {
        let lengths = match self {
            Self::Ellipsoid { axes: (x, y, z), .. } | Self::Cuboid { size: (x, y, z), .. } => vec![*x, *y, *z],
            Self::Ellipse { axes: (x, y), .. } => vec![*x, *y],
            Self::Capsule { length, diameter, .. } => vec![*length, *diameter],
            _ => return Ok(()),
        };
        let lengths = lengths.into_iter().map(Positive::get);
        let (shortest, longest) = (lengths.clone().fold(f64::INFINITY, f64::min), lengths.fold(0.0, f64::max));
        if shortest < SIZES[0] || longest > SIZES[1] {
            return Err(out_of_range());
        }
        let ratio = longest / shortest;
        if ratio > MOST_SLENDER {
            return Err(format!("the longest side is {ratio:.3e} times the shortest one: at most {MOST_SLENDER}"));
        }
        Ok(())
    }

    /// Makes the spheres.
    ///
    /// # Errors
    /// If the entry describes no shape, with the reason.
    pub fn make(&self) -> Result<MadeShape, String> {
        self.check_lengths()?;
        match *self {
            Self::Spheres(ref spheres) | Self::Discs(ref spheres) => {
                let spheres = spheres.iter().map(|sphere| (sphere.at.padded(), sphere.radius.get())).collect();
                Ok(MadeShape { spheres, deviation: None })
            }
            Self::Ellipsoid { axes: (x, y, z), spheres } => {
                ellipsoid(Solid::new(x.get(), y.get(), z.get()), usize::from(spheres))
            }
            Self::Crop { kind, spheres } => ellipsoid(kind.axes(), usize::from(spheres.unwrap_or(kind.spheres()))),
            Self::Cuboid { size: (x, y, z), spheres } => {
                let triangles = surfaces::cuboid(Solid::new(x.get(), y.get(), z.get()));
                covered(&surfaces::mesh(&triangles)?, spheres)
            }
            Self::Mesh { ref triangles, spheres, .. } => covered(&surfaces::mesh(triangles)?, spheres),
            Self::Polygon { ref points, discs } => {
                let corners: Vec<_> = points.iter().map(|point| point.padded().truncate()).collect();
                covered(&surfaces::polygon(&corners)?, discs)
            }
            Self::Ellipse { axes: (x, y), discs } => {
                ellipsoid(Solid::new(x.get(), y.get(), x.get().min(y.get())), usize::from(discs))
            }
            Self::Capsule { length, diameter, .. } if length < diameter => {
                Err("a capsule is at least as long as it is wide".to_owned())
            }
            Self::Capsule { length, diameter, spheres } => {
                let profile = Profile::Capsule { half_length: 0.5 * length.get(), radius: 0.5 * diameter.get() };
                chain(&profile, usize::from(spheres), Solid::X)
            }
        }
    }
}

/// Most spheres that are chosen for a surface. The moments of their union take seconds beyond it.
const MOST_CHOSEN: u16 = 200;

/// Largest ratio of two lengths of a shape: no longer row of spheres is one piece with as many spheres as a shape may have.
const MOST_SLENDER: f64 = 1000.0;

/// Returns why lengths outside [`SIZES`] are refused.
fn out_of_range() -> String {
    let [least, greatest] = SIZES;
    format!("lengths of a shape are from {least:e} to {greatest:e} m")
}

/// Chooses spheres for the points of a surface.
fn covered(points: &[SurfacePoint], count: u16) -> Result<MadeShape, String> {
    if count == 0 {
        return Err("the shape needs at least one sphere".to_owned());
    }
    if count > MOST_CHOSEN {
        return Err(format!("{count} spheres are too many: at most {MOST_CHOSEN} are chosen for a surface"));
    }
    // Squares of their distances, times the weights, are finite then.
    if points.iter().any(|point| point.at.length() > SIZES[1]) {
        return Err(out_of_range());
    }
    let Cover { balls, deviation } = cover(points, usize::from(count));
    if balls.is_empty() {
        return Err("no sphere fits inside: the surface bounds no body".to_owned());
    }
    let spheres = balls.iter().map(|ball| (ball.centre, ball.radius)).collect();
    Ok(MadeShape { spheres, deviation: Some(deviation) })
}

/// Makes a chain of spheres along an axis.
fn chain(profile: &Profile, count: usize, axis: Solid) -> Result<MadeShape, String> {
    let most = RigidShape::<Solid>::MOST_SPHERES;
    if count > most {
        return Err(format!("{count} spheres are too many: a shape has at most {most}"));
    }
    let links = profile.chain(count).ok_or_else(|| {
        format!("{count} spheres in a row do not reach from end to end: neighbours would not overlap; give more")
    })?;
    let deviation = Some(profile.deviation(&links));
    let spheres = links.iter().map(|&Link { x, radius }| (axis * x, radius)).collect();
    Ok(MadeShape { spheres, deviation })
}

/// Makes an ellipsoid with these axes, m: a chain if the two shorter ones are equal.
fn ellipsoid(axes: Solid, count: usize) -> Result<MadeShape, String> {
    let mut order = [0, 1, 2];
    order.sort_by(|&i, &j| axes[j].total_cmp(&axes[i]));
    let half = Solid::new(axes[order[0]], axes[order[1]], axes[order[2]]) * 0.5;
    // Equal numbers of the scene, not nearly equal ones.
    if half.y.total_cmp(&half.z).is_eq() {
        let along = Solid::ZERO.with_axis(order[0], 1.0);
        return chain(&Profile::Ellipse { a: half.x, b: half.y }, count, along);
    }
    let mut made = covered(&surfaces::ellipsoid(half), u16::try_from(count).unwrap_or(u16::MAX))?;
    for (at, _) in &mut made.spheres {
        *at = Solid::ZERO.with_axis(order[0], at.x).with_axis(order[1], at.y).with_axis(order[2], at.z);
    }
    Ok(made)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bodies::ShapeSphere;
    use crate::space::{Linear, Plane, Space};

    fn shape(config: &ShapeConfig) -> RigidShape<Solid> {
        let made = config.make().unwrap();
        let spheres: Vec<_> = made.spheres.iter().map(|&(at, radius)| ShapeSphere { at, radius }).collect();
        RigidShape::new("", &spheres).unwrap()
    }

    #[test]
    fn crops_have_the_volume_of_their_ellipsoids_up_to_the_valleys_between_spheres() {
        for kind in Crop::ALL {
            let config = ShapeConfig::Crop { kind, spheres: None };
            let axes = kind.axes();
            let whole = std::f64::consts::PI / 6.0 * axes.element_product();
            let size = shape(&config).size;
            let deviation = config.make().unwrap().deviation.unwrap();
            // The mean distance of the surfaces is zero, so the volumes differ by less than the area times the root mean square. The area by
            // Thomsen's formula.
            let [ab, ac, bc] = [axes.x * axes.y, axes.x * axes.z, axes.y * axes.z].map(|product| product.powf(1.6075));
            let area = std::f64::consts::PI * ((ab + ac + bc) / 3.0).powf(1.0 / 1.6075);
            assert!((size - whole).abs() < area * deviation.rms, "{kind:?} {}", size / whole);
            assert!((0.85..1.15).contains(&(size / whole)), "{kind:?} {}", size / whole);
            assert!(deviation.largest < 0.08 * axes.x, "{kind:?} {deviation:?}");
        }
    }

    #[test]
    fn a_surface_gets_a_number_of_spheres_that_can_be_worked_with() {
        let fault = |spheres| ShapeConfig::Crop { kind: Crop::Maize, spheres: Some(spheres) }.make().unwrap_err();
        assert!(fault(0).contains("at least one sphere") && fault(MOST_CHOSEN + 1).contains("at most 200"));
        let [length, diameter] = [2.0, 1.0].map(|length| Positive::try_from(length).unwrap());
        let fault = ShapeConfig::Capsule { length, diameter, spheres: u16::MAX }.make().unwrap_err();
        assert!(fault.contains("at most 1000"), "{fault}");
        let points = ["(0.0, 0.0)", "(1e110, 0.0)", "(0.0, 1e110)"].map(|point| ron::from_str(point).unwrap()).to_vec();
        let fault = ShapeConfig::Polygon { points, discs: 3 }.make().unwrap_err();
        assert_eq!(fault, out_of_range());
    }

    /// Numbers of all sizes, among them those whose squares vanish or overflow.
    const NUMBERS: [f64; 6] = [5e-324, 1e-120, 0.99e-3, 1e-3, 1e49, f64::MAX];

    /// Every entry that `lengths` gives is refused, or is a shape with finite numbers above zero.
    fn check_all<V: Space>(entry: impl Fn([f64; 3]) -> ShapeConfig) {
        for lengths in NUMBERS.into_iter().flat_map(|x| NUMBERS.map(|y| NUMBERS.map(|z| [x, y, z]))).flatten() {
            let Ok(made) = entry(lengths).make() else { continue };
            let spheres = made.spheres.iter().map(|&(at, radius)| ShapeSphere { at: V::narrow(at), radius });
            let Ok(shape) = RigidShape::<V>::new("", &spheres.collect::<Vec<_>>()) else { continue };
            let numbers = [shape.size, shape.mobility, shape.equivalent_radius(), shape.gyration.sum_of_components()];
            let is_positive = |number: f64| number.is_finite() && number.total_cmp(&0.0).is_gt();
            assert!(numbers.into_iter().all(is_positive), "{lengths:?} {numbers:?}");
        }
    }

    #[test]
    fn lengths_of_any_size_make_a_shape_or_are_refused() {
        let number = |x: f64| Positive::try_from(x).unwrap();
        let at = |x: f64, y: f64, z: f64| ron::from_str::<FiniteVector>(&format!("({x:e}, {y:e}, {z:e})")).unwrap();
        check_all::<Solid>(|[x, y, z]| ShapeConfig::Ellipsoid { axes: (number(x), number(y), number(z)), spheres: 3 });
        check_all::<Solid>(|[x, y, z]| ShapeConfig::Cuboid { size: (number(x), number(y), number(z)), spheres: 3 });
        check_all::<Solid>(|[x, y, _]| ShapeConfig::Capsule { length: number(x), diameter: number(y), spheres: 5 });
        check_all::<Plane>(|[x, y, _]| ShapeConfig::Ellipse { axes: (number(x), number(y)), discs: 3 });
        check_all::<Solid>(|[x, y, z]| {
            ShapeConfig::Spheres(vec![
                SphereConfig { at: at(0.0, 0.0, 0.0), radius: number(y) },
                SphereConfig { at: at(x, 0.0, 0.0), radius: number(z) },
            ])
        });
        check_all::<Plane>(|[x, y, z]| ShapeConfig::Polygon {
            points: vec![at(0.0, 0.0, 0.0), at(x, 0.0, 0.0), at(y, z, 0.0)],
            discs: 3,
        });
        check_all::<Solid>(|[x, y, z]| {
            let triangles = surfaces::cuboid(Solid::new(x, y, z)).into();
            ShapeConfig::Mesh { file: PathBuf::new(), unit: LengthUnit::Metre, spheres: 3, triangles }
        });
    }

    #[test]
    fn an_ellipsoid_may_lie_along_any_axis() {
        let number = |x: f64| Positive::try_from(x).unwrap();
        let made = |[x, y, z]: [f64; 3]| {
            let axes = (number(x), number(y), number(z));
            shape(&ShapeConfig::Ellipsoid { axes, spheres: 9 })
        };
        for [one, other] in
            [[[3.0, 1.0, 1.0], [1.0, 1.0, 3.0]], [[3.0, 2.0, 1.0], [2.0, 1.0, 3.0]], [[1.0, 3.0, 3.0], [3.0, 1.0, 3.0]]]
        {
            let [one, other] = [made(one), made(other)];
            assert!((one.size / other.size - 1.0).abs() < 1e-9);
            let sum = |shape: &RigidShape<Solid>| shape.gyration.element_sum();
            assert!((sum(&one) / sum(&other) - 1.0).abs() < 1e-9);
        }
    }
}
