//! A grid of a field: its cells, their places and volumes, and the directions of its axes.
//!
//! Coordinates are x, y, z, or r, angle, z about a vertical axis. Cells along an axis have equal widths. An axis that a grid does not
//! resolve has one cell.

use std::f64::consts::PI;

use crate::measure::fields::axis_cells::AxisCells;
use crate::measure::fields::{FieldGrid, Kernel};
use siloflow_dem::space::{Plane, Space};

/// A grid with a kernel.
#[derive(Clone, Debug)]
pub struct Grid<V: Space> {
    /// Lower ends of the first cells, upper ends of the last ones, m; numbers of cells.
    pub(super) axes: [AxisCells; 3],
    /// Place of the axis of an (r, z) grid.
    pub(super) round: Option<[f64; 2]>,
    /// The kernel, if it is not the cell itself.
    pub(super) gaussian: Option<Gaussian>,
    space: std::marker::PhantomData<V>,
}

/// A Gaussian kernel.
#[derive(Clone, Debug)]
pub(super) struct Gaussian {
    /// Standard deviation, m.
    pub width: f64,
    /// The axes along which it acts.
    pub smooth: Vec<usize>,
    /// The other axes of the space: along these a cell has sharp ends.
    pub sharp: Vec<usize>,
}

impl<V: Space> Grid<V> {
    /// Makes the grid of a scene. `y` are the ends that an (x, z) grid has along y, m, if the scene names none.
    #[must_use]
    pub fn new(grid: &FieldGrid, kernel: Kernel, periodic_y: Option<(f64, f64)>) -> Self {
        let resolved = |low: f64, high: f64, count| AxisCells::new(low, high, count, true);
        let (axes, round) = match *grid {
            FieldGrid::XY { low, high, cells } => {
                let x = resolved(low.0.get(), high.0.get(), cells.0);
                ([x, resolved(low.1.get(), high.1.get(), cells.1), AxisCells::WHOLE], None)
            }
            FieldGrid::XZ { low, high, cells, y } => {
                let [x, z] = [(low.0, high.0, cells.0), (low.1, high.1, cells.1)]
                    .map(|(low, high, count)| resolved(low.get(), high.get(), count));
                let y = y.map(|(low, high)| (low.get(), high.get())).or(periodic_y);
                ([x, y.map_or(AxisCells::WHOLE, |(low, high)| AxisCells::new(low, high, 1, false)), z], None)
            }
            FieldGrid::RZ { axis, radius, low, high, cells } => {
                let r = resolved(0.0, radius.get(), cells.0);
                ([r, AxisCells::WHOLE, resolved(low.get(), high.get(), cells.1)], Some([axis.0.get(), axis.1.get()]))
            }
            FieldGrid::XYZ { low, high, cells } => {
                let along = [(low.0, high.0, cells.0), (low.1, high.1, cells.1), (low.2, high.2, cells.2)];
                (along.map(|(low, high, count)| resolved(low.get(), high.get(), count)), None)
            }
        };
        let gaussian = match kernel {
            Kernel::Cells => None,
            Kernel::Gaussian(width) => {
                let (smooth, sharp) = (0..V::COMPONENTS).partition(|&axis| axes[axis].is_resolved);
                Some(Gaussian { width: width.get(), smooth, sharp })
            }
        };
        Self { axes, round, gaussian, space: std::marker::PhantomData }
    }

    /// Number of cells.
    #[must_use]
    pub fn len(&self) -> usize {
        self.axes.iter().map(|axis| usize::from(axis.count)).product()
    }

    /// Whether there are no cells.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    pub(super) fn cell(&self, numbers: [u16; 3]) -> usize {
        let [x, y, z] = numbers.map(usize::from);
        let [columns, rows] = [0, 1].map(|axis| usize::from(self.axes[axis].count));
        (z * rows + y) * columns + x
    }

    /// Returns the numbers of a cell along the axes.
    #[expect(clippy::cast_possible_truncation, reason = "the number along an axis is below its count")]
    fn numbers(&self, cell: usize) -> [u16; 3] {
        let [columns, rows] = [0, 1].map(|axis| usize::from(self.axes[axis].count));
        [(cell % columns) as u16, (cell / columns % rows) as u16, (cell / columns / rows) as u16]
    }

    /// Returns the middle of a cell along each axis of the space; `None` along an axis that the grid does not resolve.
    #[must_use]
    pub fn place(&self, cell: usize) -> Vec<Option<f64>> {
        let numbers = self.numbers(cell);
        let along = (0..V::COMPONENTS).map(|axis| (self.axes[axis], numbers[axis]));
        along.map(|(axis, number)| axis.is_resolved.then(|| axis.middle(number))).collect()
    }

    /// Returns the volume of a cell, m^3; in the plane its area, m^2.
    #[must_use]
    pub fn volume(&self, cell: usize) -> f64 {
        let widths = self.axes.map(|axis| axis.width());
        if self.round.is_some() {
            let ring = f64::from(self.numbers(cell)[0]);
            return PI * (2.0 * ring + 1.0) * widths[0] * widths[0] * widths[2];
        }
        widths[..V::COMPONENTS].iter().product()
    }

    /// Returns the vector from the axis of an (r, z) grid to a point, across that axis.
    fn arm_of(&self, at: V) -> Option<Plane> {
        self.round.map(|[x, y]| Plane::new(at.axis(0) - x, at.axis(1) - y))
    }

    /// Returns the components of a vector along the axes of the grid at a point.
    #[must_use]
    pub fn components(&self, vector: V, at: V) -> [f64; 3] {
        let [x, y, z] = padded(vector);
        let Some(arm) = self.arm_of(at) else { return [x, y, z] };
        // On the axis there is no radial direction: x stands for it.
        let out = arm.try_normalize().unwrap_or(Plane::X);
        [out.dot(Plane::new(x, y)), out.perp_dot(Plane::new(x, y)), z]
    }

    /// Returns the coordinates of a point.
    pub(super) fn coordinates(&self, at: V) -> [f64; 3] {
        let [x, y, z] = padded(at);
        self.arm_of(at).map_or([x, y, z], |arm| [arm.length(), 0.0, z])
    }

    pub(super) fn cell_of(&self, at: V) -> Option<usize> {
        let coordinates = self.coordinates(at);
        let [x, y, z] = [0, 1, 2].map(|axis: usize| self.axes[axis].number(coordinates[axis]));
        Some(self.cell([x?, y?, z?]))
    }
}

/// Returns the components of a vector, with 0 for those that the plane lacks.
fn padded<V: Space>(vector: V) -> [f64; 3] {
    vector.spread().to_array()
}
