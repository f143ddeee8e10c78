//! Walls: discs of a silo file, discs and wall surfaces of the scene, their motions, and the lines whose crossing counts as
//! a way out.

pub mod area;
pub(crate) mod box_tree;
pub mod clip;
pub mod config;
pub mod conveyor;
mod disc_links;
pub mod figure;
pub mod mesh;
pub mod mesh_faults;
pub mod motion;
pub mod moving;
pub(crate) mod near;
pub mod outline;
pub mod paths;
pub mod pose;
pub mod seams;
pub mod shapes;
pub mod silo_file;
pub(crate) mod surface_index;
pub mod surfaces;
pub(crate) mod triangulation;
pub mod twins;
