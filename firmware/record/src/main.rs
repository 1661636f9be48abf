//! Writes the recordings of simulated landings, and the host's results, into a folder.
#![allow(clippy::print_stdout, clippy::print_stderr, reason = "a command")]

use std::error::Error;
use std::path::Path;

fn main() -> Result<(), Box<dyn Error>> {
    let folder = std::env::args().nth(1).ok_or("usage: record FOLDER")?;
    let folder = Path::new(&folder);
    std::fs::create_dir_all(folder)?;
    for recording in touchdown_record::recordings()? {
        let results = touchdown_record::replayed(&recording.words)
            .ok_or("a recording of this program cannot be replayed")?;
        let path = |extension: &str| folder.join(&recording.name).with_extension(extension);
        std::fs::write(path("in"), bytes(&recording.words))?;
        std::fs::write(path("host"), bytes(&results))?;
        println!("{}", recording.name);
    }
    Ok(())
}

fn bytes(words: &[u32]) -> Vec<u8> {
    words.iter().flat_map(|word| word.to_le_bytes()).collect()
}
