//! A thrown particle. Its steps are a Markov chain with a mean in closed form.

use crate::{load, parts, simulation};

const G: f64 = 0.05;

/// Returns the positions, in spacings from the start, after each of 40 steps of one particle thrown with direction 7.
fn trace(seed: u64) -> Vec<(f64, f64)> {
    let loaded = load(
        "parabola.ron",
        &[
            ("seed", &seed.to_string()),
            ("outline", "[(0.0, 0.0), (0.4, 0.0), (0.4, 1.4), (0.0, 1.4)]"),
            ("particles", "[(at: (0.02, 0.7), velocity: 7)]"),
        ],
    );
    let mut simulation = simulation(&loaded, 1);
    let mut places = Vec::new();
    for step in 0..=40 {
        simulation.run_steps(step);
        let (sites, gas) = parts(&simulation);
        let s = sites.fluid().find(|&s| gas.states()[s] != 0).unwrap();
        places.push(sites.position(s) / sites.spacing);
    }
    places[1..].iter().map(|x| (x.x - places[0].x, x.y - places[0].y)).collect()
}

/// Returns E[y] of every step from the Markov chain. The vertical velocity is 3, 1, -1 or -3 half spacings per step. A
/// kick, with probability g before the step, moves it to the next lower value, down to the last one.
fn expected() -> Vec<f64> {
    let mut chance: [f64; 4] = [1.0, 0.0, 0.0, 0.0];
    let mut y = 0.0;
    (0..40)
        .map(|_| {
            let stays = [1.0 - G, 1.0 - G, 1.0 - G, 1.0];
            let from_above = |n: usize| if n > 0 { G * chance[n - 1] } else { 0.0 };
            chance = std::array::from_fn(|n| stays[n] * chance[n] + from_above(n));
            y += 0.5 * (3.0 * chance[0] + chance[1] - chance[2] - 3.0 * chance[3]);
            y
        })
        .collect()
}

#[test]
fn markov_chain_gives_the_published_means() {
    let chain = expected();
    for (t, y) in [(1, 1.450), (5, 6.750), (10, 12.252), (20, 19.586), (30, 22.317), (40, 20.996)] {
        // Published to three decimals.
        assert!((chain[t - 1] - y).abs() < 5.1e-4, "{t}: {}", chain[t - 1]);
    }
    // Before any particle falls at full speed, the mean is a parabola: 1.5 t - g t (t + 1)/2.
    for t in 1..=3 {
        let parabola = 1.5 * f64::from(t) - G * f64::from(t * (t + 1)) / 2.0;
        assert!((chain[t as usize - 1] - parabola).abs() < 1e-12);
    }
}

#[test]
fn mean_path_of_thrown_particles_is_the_mean_of_the_chain() {
    const N: u64 = 300;
    let traces: Vec<_> = (0..N).map(trace).collect();
    for (step, y) in expected().into_iter().enumerate() {
        let n = N as f64;
        let mean = traces.iter().map(|trace| trace[step].1).sum::<f64>() / n;
        let variance = traces.iter().map(|trace| (trace[step].1 - mean).powi(2)).sum::<f64>() / (n - 1.0);
        // Five standard errors: all forty steps of one chain pass in all but a few of 10^5 tests.
        assert!((mean - y).abs() < 5.0 * (variance / n).sqrt(), "step {}: {mean} {y}", step + 1);
        // The horizontal velocity never changes: a kick moves from direction 7 to 2, 3 and 9.
        let x = (step + 1) as f64 * 0.75f64.sqrt();
        assert!(traces.iter().all(|trace| (trace[step].0 - x).abs() < 1e-9));
    }
}
