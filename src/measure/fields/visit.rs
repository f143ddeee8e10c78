//! The cells that a grain or a contact adds to, and with which weights.
//!
//! A line is divided where it crosses borders of cells, which are planes or cylinders; the division is exact. Along periodic axes
//! every image counts.

use crate::measure::fields::grid::{Gaussian, Grid};
use crate::measure::fields::kernel::{density, parts_of_line, points_of_part};
use siloflow_dem::periodic::Periodic;
use siloflow_dem::space::Space;

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
            Some(gaussian) => {
                if self.is_between_sharp_ends(image, gaussian) {
                    self.visit_around(&[(image, 1.0)], gaussian, |cell, weight| each(cell, weight, image));
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
            Some(gaussian) => self.pieces(image, way, &gaussian.sharp, |start, end| {
                let from = image + way * start;
                let part = way * (end - start);
                let middle = from + part * 0.5;
                if self.is_between_sharp_ends(middle, gaussian) {
                    let parts = parts_of_line(part.length_squared().sqrt(), gaussian.width);
                    for number in 0..parts {
                        let points = points_of_part(number, parts);
                        let points = points.map(|(x, share)| (from + part * x, share * (end - start)));
                        self.visit_around(&points, gaussian, |cell, weight| each(cell, weight, middle));
                    }
                }
            }),
        });
    }

    /// Whether a point is in the grid along the axes that the Gaussian does not smooth.
    fn is_between_sharp_ends(&self, at: V, gaussian: &Gaussian) -> bool {
        let at = self.coordinates(at);
        gaussian.sharp.iter().all(|&axis| self.axes[axis].number(at[axis]).is_some())
    }

    /// Calls `each` with the cells whose middle is within the cut of a point, and with the sum of share times density over the
    /// points. The density is a product over the axes, so each of its factors is evaluated once for a row of cells.
    fn visit_around(&self, points: &[(V, f64)], gaussian: &Gaussian, mut each: impl FnMut(usize, f64)) {
        let width = gaussian.width;
        let along =
            |axis: usize, each: fn(f64, f64) -> f64, start| points.iter().map(|(x, _)| x.axis(axis)).fold(start, each);
        let ranges: [_; 3] = std::array::from_fn(|axis| {
            if !gaussian.smooth.contains(&axis) {
                return 0..1;
            }
            let low = along(axis, f64::min, f64::INFINITY);
            let high = along(axis, f64::max, f64::NEG_INFINITY);
            self.axes[axis].numbers(low - CUT * width, high + CUT * width)
        });
        if ranges.iter().any(std::ops::Range::is_empty) {
            return;
        }
        // For each cell along an axis, the factors of all points.
        let factors: [Vec<f64>; 3] = std::array::from_fn(|axis| {
            let cells = &self.axes[axis];
            let factor = |number, x: V| {
                if gaussian.smooth.contains(&axis) { density(width, x.axis(axis) - cells.middle(number)) } else { 1.0 }
            };
            ranges[axis].clone().flat_map(|number| points.iter().map(move |(x, _)| factor(number, *x))).collect()
        });
        let depth: f64 = gaussian.sharp.iter().map(|&axis| self.axes[axis].width()).product();
        let [of_x, of_y, of_z] = factors.each_ref().map(|factors| factors.chunks_exact(points.len()));
        let mut of_row = vec![0.0; points.len()];
        for (z, of_z) in ranges[2].clone().zip(of_z) {
            for (y, of_y) in ranges[1].clone().zip(of_y.clone()) {
                for (index, (of_row, (_, share))) in of_row.iter_mut().zip(points).enumerate() {
                    *of_row = share / depth * of_y[index] * of_z[index];
                }
                for (x, of_x) in ranges[0].clone().zip(of_x.clone()) {
                    each(self.cell([x, y, z]), of_row.iter().zip(of_x).map(|(row, x)| row * x).sum());
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
        let low = from.min(from + way);
        let high = from.max(from + way);
        // One border more on each side, because the middles of cells count in `numbers`.
        let numbers = cells.numbers(low - cells.width(), high + cells.width());
        cuts.extend((numbers.start..=numbers.end).map(|number| (cells.border(number) - from) / way));
    }

    fn cuts_at_radii(&self, from: V, way: V, centre: [f64; 2], cuts: &mut Vec<f64>) {
        let x = from.axis(0) - centre[0];
        let y = from.axis(1) - centre[1];
        let u = way.axis(0);
        let v = way.axis(1);
        let square = u * u + v * v;
        let middle = x * u + y * v;
        let start = x * x + y * y;
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
        let reach = self.gaussian.as_ref().map_or(0.0, |gaussian| CUT * gaussian.width);
        let shifts: [Vec<f64>; 3] = std::array::from_fn(|axis| {
            if axis >= V::COMPONENTS {
                return vec![0.0];
            }
            let Some(side) = periodic.side(axis) else { return vec![0.0] };
            let (low, high) = match self.round {
                Some(centre) if axis < 2 => (centre[axis] - self.axes[0].high, centre[axis] + self.axes[0].high),
                _ => (self.axes[axis].low, self.axes[axis].high),
            };
            let first = from.axis(axis);
            let last = from.axis(axis) + way.axis(axis);
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
