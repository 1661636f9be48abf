"""Campaigns: many landings in a folder of blocks."""

from __future__ import annotations

import json
import os
import re
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from sindy import _native
from sindy._errors import whole
from sindy._solvers import threads

from ._land import Landings, Scenario, _given
from ._trial import Path

Progress = Callable[[int, int], object]


class Campaign(Landings):
    """All landings of a campaign, read from its folder.

    Attributes
    ----------
    folder : str
        Where its blocks are: a folder, or an address in object storage.
    """

    def __init__(self, native: _native.SpaceLandings, folder: str) -> None:
        super().__init__(native)
        self.folder = folder

    @classmethod
    def read(cls, folder: Path, n_jobs: int | None = None) -> Campaign:
        """A complete campaign from its folder, whoever flew it."""
        at = _place(folder)
        return cls(_native.campaign_read(at, threads(n_jobs)), at)

    def report(self, folder: Path | None = None, *, n_jobs: int | None = None) -> str:
        """Writes ``report.html`` and ``figures/`` into a folder, by default the campaign's, as the command does; the report's path."""
        if folder is not None:
            return super().report(folder, n_jobs=n_jobs)
        _native.campaign_report(self.folder, threads(n_jobs))
        return f"{self.folder}/report.html" if _is_address(self.folder) else os.path.join(self.folder, "report.html")

    def __repr__(self) -> str:
        return f"Campaign({len(self.landed)} landings, {int(self.landed.sum())} landed)"


@dataclass(frozen=True)
class _Begun:
    """A campaign whose folder is there."""

    folder: str
    sha256: str
    landings: int
    block: int
    missing: list[int]

    def there(self) -> int:
        """Landings that were there."""
        return self.landings - sum(self.rows(block) for block in self.missing)

    def rows(self, block: int) -> int:
        """Landings of a block."""
        return min(self.block, self.landings - block * self.block)

    def seen(self) -> set[int]:
        """The blocks that are there now: they appear whole."""
        return set(_native.campaign_blocks(self.folder))

    def read(self, jobs: int | None) -> Campaign:
        """The complete campaign, its figures written."""
        native = _native.campaign_read(self.folder, jobs)
        native.write_results(self.folder)
        return Campaign(native, self.folder)


def _is_address(place: str) -> bool:
    """Whether a place is an address in object storage, also as ``pathlib`` writes it: ``s3:/bucket``, which is refused."""
    return re.match(r"\s*([A-Za-z][A-Za-z0-9+.-]*://|(s3|gs|az):)", place, re.IGNORECASE) is not None


def _place(place: Path) -> str:
    """A folder as an absolute path; an address as it is."""
    at = os.fspath(place)
    return at if _is_address(at) else os.path.abspath(at)


def _begin(
    sweep: Scenario, out: Path, trials: int | None, seed: int | None, resume: bool, jobs: int | None
) -> _Begun:
    file, keys = _given(sweep)
    folder = _place(out)
    trials, seed = whole("trials", trials, 1), whole("seed", seed)
    return _Begun(folder, *_native.campaign_begin(file, keys, folder, trials, seed, resume, jobs))


def _ranges(blocks: list[int], most: int) -> list[tuple[int, int]]:
    """Increasing blocks as ranges of at most so many neighbours, from the first to before the second."""
    ranges: list[tuple[int, int]] = []
    for block in blocks:
        if ranges and ranges[-1][1] == block and block - ranges[-1][0] < most:
            ranges[-1] = (ranges[-1][0], block + 1)
        else:
            ranges.append((block, block + 1))
    return ranges


def campaign(
    sweep: Scenario,
    out: Path,
    *,
    trials: int | None = None,
    seed: int | None = None,
    resume: bool = True,
    progress: Progress | None = None,
    n_jobs: int | None = None,
) -> Campaign:
    """Flies a campaign as the command ``touchdown campaign`` does: a folder of blocks, each a Parquet file.

    A block that is there is not flown again, so the same call goes on after an interruption. The bytes do not depend on
    threads or interruptions, and are those of the command; its report and figures are not written.

    Parameters
    ----------
    sweep : path or mapping
        The keys of ``touchdown settings campaign``: a TOML file, or nested dictionaries.
    out : path
        The folder, or an address in object storage: ``s3://bucket/name``, ``gs://bucket/name`` or ``az://container/name``.
        Keys and endpoints are those of the environment: ``AWS_ACCESS_KEY_ID``, ``AWS_SECRET_ACCESS_KEY``, ``AWS_REGION``,
        ``AWS_ENDPOINT_URL``; ``GOOGLE_APPLICATION_CREDENTIALS``; ``AZURE_STORAGE_ACCOUNT_NAME``,
        ``AZURE_STORAGE_ACCOUNT_KEY``.
    trials, seed : int, optional
        Those of the sweep if not given.
    resume : bool
        Whether landings of this campaign may be in the folder already; those of other settings are always refused.
    progress : callable, optional
        Called with the landings that are there and those of the campaign, some twenty times a second. What it raises
        ends the campaign.
    n_jobs : int, optional
        Threads.

    Returns
    -------
    Campaign
        The table of landings with `folder`, `results` and `trace`. ``Campaign.read`` reads it again.

    Examples
    --------
    >>> import tempfile, touchdown as td
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     sweep = {"trials": 2, "block": 1, "scenario": {"timeout_s": 30.0}}
    ...     td.campaign(sweep, folder), td.campaign_status(folder)["blocks_there"]
    (Campaign(2 landings, 2 landed), 2)
    """
    jobs = threads(n_jobs)
    begun = _begin(sweep, out, trials, seed, resume, jobs)
    there = begun.there()
    for first, end in _ranges(begun.missing, begun.landings):
        base = there

        def look(flown: int, base: int = base) -> None:
            if progress is not None:
                progress(base + flown, begun.landings)

        _native.campaign_fly(begun.folder, begun.sha256, first, end, jobs, look)
        there += sum(begun.rows(block) for block in range(first, end))
    if progress is not None:
        progress(there, begun.landings)
    return begun.read(jobs)


def campaign_status(folder: Path, n_jobs: int | None = None) -> dict[str, Any]:
    """What of a campaign is in its folder or at its address: that of ``touchdown campaign status --json``.

    ``blocks_there``, ``blocks``, ``missing`` (ranges, from the first to before the second), ``broken``, ``rows``,
    ``landings``, ``complete``.
    """
    out: dict[str, Any] = json.loads(_native.campaign_status(_place(folder), threads(n_jobs)))
    return out
