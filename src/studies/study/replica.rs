//! A replica: one run of a study. From the opening of the door on, it counts the particles in blocks every ten steps.
//! It also keeps densities for the pictures.

use std::num::NonZeroUsize;

use crate::behaviour::Registry;
use crate::lattice_silo::door::DoorState;
use crate::lattice_silo::observables::{BLOCK, Blocks, Frame, History, Observables};
use crate::lattice_silo::pictures::{CELL, DensityCell, densities};
use crate::simulation::Simulation;
use crate::studies::study::plan::Case;
use siloflow_dem::outcome::End;
use siloflow_dem::space::Vector;
use siloflow_dem::step::Clock;
use siloflow_lattice::gas::Gas;
use siloflow_lattice::sites::Sites;
use siloflow_lattice::velocities::in_bonds;
use siloflow_text::fault::Fault;

/// Steps between frames.
const FRAME_INTERVAL: u64 = 10;

/// The results of one run.
#[derive(Clone, Debug)]
pub struct Replica {
    /// The case that was run.
    pub case: Case,
    /// The observables of the discharge.
    pub observables: Observables,
    /// Densities at the times of the pictures: (steps since the door opened, cells). Times after the end of the run are
    /// missing.
    pub pictures: Vec<(u64, Vec<DensityCell>)>,
    /// Edges of the silo, m.
    pub lines: Vec<(Vector, Vector)>,
    /// Number of site updates: steps times fluid sites.
    pub updates: u64,
}

/// Assignment of fluid sites to blocks: `block_of` holds (site, index of its block).
struct BlockCounter {
    blocks: Blocks,
    block_of: Vec<(usize, usize)>,
}

impl BlockCounter {
    fn new(sites: &Sites, outlet: Vector) -> Self {
        let place = |s: usize| (s / sites.stride, s % sites.stride);
        let first_column = sites.fluid().map(|s| place(s).0).min().unwrap_or(0);
        let first_row = sites.fluid().map(|s| place(s).1).min().unwrap_or(0);
        let block = |s: usize| ((place(s).0 - first_column) / BLOCK.0, (place(s).1 - first_row) / BLOCK.1);
        let columns = sites.fluid().map(|s| block(s).0).max().map_or(0, |last| last + 1);
        let rows = sites.fluid().map(|s| block(s).1).max().map_or(0, |last| last + 1);
        let block_of: Vec<_> = sites.fluid().map(|s| (s, block(s).0 * rows + block(s).1)).collect();
        let mut counts = vec![0; columns * rows];
        for &(_, block) in &block_of {
            counts[block] += 1;
        }
        // The centre of a block, from its first site: columns 0 to 4 have their middle at 2. The sites of rows 0 to 3
        // span 0 to 3.5 in height over columns of both parities, with the middle at 1.75.
        let corner = (sites.position(first_column * sites.stride + first_row) - outlet) / sites.spacing;
        let half_a_row = 0.5 * f64::from(u8::from(first_column % 2 == 1));
        #[expect(clippy::cast_precision_loss, reason = "small numbers of blocks")]
        let along = |n: usize, first: f64, block: usize, step: f64, middle: f64| {
            (0..n).map(|i| first + step * ((i * block) as f64 + middle)).collect()
        };
        let x = along(columns, corner.x, BLOCK.0, in_bonds((1, 0)).0, 2.0);
        let y = along(rows, corner.y - half_a_row, BLOCK.1, 1.0, 1.75);
        Self { blocks: Blocks { columns, rows, sites: counts, x, y }, block_of }
    }

    fn frame(&self, gas: &Gas, step: u64) -> Frame {
        let mut counts = vec![0; self.blocks.sites.len()];
        for &(s, block) in &self.block_of {
            counts[block] += gas.states()[s].count_ones();
        }
        Frame { step, out: gas.out(), counts }
    }
}

impl Replica {
    /// Runs a case.
    ///
    /// # Errors
    /// If the scene of the case is not valid, or the run fails.
    pub fn run(case: Case, pictures: &[u64]) -> Result<Self, Fault> {
        let loaded = case.load()?;
        let outlet = loaded.scene.door.map_or(Vector::ZERO, |door| door.from.get::<Vector>().midpoint(door.to.get()));
        let mut simulation = Simulation::of_lattice(&loaded, &Registry::default(), NonZeroUsize::MIN)?;
        let counter = BlockCounter::new(simulation.world().resource(), outlet);
        let mut frames = Vec::new();
        let mut shown = Vec::new();
        loop {
            let end = simulation.step();
            let sites = simulation.world().resource::<Sites>();
            let gas = simulation.world().resource::<Gas>();
            let clock = simulation.world().resource::<Clock>();
            let door = simulation.world().resource::<DoorState>();
            if let Some(since) = door.steps_since(clock) {
                if since.is_multiple_of(FRAME_INTERVAL) {
                    frames.push(counter.frame(gas, since));
                }
                if pictures.contains(&since) {
                    shown.push((since, densities(sites, gas, CELL)));
                }
            }
            match end {
                Some(End::Failed(failure)) => {
                    let message = format!("{}, {}, seed {}: {failure}", case.silo, case.variant, case.seed);
                    return Err(Fault::new("study::failed", message).help("run the scene alone to see more"));
                }
                Some(_) => return Self::of(case, counter, frames, shown, &simulation),
                None => {}
            }
        }
    }

    fn of(
        case: Case,
        counter: BlockCounter,
        mut frames: Vec<Frame>,
        pictures: Vec<(u64, Vec<DensityCell>)>,
        simulation: &Simulation,
    ) -> Result<Self, Fault> {
        if frames.is_empty() {
            let message = format!("{}, {}: the run ended before the door opened", case.silo, case.variant);
            return Err(Fault::new("study::closed", message).help("raise `until` in the scene"));
        }
        let start = frames.remove(0);
        let history = History { blocks: counter.blocks, start, frames };
        let sites = simulation.world().resource::<Sites>();
        let clock = simulation.world().resource::<Clock>();
        Ok(Self {
            case,
            observables: Observables::of(&history),
            pictures,
            lines: sites.lines().to_vec(),
            updates: clock.steps * sites.fluid_count() as u64,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use siloflow_lattice::outline::Polygon;

    #[test]
    fn block_centres_are_the_centres_of_their_sites() {
        let corners = [(-6.0, 0.0), (6.0, 0.0), (6.0, 19.5), (-6.0, 19.5)].map(|(x, y)| Vector::new(x, y));
        let sites = Sites::new(&Polygon(corners.to_vec()), &[], None, 1.0);
        let counter = BlockCounter::new(&sites, Vector::ZERO);
        let Blocks { x, y, sites: counts, columns, rows } = &counter.blocks;
        assert_eq!((*columns, *rows), (3, 5));
        for (block, &count) in counts.iter().enumerate() {
            let positions = counter.block_of.iter().filter(|(_, b)| *b == block).map(|&(s, _)| sites.position(s));
            let (low, high) = positions.fold((Vector::INFINITY, -Vector::INFINITY), |(l, h), x| (l.min(x), h.max(x)));
            let middle = 0.5 * (low + high);
            if count == 20 {
                assert!((middle - Vector::new(x[block / rows], y[block % rows])).length() < 1e-12, "{block}");
            }
        }
    }
}
