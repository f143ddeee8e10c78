//! The quantities that are estimated from a scene before a run.

use siloflow_dem::contact::Contact;
use siloflow_dem::integrate::Integrator;

/// Estimates of a scene with grains, SI.
#[derive(Clone, Copy, Debug)]
pub struct Estimates {
    /// The time step, s.
    pub dt: f64,
    /// The scheme.
    pub scheme: Integrator,
    /// The scene's contact law.
    pub contact: Contact,
    /// The shortest contact duration, or half period of a contact's tangential or rolling spring in units of that of its normal
    /// spring, times the duration of that contact, s.
    pub shortest_swing: f64,
    /// Lowest restitution of a head-on impact of any pair.
    pub lowest_restitution: f64,
    /// Radius of the smallest grain, m.
    pub radius: f64,
    /// Mass of the smallest grain, kg.
    pub mass: f64,
    /// Duration of the shortest contact, s.
    pub contact_duration: f64,
    /// Restitution of an impact of two smallest grains.
    pub restitution: f64,
    /// Largest stable step of every single contact, s; infinite if no two bodies can meet.
    pub pair_limit: f64,
    /// Largest stable step in a dense bed, s.
    pub bed_limit: f64,
    /// Largest damping rates of any contact: c/(2 m) along the normal, and of sliding, rolling or twisting, 1/s.
    pub damping_rates: [f64; 2],
    /// The shortest relaxation time c/k of tangential, rolling and twisting springs, s; infinite without such springs.
    pub relaxation: f64,
    /// Speed of a grain after a fall to the lowest point of the scene, m/s.
    pub impact_speed: f64,
    /// Overlap over radius in an undamped impact of two smallest grains at that speed.
    pub impact_overlap: f64,
    /// Overlap over radius at the bottom of the bed, from its weight.
    pub static_overlap: f64,
    /// Overlap over radius of a smallest grain that alone carries the heaviest one.
    pub caught_overlap: f64,
    /// Stiffness of a contact at that overlap, N/m.
    pub stiffness: f64,
    /// Largest overlap over radius that adhesion alone causes, in two bodies that touch at rest.
    pub adhesive_overlap: f64,
}
