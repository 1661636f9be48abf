//! Landings of the computer in single precision beside those in double precision.

use touchdown_record::{SEED, recordings, replayed, space};
use touchdown_sim::landing::space::{Case, SpaceLander};

#[test]
fn xval_single_precision_lands_as_well_as_double() {
    // Six trials of each case: enough that a broken computer shows, few enough for every run.
    for case in Case::ALL {
        let lander = SpaceLander::new(&case.scenario()).unwrap();
        let trials = 0..6;
        let double = trials
            .clone()
            .filter(|&i| lander.land(i, SEED, false).unwrap().outcome.landed());
        let single = trials
            .clone()
            .filter(|&i| space(case, &lander, i).unwrap().landing.outcome.landed());
        let (double, single) = (double.count(), single.count());
        // One landing of six may fall on the other side of a limit.
        assert!(single + 1 >= double, "{case:?}: {single} {double}");
    }
}

#[test]
fn regress_recordings_land_and_replay() {
    for recording in recordings().unwrap() {
        assert!(recording.landed, "{}", recording.name);
        let results = replayed(&recording.words).unwrap();
        // The start is one call; all others are landings of some seconds.
        let least = if recording.name == "computer-start" {
            1
        } else {
            400
        };
        assert!(results.len() >= least, "{}", recording.name);
    }
}
