//! A motion given by a table: a smooth curve through points in time.
//!
//! Between two rows the curve is a cubic (Hermite) with the slopes of Fritsch and Carlson (SIAM J. Numer. Anal. 17, 238, 1980):
//! it is monotone where the rows are, so it never overshoots them, and its rate is continuous. Before the first row and after
//! the last one the wall rests.

/// A curve through the rows of a table.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Curve {
    /// Times, s, ascending.
    times: Vec<f64>,
    /// Values at these times.
    values: Vec<[f64; 3]>,
    /// Rates at these times, 1/s.
    rates: Vec<[f64; 3]>,
}

/// Values at a time, with their rates.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct InTime<T> {
    /// The values.
    pub value: T,
    /// Their rates, 1/s.
    pub rate: T,
}

impl Curve {
    /// Reads a CSV table: a header that begins with `time_s`, then a time (s) and `count` values (1 to 3) in each row.
    ///
    /// # Errors
    /// In words, with the number of the line.
    pub fn parse(text: &str, count: usize) -> Result<Self, String> {
        let mut lines = text.lines().enumerate().map(|(line, text)| (line + 1, text.trim()));
        let header = lines.next().map_or("", |(_, header)| header);
        if !header.starts_with("time_s") {
            return Err(format!("line 1: expected a header that begins with `time_s`, found {header:?}"));
        }
        let mut curve = Self::default();
        let mut lines_of_rows = Vec::new();
        for (line, text) in lines.filter(|(_, text)| !text.is_empty() && !text.starts_with('#')) {
            let numbers: Result<Vec<f64>, _> = text.split(',').map(|cell| cell.trim().parse()).collect();
            let numbers = numbers.map_err(|error| format!("line {line}: {error}"))?;
            if numbers.len() != count + 1 || numbers.iter().any(|number| !number.is_finite()) {
                return Err(format!("line {line}: expected a time and {count} finite numbers, found {text:?}"));
            }
            if curve.times.last().is_some_and(|&last| numbers[0] <= last) {
                return Err(format!(
                    "line {line}: the time {} s does not come after that of the row before",
                    numbers[0]
                ));
            }
            let mut row = [0.0; 3];
            row[..count].copy_from_slice(&numbers[1..]);
            curve.times.push(numbers[0]);
            lines_of_rows.push(line);
            curve.values.push(row);
        }
        if curve.times.len() < 2 {
            return Err("expected at least two rows below the header".to_owned());
        }
        curve.rates = rates(&curve.times, &curve.values);
        if let Some(row) = curve.first_overflow() {
            return Err(format!(
                "line {}: the change since the row before is too fast for a number",
                lines_of_rows[row]
            ));
        }
        Ok(curve)
    }

    /// Returns the first row before which the curve, or its rate, is not finite: a slope may be larger than any number.
    fn first_overflow(&self) -> Option<usize> {
        let is_finite = |&row: &usize| {
            let length = self.times[row] - self.times[row - 1];
            let is_finite = |found: InTime<[f64; 3]>| found.value.iter().chain(&found.rate).all(|x| x.is_finite());
            let slope = |axis: usize| (self.values[row][axis] - self.values[row - 1][axis]) / length;
            // Three times the slope is the largest rate, and its square is a part of speeds.
            let is_slow = length.is_finite() && (0..3).all(|axis| (3.0 * slope(axis)).powi(2).is_finite());
            let times = [0.0, 0.25, 0.5, 0.75].map(|share| self.times[row - 1] + share * length);
            is_slow && times.into_iter().all(|time| is_finite(self.at(time)))
        };
        (1..self.times.len()).find(|row| !is_finite(row))
    }

    /// Returns the values at a time (s) and their rates (1/s).
    #[must_use]
    pub fn at(&self, time: f64) -> InTime<[f64; 3]> {
        let next = self.times.partition_point(|&row| row <= time);
        let rest = |row: usize| InTime { value: self.values[row], rate: [0.0; 3] };
        if next == 0 {
            return rest(0);
        }
        if next == self.times.len() {
            return rest(next - 1);
        }
        let length = self.times[next] - self.times[next - 1];
        let share = (time - self.times[next - 1]) / length;
        let mut found = InTime { value: [0.0; 3], rate: [0.0; 3] };
        for axis in 0..3 {
            let [from, to] = [next - 1, next].map(|row| self.values[row][axis]);
            let [start, end] = [next - 1, next].map(|row| self.rates[row][axis] * length);
            // from + c1 s + c2 s^2 + c3 s^3
            let c2 = 3.0 * (to - from) - 2.0 * start - end;
            let c3 = 2.0 * (from - to) + start + end;
            found.value[axis] = from + share * (start + share * (c2 + share * c3));
            found.rate[axis] = (start + share * (2.0 * c2 + share * 3.0 * c3)) / length;
        }
        found
    }

