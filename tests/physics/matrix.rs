//! Square matrices for linear recurrences.

use std::ops::{Index, IndexMut};

/// A matrix by rows.
#[derive(Clone, Debug)]
pub struct Matrix {
    columns: usize,
    numbers: Vec<f64>,
}

impl Index<[usize; 2]> for Matrix {
    type Output = f64;

    fn index(&self, [row, column]: [usize; 2]) -> &f64 {
        &self.numbers[row * self.columns + column]
    }
}

impl IndexMut<[usize; 2]> for Matrix {
    fn index_mut(&mut self, [row, column]: [usize; 2]) -> &mut f64 {
        &mut self.numbers[row * self.columns + column]
    }
}

impl Matrix {
    pub fn zero(rows: usize, columns: usize) -> Self {
        Self { columns, numbers: vec![0.0; rows * columns] }
    }

    pub fn from_rows(rows: &[Vec<f64>]) -> Self {
        Self { columns: rows[0].len(), numbers: rows.concat() }
    }

    fn squared(&self) -> Self {
        let mut product = Self::zero(self.columns, self.columns);
        for (target, row) in product.numbers.chunks_mut(self.columns).zip(self.numbers.chunks(self.columns)) {
            for (factor, other) in row.iter().zip(self.numbers.chunks(self.columns)) {
                target.iter_mut().zip(other).for_each(|(sum, number)| *sum += factor * number);
            }
        }
        product
    }

    /// Divides by the largest number, which is returned.
    fn normalise(&mut self) -> f64 {
        let size = self.numbers.iter().fold(0.0f64, |size, number| size.max(number.abs()));
        self.numbers.iter_mut().for_each(|number| *number /= size);
        size
    }
}

/// Returns the spectral radius of a square matrix, by Gelfand's formula: the norm of its 2^24th power. Where powers grow like their number,
/// as for an eigenvalue 1 without its own eigenvector, that adds up to 24 ln 2/2^24 = 1e-6.
pub fn spectral_radius(matrix: &Matrix) -> f64 {
    let mut power = matrix.clone();
    let mut logarithm = power.normalise().ln();
    for _ in 0..24 {
        power = power.squared();
        logarithm = 2.0 * logarithm + power.normalise().ln();
    }
    (logarithm / f64::from(1 << 24)).exp()
}

/// Returns the largest eigenvalue of a symmetric matrix that is positive.
pub fn largest_eigenvalue(matrix: &Matrix) -> f64 {
    if matrix.numbers.iter().all(|&number| number == 0.0) { 0.0 } else { spectral_radius(matrix) }
}
