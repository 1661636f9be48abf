//! Reads a request from standard input and writes its answer to standard output. A browser's worker runs it as a WASI
//! program, once for each request.

use std::io::{self, Read as _, Write as _};

fn main() -> io::Result<()> {
    let mut request = String::new();
    io::stdin().read_to_string(&mut request)?;
    io::stdout().write_all(touchdown_web::answer(&request).as_bytes())
}
