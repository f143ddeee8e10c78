//! The error that f32 would cause, and the time that it would save. `docs/explanation/precision.md` has the results.
//!
//! ```text
//! cargo run --release --example precision            # errors: ten minutes
//! cargo run --release --example precision -- --time  # the pair-force loop in f64 and in f32
//! ```
//!
//! A small, separate discrete element method that uses no code of siloflow. It is generic over the number types
//! ([`numbers`]).
#![expect(clippy::print_stdout, reason = "the program prints a table")]

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
    let print_line = &mut |line| println!("{line}");
    print_line(table::heading());
    bounce::rows(print_line);
    column::rows(print_line);
    bed::rows(print_line);
    gas::rows(print_line);
}
