//! Chooses spheres (discs) that fill a body, so that the surface of their union is near that of the body.
//!
//! At each point of a surface there is a largest sphere that touches it from inside. The body is the union of all these spheres. As many of
//! them as are asked for are chosen so that the mean square distance of the points from their union is small: first one by one, each time the one
//! that lowers it most, then by exchanges of a chosen sphere for another one until no exchange helps. These are the k-medoids of Kaufman and
//! Rousseeuw (Finding Groups in Data, 1990), with the exchanges of Schubert and Rousseeuw (Inf. Syst. 101, 101804, 2021).
//!
//! The chosen spheres are one piece at every moment. All lie inside the body, so its surface is outside their union, by d at a point. At the end all
//! radii grow by the mean of d: of all amounts this one leaves the smallest mean square, and the volume is that of the body up to terms of second order.
//!
//! The result is a local minimum, not always the best one.

use crate::bodies::makers::Deviation;
use crate::bodies::sphere_union::Ball;
use crate::space::Solid;

/// A point of a surface.
#[derive(Clone, Copy, Debug)]
pub struct SurfacePoint {
    /// Place, m.
    pub at: Solid,
    /// The area (length) that the point stands for, in any unit.
    pub weight: f64,
    /// The largest sphere that touches the surface here from inside.
    pub ball: Ball,
}

/// The chosen spheres.
#[derive(Clone, Debug)]
pub struct Cover {
    /// The spheres.
    pub balls: Vec<Ball>,
    /// The distance of the surface from that of their union.
    pub deviation: Deviation,
}

/// Most spheres among which are chosen.
const MOST_CANDIDATES: usize = 800;

/// Most exchanges.
const MOST_EXCHANGES: usize = 300;

/// A share of the sum of squares below which a change does not count.
const LEAST_GAIN: f64 = 1e-9;

/// Largest distance of the centres of two spheres that count as connected, in sums of their radii.
const CONNECTED: f64 = 0.98;

/// Squared distances, times the weights, of all points from all candidates; and the choice.
struct Choice<'a> {
    candidates: &'a [Ball],
    /// For each candidate, of each point.
    squares: Vec<Vec<f64>>,
    chosen: Vec<usize>,
}

/// The nearest two of the chosen candidates to a point.
#[derive(Clone, Copy)]
struct Nearest {
    /// Place of the nearest in the choice.
    place: usize,
    square: f64,
    second: f64,
}

/// An exchange, and by how much it raises the sum of squares.
struct Exchange {
    change: f64,
    place: usize,
    candidate: usize,
}

