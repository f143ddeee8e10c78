//! Conservation: every particle is accounted for.

use crate::{parts, simulation, small_silo};

const BASE: &str = "p: 0.2, q: 0.2, b: 0.05, k: 0.05, g: 0.2, h: 0.05";

#[test]
fn every_particle_is_inside_or_out() {
    for (rules, fill) in [
        (BASE, "fill: (per_site: 6.0),"),
        (BASE, "fill: (per_site: 13.0),"),
        ("p: 0.8, q: 0.8, b: 0.8, k: 0.8, g: 0.95, h: 0.8", "pour: (per_site: 6.0),"),
    ] {
        let mut simulation = simulation(&small_silo(rules, 100, fill), 1);
        for step in 0..400 {
            simulation.run_steps(step);
            let gas = parts(&simulation).1;
            assert_eq!(gas.count() + gas.out(), gas.entered(), "{fill} step {step}");
        }
        let gas = parts(&simulation).1;
        assert!(gas.out() > 0 && gas.inside() > 0);
    }
}

#[test]
fn pouring_adds_exactly_its_number_of_particles() {
    let loaded = small_silo(BASE, 1_000_000, "pour: (per_site: 3.0, chance: 0.7),");
    let mut simulation = simulation(&loaded, 1);
    simulation.run_steps(600);
    let (sites, gas) = parts(&simulation);
    assert_eq!(gas.entered(), 3 * sites.fluid_count() as u64);
}

#[test]
fn particle_at_rest_stays_if_h_is_zero() {
    let particles = "particles: [(at: (13.0, 20.0), velocity: 0)],";
    let loaded = small_silo("p: 0.2, q: 0.2, b: 0.5, k: 0.5, g: 0.9, h: 0.0", 0, particles);
    let mut simulation = simulation(&loaded, 1);
    simulation.run_steps(0);
    let before = parts(&simulation).1.states().to_vec();
    simulation.run_steps(200);
    assert_eq!(parts(&simulation).1.states(), before);
}
