//! The table of exit statuses: every command, every way to fail, one JSON object for each failure.

use std::ffi::{OsStr, OsString};
use std::path::Path;

use crate::common::{json, rotor_row, run, text, write_log};

/// What the commands are given; `{}` in an argument is the folder of these files.
fn write_files(folder: &Path) {
    let write = |name: &str, text: &str| std::fs::write(folder.join(name), text).unwrap();
    write_log(&folder.join("log.csv"), 600, rotor_row);
    write("thrust.toml", touchdown_model::published::EQ_11);
    write("ground.toml", touchdown_model::published::EQ_12);
    write("bad.toml", "colour = 1\n");
    write("sweep.toml", "trials = 1\n");
    write("file", "");
}

/// Commands with the exit status that each must have.
const FAILURES: &[(u8, &str)] = &[
    // Arguments.
    (2, ""),
    (2, "fly"),
    (2, "identify"),
    (2, "reproduce --colour red"),
    (2, "rig"),
    (2, "inspect"),
    (2, "identify thrust {}/log.csv --form magic"),
    (2, "validate {}/log.csv"),
    (2, "land --controller magic --out {}/out"),
    (2, "land --controller observer --out {}/out"),
    (2, "campaign"),
    (2, "campaign {}/sweep.toml --shard 3/2 --out {}/out"),
    (2, "settings magic"),
    (2, "completions magic"),
    (2, "man"),
    (2, "export"),
    (2, "export {}/log.csv --to fortran --out {}/out"),
    // A file in place of a folder.
    (2, "reproduce --quick --out {}/file"),
    (2, "inspect {}/log.csv --out {}/file"),
    (2, "identify thrust {}/log.csv --out {}/file"),
    (2, "validate {}/thrust.toml {}/log.csv --out {}/file"),
    (2, "campaign {}/sweep.toml --out {}/file"),
    // Settings, scenarios and sweeps.
    (2, "reproduce --settings {}/none.toml --out {}/out"),
    (2, "reproduce --settings {}/bad.toml --out {}/out"),
    (2, "rig {}/none.toml --out {}/out"),
    (2, "rig {}/bad.toml --out {}/out"),
    (2, "identify thrust {}/log.csv --settings {}/none.toml"),
    (2, "identify thrust {}/log.csv --settings {}/bad.toml"),
    (2, "land {}/none.toml --out {}/out"),
    (2, "land {}/bad.toml --out {}/out"),
    (2, "land --space {}/none.toml --out {}/out"),
    (2, "land --space {}/bad.toml --out {}/out"),
    (2, "campaign {}/none.toml --out {}/out"),
    (2, "campaign {}/bad.toml --out {}/out"),
    (2, "campaign merge {}/none --out {}/out"),
    (2, "campaign replay {}/none.toml --landing 0 --mcap {}/out"),
    // Maps.
    (2, "inspect {}/log.csv --map {}/none.toml"),
    (2, "inspect {}/log.csv --map {}/bad.toml"),
    (2, "identify thrust {}/log.csv --map {}/none.toml"),
    (2, "identify ground-effect {}/log.csv --map {}/bad.toml"),
    (2, "validate {}/thrust.toml {}/log.csv --map {}/none.toml"),
    // Cards.
    (2, "identify ground-effect {}/log.csv --thrust {}/none.toml"),
    (2, "identify ground-effect {}/log.csv --thrust {}/bad.toml"),
    (2, "validate {}/none.toml {}/log.csv"),
    (2, "validate {}/bad.toml {}/log.csv"),
    (
        2,
        "validate {}/ground.toml {}/log.csv --thrust {}/none.toml",
    ),
    (2, "land --thrust {}/none.toml --out {}/out"),
    (2, "land --space --dynamic {}/none.toml --out {}/out"),
    // Logs.
    (1, "inspect {}/none.csv"),
    (1, "identify thrust {}/none.csv"),
    (
        1,
        "identify ground-effect {}/none.csv --thrust {}/thrust.toml",
    ),
    (1, "validate {}/thrust.toml {}/none.csv"),
    (1, "inspect {}/file"),
    // Results that cannot be written: a folder below a file.
    (1, "reproduce --quick --out {}/file/out"),
    (1, "rig --out {}/file/out"),
    (1, "inspect {}/log.csv --out {}/file/out"),
    (1, "identify thrust {}/log.csv --out {}/file/out"),
    (1, "validate {}/thrust.toml {}/log.csv --out {}/file/out"),
    (
        1,
        "land --controller feedback --trials 1 --thrust {}/thrust.toml --out {}/file/out",
    ),
    (1, "land --space --trials 1 --out {}/file/out"),
    (1, "campaign {}/sweep.toml --out {}/file/out"),
    (1, "man --out {}/file/out"),
];