impl Choice<'_> {
    fn are_connected(&self, i: usize, j: usize) -> bool {
        let [one, other] = [&self.candidates[i], &self.candidates[j]];
        one.centre.distance(other.centre) < CONNECTED * (one.radius + other.radius)
    }

    /// Whether the chosen spheres, with `exchange` made, are one piece.
    fn is_one_piece(&self, exchange: &Exchange) -> bool {
        let mut left = self.chosen.clone();
        left[exchange.place] = exchange.candidate;
        let mut next = vec![left.swap_remove(0)];
        while let Some(one) = next.pop() {
            let reached = left.extract_if(.., |other| self.are_connected(one, *other));
            next.extend(reached);
        }
        left.is_empty()
    }

    /// Adds the candidate that lowers the sum of squares most, of those connected with the chosen ones. Returns whether that was worth a sphere.
    fn add(&mut self, least: &mut [f64]) -> bool {
        let before: f64 = least.iter().sum();
        let after = |squares: &Vec<f64>| squares.iter().zip(&*least).map(|(one, least)| one.min(*least)).sum::<f64>();
        let is_near = |candidate: usize| {
            self.chosen.is_empty() || self.chosen.iter().any(|&chosen| self.are_connected(candidate, chosen))
        };
        let near = (0..self.squares.len()).filter(|&candidate| is_near(candidate));
        let sums = near.map(|candidate| (candidate, after(&self.squares[candidate])));
        let Some((best, sum)) = sums.min_by(|a, b| a.1.total_cmp(&b.1)) else { return false };
        if sum >= before * (1.0 - LEAST_GAIN) {
            return false;
        }
        least.iter_mut().zip(&self.squares[best]).for_each(|(least, one)| *least = least.min(*one));
        self.chosen.push(best);
        true
    }

    /// Returns the nearest two chosen candidates of each point.
    fn nearest(&self) -> Vec<Nearest> {
        let points = self.squares.first().map_or(0, Vec::len);
        let none = Nearest { place: 0, square: f64::INFINITY, second: f64::INFINITY };
        let mut nearest = vec![none; points];
        for (place, &candidate) in self.chosen.iter().enumerate() {
            for (near, &square) in nearest.iter_mut().zip(&self.squares[candidate]) {
                if square < near.square {
                    *near = Nearest { place, square, second: near.square };
                } else if square < near.second {
                    near.second = square;
                }
            }
        }
        nearest
    }

    /// Returns the best exchange of a chosen sphere for `candidate`.
    fn exchange(&self, candidate: usize, nearest: &[Nearest]) -> Exchange {
        let mut gained = 0.0;
        let mut lost = vec![0.0; self.chosen.len()];
        for (near, &square) in nearest.iter().zip(&self.squares[candidate]) {
            if square < near.square {
                gained += square - near.square;
            } else {
                lost[near.place] += square.min(near.second) - near.square;
            }
        }
        let best = lost.iter().enumerate().min_by(|a, b| a.1.total_cmp(b.1));
        let (place, lost) = best.map_or((0, f64::INFINITY), |(place, lost)| (place, *lost));
        Exchange { change: gained + lost, place, candidate }
    }

    /// Makes the best exchange that leaves one piece. Returns whether one helps.
    fn improve(&mut self) -> bool {
        let nearest = self.nearest();
        let sum: f64 = nearest.iter().map(|near| near.square).sum();
        let exchanges = (0..self.squares.len()).map(|candidate| self.exchange(candidate, &nearest));
        // NaN is no gain.
        let mut exchanges: Vec<_> = exchanges.filter(|one| one.change < -LEAST_GAIN * sum).collect();
        exchanges.sort_by(|a, b| a.change.total_cmp(&b.change));
        let Some(best) = exchanges.iter().find(|exchange| self.is_one_piece(exchange)) else { return false };
        self.chosen[best.place] = best.candidate;
        true
    }
}

/// Returns how far a point is outside a sphere, m.
fn outside(point: &SurfacePoint, ball: &Ball) -> f64 {
    (point.at.distance(ball.centre) - ball.radius).max(0.0)
}

/// Chooses at most `count` spheres; fewer if more would not help.
#[must_use]
pub fn cover(points: &[SurfacePoint], count: usize) -> Cover {
    let stride = points.len().div_ceil(MOST_CANDIDATES).max(1);
    let candidates: Vec<_> = points.iter().step_by(stride).map(|point| point.ball).collect();
    let squares = |ball: &Ball| points.iter().map(|point| point.weight * outside(point, ball).powi(2)).collect();
    let mut choice =
        Choice { candidates: &candidates, squares: candidates.iter().map(squares).collect(), chosen: Vec::new() };
    // The first sphere lowers any distance.
    let mut least = vec![f64::MAX.sqrt(); points.len()];
    while choice.chosen.len() < count && choice.add(&mut least) {}
    for _ in 0..MOST_EXCHANGES {
        if !choice.improve() {
            break;
        }
    }
    let mut balls: Vec<_> = choice.chosen.iter().map(|&candidate| candidates[candidate]).collect();
    let growth = Moments::of(points, &balls).mean();
    for ball in &mut balls {
        ball.radius += growth;
    }
    let moments = Moments::of(points, &balls);
    Cover { balls, deviation: Deviation { largest: moments.largest, rms: (moments.squares / moments.weight).sqrt() } }
}

/// Sums over the distances of a surface from that of a union of spheres, positive outside.
#[derive(Default)]
struct Moments {
    weight: f64,
    sum: f64,
    squares: f64,
    /// The largest absolute distance, m.
    largest: f64,
}

impl Moments {
    fn of(points: &[SurfacePoint], balls: &[Ball]) -> Self {
        let mut moments = Self::default();
        for SurfacePoint { at, weight, .. } in points {
            let distances = balls.iter().map(|ball| at.distance(ball.centre) - ball.radius);
            let distance = distances.fold(f64::INFINITY, f64::min);
            moments.weight += weight;
            moments.sum += weight * distance;
            moments.squares += weight * distance * distance;
            moments.largest = moments.largest.max(distance.abs());
        }
        moments
    }

    fn mean(&self) -> f64 {
        self.sum / self.weight
    }
}
