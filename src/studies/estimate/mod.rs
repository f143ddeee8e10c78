//! An estimate: a figure of a scene with its error, from as few and as soft runs as will do.
//!
//! | part | file |
//! |---|---|
//! | the figure: a number of the summary, or a mean over part of a table | [`figures`](crate::studies::figures) |
//! | windows that begin and end at events | [`moment`](crate::measure::moment) |
//! | the keys of a scene that make it softer | [`softening`] |
//! | how soft it may be | [`softness`] |
//! | the estimator: a function of a source of runs | [`estimator`] |
//! | which run serves most | [`design`] |
//! | larger radii that make up for overlaps | [`growth`] |
//! | the runs of one stiffness | [`rung`] |
//! | the statistics of the extrapolation | [`extrapolation`](siloflow_figures::statistics::extrapolation) |
//! | what is asked for, the answer | [`goal`], [`answer`] |
//! | the effect of half of the step, of a larger silo | [`comparison`] |
//! | the kinds of runs | [`variant`] |
//! | results: JSON, tables, words | [`results`], [`words`] |
//! | the figure of value against softness | [`picture`] |
//!
//! The meaning of the interval: with the stated confidence it contains the mean of the figure over all seeds, at the stiffness and the step of the scene. The scatter of
//! a single run is another number, and stands beside it.

pub mod answer;
pub mod comparison;
pub mod design;
pub mod estimator;
pub mod goal;
pub mod growth;
pub mod picture;
pub mod results;
pub mod rung;
pub mod softening;
pub mod softness;
pub mod variant;
pub mod words;

#[cfg(test)]
mod coverage;
