"""The paper's experiments from Python: the command's bytes, tables, cards, figures."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import touchdown as td


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> td.Reproduction:
    """The smallest run: a landing of each method, few trials of the rig."""
    told: list[tuple[str, int, int]] = []
    out = tmp_path_factory.mktemp("run") / "out"
    made = td.reproduce(out, {"trials": 1}, quick=True, seed=7, progress=lambda *at: told.append(at))
    assert made.folder == str(out) and len({stage for stage, _, _ in told}) > 2
    assert all(done <= steps for _, done, steps in told)
    return made


def test_xval_the_files_are_those_of_the_command(run: td.Reproduction, tmp_path: Path) -> None:
    command = os.environ.get("TOUCHDOWN_COMMAND")
    if not command:
        pytest.skip("TOUCHDOWN_COMMAND names no command to compare with")
    arguments = ["reproduce", "--quick", "--trials", "1", "--seed", "7", "--quiet", "--out", str(tmp_path)]
    subprocess.run([command, *arguments], check=True, capture_output=True)
    own = Path(run.folder)
    names = sorted(p.relative_to(tmp_path) for p in tmp_path.rglob("*") if p.is_file())
    assert names == sorted(p.relative_to(own) for p in own.rglob("*") if p.is_file())
    # Both are compiled from the same sources, and a run is a pure function of its settings.
    differ = [name for name in names if (own / name).read_bytes() != (tmp_path / name).read_bytes()]
    assert Path("results.json") in names and differ == []


def test_prop_tables_hold_what_the_results_count(run: td.Reproduction) -> None:
    landings, sea = run.landings, run.sea
    assert set(landings["experiment"]) == {
        "ground_landing",
        "deck_landing_with_acceleration",
        "deck_landing_without_acceleration",
    }
    on_deck = landings["experiment"] == "deck_landing_with_acceleration"
    for method, figures in run.results["deck_landing"]["with_acceleration"].items():
        own = on_deck & (landings["method"] == method)
        assert own.sum() == 1 and (landings["outcome"][own] == "landed").sum() == figures["landed"]
        assert np.isfinite(landings["v_l_mps"][own]).sum() == figures["landed"]
    assert landings["trial"].dtype == np.int64 and landings["t_l_s"].dtype == np.float64
    for deck, ways in run.results["sea"]["decks"].items():
        for how, figures in ways.items():
            rows = (sea["case"] == deck) & (sea["how"] == how)
            landed = 0 if figures["landed"] is None else figures["landed"]["count"]
            assert rows.sum() == 1 and (sea["outcome"][rows] == "landed").sum() == landed
    errors = run.errors
    row = (errors["data"] == "rich_data") & (errors["model"] == "lag") & (errors["trial"] == "sine")
    expected = run.results["ground_effect"]["rich_data"]["lag"]["sine"]
    assert row.sum() == 1 and errors["mae_n"][row][0] == expected["mae_n"]
    assert len(errors.to_pandas()) == len(errors["mae_n"]) == errors.to_polars().height == errors.to_arrow().num_rows


def test_prop_cards_trials_figures_and_report_are_those_of_the_folder(run: td.Reproduction) -> None:
    cards = run.cards
    assert {"paper-eq11", "paper-eq12"} < set(cards)
    assert {card.kind for card in cards.values()} == {"thrust", "ground_effect"}
    sets = run.trial_sets
    trial = run.trials(sets[0])[0]
    assert "throttle" in trial and len(sets) == 8
    with pytest.raises(td.SindyError, match="one of " + sets[0]):
        run.trials("none")
    assert all(svg.startswith("<svg") for svg in run.figures.values()) and len(run.figures) > 5
    assert run.html.startswith("<!DOCTYPE html>") and Path(run.report).read_text() == run.html
    again = td.Reproduction(run.folder)
    assert again.results == run.results and repr(again) == "Reproduction(seed 7, 1 landings of each method, quick)"


def test_prop_faults_are_told_before_the_work(tmp_path: Path) -> None:
    with pytest.raises(td.SindyError, match="key `trials`: expected 1 to 100000, found 0"):
        td.reproduce(tmp_path / "a", {"trials": 0})
    with pytest.raises(td.SindyError, match="colour"):
        td.reproduce(tmp_path / "a", {"colour": 3})
    file = tmp_path / "s.toml"
    file.write_text("trials = 4\nseed = -1\n")
    with pytest.raises(td.SindyError, match="s.toml"):
        td.reproduce(tmp_path / "a", file)
    with pytest.raises(td.SindyError, match="expected a folder, found a file"):
        td.reproduce(file, quick=True)
    with pytest.raises(td.SindyError, match="results.json"):
        td.Reproduction(tmp_path)
    assert not (tmp_path / "a").exists()


# Interrupted by another thread, which only runs where the lock is released.
_INTERRUPTED = """
import os, signal, sys, threading, time
import touchdown as td
signal.signal(signal.SIGINT, signal.default_int_handler)  # a job in the background starts with it ignored
at = []
def interrupt():
    at.append(time.monotonic())
    signal.raise_signal(signal.SIGINT)
threading.Timer(0.5, interrupt).start()
try:
    td.reproduce(sys.argv[1])
    print("finished")
except KeyboardInterrupt:
    print(time.monotonic() - at[0])
sys.stdout.flush()
os._exit(0)
"""


@pytest.mark.skipif(sys.platform == "win32", reason="signals of Unix")
def test_prop_ctrl_c_stops_a_run_at_once(tmp_path: Path) -> None:
    command = [sys.executable, "-c", _INTERRUPTED, str(tmp_path)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=300)
    waited = done.stdout.strip()
    assert waited != "finished", "the run was over before it was interrupted"
    # 0.2 s is what is promised; a loaded machine may schedule late.
    assert float(waited) < 1.0, done
    assert not (tmp_path / "results.json").exists()


def test_prop_an_error_of_progress_ends_the_run(tmp_path: Path) -> None:
    class Enough(Exception):
        pass

    def stop(stage: str, done: int, steps: int) -> None:
        raise Enough(json.dumps([stage, done, steps]))

    with pytest.raises(Enough):
        td.reproduce(tmp_path, progress=stop)
    assert not (tmp_path / "results.json").exists()
