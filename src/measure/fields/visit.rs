//! The cells that a grain or a contact adds to, and with which weights.
//!
//! A line is divided where it crosses borders of cells, which are planes or cylinders; the division is exact. Along periodic axes
//! every image counts.

use crate::measure::fields::grid::Grid;
use crate::measure::fields::kernel::{density, mean_along};
use crate::periodic::Periodic;
use crate::space::Space;

/// Standard deviations at which a Gaussian is cut off along each axis.
const CUT: f64 = 6.0;

impl<V: Space> Grid<V> {
    /// Calls `each` with every cell that a grain at `centre` adds to, its weight (1/m^3, in the plane 1/m^2), and the place of the
    /// image.
    pub fn visit_point(&self, centre: V, periodic: Option<&Periodic<V>>, mut each: impl FnMut(usize, f64, V)) {
        self.images(centre, V::ZERO, periodic, |image| match &self.gaussian {
            None => {
                if let Some(cell) = self.cell_of(image) {
                    each(cell, 1.0 / self.volume(cell), image);
                }
            }
            Some((width, axes)) => {
                let sharp = sharp_axes::<V>(axes);
                let at = self.coordinates(image);
                if sharp.iter().all(|&axis| self.axes[axis].number(at[axis]).is_some()) {
                    let depth: f64 = sharp.iter().map(|&axis| self.axes[axis].width()).product();
                    self.visit_around(image, V::ZERO, |cell, start, _| {
                        let squared = start.iter().map(|x| x * x).sum();
                        each(cell, density(*width, power(axes), squared) / depth, image);
                    });
                }
            }
        });
    }

    /// Calls `each` with every cell that a contact adds to: its line runs from `from` along `way`. The weight (1/m^3, in the plane
    /// 1/m^2) is the mean of the kernel along the line. The last argument is the middle of the part in the cell.
    pub fn visit_branch(&self, from: V, way: V, periodic: Option<&Periodic<V>>, mut each: impl FnMut(usize, f64, V)) {
        self.images(from, way, periodic, |image| match &self.gaussian {
            None => self.pieces(image, way, &[0, 1, 2], |start, end| {
                let middle = image + way * (0.5 * (start + end));
                if let Some(cell) = self.cell_of(middle) {
                    each(cell, (end - start) / self.volume(cell), middle);
                }
            }),
            Some((width, axes)) => {
                let sharp = sharp_axes::<V>(axes);
                let depth: f64 = sharp.iter().map(|&axis| self.axes[axis].width()).product();
                self.pieces(image, way, &sharp, |start, end| {
                    let at = self.coordinates(image + way * (0.5 * (start + end)));
                    if sharp.iter().all(|&axis| self.axes[axis].number(at[axis]).is_some()) {
                        let (from, part) = (image + way * start, way * (end - start));
                        self.visit_around(from, part, |cell, start_of_part, way_of_part| {
                            let mean = mean_along(*width, power(axes), start_of_part, way_of_part);
                            each(cell, mean * (end - start) / depth, from + part * 0.5);
                        });
                    }
                });
            }
        });
    }

    /// Calls `each` with the cells whose middle is within the cut of the line from `from` along `way`, and with start and way
    /// along the axes of the Gaussian, relative to that middle.
    fn visit_around(&self, from: V, way: V, mut each: impl FnMut(usize, &[f64], &[f64])) {
        let Some((width, smooth)) = &self.gaussian else { return };
        let ranges: [_; 3] = std::array::from_fn(|axis| {
            if !smooth.contains(&axis) {
                return 0..1;
            }
            let [a, b] = [from.axis(axis), from.axis(axis) + way.axis(axis)];
            self.axes[axis].numbers(a.min(b) - CUT * width, a.max(b) + CUT * width)
        });
        let way: Vec<_> = smooth.iter().map(|&axis| way.axis(axis)).collect();
        let mut start = vec![0.0; smooth.len()];
        for z in ranges[2].clone() {
            for y in ranges[1].clone() {
                for x in ranges[0].clone() {
                    let numbers = [x, y, z];
                    for (start, &axis) in start.iter_mut().zip(smooth) {
                        *start = from.axis(axis) - self.axes[axis].middle(numbers[axis]);
                    }
                    each(self.cell(numbers), &start, &way);
                }
            }
        }
    }

