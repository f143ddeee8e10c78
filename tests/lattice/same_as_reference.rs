//! The fast automaton and the literal reference produce the same states, bit by bit, for any order in which the
//! reference visits the sites. The reference has its own rules, neighbours, blocked directions and collision table.
//! Three inputs come from the fast automaton: the kinds of the sites, the reflections (which have their own tests) and
//! the draws of each decision.

use siloflow::lattice::rules::Walls;
use siloflow::lattice::sites::{Kind, Sites};
use siloflow::lattice_silo::loaded::LoadedLattice;
use siloflow::prelude::*;

use crate::reference::{self, Reference, Reflections};
use crate::{parts, simulation, small_silo};

fn reflections(sites: &Sites) -> Reflections {
    let table: std::collections::HashMap<_, _> = sites.edges.iter().map(|edge| (edge.site, edge.reflection)).collect();
    Box::new(move |site, direction| usize::from(table[&site][direction]))
}

fn kind(kind: Kind) -> reference::Kind {
    match kind {
        Kind::Fluid => reference::Kind::Fluid,
        Kind::Wall => reference::Kind::Wall,
        Kind::Sink => reference::Kind::Sink,
    }
}

fn literal(loaded: &LoadedLattice, simulation: &Simulation) -> Reference {
    let (sites, gas) = parts(simulation);
    let r = loaded.rules;
    let rules = reference::Rules {
        p: r.p.get(),
        q: r.q.get(),
        b: r.b.get(),
        k: r.k.get(),
        g: r.g.get(),
        h: r.h.get(),
        random_reflection: r.walls == Walls::Scatter,
    };
    let top = sites.fluid().map(|s| sites.coordinates(s).1).max().unwrap();
    let kinds = sites.kinds.iter().copied().map(kind).collect();
    let states = gas.states().to_vec();
    Reference::new(rules, loaded.scene.seed, sites.stride, top as isize, kinds, states, reflections(sites))
}

/// Steps both automata and compares them. The reference visits its sites forwards, backwards or with a large stride.
fn assert_equal_states(rules: &str) {
    const OPENS: u64 = 20;
    let loaded = small_silo(rules, OPENS, "fill: (per_site: 7.0),");
    let mut fast = simulation(&loaded, 1);
    fast.run_steps(0);
    let mut literal = literal(&loaded, &fast);
    let forwards: Vec<usize> = parts(&fast).0.fluid().collect();
    let backwards: Vec<usize> = forwards.iter().rev().copied().collect();
    let stride = 101;
    assert_ne!(forwards.len() % stride, 0);
    let strided: Vec<usize> = (0..forwards.len()).map(|i| forwards[i * stride % forwards.len()]).collect();
    for step in 1..=120 {
        fast.run_steps(step);
        literal.step([&forwards, &backwards, &strided][step as usize % 3]);
        let (sites, gas) = parts(&fast);
        assert_eq!(literal.steps(), step);
        assert_eq!(gas.states(), literal.state(), "{rules}, step {step}");
        assert_eq!((gas.out(), gas.inside()), (literal.outflow(), literal.resident()), "{rules}, step {step}");
        if step == OPENS {
            sites.doorway.iter().for_each(|&s| literal.set_kind(s, reference::Kind::Sink));
            literal.set_reflections(reflections(sites));
        }
    }
    assert!(literal.outflow() > 100, "{rules}: {} out", literal.outflow());
}

#[test]
fn base_case_and_its_variants_equal_the_reference() {
    assert_equal_states("p: 0.2, q: 0.2, b: 0.05, k: 0.05, g: 0.2, h: 0.05");
    assert_equal_states("p: 0.8, q: 0.2, b: 0.8, k: 0.05, g: 0.95, h: 0.8");
    assert_equal_states("p: 0.0, q: 0.0, b: 0.0, k: 0.0, g: 0.2, h: 0.0");
    assert_equal_states("p: 0.2, q: 0.8, b: 0.05, k: 0.8, g: 0.05, h: 0.05");
}

#[test]
fn rules_with_probability_one_equal_the_reference() {
    assert_equal_states("p: 1.0, q: 1.0, b: 1.0, k: 1.0, g: 1.0, h: 1.0");
    assert_equal_states("p: 0.0, q: 1.0, b: 1.0, k: 0.5, g: 1.0, h: 0.0");
}

#[test]
fn scattering_walls_equal_the_reference() {
    assert_equal_states("p: 0.2, q: 0.2, b: 0.8, k: 0.05, g: 0.2, h: 0.05, walls: Scatter");
}
