"""Trials, identification and cards against known stands and the command's own cards."""

from __future__ import annotations

import base64
import csv
import json
import os
import pickle
import re
import subprocess
import sys
import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import touchdown as td


def stand(lag_s: float = 0.05, seed: int = 1, seconds: float = 40.0) -> td.Trial:
    """A motor behind a lag on a stand: T = 20 s'^2 with s' = (s - s') / lag, noise of 0.02 N."""
    rng = np.random.default_rng(seed)
    dt = 0.002
    t = dt * np.arange(int(seconds / dt))
    steps = np.repeat(rng.uniform(0.25, 0.7, int(seconds)), int(1.0 / dt))[: t.size]
    state = np.empty_like(steps)
    state[0] = steps[0]
    decay = np.exp(-dt / lag_s)
    for k in range(t.size - 1):
        state[k + 1] = steps[k] + (state[k] - steps[k]) * decay
    thrust = 20.0 * state**2 + 0.02 * rng.standard_normal(t.size)
    return td.Trial({"time_s": t[::5], "throttle": steps[::5], "thrust_n": thrust[::5]}, name=f"stand {seed}")


@pytest.fixture(scope="module")
def card() -> td.Card:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", td.SindyWarning)
        return td.identify.thrust([stand(seed=1), stand(seed=2)])


def test_analytic_a_stand_gives_its_curve_and_lag(card: td.Card) -> None:
    unseen = stand(seed=3)
    error = card.predict(unseen) - unseen["thrust_n"]
    # Noise of 0.02 N, and a sampling of 10 ms that sees the steps late by up to one sample.
    assert np.sqrt(np.mean(error[50:] ** 2)) < 0.1
    assert card.fit["rows_used"] > 0 and card.terms
    lag = [t["value"] for t in card.terms if t["unit"] == "s"]
    assert any(abs(value - 0.05) < 0.01 for value in lag), card.terms


def test_prop_cards_are_written_and_read_to_the_bit(card: td.Card, tmp_path: Path) -> None:
    card.save(tmp_path / "card.toml")
    for again in (td.Card.load(tmp_path / "card.toml"), td.Card.from_toml(card.to_toml()), pickle.loads(pickle.dumps(card))):
        assert again.to_toml() == card.to_toml()
    assert "<table>" in card._repr_html_()


def test_prop_trials_are_tables_and_files(tmp_path: Path) -> None:
    pandas = pytest.importorskip("pandas")
    trial = stand(seconds=2.0)
    assert list(trial) == ["time_s", "throttle", "thrust_n"] and "height_m" not in trial
    frame = trial.to_pandas()
    again = td.Trial(frame)
    frame.to_csv(tmp_path / "stand.csv", index=False, float_format="%.17g")
    (read,) = td.read(tmp_path / "stand.csv")
    for name in trial:
        assert np.array_equal(trial[name], again[name]) and np.array_equal(trial[name], read[name])
        assert np.array_equal(trial.to_arrow()[name].to_numpy(), trial[name])
    assert isinstance(pandas.DataFrame(dict(read)), pandas.DataFrame)
    (tmp_path / "map.toml").write_text(
        "schema = 1\n[channels]\ntime_s = 'time_s'\nthrottle = '2*throttle'\nthrust_n = 'thrust_n'\n"
    )
    (mapped,) = td.read([tmp_path / "stand.csv"], map=tmp_path / "map.toml")
    assert np.array_equal(mapped["throttle"], 2.0 * trial["throttle"])


def test_prop_bad_input_says_what_and_why(tmp_path: Path, card: td.Card) -> None:
    trial = stand(seconds=2.0)
    cases = [
        lambda: td.read(tmp_path / "nothing.csv"),
        lambda: td.read(tmp_path / "nothing.csv", map="nothing"),
        lambda: td.Trial({"throttle": [1.0]}),
        lambda: td.Trial({"time_s": [1.0, 0.5], "throttle": [0.1, 0.2]}),
        lambda: td.Card.load(tmp_path / "nothing.toml"),
        lambda: td.Card.from_toml("schema = 99"),
        lambda: td.identify.thrust([]),
        lambda: td.identify.thrust(trial, {"thrusts": {}}),
        lambda: td.identify.ground_effect(trial),
        lambda: td.identify.ground_effect(trial, card, form="lagg"),
        lambda: card.predict(td.Trial({"time_s": [0.0, 1.0], "height_m": [1.0, 1.0]})),
    ]
    for case in cases:
        with pytest.raises(td.SindyError) as caught:
            case()
        assert caught.value.key and caught.value.found, str(caught.value)


