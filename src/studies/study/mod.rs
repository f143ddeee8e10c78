//! The lattice-gas study: runs both silos with all variants of the parameters and several seeds, and tests the paper's
//! claims.
//!
//! A study file names scenes, seeds and variants ([`plan`]). A replica is one run, on a single thread ([`replica`]). As
//! many replicas run in parallel as there are threads; the results do not depend on the number of threads. Observables
//! are averaged over the seeds ([`results`]) and the claims are tested with the averages ([`claims`]). The output
//! consists of tables, sheets of pictures and figures ([`report`], [`figures`]).

pub mod claims;
pub mod figures;
pub mod plan;
pub mod replica;
pub mod report;
pub mod results;
