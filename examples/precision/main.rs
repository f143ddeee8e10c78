//! What f32 would cost in error, and gain in time: `docs/explanation/precision.md` has the figures.
//!
//! ```text
//! cargo run --release --example precision            # errors: ten minutes
//! cargo run --release --example precision -- --time  # the pair-force loop in f64 and in f32
//! ```
//!
//! A small discrete element method of its own, nothing of siloflow's, written once over the number types ([`numbers`]).
#![expect(clippy::print_stdout, reason = "the table is what it is for")]

mod bed;
mod bounce;
mod column;
mod discs;
mod gas;
mod numbers;
mod table;
mod timing;

fn main() {
    if std::env::args().any(|argument| argument == "--time") {
        return timing::rows(&mut |line| println!("{line}"));
    }
    let say = &mut |line| println!("{line}");
    say(table::heading());
    bounce::rows(say);
    column::rows(say);
    bed::rows(say);
    gas::rows(say);
}