def test_prop_the_commands_card(tmp_path: Path) -> None:
    command = os.environ.get("TOUCHDOWN_COMMAND", "")
    if not Path(command).is_file():
        pytest.skip("TOUCHDOWN_COMMAND names no command")
    trial = stand(seed=4, seconds=20.0)
    frame = trial.to_pandas()
    frame.to_csv(tmp_path / "stand.csv", index=False, float_format="%.17g")
    arguments = [command, "identify", "thrust", "stand.csv", "--out", "card.toml"]
    subprocess.run(arguments, cwd=tmp_path, check=True, capture_output=True)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", td.SindyWarning)
        ours = td.identify.thrust(td.read(tmp_path / "stand.csv"))
    theirs = td.Card.load(tmp_path / "card.toml")
    assert ours.terms == theirs.terms and ours.to_dict()["validity"] == theirs.to_dict()["validity"]


def test_prop_the_commands_report(tmp_path: Path) -> None:
    stand(seed=4, seconds=20.0).to_pandas().to_csv(tmp_path / "stand.csv", index=False, float_format="%.17g")
    command("identify", "thrust", "stand.csv", "--rotors", "1", "--out", "results", cwd=tmp_path)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", td.SindyWarning)
        settings = {"vehicle": {"measured_rotors": 1}}
        card = td.identify.thrust(td.read(tmp_path / "stand.csv"), settings=settings, report=tmp_path / "ours.html")

    def shown(file: str) -> str:
        page = (tmp_path / file).read_text()
        return page[page.index("<body") : page.index("How to redo this</h2>")]

    # A table knows the file, a trial its name; a card of the command in a folder is called after its log.
    theirs = shown("results/report.html").replace("stand.csv", "stand")
    assert shown("ours.html").replace(card.name, "stand") == theirs
    with pytest.raises(OSError, match="no-folder"):
        td.identify.thrust(td.read(tmp_path / "stand.csv"), settings=settings, report=tmp_path / "no-folder/ours.html")


def command(*arguments: object, cwd: Path) -> None:
    """Runs the command, if there is one."""
    program = os.environ.get("TOUCHDOWN_COMMAND", "")
    if not Path(program).is_file():
        pytest.skip("TOUCHDOWN_COMMAND names no command")
    subprocess.run([program, *map(str, arguments)], cwd=cwd, check=True, capture_output=True)


def columns(path: Path) -> dict[str, list[str]]:
    """A CSV file by columns."""
    with path.open(newline="") as file:
        rows = list(csv.DictReader(file))
    return {name: [row[name] for row in rows] for name in rows[0]}


def assert_same(ours: td.Landings, theirs: dict[str, list[str]]) -> None:
    """Every cell of the command's table: texts as they are, numbers to the bit."""
    for name, cells in theirs.items():
        if ours[name].dtype != object:
            numbers = [float(cell) if cell else np.nan for cell in cells]
            assert np.array_equal(ours[name], numbers, equal_nan=True), name
        else:
            assert [value or "" for value in ours[name]] == cells, name


def assert_same_report(ours: td.Landings, tmp_path: Path) -> None:
    """The files of a report are those in the command's folder; a card has a path there, and none here."""
    assert ours.report(tmp_path / "ours") == str(tmp_path / "ours/report.html")
    files = [file.relative_to(tmp_path / "ours") for file in (tmp_path / "ours").rglob("*") if file.is_file()]
    assert Path("report.html") in files and len(files) > 4
    for file in files:
        theirs = (tmp_path / "out" / file).read_bytes()
        if file.name == "report.html":
            theirs = re.sub(rb"(\n\[cards\]\n)thrust = .*\n", rb"\1", theirs)
        assert (tmp_path / "ours" / file).read_bytes() == theirs, file
    for bad in (None, "", "s3://bucket/x"):
        with pytest.raises(td.SindyError) as caught:
            ours.report(bad)
        assert caught.value.key == "folder" and caught.value.expected and not list(tmp_path.glob("s3*"))


