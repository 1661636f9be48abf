//! The command `touchdown`.

use std::process::ExitCode;

mod cli;

fn main() -> ExitCode {
    cli::main()
}
