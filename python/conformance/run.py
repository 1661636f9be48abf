"""Runs the tests of PySINDy 2.1.0 against ``sindy.pysindy`` and compares with ``expected.toml``.

    python python/conformance/run.py [--sdist pysindy-2.1.0.tar.gz] [--write]

The tests come from PySINDy's source distribution: a file, or what pip downloads. Nothing of it is kept. The interpreter has to
have ``sindy``, pytest, scikit-learn, SciPy and ``derivative``. The result is 0 where every outcome is the expected one.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tarfile
import tempfile
import tomllib
from collections import Counter
from pathlib import Path

HERE = Path(__file__).resolve().parent
EXPECTED = HERE / "expected.toml"
# Tests of whole files for kinds that are not there (deeptime, notebooks) and of a class of arrays that is
# PySINDy's own (axes) are not run; neither are those of right-hand sides (odes), which are the tests' own data.
FILES = [
    "test_pysindy.py",
    "test_sindyc.py",
    "test_feature_library.py",
    "test_differentiation.py",
    "test_optimizers/test_optimizers.py",
    "test_optimizers/test_trapping.py",
    "utils/test_utils.py",
]
HEAD = """\
# Outcomes of PySINDy 2.1.0's own tests against sindy.pysindy, written by `python python/conformance/run.py --write`.
# Tests that pass are listed by file; every other test has its reason. Reasons of deviations on purpose are in `reasons`, by the
# start of the test's name, and are kept by --write.
"""


def download(folder: Path) -> Path:
    """The source distribution, by pip."""
    subprocess.run(
        [sys.executable, "-m", "pip", "download", "--quiet", "--no-deps", "--no-binary", "pysindy", "pysindy==2.1.0", "-d", folder],
        check=True,
    )
    return next(folder.glob("pysindy-*.tar.gz"))


def run(archive: Path, folder: Path) -> dict[str, str]:
    """The outcome of each test."""
    with tarfile.open(archive) as tar:
        tar.extractall(folder, filter="data")
    root = folder / "pysindy-2.1.0"
    result = folder / "outcomes.json"
    paths = [str(HERE), *filter(None, [os.environ.get("PYTHONPATH")])]
    paths = [str(Path(one).resolve()) for one in os.pathsep.join(paths).split(os.pathsep)]
    environment = os.environ | {
        "PYSINDY_SDIST": str(root), "PYSINDY_OUTCOMES": str(result), "PYTHONPATH": os.pathsep.join(paths),
    }  # fmt: skip
    command = [sys.executable, "-m", "pytest", "-q", "-p", "shim", "-p", "no:cacheprovider", "-c", os.devnull, "--rootdir", "."]
    command += ["--tb=no", "-W", "ignore", *FILES]
    # Its summary counts what is expected to fail; it is printed only where the run did not come to its end.
    done = subprocess.run(command, cwd=root / "test", env=environment, check=False, capture_output=True, text=True)
    if not result.is_file():
        raise SystemExit(f"PySINDy's tests did not run:\n{done.stdout}{done.stderr}")
    outcomes: dict[str, str] = json.loads(result.read_text())
    return outcomes


def explained(outcomes: dict[str, str], reasons: dict[str, str]) -> dict[str, str]:
    """Outcomes with the errors of deviations on purpose replaced by their reasons."""
    out = {}
    for test, outcome in outcomes.items():
        name = test.split("::", 1)[1]
        if outcome != "pass" and not outcome.startswith("absent"):
            known = [start for start in reasons if name.startswith(start)]
            outcome = f"on purpose: {max(known, key=len)}" if known else f"failed: {outcome}"
        out[test] = outcome
    return out


def write(outcomes: dict[str, str], reasons: dict[str, str]) -> None:
    """The list of expected outcomes."""
    lines = [HEAD, "[reasons]", *(f"{json.dumps(k)} = {json.dumps(v)}" for k, v in reasons.items())]
    for file in FILES:
        lines += ["", f"[{json.dumps(file)}]"]
        found = {k.split("::", 1)[1]: v for k, v in outcomes.items() if k.split("::", 1)[0] == file}
        lines.append("pass = [")
        for name in sorted(name for name, outcome in found.items() if outcome == "pass"):
            entry = json.dumps(name) + ","
            together = f"{lines[-1]} {entry}"
            if lines[-1].startswith("  ") and len(together) <= 130:
                lines[-1] = together
            else:
                lines.append("  " + entry)
        lines.append("]")
        lines += [f"{json.dumps(k)} = {json.dumps(v)}" for k, v in sorted(found.items()) if v != "pass"]
    EXPECTED.write_text("\n".join(lines) + "\n")


def read() -> tuple[dict[str, str], dict[str, str]]:
    """The expected outcome of each test, and the reasons."""
    known = tomllib.loads(EXPECTED.read_text()) if EXPECTED.exists() else {}
    reasons = known.pop("reasons", {})
    expected = {}
    for file, tests in known.items():
        passing = dict.fromkeys(tests.pop("pass", []), "pass")
        expected |= {f"{file}::{name}": value for name, value in (tests | passing).items()}
    return expected, reasons


def main() -> int:
    """Runs and compares."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--sdist", type=Path)
    parser.add_argument("--write", action="store_true", help="write the list of expected outcomes")
    given = parser.parse_args()
    expected, reasons = read()
    with tempfile.TemporaryDirectory() as folder:
        archive = given.sdist or download(Path(folder))
        outcomes = explained(run(archive, Path(folder)), reasons)
    if given.write:
        write(outcomes, reasons)
        expected, _ = read()
    for file in FILES:
        kinds = Counter(v.split(":")[0] for k, v in outcomes.items() if k.split("::")[0] == file)
        print(f"{file}: {dict(kinds)}")
    print("all:", dict(Counter(v.split(":")[0] for v in outcomes.values())))
    other = {k for k in expected.keys() | outcomes.keys() if expected.get(k) != outcomes.get(k)}
    for test in sorted(other):
        print(f"{test}: expected {expected.get(test, 'not listed')}; found {outcomes.get(test, 'not run')}")
    return 1 if other else 0


if __name__ == "__main__":
    sys.exit(main())
