//! An animated picture (SVG) of one landing by each of three methods on the paper's oscillating deck:
//! `cargo run --release -p touchdown --example landing_animation [FILE]`.
//!
//! All three fly the same trial: the same deck, the same thrust error, the same strength of the ground effect. A viewer that
//! does not animate shows the last frame.

#![allow(clippy::print_stdout, reason = "a program that says what it wrote")]

use std::error::Error;
use std::fmt::Write as _;

use touchdown_campaign::progress::Silent;
use touchdown_campaign::vertical::controllers::controller;
use touchdown_campaign::vertical::landings;
use touchdown_campaign::vertical::settings::LandSettings;
use touchdown_flight::Method;
use touchdown_reproduce::experiments::identify_cards;
use touchdown_sim::landing::vertical::{Landing, LandingTrace};

/// Length of the film (s): the slowest of the landings shown, and some seconds to read the results.
const DURATION_S: f64 = 10.0;
/// Time between two positions (s); the picture moves on straight lines in between.
const FRAME_S: f64 = 0.1;
/// Scale of the drawing (px/m), and of the arrow of the ground-effect force (px/N).
const PX_PER_M: f64 = 400.0;
const PX_PER_N: f64 = 40.0;
/// Width of a column, and the deck's surface at rest (px).
const COLUMN_PX: f64 = 266.0;
const DECK_PX: f64 = 350.0;
/// The methods, their titles and the colours that they have in reports.
const METHODS: [(Method, &str, &str); 3] = [
    (Method::Feedback, "Feedback alone", "#56b4e9"),
    (Method::Empirical, "Empirical model fed forward", "#d55e00"),
    (Method::Dynamic, "Identified model fed forward", "#0072b2"),
];

fn main() -> Result<(), Box<dyn Error>> {
    let path = std::env::args().nth(1);
    let path = path.as_deref().unwrap_or("landing.svg");
    let settings = LandSettings::deck();
    let seed = 1;
    let rig = touchdown_sim::rig::RigSettings::default();
    let cards = identify_cards(&rig, seed, &Silent)?;
    let mut flights = Vec::new();
    for (method, _, _) in METHODS {
        let controller = controller(method, &cards, &settings, true)?;
        let flown = landings::run(&settings.scenario, None, &controller, 1, seed, 1, &Silent)?;
        flights.extend(flown);
    }
    std::fs::write(path, draw(&flights)?)?;
    println!("{path}");
    Ok(())
}

/// The picture.
fn draw(landings: &[Landing]) -> Result<String, Box<dyn Error>> {
    let trace = |landing: &Landing| landing.trace.clone().ok_or("a landing without its record");
    // The longest record has the deck's motion after the others have landed: the trial is the same.
    let deck = trace(&landings[0])?;
    let mut out = String::from(HEAD);
    for (column, (landing, (_, title, colour))) in landings.iter().zip(METHODS).enumerate() {
        let x = COLUMN_PX * (column as f64 + 0.5);
        writeln!(
            out,
            "<g transform=\"translate({x:.0} 0)\" text-anchor=\"middle\">"
        )?;
        writeln!(
            out,
            "<text y=\"34\" font-weight=\"600\" fill=\"{colour}\">{title}</text>"
        )?;
        result(&mut out, landing)?;
        scene(&mut out, &trace(landing)?, &deck, colour)?;
        out.push_str("</g>\n");
    }
    out.push_str("</svg>\n");
    Ok(out)
}

/// The line below the title: how the landing ended, from that moment on.
fn result(out: &mut String, landing: &Landing) -> std::fmt::Result {
    let (text, from) = match (landing.t_l_s, landing.v_l_mps) {
        (Some(t), Some(v)) => (format!("landed after {t:.1} s at {:.0} mm/s", 1e3 * v), t),
        _ => ("does not land: hovers".to_string(), 0.8 * DURATION_S),
    };
    let share = from / DURATION_S;
    writeln!(
        out,
        "<text y=\"56\" fill=\"#444\">{text}<animate attributeName=\"opacity\" dur=\"{DURATION_S}s\" \
         repeatCount=\"indefinite\" calcMode=\"discrete\" values=\"0;1\" keyTimes=\"0;{share:.3}\"/></text>"
    )
}

