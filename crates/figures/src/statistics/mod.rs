//! Statistics of plain numbers: means and their errors, fits, tests.
//!
//! | subject | file |
//! |---|---|
//! | mean and standard error, median, geometric mean | [`mean`] |
//! | Student's t, from the printed table | [`student`] |
//! | quantiles of Student's, Fisher's and the binomial distribution | [`quantile`] |
//! | a mean at one end of a ladder, from means along it | [`extrapolation`] |
//! | a mean rate with its interval | [`rate`] |
//! | straight lines with standard errors | [`line`](mod@line) |
//! | laws that a transformation makes straight | [`fit`] |
//! | laws that are not straight lines: Levenberg's and Marquardt's method | [`least_squares`] |
//! | curves given as points | [`points`] |
//! | the test against a geometric distribution | [`geometric`] |
//! | numbers with a number of significant digits | [`digits`] |
//!
//! The functions know nothing of runs or scenes. Random numbers are given as an argument.

pub mod digits;
pub mod extrapolation;
pub mod fit;
pub mod geometric;
pub mod least_squares;
pub mod line;
pub mod mean;
pub mod points;
pub mod quantile;
pub mod rate;
pub mod student;

#[cfg(test)]
mod noise;
