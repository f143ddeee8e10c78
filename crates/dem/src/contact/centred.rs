//! The scheme `Centred`: velocity Verlet of second order in the step also with dashpots and friction, with one evaluation of the forces
//! in a step.
//!
//! Velocity Verlet evaluates forces at x(t+dt) with the velocities v_h in the middle of the step. The force of a dashpot so has an error of
//! first order, and a contact that opens or closes inside a step has its force for the whole step or not at all. The scheme corrects both:
//!
//! * Every contact sees predicted velocities v_p = v_h + beta dt/2 a(t), beta = (1 - q)/(1 + q), q = b dt, with the largest damping rate b
//!   of any contact ([`velocity_prediction`]).
//! * A contact near an event is evaluated anew, with its force averaged over the step from t+dt/2 to t+3dt/2 ([`window`]). Near an event are
//!   contacts that may open or close in the step, contacts whose normal force may change its sign, and contacts of a lone grain.
//!
//! Positions move as in velocity Verlet. A scene without dashpots and friction has the same numbers with both schemes, to the last bit.
//!
//! # A step
//!
//! 1. *Drift*: v_h and v_p from a(t), then x(t+dt) from v_h. Bodies hold v_p, and v_h is kept beside it. The longest move gives the margin of
//!    the search and the radii that particles sweep within half a step.
//! 2. *Neighbours*: the time and the shares of the prediction are set. The search finds all pairs that may touch within half a step.
//! 3. *Forces*: pairs with a lone grain are marked. All laws run in batches, with v_p. Lanes near an event get v_h and the velocity gain of
//!    half a step, and the law's [`centred`](crate::contact::PairLaw::centred) force. In one of eight steps contacts are counted, which tells the
//!    lone grains.
//! 4. *Kick*: v(t+dt) from v_h.
//!
//! Step zero has no drift. Its forces are averaged over the first half step, which is all that the first kick covers (`start`).
//!
//! # Files
//!
//! | file | part |
//! |---|---|
//! | [`velocity_prediction`] | beta, how springs advance, and the plugin of the scheme |
//! | [`window`] | the averaged force: derivation, stability, limits |
//! | [`normal_load`], [`slider`] | the averaged normal force as a load of friction; the averaged force of friction and rolling resistance |
//! | `start` | forces of step zero |
//! | `lone_grains` | which grains are lone, and the marks of their pairs |
//! | `pair_velocities` | v_h, and the gain of half a step, of a single contact |
//!
//! Some parts stand where other code needs them:
//! * `store/prediction.rs` holds v_h, the margins and the marks of lone grains. They are columns of the store, which knows no contact.
//! * `integrate/recorded_velocity.rs` tells the drift and the kick which velocity a body holds. Both are written once for all schemes.
//! * `contact/batch/events.rs` and `contact/batch/gathered.rs` evaluate lanes near an event, and keep v_h of lanes. They use the columns of a
//!   batch, which only the batch sees.
//! * Each law has its centred force beside its plain one: `PairLaw::centred`, in most laws by [`Composite`](crate::contact::composite::Composite).
//!
//! Limits are those of [`window`] and [`velocity_prediction`]. The step limits with several contacts are in `scene::check::crowd` of `siloflow`.

pub(super) mod lone_grains;
pub mod normal_load;
mod pair_velocities;
pub mod slider;
pub(super) mod start;
pub mod velocity_prediction;
pub mod window;