/// Deck, vehicle and the arrow of the ground-effect force.
fn scene(
    out: &mut String,
    flown: &LandingTrace,
    deck: &LandingTrace,
    colour: &str,
) -> std::fmt::Result {
    let frames = 0..=(DURATION_S / FRAME_S).round() as usize;
    let times: Vec<f64> = frames.map(|k| k as f64 * FRAME_S).collect();
    let at = |values: &[f64], t: f64| {
        let row = deck.time_s.partition_point(|s| *s < t - 1e-9);
        values.get(row).copied()
    };
    let deck_px = |t: f64| DECK_PX - PX_PER_M * at(&deck.deck_height_m, t).unwrap_or(0.0);
    // After touchdown the vehicle rides on the deck.
    let rest_m = flown.height_m.last().copied().unwrap_or(0.0);
    let vehicle_px = |t: f64| deck_px(t) - PX_PER_M * at(&flown.height_m, t).unwrap_or(rest_m);
    let arrow = |t: f64| PX_PER_N * at(&flown.ground_effect_n, t).unwrap_or(0.0).max(0.0);
    moving(out, &times, deck_px, DECK)?;
    moving(out, &times, vehicle_px, &VEHICLE.replace("COLOUR", colour))?;
    let lengths: Vec<String> = times.iter().map(|t| format!("{:.1}", -arrow(*t))).collect();
    let paths: Vec<String> = lengths.iter().map(|l| format!("M0-26v{l}")).collect();
    moving(
        out,
        &times,
        vehicle_px,
        &format!(
            "<path d=\"{}\" stroke=\"#009e73\" stroke-width=\"5\"><animate attributeName=\"d\" dur=\"{DURATION_S}s\" \
             repeatCount=\"indefinite\" values=\"{}\"/></path>",
            paths.last().map_or("", String::as_str),
            paths.join(";")
        ),
    )
}

/// A drawing whose height follows `y_px` over the frames' times, and stands at the last without animation.
fn moving(
    out: &mut String,
    times: &[f64],
    y_px: impl Fn(f64) -> f64,
    drawing: &str,
) -> std::fmt::Result {
    let places: Vec<String> = times.iter().map(|t| format!("0 {:.1}", y_px(*t))).collect();
    let last = places.last().map_or("0 0", String::as_str);
    writeln!(
        out,
        "<g transform=\"translate({last})\"><animateTransform attributeName=\"transform\" type=\"translate\" \
         dur=\"{DURATION_S}s\" repeatCount=\"indefinite\" values=\"{}\"/>{drawing}</g>",
        places.join(";")
    )
}

/// Canvas and the line that explains it.
const HEAD: &str = r##"<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 798 430" font-family="Inter, Helvetica, Arial, sans-serif" font-size="15">
<rect width="798" height="430" rx="8" fill="#fff"/>
<text x="399" y="416" text-anchor="middle" font-size="13" fill="#666">Simulated. The deck heaves by ±5 cm at 0.5 Hz. Green: ground-effect force.</text>
"##;
/// The deck, its surface at y = 0.
const DECK: &str = r##"<rect x="-124" width="248" height="10" fill="#888"/>"##;
/// The vehicle: feet 0.1 m below its reference point at y = 0, rotors of 0.12 m radius 0.05 m above it.
const VEHICLE: &str = r##"<g fill="none" stroke="#222" stroke-width="4"><path d="M-64-14H64M-64-14V-20M64-14V-20M-30-6L-50 39M30-6L50 39"/><path d="M-112-21H-16M16-21H112" stroke="COLOUR"/><rect x="-26" y="-24" width="52" height="22" rx="6" fill="#222" stroke="none"/></g>"##;
