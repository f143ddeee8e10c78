//! Flights of single particles thrown in direction 7 with h = 0, simulated by the automaton, and their exact mean.
//!
//! The vertical velocity of a thrown particle is 3, 1, -1 or -3 half spacings per step. In each step it changes to the
//! next lower value with probability g; -3 is the terminal velocity. This is a Markov chain. In the first three steps
//! no kick is lost at the terminal velocity, and the mean height is exactly the parabola 1.5 t - g t (t + 1)/2.

use std::num::NonZeroUsize;
use std::path::Path;

use crate::behaviour::Registry;
use crate::lattice_silo::loaded::LoadedLattice;
use crate::simulation::Simulation;
use siloflow_dem::space::Vector;
use siloflow_lattice::gas::Gas;
use siloflow_lattice::sites::Sites;
use siloflow_text::fault::Fault;
use siloflow_text::source::Source;

/// Flights of several thrown particles.
#[derive(Clone, Debug)]
pub struct Flights {
    /// Probability of a kick by gravity in a step.
    pub g: f64,
    /// Positions of each particle after 0 to [`STEPS`] steps, spacings from its start.
    pub(super) flights: Vec<Vec<Vector>>,
}

impl Flights {
    /// Simulates one particle for each of the seeds 0 to `seeds` - 1, thrown in direction 7.
    ///
    /// # Errors
    /// If g is not a probability.
    pub fn run(seeds: u64, g: f64) -> Result<Self, Fault> {
        if !(0.0..=1.0).contains(&g) {
            let fault = Fault::new("scene::out_of_range", format!("g = {g} is not a probability"));
            return Err(fault.help("give a number from 0 to 1"));
        }
        let flights = (0..seeds).map(|seed| flight(seed, g)).collect::<Result<_, _>>()?;
        Ok(Self { g, flights })
    }

    /// Returns the number of flights.
    #[must_use]
    #[expect(clippy::len_without_is_empty, reason = "no caller needs is_empty")]
    pub fn len(&self) -> usize {
        self.flights.len()
    }

    /// Returns the heights of all particles after `step` steps, spacings.
    ///
    /// # Panics
    /// If `step` is larger than 40.
    #[must_use]
    pub fn heights(&self, step: usize) -> Vec<f64> {
        self.flights.iter().map(|flight| flight[step].y).collect()
    }

    /// Returns the mean height after `step` steps by the Markov chain and by the parabola, spacings.
    ///
    /// # Panics
    /// If `step` is larger than 40.
    #[must_use]
    pub fn expected_heights(&self, step: usize) -> (f64, f64) {
        (expected(self.g)[step].y, parabola(self.g)[step].y)
    }
}

/// Number of steps of a flight.
pub(super) const STEPS: u32 = 40;

/// Simulates a thrown particle. Returns its positions after 0 to [`STEPS`] steps, spacings from its start.
pub(super) fn flight(seed: u64, g: f64) -> Result<Vec<Vector>, Fault> {
    // The box is large enough for any flight: 40 steps of sqrt(3)/2 spacings in x, and at most 3/2 spacings in y.
    let text = format!(
        "(method: LatticeGas(spacing: 1.0, p: 0.0, q: 0.0, b: 0.0, k: 0.0, g: {g:?}, h: 0.0),
          seed: {seed}, until: {STEPS}, pictures: None,
          outline: [(0.0, 0.0), (40.0, 0.0), (40.0, 140.0), (0.0, 140.0)],
          particles: [(at: (2.0, 70.0), velocity: 7)])"
    );
    let source = Source::new("thrown.ron", "thrown", Path::new(""), text);
    let loaded = LoadedLattice::new(source, &[])?;
    let mut simulation = Simulation::of_lattice(&loaded, &Registry::default(), NonZeroUsize::MIN)?;
    let mut places = Vec::new();
    for step in 0..=STEPS {
        simulation.run_steps(u64::from(step));
        places.push(place(&simulation)?);
    }
    let start = places[0];
    Ok(places.into_iter().map(|place| place - start).collect())
}

/// Returns the position of the particle, in units of the scene's spacing of 1 m.
fn place(simulation: &Simulation) -> Result<Vector, Fault> {
    let sites = simulation.world().resource::<Sites>();
    let gas = simulation.world().resource::<Gas>();
    let site = sites.fluid().find(|&s| gas.states()[s] != 0);
    site.map(|s| sites.position(s)).ok_or_else(|| Fault::new("study::lost", "no particle is in the box"))
}

/// Returns the mean position of the flights at each step; empty if there are no flights.
pub(super) fn mean(flights: &[Vec<Vector>]) -> Vec<Vector> {
    let Some(first) = flights.first() else { return Vec::new() };
    let count = flights.iter().fold(0.0, |count, _| count + 1.0);
    (0..first.len()).map(|t| flights.iter().map(|flight| flight[t]).sum::<Vector>() / count).collect()
}

/// Returns the exact mean position after 0 to [`STEPS`] steps, by the Markov chain, spacings.
pub(super) fn expected(g: f64) -> Vec<Vector> {
    let mut chance = [1.0, 0.0, 0.0, 0.0];
    let mut at = Vector::ZERO;
    let mut places = vec![at];
    for _ in 0..STEPS {
        // A velocity is reached by a kick from the next higher one, or kept without a kick. A kick does not change the
        // last.
        let kicked = chance.map(|chance| chance * g);
        let stays = chance.map(|chance| chance * (1.0 - g));
        chance = [stays[0], kicked[0] + stays[1], kicked[1] + stays[2], kicked[2] + chance[3]];
        at += Vector::new(0.75f64.sqrt(), 0.5 * (3.0 * chance[0] + chance[1] - chance[2] - 3.0 * chance[3]));
        places.push(at);
    }
    places
}

/// Returns the positions on the parabola after 0 to [`STEPS`] steps, spacings.
pub(super) fn parabola(g: f64) -> Vec<Vector> {
    let at = |t: f64| Vector::new(0.75f64.sqrt() * t, 1.5 * t - g * t * (t + 1.0) / 2.0);
    (0..=STEPS).map(|t| at(f64::from(t))).collect()
}

/// Returns the last step up to which the parabola is within `tolerance` spacings of the exact mean.
pub(super) fn parabola_holds_until(g: f64, tolerance: f64) -> usize {
    let off = expected(g).into_iter().zip(parabola(g)).map(|(exact, parabola)| exact.distance(parabola));
    off.take_while(|&off| off <= tolerance).count().saturating_sub(1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_parabola_is_exact_for_three_steps() {
        for g in [0.05, 0.2, 0.95] {
            // The tolerance covers the rounding of three sums of numbers of order 1.
            assert_eq!(parabola_holds_until(g, 1e-12), 3, "{g}");
        }
        assert_eq!(parabola_holds_until(0.0, 1e-12), 40);
        // The reference value has three decimals.
        assert!((expected(0.05)[40].y - 20.996).abs() < 5.1e-4);
    }

    #[test]
    fn a_flight_with_g_1_is_the_exact_mean() {
        let flown = flight(7, 1.0).unwrap();
        let exact = expected(1.0);
        // The tolerance covers a few roundings of coordinates of up to 140.
        assert!(flown.iter().zip(&exact).all(|(a, b)| a.distance(*b) < 1e-11));
        assert_eq!(mean(&[flown.clone(), flown.clone()]), flown);
    }
}
