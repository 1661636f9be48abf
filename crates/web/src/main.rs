//! Reads a request from standard input and writes its answer to standard output. A browser's worker runs it as a WASI
//! program, once for each request. What it is doing goes to standard error.

use std::io::{self, Read as _, Write as _};

fn main() -> io::Result<()> {
    let mut request = String::new();
    io::stdin().read_to_string(&mut request)?;
    // A line of JSON for each stage. What else is there is of a panic.
    let stages = |text: &str| {
        let line = format!("{}\n", serde_json::json!({ "stage": text }));
        // Without it there is an answer all the same.
        let _ = io::stderr().write_all(line.as_bytes());
    };
    io::stdout().write_all(touchdown_web::answer(&request, &stages).as_bytes())
}
