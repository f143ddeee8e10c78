//! Measures the memory speed of this machine: bandwidth of one core as a function of array size, and latency of
//! dependent reads.
//!
//! `cargo run --release --example memory`. docs/developers/speed-notebook.md compares the results with the memory traffic of a step.

#![allow(clippy::print_stdout, reason = "a program that prints")]
#![allow(clippy::cast_precision_loss, reason = "printed results")]

use std::hint::black_box;
use std::time::Instant;

/// Returns GB/s of reading an array of `doubles` numbers, and of adding another array to it (24 B each), over about a
/// GiB.
fn bandwidth(doubles: usize) -> [f64; 2] {
    let mut a = vec![1.0f64; doubles];
    let b = vec![2.0f64; doubles];
    let rounds = (1 << 27) / doubles;
    let rate = |bytes: usize, start: Instant| (rounds * doubles * bytes) as f64 / start.elapsed().as_secs_f64() / 1e9;
    let start = Instant::now();
    let mut sums = [0.0; 16];
    for _ in 0..rounds {
        for sixteen in black_box(&a).chunks_exact(16) {
            for (sum, x) in sums.iter_mut().zip(sixteen) {
                *sum += x;
            }
        }
    }
    black_box(sums);
    let read = rate(8, start);
    let start = Instant::now();
    for _ in 0..rounds {
        for (x, y) in black_box(&mut a).iter_mut().zip(&b) {
            *x += 0.5 * y;
        }
    }
    [read, rate(24, start)]
}

/// Returns the latency of a read, ns: each read gives the place of the next one, over `lines` lines of 64 B in random
/// order.
fn latency(lines: usize) -> f64 {
    let (mut order, mut state): (Vec<usize>, _) = ((0..lines).collect(), 12_345u64);
    for i in (1..lines).rev() {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        order.swap(i, usize::try_from(state >> 33).unwrap_or(0) % (i + 1));
    }
    let mut next = vec![[0usize; 8]; lines];
    for (i, &place) in order.iter().enumerate() {
        next[place][0] = order[(i + 1) % lines];
    }
    let mut at = 0;
    let reads = 3_000_000;
    let start = Instant::now();
    for _ in 0..reads {
        at = next[at][0];
    }
    black_box(at);
    start.elapsed().as_secs_f64() / f64::from(reads) * 1e9
}

fn main() {
    println!("{:>9}  {:>12}  {:>12}  {:>14}", "kB", "read, GB/s", "a += b, GB/s", "latency, ns");
    for kilobytes in [64, 256, 700, 1400, 4000, 8000, 24_000, 130_000] {
        let [read, add] = bandwidth(kilobytes * 1024 / 8);
        println!("{kilobytes:>9}  {read:>12.1}  {add:>12.1}  {:>14.1}", latency(kilobytes * 1024 / 64));
    }
}
