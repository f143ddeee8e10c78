//! Figures: SVG and PNG drawings, diagrams with axes, colours, and statistics. No ECS and no physics.

pub mod colour;
pub mod diagram;
pub mod movie;
pub mod png;
pub mod statistics;
pub mod svg;
