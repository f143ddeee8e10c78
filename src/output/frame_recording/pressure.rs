//! The pressure on a grain: the sum of its elastic contact forces over its circumference, N/m, in solid space over its surface,
//! N/m^2.

use std::f64::consts::PI;

use siloflow_dem::space::{Dimension, Space};
use siloflow_dem::survey::{Partner, Survey};

/// Returns the pressure of each slot.
pub(in crate::output) fn of<V: Space>(survey: &Survey<V>) -> Vec<f64> {
    let mut sums = vec![0.0; survey.store.len()];
    survey.contacts(|i, partner, pair, memory| {
        let force = survey.law.force(pair, &mut memory.clone()).elastic().length();
        sums[i] += force;
        if let Partner::Particle(j) = partner {
            sums[j] += force;
        }
    });
    let surface = |radius: f64| match V::DIMENSION {
        Dimension::Plane => 2.0 * PI * radius,
        Dimension::Solid => 4.0 * PI * radius * radius,
    };
    sums.iter().zip(&survey.store.body).map(|(sum, body)| sum / surface(body.radius)).collect()
}