def assert_drawn(html: str) -> None:
    """A plot, and a table below it."""
    image, table = html.split(">", 1)
    assert image.startswith('<img src="data:image/svg+xml;base64,') and table.startswith("<table>")
    assert b"<svg" in base64.b64decode(image.split(",")[1].rstrip('"'))


def test_prop_the_commands_landings_in_space(tmp_path: Path) -> None:
    sweep = {"trials": 3, "seed": 5, "grid": {"control.controller": ["feedback", "dynamic"]}, "scenario": {"timeout_s": 20.0}}
    (tmp_path / "sweep.toml").write_text(
        "trials = 3\nseed = 5\n[grid]\n'control.controller' = ['feedback', 'dynamic']\n[scenario]\ntimeout_s = 20.0\n"
    )
    command("land", "sweep.toml", "--space", "--out", "out", cwd=tmp_path)
    theirs = columns(tmp_path / "out/landings.csv")
    ours = td.land(sweep, space=True)
    assert_same(ours, theirs)
    assert_same(td.land(tmp_path / "sweep.toml", space=True, n_jobs=1), theirs)
    points = json.loads((tmp_path / "out/results.json").read_text())["points"]
    assert ours.results["points"] == points
    trace = ours.trace(1)
    rows = len(trace["time_s"])
    assert trace["position_m"].shape == (rows, 3) and trace["attitude"].shape == (rows, 4) and len(trace["phase"]) == rows
    # The series ends where the table says that the landing does, up to a step of the landing computer.
    assert abs(trace["time_s"][-1] - ours["end_s"][1]) < 0.011
    assert_same_report(ours, tmp_path)
    assert_drawn(ours._repr_html_())
    assert_drawn(td.Space(settings={"seed": 5}).land(1)._repr_html_())


def test_prop_the_commands_vertical_landings(card: td.Card, tmp_path: Path) -> None:
    card.save(tmp_path / "thrust.toml")
    names = ["feedback", "imbc"]
    arguments = [word for name in names for word in ("--controller", name)]
    command("land", *arguments, "--thrust", "thrust.toml", "--trials", 4, "--seed", 2, "--out", "out", cwd=tmp_path)
    ours = td.land(thrust=card, controllers=names, trials=4, seed=2)
    assert_same(ours, columns(tmp_path / "out/landings.csv"))
    assert ours.results == json.loads((tmp_path / "out/results.json").read_text())["landing"]
    assert ours.trace(0)["height_m"][0] >= 0.5 and len(ours.to_pandas()) == 8
    assert_same_report(ours, tmp_path)
    assert_drawn(ours._repr_html_())
    with pytest.raises(td.SindyError, match="copies have no report"):
        pickle.loads(pickle.dumps(ours)).report(tmp_path / "again")


def test_regress_texts_of_a_table_are_compared_row_by_row(card: td.Card) -> None:
    landings = td.land(thrust=card, controllers=["feedback", "imbc"], trials=4, seed=2)
    own = landings["controller"] == "imbc"
    # A list compares as a whole: False, without a word.
    assert own.tolist() == [False] * 4 + [True] * 4
    assert ((landings["outcome"] == "landed") == landings.landed).all()
    assert landings["t_l_s"][own & landings.landed].shape == (landings.landed[own].sum(),)
    space = td.land({"scenario": {"timeout_s": 30.0}}, space=True, trials=2, seed=3)
    assert (space["outcome"] == "landed").tolist() == [True, True]
    # Nothing went wrong: all absent, and texts all the same in tables of others.
    assert space["why"].tolist() == [None, None] and (space["why"] == "x").tolist() == [False, False]
    assert str(space.to_polars()["why"].dtype) == "String" and str(space.to_arrow().schema.field("why").type) == "string"
    phase = space.trace(0)["phase"]
    assert 0 < (phase == phase[-1]).sum() < len(phase)


