//! Any bytes after the start of an MCAP file are a recording that can be replayed, or an error.
#![no_main]

use libfuzzer_sys::fuzz_target;
use touchdown_link::companion::{Event, Session};
use touchdown_link::recording::{Recorder, Recording};
use touchdown_link::settings::FlightSettings;

fuzz_target!(|bytes: &[u8]| {
    let path = std::env::temp_dir().join(format!("touchdown-fuzz-{}.mcap", std::process::id()));
    let mut recorder =
        Recorder::create(&path, &FlightSettings::default(), &Session::default()).unwrap();
    let middle = bytes.len() / 2;
    recorder
        .write(0, Event::Received(&bytes[..middle]), &[])
        .unwrap();
    recorder.write(10_000, Event::Tick, &[]).unwrap();
    recorder.finish().unwrap();
    let mut file = std::fs::read(&path).unwrap();
    // The second half overwrites a part of the file.
    if let Some((&at, rest)) = bytes[middle..].split_first() {
        let at = usize::from(at) * file.len() / 256;
        let length = rest.len().min(file.len() - at);
        file[at..at + length].copy_from_slice(&rest[..length]);
    }
    std::fs::write(&path, &file).unwrap();
    if let Ok(recording) = Recording::read(&path) {
        let _ = touchdown_link::replay::replay(&recording, None);
    }
});
