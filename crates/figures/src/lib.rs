//! Figures: SVG and PNG drawings, diagrams with axes, colours, and statistics. It imports `siloflow-text` and no other crate of siloflow: no entity-component-system,
//! no physics, no files.
//!
//! Begin with [`svg::Picture`] for pictures, [`diagram`] for curves, [`statistics`] for means and fits.

pub mod colour;
pub mod diagram;
pub mod movie;
pub mod png;
pub mod statistics;
pub mod svg;