#[test]
fn prop_every_failure_has_its_status_and_an_object() {
    let folder = tempfile::tempdir().unwrap();
    write_files(folder.path());
    let at = folder.path().display().to_string();
    for (status, command) in FAILURES {
        let arguments = command
            .split_whitespace()
            .map(|word| word.replace("{}", &at));
        let arguments: Vec<OsString> = arguments.chain(["--json".into()]).map(Into::into).collect();
        let output = run(&arguments);
        let error = text(&output.stderr);
        assert_eq!(
            output.status.code(),
            Some(i32::from(*status)),
            "{command}: {error}"
        );
        let object: serde_json::Value = serde_json::from_slice(&output.stdout)
            .unwrap_or_else(|e| panic!("{command}: {e}: {}", text(&output.stdout)));
        assert_eq!(object["outcome"], "refused", "{command}");
        let said = object["error"].as_str().unwrap();
        assert!(
            !said.is_empty() && !said.contains("Usage"),
            "{command}: {said}"
        );
        assert!(
            error.contains("error: ") || said.contains("subcommand"),
            "{command}: {error}"
        );
        assert!(
            error.contains(said) || said.contains("subcommand"),
            "{command}: {said} / {error}"
        );
        assert!(
            !folder.path().join("out/results.json").exists(),
            "{command}"
        );
    }
    let help = text(&run(["--help"]).stdout);
    for line in touchdown_terminal::EXIT_STATUS.lines().skip(1) {
        let code = line.split_whitespace().next().unwrap();
        assert!(help.contains(&format!("  {code} ")), "{help}");
    }
}

#[test]
fn prop_completions_and_manual_pages_cover_every_command() {
    let folder = tempfile::tempdir().unwrap();
    let commands = [
        "reproduce",
        "rig",
        "inspect",
        "identify",
        "validate",
        "export",
        "land",
        "campaign",
    ];
    for shell in ["bash", "zsh", "fish", "powershell", "elvish"] {
        let script = text(&run(["completions", shell]).stdout);
        for command in commands {
            assert!(script.contains(command), "{shell}: {command}");
        }
        let object = json(0, ["completions", shell]);
        assert_eq!(object["script"], script, "{shell}");
    }
    let out = folder.path().join("man1");
    let arguments: [OsString; 3] = ["man".into(), "--out".into(), out.clone().into()];
    let object = json(0, arguments);
    for command in commands {
        let page = out.join(format!("touchdown-{command}.1"));
        let text = std::fs::read_to_string(&page).unwrap();
        assert!(text.contains(".TH") && text.contains(command), "{command}");
        let files = object["files"].as_array().unwrap();
        assert!(
            files
                .iter()
                .any(|file| Path::new(file.as_str().unwrap()) == page)
        );
    }
    assert!(out.join("touchdown-identify-thrust.1").exists());
    assert!(!out.join("touchdown-help.1").exists());
}

#[test]
fn prop_nothing_landed_is_an_outcome_that_says_why() {
    let folder = tempfile::tempdir().unwrap();
    write_files(folder.path());
    let out = folder.path().join("out");
    // Too short a time to land in.
    let scenario = folder.path().join("short.toml");
    std::fs::write(&scenario, "trials = 2\n[scenario]\ntimeout_s = 1.0\n").unwrap();
    let mut arguments: Vec<OsString> = ["land", "--controller", "feedback", "--thrust"]
        .map(OsString::from)
        .into();
    arguments.extend([folder.path().join("thrust.toml").into(), scenario.into()]);
    arguments.extend([OsString::from("--out"), out.clone().into()]);
    let output = run(&arguments);
    let said = text(&output.stdout);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    assert!(
        said.contains("none of 2 landings by feedback landed: 2 timed out"),
        "{said}"
    );
    let table = std::fs::read_to_string(out.join("landings.csv")).unwrap();
    let mut lines = table.lines();
    assert_eq!(
        lines.next().unwrap(),
        "controller,trial,outcome,t_l_s,v_l_mps,s_l_m,final_height_m"
    );
    assert!(
        lines
            .next()
            .unwrap()
            .starts_with("feedback,0,timed_out,,,,")
    );
    assert_eq!(lines.count(), 1);
    // The same in space.
    let sweep = folder.path().join("short-sweep.toml");
    std::fs::write(&sweep, "trials = 2\n[scenario]\ntimeout_s = 1.0\n").unwrap();
    let mut arguments: Vec<OsString> = ["land", "--space"].map(OsString::from).into();
    arguments.extend([sweep.into(), OsString::from("--out"), out.into()]);
    let output = run(&arguments);
    let said = text(&output.stdout);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    assert!(said.contains("none of 2 landings at"), "{said}");
    assert!(said.contains("landed: 2 "), "{said}");
}

