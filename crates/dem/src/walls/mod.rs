//! Walls: discs of a silo file, discs and wall surfaces of the scene, their motions, and the lines whose crossing counts as
//! a way out.
//!
//! | word | meaning |
//! |---|---|
//! | [`Wall`](config::Wall) | an entry of the scene key `walls`: a shape, a material, a name, and whether it is the door |
//! | [`WallShape`](config::shape::WallShape) | the shape of a wall in the numbers of the scene, such as a cylinder or the file of a mesh |
//! | wall grain | a disc or sphere that is a grain which no force moves: of a silo file, or of the scene if it has no name and is no door |
//! | [`Surface`](surface::Surface) | the geometry of a wall, or of a part of it: a polygon or mesh has one surface for each triangle |
//! | [`Shape`](shapes::Shape) | the trait that each kind of surface implements |
//! | [`SurfaceWall`](surface_wall::SurfaceWall) | a surface in a run: with its wall, material, velocity and door |
//! | [`Surfaces`](surfaces::Surfaces) | all surfaces of a run, with their motions, the search by place and the loads on them |
//! | [`Enclosure`](enclosure::Enclosure), [`SolidEnclosure`](paths::SolidEnclosure) | the lines or surfaces that a grain crosses only on its way out |

mod area;
pub(crate) mod box_tree;
pub mod clip;
pub mod config;
pub mod conveyor;
mod disc_links;
pub mod drawing;
pub mod enclosure;
pub mod free;
pub mod leaving;
pub mod link;
pub mod mesh;
pub mod mesh_faults;
pub mod motion;
pub mod mover;
pub mod moving;
pub(crate) mod near;
pub mod paths;
pub mod pose;
pub mod seams;
pub mod shapes;
pub mod silo_file;
pub mod surface;
pub(crate) mod surface_index;
pub mod surface_wall;
pub mod surfaces;
pub(crate) mod triangulation;
pub mod twins;
