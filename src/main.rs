//! The program `siloflow`.

use std::process::ExitCode;

fn main() -> ExitCode {
    siloflow::cli::main()
}
