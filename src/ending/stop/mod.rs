//! Conditions that end a run early: the scene key `stop`. The first condition that holds ends the run.
//!
//! | condition | the run ends at the first step at whose end |
//! |---|---|
//! | `AtRest` | the bed is at rest: [`crate::rest`] |
//! | `EndOfFlow(still: s)` | `still` seconds have passed since the door began to open and since the last grain left through it |
//! | `Clogged(still: s)` | the same, while grains are above the outlet: [`clog`] |
//! | `Out(n)` | `n` grains have left through a door |
//!
//! `EndOfFlow` finds the end of a discharge that leaves grains inside: a flat bottom keeps dead zones, and an arch may block the orifice.
//! `still` must be longer than the pauses of the flow, or the run ends in a pause. An empty silo, a failure and `until` end a run
//! without any condition.
//!
//! A [`kick`] restarts the flow at a clog instead, until the scene's kicks are used up.

pub mod avalanches;
pub mod clog;
pub mod conditions;
pub mod kick;
mod outlet;
mod stillness;
