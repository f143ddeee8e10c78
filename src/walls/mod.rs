//! Walls: discs of a silo file, discs and wall surfaces of the scene, and the lines whose crossing counts as a way out.

pub mod config;
pub mod conveyor;
pub(crate) mod mesh;
pub(crate) mod near;
pub mod outline;
pub mod paths;
pub mod seams;
pub mod shapes;
pub mod silo_file;
pub(crate) mod surface_index;
pub mod surfaces;
pub(crate) mod triangulation;