def test_prop_the_commands_validation(card: td.Card, tmp_path: Path) -> None:
    stand(seed=6, seconds=20.0).to_pandas().to_csv(tmp_path / "unseen.csv", index=False, float_format="%.17g")
    card.save(tmp_path / "card.toml")
    command("validate", "card.toml", "unseen.csv", "--out", "out", cwd=tmp_path)
    theirs = json.loads((tmp_path / "out/results.json").read_text())["results"][0]
    (ours,) = td.validate(card, td.read(tmp_path / "unseen.csv"))
    assert ours.measured == theirs["measured"] and ours.seen == theirs["seen"]
    assert np.nanmax(np.abs(ours.predicted_n - ours.measured_n)) == ours.measured["worst"]


VEHICLE = {"flight": {"mass_kg": 0.03, "rotor_radius_m": 0.023}}


@pytest.fixture()
def flights(tmp_path: Path) -> tuple[list[Path], Path]:
    """Three measured flights and their map; the vehicle's settings lie in the folder."""
    project = Path(__file__).resolve().parents[2]
    data = os.environ.get("TOUCHDOWN_DATA") or project.parent / "shared/data"
    folder = Path(data) / "flight-crazypad-takeoff-landing"
    if not folder.is_dir():
        pytest.skip(f"no data at {folder}")
    (tmp_path / "vehicle.toml").write_text("[flight]\nmass_kg = 0.03\nrotor_radius_m = 0.023\n")
    mapped = project / "examples/maps/flight-crazypad-motor.toml"
    return [folder / f"E9_log0{k}_motor.csv" for k in range(3)], mapped


def assert_same_card(ours: td.Card, path: Path) -> None:
    """All that a card says of the vehicle is what the command's says."""
    theirs = td.Card.load(path).to_dict()
    for key in ("terms", "scores", "validity", "vehicle", "warnings", "form"):
        assert ours.to_dict()[key] == theirs[key], key


def test_prop_the_commands_ground_effect_of_flights(flights: tuple[list[Path], Path], tmp_path: Path) -> None:
    logs, mapped = flights
    command("identify", "ground-effect", *logs, "--map", mapped, "--settings", "vehicle.toml", "--out", "card.toml", cwd=tmp_path)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", td.SindyWarning)
        assert_same_card(td.identify.ground_effect(td.read(logs, map=mapped), settings=VEHICLE), tmp_path / "card.toml")


@pytest.mark.parametrize("form", [None, "first_order"])
def test_prop_the_commands_thrust_of_flights(flights: tuple[list[Path], Path], tmp_path: Path, form: str | None) -> None:
    logs, mapped = flights
    asked = [] if form is None else ["--form", form]
    command("identify", "thrust", *logs, "--map", mapped, "--settings", "vehicle.toml", *asked, "--out", "card.toml", cwd=tmp_path)
    settings = VEHICLE if form is None else {**VEHICLE, "thrust": {"form": form}}
    with pytest.warns(td.SindyWarning, match="thrust is 0.03 kg times specific force in"):
        ours = td.identify.thrust(td.read(logs, map=mapped), settings=settings)
    assert_same_card(ours, tmp_path / "card.toml")


def test_prop_a_card_is_an_equation(card: td.Card) -> None:
    latex = card.to_latex(3)
    assert latex.startswith(r"\begin{aligned}") and "T &=" in latex and "p_" not in latex
    rest = card.thrust_at_rest([[0.3, 0.5]])
    assert rest.shape == (1, 2) and abs(rest[0, 1] - 20.0 * 0.5**2) < 0.1


# Seconds of landings in one call; says how long it took to stop after a Ctrl-C.
_INTERRUPTED = """
import os, sys, time, signal, threading, touchdown as td
signal.signal(signal.SIGINT, signal.default_int_handler)
at = []
def interrupt():
    at.append(time.monotonic())
    signal.raise_signal(signal.SIGINT)
threading.Timer(0.7, interrupt).start()
try:
    td.land({"scenario": {"timeout_s": 30.0}}, space=True, trials=3000)
    print("finished")
except KeyboardInterrupt:
    print(time.monotonic() - at[0])
sys.stdout.flush()
os._exit(0)
"""