    /// Returns the lowest and the highest values of the rows, which the curve never leaves.
    #[must_use]
    pub fn range(&self) -> [[f64; 3]; 2] {
        let extreme = |axis: usize, pick: fn(f64, f64) -> f64| {
            self.values.iter().map(|row| row[axis]).reduce(pick).unwrap_or_default()
        };
        [f64::min as fn(f64, f64) -> f64, f64::max].map(|pick| [0, 1, 2].map(|axis| extreme(axis, pick)))
    }

    /// Returns the largest rate at the rows and half-way between them, by magnitude, 1/s.
    #[must_use]
    pub fn fastest(&self) -> f64 {
        let middles = self.times.windows(2).map(|pair| 0.5 * (pair[0] + pair[1]));
        let length = |rate: [f64; 3]| rate.iter().map(|rate| rate * rate).sum::<f64>().sqrt();
        self.times.iter().copied().chain(middles).map(|time| length(self.at(time).rate)).fold(0.0, f64::max)
    }
}

/// Returns the rates at the rows: at an inner row the weighted harmonic mean of the slopes beside it, or zero if they differ in
/// sign; at the first and the last row the slope beside it.
fn rates(times: &[f64], values: &[[f64; 3]]) -> Vec<[f64; 3]> {
    let last = times.len() - 1;
    let length = |row: usize| times[row + 1] - times[row];
    let slope = |row: usize, axis: usize| (values[row + 1][axis] - values[row][axis]) / length(row);
    let rate = |row: usize, axis: usize| {
        if row == 0 || row == last {
            return slope(row.min(last - 1), axis);
        }
        let before = slope(row - 1, axis);
        let after = slope(row, axis);
        if before * after <= 0.0 {
            return 0.0;
        }
        let weight_before = 2.0 * length(row) + length(row - 1);
        let weight_after = length(row) + 2.0 * length(row - 1);
        (weight_before + weight_after) / (weight_before / before + weight_after / after)
    };
    (0..=last).map(|row| [0, 1, 2].map(|axis| rate(row, axis))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_straight_table_is_a_straight_line() {
        let curve = Curve::parse("time_s,x_m,y_m\n0,1,0\n1,3,0\n4,9,0\n", 2).unwrap();
        for time in [0.0, 0.3, 1.0, 2.7] {
            let InTime { value, rate } = curve.at(time);
            assert!((value[0] - (1.0 + 2.0 * time)).abs() < 1e-14 && (rate[0] - 2.0).abs() < 1e-14, "{time}");
        }
        assert_eq!(curve.at(-1.0), InTime { value: [1.0, 0.0, 0.0], rate: [0.0; 3] });
        assert_eq!(curve.at(9.0), InTime { value: [9.0, 0.0, 0.0], rate: [0.0; 3] });
    }

    #[test]
    fn the_curve_never_overshoots_its_rows_and_its_rate_is_the_slope_of_its_values() {
        let curve = Curve::parse("time_s,angle_rad\n0,0\n0.1,1\n0.5,1\n0.6,0.2\n2,0\n", 1).unwrap();
        let times = (0..2000).map(|n| f64::from(n) * 1e-3);
        for time in times {
            let value = curve.at(time).value[0];
            let rate = curve.at(time).rate[0];
            assert!((-1e-15..=1.0 + 1e-15).contains(&value), "{time}: {value}");
            let step = 1e-7;
            let slope = (curve.at(time + step).value[0] - value) / step;
            // The second derivative is at most 6 |change| / length^2 = 600 per s^2, times half the step.
            assert!(curve.times.contains(&time) || (slope - rate).abs() < 1e-4, "{time}: {slope} {rate}");
        }
    }

    #[test]
    fn the_range_holds_all_rows() {
        let curve = Curve::parse("time_s,x,y\n0,1,-2\n1,3,0\n2,-1,5\n", 2).unwrap();
        assert_eq!(curve.range(), [[-1.0, -2.0, 0.0], [3.0, 5.0, 0.0]]);
    }

    #[test]
    fn bad_tables_are_refused_with_their_line() {
        for (text, words) in [
            ("", "line 1"),
            ("x,y\n", "line 1"),
            ("time_s,x\n0,0\n", "two rows"),
            ("time_s,x\n0,0\n0,1\n", "line 3"),
            ("time_s,x\n0,0\n1,nan\n", "line 3"),
            ("time_s,x\n0,0\n1,1,1\n", "line 3"),
            ("time_s,x\n0,zero\n", "line 2"),
            ("time_s,x\n0,0\n1e-308,10\n", "line 3"),
            ("time_s,x\n-1,0\n0,0\n\n1e-300,1e300\n", "line 5"),
            ("time_s,x\n0,-1e308\n1,1e308\n", "line 3"),
            ("time_s,x\n-1e308,0\n1e308,1\n", "line 3"),
        ] {
            let error = Curve::parse(text, 1).unwrap_err();
            assert!(error.contains(words), "{text:?}: {error}");
        }
    }
}
