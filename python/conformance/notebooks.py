"""Runs PySINDy's own notebooks under PySINDy and under ``sindy.pysindy``, and prints a table of both.

    python python/conformance/notebooks.py FOLDER [--limit SECONDS] [--only TEXT] [--errors]

FOLDER holds notebooks, also in folders below it. PySINDy's repository has them in ``examples`` and ``docs``:
``git clone --branch v2.1.0 https://github.com/dynamicslab/pysindy``. They are executed in a copy of FOLDER, which is deleted.

One line differs between the two runs. Where ``import pysindy as ps`` is a notebook's only import of PySINDy, that line becomes
``from sindy import pysindy as ps``. Otherwise the line ``import sindy.pysindy.drop_in`` is set before everything else.

The interpreter needs ``sindy``, PySINDy 2.1.0, nbclient, ipykernel and what the notebooks import themselves. The result is 0
where every notebook that runs under PySINDy runs under ``sindy.pysindy``.
"""

from __future__ import annotations

import argparse
import math
import re
import shutil
import sys
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import nbformat
from nbclient import NotebookClient
from nbclient.exceptions import CellExecutionError, CellTimeoutError, DeadKernelError

IMPORT = "import pysindy as ps"
REPLACED = "from sindy import pysindy as ps"
DROP_IN = "import sindy.pysindy.drop_in"
NUMBER = re.compile(r"-?\d+(?:\.\d+)?(?:e[-+]?\d+)?")


@dataclass
class Outcome:
    """How one execution of a notebook ended."""

    seconds: float
    errors: list[str]
    printed: list[str]

    def __str__(self) -> str:
        if not self.errors:
            return "yes"
        return ("" if len(self.errors) == 1 else f"{len(self.errors)} cells fail, ") + self.errors[0]


def use_layer(code: list[Any], folder: Path) -> None:
    """Changes the one line that makes a notebook's cells use the layer."""
    beside = [path.read_text() for path in folder.glob("*.py")]
    imports = re.findall(r"^\s*(?:import|from)\s+pysindy.*$", "\n".join([*(cell.source for cell in code), *beside]), flags=re.M)
    if [line.strip() for line in imports] == [IMPORT]:
        for cell in code:
            cell.source = cell.source.replace(IMPORT, REPLACED)
    else:
        code[0].source = f"{DROP_IN}\n{code[0].source}"


def execute(path: Path, layer: bool, limit_s: float, every_cell: bool = False) -> Outcome:
    """Executes a notebook in its folder, at most for a given time."""
    notebook = nbformat.read(path, as_version=4)
    code = [cell for cell in notebook.cells if cell.cell_type == "code"]
    for cell in code:
        cell.outputs = []
    if layer:
        use_layer(code, path.parent)
    start = time.monotonic()
    client = NotebookClient(
        notebook,
        kernel_name="python3",
        allow_errors=every_cell,
        timeout_func=lambda _: max(1, int(limit_s - (time.monotonic() - start))),
        resources={"metadata": {"path": str(path.parent)}},
    )
    errors = []
    try:
        client.execute()
    except CellExecutionError:
        pass  # it stands in the cell's output
    except CellTimeoutError:
        errors.append(f"not done after {limit_s:g} s")
    except DeadKernelError:
        errors.append("the kernel died")
    seconds = time.monotonic() - start
    errors = [f"cell {k} of {len(code)}: {text}" for k, cell in enumerate(code, 1) for text in raised(cell)] + errors
    return Outcome(seconds, errors, [printed(cell) for cell in code])


def raised(cell: Any) -> list[str]:
    """The error that a cell raised, in one line."""
    found = [one for one in cell.outputs if one.output_type == "error"]
    return [f"{one.ename}: {(one.evalue.strip().splitlines() or [''])[0]}" for one in found[:1]]


def printed(cell: Any) -> str:
    """What a cell printed on its standard output."""
    return "".join(one.text for one in cell.outputs if one.output_type == "stream" and one.name == "stdout")


def same_text(theirs: Outcome, ours: Outcome) -> str:
    """In how many of the cells that print under PySINDy the same words are printed, and numbers within 0.1 %."""
    pairs = [(a, b) for a, b in zip(theirs.printed, ours.printed) if a.strip()]
    return f"{sum(alike(a, b) for a, b in pairs)} of {len(pairs)}"


def alike(one: str, other: str) -> bool:
    """Whether two texts have the same words, and numbers within 0.1 %."""
    if NUMBER.sub("0", one) != NUMBER.sub("0", other):
        return False
    pairs = zip(NUMBER.findall(one), NUMBER.findall(other))
    return all(math.isclose(float(a), float(b), rel_tol=1e-3) for a, b in pairs)


def main() -> int:
    """Runs and prints."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--limit", type=float, default=600.0, metavar="SECONDS", help="for one run of one notebook (600)")
    parser.add_argument("--only", default="", metavar="TEXT", help="notebooks whose path has this text")
    parser.add_argument("--errors", action="store_true", help="execute cells after one that failed, too, and write all errors")
    given = parser.parse_args()
    failed = False
    print("| notebook | runs with PySINDy | s | runs with sindy.pysindy | s | cells that print the same |")
    print("| --- | --- | --- | --- | --- | --- |", flush=True)
    with tempfile.TemporaryDirectory() as temporary:
        copy = Path(shutil.copytree(given.folder, Path(temporary, "notebooks"), ignore=shutil.ignore_patterns(".git")))
        for path in sorted(copy.rglob("*.ipynb")):
            name = str(path.relative_to(copy))
            if given.only not in name or ".ipynb_checkpoints" in name:
                continue
            theirs, ours = (execute(path, layer, given.limit, given.errors) for layer in (False, True))
            if given.errors:
                for tool, outcome in (("pysindy", theirs), ("sindy.pysindy", ours)):
                    for error in outcome.errors:
                        print(f"{name}, {tool}: {error}", file=sys.stderr, flush=True)
            failed |= bool(ours.errors) and not theirs.errors
            cells = [name, theirs, f"{theirs.seconds:.1f}", ours, f"{ours.seconds:.1f}", same_text(theirs, ours)]
            print("|", " | ".join(str(cell).replace("|", "\\|") for cell in cells), "|", flush=True)
    return int(failed)


if __name__ == "__main__":
    sys.exit(main())