/// What is wrong is one sentence with file, line, key and the nearest known key, in every kind of configuration.
#[test]
fn regress_an_unknown_key_is_one_sentence_and_comes_before_the_logs() {
    let folder = tempfile::tempdir().unwrap();
    write_files(folder.path());
    let file = |name: &str, text: &str| {
        std::fs::write(folder.path().join(name), text).unwrap();
    };
    file("flight.toml", "[vehicle]\n\nmass_kgg = 1.2\n");
    file("identify.toml", "[flight]\n\nmass_kgg = 1.2\n");
    file("space.toml", "[scenario.plant]\n\nmass_kgg = 1.2\n");
    let map = "schema = 1\nchannels = { time_s = 't' }\n[vehicle]\nmass_kgg = 1.2\n";
    file("map.toml", map);
    let card = touchdown_model::published::EQ_11.replace("\nname =", "\nnamee =");
    file("card.toml", &card);
    let at = |name: &str| folder.path().join(name).display().to_string();
    let (empty, ground) = (at("file"), at("ground.toml"));
    // The log is empty in all of them: configuration is checked first.
    let ground_effect = ["identify", "ground-effect", &empty];
    let flown = ["--out", &at("out")];
    let mass = "unknown key; the nearest known key is `mass_kg`";
    for (name, command, key, expected) in [
        (
            "identify.toml",
            [&ground_effect[..], &["--settings"]],
            "line 3, key `flight.mass_kgg`",
            mass,
        ),
        (
            "map.toml",
            [&ground_effect[..], &["--map"]],
            "line 4, vehicle.mass_kgg",
            mass,
        ),
        (
            "map.toml",
            [&["inspect", &empty], &["--map"]],
            "line 4, vehicle.mass_kgg",
            mass,
        ),
        (
            "card.toml",
            [&ground_effect[..], &["--thrust"]],
            "key `namee`",
            "unknown key; the nearest known key is `name`",
        ),
        (
            "card.toml",
            [&["validate", &ground, &empty], &["--thrust"]],
            "key `namee`",
            "`name`",
        ),
        (
            "space.toml",
            [&flown[..], &["campaign"]],
            "line 3, key `scenario.plant.mass_kgg`",
            mass,
        ),
        (
            "space.toml",
            [&flown[..], &["land", "--space"]],
            "line 3, key `scenario.plant.mass_kgg`",
            mass,
        ),
        (
            "space.toml",
            [&flown[..], &["land"]],
            "line 3, key `scenario.plant.mass_kgg`",
            mass,
        ),
        (
            "flight.toml",
            [&[], &["fly"]],
            "line 3, key `vehicle.mass_kgg`",
            mass,
        ),
    ] {
        let [first, last] = command;
        let path = at(name);
        // `--out` stands after the command.
        let words = match first {
            ["--out", ..] => [last, &[&path], first].concat(),
            _ => [first, last, &[&path]].concat(),
        };
        let output = run(&words);
        let error = text(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{words:?}: {error}");
        for part in [name, key, expected] {
            assert!(error.contains(part), "{words:?}: {error}");
        }
        assert_eq!(error.trim_end().lines().count(), 1, "{words:?}: {error}");
    }
}

#[test]
fn regress_a_missing_or_empty_log_says_what_to_do_next() {
    let folder = tempfile::tempdir().unwrap();
    write_files(folder.path());
    let at = |name: &str| folder.path().join(name).display().to_string();
    for (log, next) in [
        ("none.csv", "check the path"),
        ("file", "copy or export the log again"),
    ] {
        for command in [&["inspect"][..], &["identify", "thrust"]] {
            let output = run([command, &[&at(log)]].concat());
            let error = text(&output.stderr);
            assert!(error.contains(next), "{command:?} {log}: {error}");
        }
    }
}

#[test]
fn regress_a_flight_that_is_refused_leaves_the_files_of_before() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    // A link that nobody opens, a limit that is no number, and a recording in place of the settings.
    for (settings, out, names) in [
        (
            "link = \"tcp:127.0.0.1:1\"\n",
            "last.mcap",
            "tcp:127.0.0.1:1",
        ),
        ("[limits]\nstale_s = nan\n", "last.mcap", "limits.stale_s"),
        ("link = \"tcp:127.0.0.1:1\"\n", "flight.toml", "--out"),
    ] {
        std::fs::write(path("flight.toml"), settings).unwrap();
        std::fs::write(path("last.mcap"), "the last flight").unwrap();
        let (settings_file, out) = (path("flight.toml"), path(out));
        let output = run([
            OsStr::new("fly"),
            settings_file.as_os_str(),
            OsStr::new("--out"),
            out.as_os_str(),
        ]);
        let error = text(&output.stderr);
        assert!(!output.status.success() && error.contains(names), "{error}");
        let left = |name: &str| std::fs::read_to_string(path(name)).unwrap();
        assert_eq!(left("last.mcap"), "the last flight", "{error}");
        assert_eq!(left("flight.toml"), settings, "{error}");
    }
}
