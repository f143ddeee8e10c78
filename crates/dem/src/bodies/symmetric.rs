//! Eigenvalues and eigenvectors of a symmetric matrix of three rows, by Jacobi's rotations.

use crate::space::Solid;

/// A symmetric matrix: its diagonal, and the entries (y z), (z x) and (x y).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Symmetric {
    /// The entries of the diagonal.
    pub diagonal: Solid,
    /// The entries (y z), (z x) and (x y).
    pub beside: Solid,
}

/// Eigenvalues, and the unit vectors that belong to them: a right-handed frame.
#[derive(Clone, Copy, Debug)]
pub struct Eigen {
    /// The eigenvalues.
    pub values: Solid,
    /// The eigenvector of each.
    pub vectors: [Solid; 3],
}

impl Symmetric {
    fn rows(&self) -> [[f64; 3]; 3] {
        let Self { diagonal: d, beside: b } = *self;
        [[d.x, b.z, b.y], [b.z, d.y, b.x], [b.y, b.x, d.z]]
    }

    /// Returns the eigenvalues and eigenvectors. A matrix that is diagonal up to rounding keeps its axes.
    #[must_use]
    pub fn eigen(&self) -> Eigen {
        let mut a = self.rows();
        let mut v = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let scale = self.diagonal.abs().max_element() + self.beside.abs().max_element();
        // Each sweep squares the relative size of the entries beside the diagonal.
        for _ in 0..20 {
            for [p, q] in [[0, 1], [1, 2], [0, 2]] {
                if a[p][q].abs() <= 1e-14 * scale {
                    continue;
                }
                let ratio = (a[q][q] - a[p][p]) / (2.0 * a[p][q]);
                let tangent = ratio.signum() / (ratio.abs() + (ratio * ratio + 1.0).sqrt());
                let cosine = 1.0 / (tangent * tangent + 1.0).sqrt();
                let sine = tangent * cosine;
                for row in &mut a {
                    [row[p], row[q]] = [cosine * row[p] - sine * row[q], sine * row[p] + cosine * row[q]];
                }
                let [row_p, row_q] = [a[p], a[q]];
                for k in 0..3 {
                    a[p][k] = cosine * row_p[k] - sine * row_q[k];
                    a[q][k] = sine * row_p[k] + cosine * row_q[k];
                }
                for row in &mut v {
                    [row[p], row[q]] = [cosine * row[p] - sine * row[q], sine * row[p] + cosine * row[q]];
                }
            }
        }
        let vector = |column: usize| Solid::new(v[0][column], v[1][column], v[2][column]);
        Eigen { values: Solid::new(a[0][0], a[1][1], a[2][2]), vectors: [vector(0), vector(1), vector(2)] }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn eigenvectors_reproduce_the_matrix() {
        let matrix = Symmetric { diagonal: Solid::new(2.0, -1.0, 0.5), beside: Solid::new(0.3, -0.8, 1.1) };
        let Eigen { values, vectors } = matrix.eigen();
        let rows = matrix.rows().map(|[x, y, z]| Solid::new(x, y, z));
        for (value, vector) in values.to_array().into_iter().zip(vectors) {
            let image = Solid::new(rows[0].dot(vector), rows[1].dot(vector), rows[2].dot(vector));
            assert!((image - vector * value).length() < 1e-13);
        }
        assert!((vectors[0].cross(vectors[1]) - vectors[2]).length() < 1e-14);
        assert!((values.element_sum() - 1.5).abs() < 1e-14);
    }

    #[test]
    fn a_diagonal_matrix_keeps_its_axes() {
        let matrix = Symmetric { diagonal: Solid::new(2.0, 1.0, 3.0), beside: Solid::splat(1e-16) };
        assert_eq!(matrix.eigen().vectors, [Solid::X, Solid::Y, Solid::Z]);
    }
}
