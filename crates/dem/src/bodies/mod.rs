//! Shapes of grains: rigid bodies made of spheres (discs in the plane).
//!
//! A shaped grain is one entity with [`Shape`] and [`Orientation`]. Its [`Position`](crate::particle::Position) is the centre of mass, and its
//! [`Radius`](crate::particle::Radius) that of the sphere (disc) of equal volume (area). Contacts act between its spheres, which are rows of the
//! [store](crate::store). The mass is that of the *union* of the spheres: overlaps count once.
//!
//! | file | part |
//! |---|---|
//! | [`shape`] | a shape with its mass properties, and the components of a shaped grain |
//! | [`config`] | the scene key `shapes` |
//! | [`crops`] | published sizes of grains |
//! | [`makers`] | chains of spheres: capsules, ellipses, ellipsoids of revolution |
//! | [`surfaces`] | points of other surfaces: any ellipsoids, polygons, closed meshes |
//! | [`cover`] | spheres for the points of a surface |
//! | [`disc_union`] | area and moments of a union of discs, exact |
//! | [`sphere_union`] | volume and moments of a union of spheres, by slices |
//! | [`symmetric`] | eigenvalues of a symmetric matrix |

pub mod config;
pub mod cover;
pub mod crops;
pub mod disc_union;
pub mod makers;
pub mod shape;
pub mod sphere_union;
pub mod surfaces;
pub mod symmetric;

pub use self::shape::{Orientation, RigidShape, Shape, ShapeFault, ShapeSphere};