    /// Divides the line from `from` along `way` at the borders of cells along these axes, and calls `each` with the
    /// ends of each part as shares of the line.
    fn pieces(&self, from: V, way: V, axes: &[usize], mut each: impl FnMut(f64, f64)) {
        let mut cuts = vec![0.0, 1.0];
        for &axis in axes.iter().filter(|&&axis| axis < V::COMPONENTS) {
            match self.round {
                Some(centre) if axis == 0 => self.cuts_at_radii(from, way, centre, &mut cuts),
                Some(_) if axis == 1 => {}
                _ => self.cuts_at_planes(axis, from.axis(axis), way.axis(axis), &mut cuts),
            }
        }
        cuts.retain(|cut| (0.0..=1.0).contains(cut));
        cuts.sort_unstable_by(f64::total_cmp);
        cuts.windows(2).filter(|ends| ends[0] < ends[1]).for_each(|ends| each(ends[0], ends[1]));
    }

    fn cuts_at_planes(&self, axis: usize, from: f64, way: f64, cuts: &mut Vec<f64>) {
        let cells = &self.axes[axis];
        if way == 0.0 || !cells.low.is_finite() {
            return;
        }
        let (low, high) = (from.min(from + way), from.max(from + way));
        // One border more on each side, because the middles of cells count in `numbers`.
        let numbers = cells.numbers(low - cells.width(), high + cells.width());
        cuts.extend((numbers.start..=numbers.end).map(|number| (cells.border(number) - from) / way));
    }

    fn cuts_at_radii(&self, from: V, way: V, centre: [f64; 2], cuts: &mut Vec<f64>) {
        let (x, y) = (from.axis(0) - centre[0], from.axis(1) - centre[1]);
        let (u, v) = (way.axis(0), way.axis(1));
        let (square, middle, start) = (u * u + v * v, x * u + y * v, x * x + y * y);
        if square == 0.0 {
            return;
        }
        let cells = &self.axes[0];
        let reach = square.sqrt() + cells.width();
        let numbers = cells.numbers(start.sqrt() - reach, start.sqrt() + reach);
        for number in numbers.start..=numbers.end {
            let radius = cells.border(number);
            let root = middle * middle - square * (start - radius * radius);
            if root > 0.0 {
                cuts.extend([(-middle - root.sqrt()) / square, (-middle + root.sqrt()) / square]);
            }
        }
    }

    /// Calls `each` with the images of `from` for which the line along `way` may lie in the grid or near it.
    fn images(&self, from: V, way: V, periodic: Option<&Periodic<V>>, mut each: impl FnMut(V)) {
        let Some(periodic) = periodic else { return each(from) };
        let reach = self.gaussian.as_ref().map_or(0.0, |(width, _)| CUT * width);
        let shifts: [Vec<f64>; 3] = std::array::from_fn(|axis| {
            if axis >= V::COMPONENTS {
                return vec![0.0];
            }
            let Some(side) = periodic.side(axis) else { return vec![0.0] };
            let (low, high) = match self.round {
                Some(centre) if axis < 2 => (centre[axis] - self.axes[0].high, centre[axis] + self.axes[0].high),
                _ => (self.axes[axis].low, self.axes[axis].high),
            };
            let (first, last) = (from.axis(axis), from.axis(axis) + way.axis(axis));
            // Images n with first + n side <= high + reach and last + n side >= low - reach, for either order of ends.
            let n_low = ((low - reach - first.max(last)) / side).ceil();
            let n_high = ((high + reach - first.min(last)) / side).floor();
            let count = (n_high - n_low).clamp(-1.0, 1000.0);
            let mut shifts = Vec::new();
            let mut n = n_low;
            while n <= n_low + count {
                shifts.push(n * side);
                n += 1.0;
            }
            shifts
        });
        for &z in &shifts[2] {
            for &y in &shifts[1] {
                for &x in &shifts[0] {
                    let shift = [x, y, z];
                    each(from + V::from_components(|axis| shift[axis]));
                }
            }
        }
    }
}

/// The number of axes as an exponent.
fn power(axes: &[usize]) -> i32 {
    i32::try_from(axes.len()).unwrap_or(3)
}

/// Returns the axes of the space along which the cells of a grid with a Gaussian are sharp.
fn sharp_axes<V: Space>(smooth: &[usize]) -> Vec<usize> {
    (0..V::COMPONENTS).filter(|axis| !smooth.contains(axis)).collect()
}
