//! The files of siloflow: those of a run directory, and how they are read and written. No physics and no ECS.

pub mod columns;
pub mod own_files;