@pytest.mark.skipif(sys.platform == "win32", reason="signals of Unix")
def test_prop_ctrl_c_stops_landings_at_once() -> None:
    done = subprocess.run([sys.executable, "-c", _INTERRUPTED], capture_output=True, text=True, timeout=300)
    waited = done.stdout.strip()
    assert waited != "finished", "the landings were over before they were interrupted"
    # 0.2 s is what is promised; a loaded machine may schedule late.
    assert float(waited) < 1.0, done


def test_prop_faults_of_landings_are_named(card: td.Card) -> None:
    with pytest.raises(td.SindyError, match="`grid`: expected one point, found 2"):
        td.Space("sea", {"grid": {"timeout_s": [20.0, 30.0]}})
    cases = [
        (lambda: td.land(), "thrust"),
        (lambda: td.land({"scenarios": {}}, space=True), "scenarios"),
        (lambda: td.land({"scenario": {"timeout_s": -1.0}}, space=True), "timeout_s"),
        (lambda: td.land(thrust=card, controllers=["dynamic"]), "cards"),
        (lambda: td.land(thrust=card, controllers=["observer"]), "controllers"),
        (lambda: td.land("nothing.toml", space=True), "scenario"),
        (lambda: td.validate(card, []), "trials"),
    ]
    for case, key in cases:
        with pytest.raises(td.SindyError) as caught:
            case()
        assert key in caught.value.key and caught.value.found, (caught.value.key, str(caught.value))


def test_prop_landings_trials_and_scenarios_are_pickled(card: td.Card, tmp_path: Path) -> None:
    def again(value: object) -> Any:
        return pickle.loads(pickle.dumps(value))

    keys = {"trials": 3, "scenario": {"timeout_s": 30.0}, "grid": {"control.controller": ["observer", "feedback"]}}
    for landings in (td.land(keys, space=True, seed=4), td.land({"trials": 3}, thrust=card, traces=1, controllers=["feedback", "ssc"])):
        other = again(landings)
        assert repr(other) == repr(landings) and other.results == landings.results and other.scenario == landings.scenario
        assert list(other) == list(landings)
        for name in landings:
            np.testing.assert_array_equal(other[name], landings[name])
        for row in (0, 3):
            for name, values in landings.trace(row).items():
                np.testing.assert_array_equal(other.trace(row)[name], values)
    with pytest.raises(td.SindyError, match="keeps its series"):
        other.trace(1)
    space = td.Space("sea", seed=3)
    landing, same = space.land(5), again(space).land(5)
    # As text: NaN is no number's equal.
    assert str(dict(same)) == str(dict(landing)) and repr(again(landing)) == repr(landing)
    np.testing.assert_array_equal(again(landing).trace()["position_m"], landing.trace()["position_m"])
    trial = stand(seconds=5.0)
    trial.to_pandas().to_csv(tmp_path / "log.csv", index=False)
    for of in (trial, td.read(tmp_path / "log.csv")[0]):
        other = again(of)
        assert repr(other) == repr(of) and other.warnings == of.warnings and other._native.rows == of._native.rows
        for name in of:
            np.testing.assert_array_equal(other[name], of[name])
    campaign = td.campaign({"trials": 2, "block": 1, "scenario": {"timeout_s": 30.0}}, tmp_path / "campaign")
    assert again(campaign).folder == campaign.folder and again(campaign).results == campaign.results


@pytest.mark.parametrize("value", [-1, 1.5, "two", True, 2**64])
def test_prop_numbers_that_are_not_whole_are_named(card: td.Card, tmp_path: Path, value: Any) -> None:
    sweep = {"trials": 1, "block": 1}
    for key, call in {
        "trials": lambda: td.land(sweep, space=True, trials=value),
        "seed": lambda: td.land(sweep, space=True, seed=value),
        "traces": lambda: td.land(thrust=card, traces=value),
        "trial": lambda: td.Space("still").land(value),
        "landing": lambda: td.land(sweep, space=True).trace(value),
    }.items():
        with pytest.raises(td.SindyError) as caught:
            call()
        assert caught.value.key == key and caught.value.expected.startswith("a whole number"), str(caught.value)
    with pytest.raises(td.SindyError, match="`seed`"):
        td.campaign(sweep, tmp_path / "out", seed=value)
    assert not (tmp_path / "out").exists()
