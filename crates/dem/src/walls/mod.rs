//! Walls: discs of a silo file, discs and wall surfaces of the scene, their motions, and the lines whose crossing counts as
//! a way out.

mod area;
pub(crate) mod box_tree;
mod clip;
pub mod config;
pub mod conveyor;
mod disc_links;
pub mod drawing;
pub mod enclosure;
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
