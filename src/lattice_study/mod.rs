//! The study: both silos, all variants of the parameters, several seeds; figures, sheets of pictures, and what becomes of the
//! paper's claims.
//!
//! A study file names scenes, seeds and variants ([`plan`]). Every replica is a run of its own ([`replica`]) on one thread, as
//! many side by side as there are threads; the result does not depend on their number. Observables are averaged over the
//! seeds ([`results`]), the claims are compared with them ([`claims`]), and all is written ([`report`]).

pub mod claims;
pub mod figures;
pub mod plan;
pub mod replica;
pub mod report;
pub mod results;
