"""Campaigns in object storage, on a local server that speaks the protocol of Amazon S3."""

from __future__ import annotations

import json
import multiprocessing
import os
import subprocess
from collections.abc import Iterator
from concurrent.futures import Executor, ProcessPoolExecutor
from pathlib import Path
from typing import Any

import pytest
from test_campaign import SWEEP, Dying, files, unix, whole

import touchdown as td

boto3 = pytest.importorskip("boto3")
server = pytest.importorskip("moto.server")

__all__ = ["whole"]


class Bucket:
    """A bucket of the server, read by another client than ours: Amazon's own."""

    name = "campaigns"

    def __init__(self, endpoint: str) -> None:
        self.client = boto3.client("s3", endpoint_url=endpoint)
        self.client.create_bucket(Bucket=self.name)

    def address(self, prefix: str) -> str:
        return f"s3://{self.name}/{prefix}"

    def files(self, prefix: str) -> dict[str, bytes]:
        pages = self.client.get_paginator("list_objects_v2").paginate(Bucket=self.name, Prefix=f"{prefix}/")
        keys = [of["Key"] for page in pages for of in page.get("Contents", [])]
        got = {key: self.client.get_object(Bucket=self.name, Key=key)["Body"].read() for key in keys}
        return {key.removeprefix(f"{prefix}/"): body for key, body in got.items()}

    def remove(self, key: str) -> None:
        self.client.delete_object(Bucket=self.name, Key=key)

    def put(self, key: str, body: bytes) -> None:
        self.client.put_object(Bucket=self.name, Key=key, Body=body)


@pytest.fixture(scope="module")
def bucket() -> Iterator[Bucket]:
    running = server.ThreadedMotoServer(ip_address="127.0.0.1", port=0, verbose=False)
    running.start()
    host, port = running.get_host_and_port()
    endpoint = f"http://{host}:{port}"
    with pytest.MonkeyPatch.context() as environment:
        for name, value in {
            "AWS_ACCESS_KEY_ID": "tester",
            "AWS_SECRET_ACCESS_KEY": "secret",
            "AWS_REGION": "us-east-1",
            "AWS_DEFAULT_REGION": "us-east-1",
            "AWS_ENDPOINT_URL": endpoint,
        }.items():
            environment.setenv(name, value)
        yield Bucket(endpoint)
    running.stop()


def test_prop_a_campaign_in_a_bucket_goes_on_and_has_the_bytes_of_a_folder(whole: Path, bucket: Bucket) -> None:
    class Enough(Exception):
        pass

    def few(there: int, _of: int) -> None:
        if there >= 12:
            raise Enough

    out = bucket.address("a/campaign")
    with pytest.raises(Enough):
        td.campaign(SWEEP, out, progress=few, n_jobs=1)
    status = td.campaign_status(out)
    assert 0 < status["blocks_there"] < 8 and status["rows"] == 6 * status["blocks_there"]
    assert "results.json" not in bucket.files("a/campaign")
    with pytest.raises(td.SindyError, match="resume"):
        td.campaign(SWEEP, out, resume=False)
    with pytest.raises(td.SindyError, match="other settings"):
        td.campaign(SWEEP, out, seed=2)
    campaign = td.campaign(SWEEP, out)
    assert campaign.folder == out
    assert bucket.files("a/campaign") == files(whole)
    assert td.Campaign.read(out).results == campaign.results
    report = campaign.report()
    assert report == f"{out}/report.html" and "report.html" in bucket.files("a/campaign")


@unix
def test_prop_a_killed_worker_changes_no_byte_in_a_bucket(whole: Path, bucket: Bucket, tmp_path: Path) -> None:
    made: list[ProcessPoolExecutor] = []

    def make() -> Executor:
        made.append(ProcessPoolExecutor(2, mp_context=multiprocessing.get_context("spawn")))
        return Dying(made[-1], tmp_path / "marker")

    td.dist.campaign(make, SWEEP, bucket.address("killed"))
    # The first worker died; another pool flew what was missing.
    assert int((tmp_path / "marker").read_text().split()[1]) != os.getpid() and len(made) == 2
    assert bucket.files("killed") == files(whole)


def test_xval_the_command_writes_the_same_into_a_bucket_and_a_folder(whole: Path, bucket: Bucket, tmp_path: Path) -> None:
    command = os.environ.get("TOUCHDOWN_COMMAND")
    if not command:
        pytest.skip("TOUCHDOWN_COMMAND names no command")

    def run(*arguments: Any, status: int = 0) -> subprocess.CompletedProcess[str]:
        words = [command, "campaign", *map(str, arguments), "--quiet"]
        done = subprocess.run(words, capture_output=True, text=True, timeout=300)
        assert done.returncode == status, done.stderr
        return done

    sweep, out = whole / "sweep.toml", bucket.address("by/command")
    run(sweep, "--out", tmp_path / "folder")
    # A part, then the others.
    run(sweep, "--blocks", "0..3", "--out", out)
    there = json.loads(run("status", out, "--json").stdout)
    assert there["missing"] == [[3, 8]] and there == td.campaign_status(out)
    run(sweep, "--out", out, "--resume")
    assert bucket.files("by/command") == files(tmp_path / "folder")
    # Merges go both ways.
    run("merge", out, "--out", tmp_path / "merged")
    run("merge", tmp_path / "merged", "--out", bucket.address("merged"))
    assert bucket.files("merged") == files(tmp_path / "merged") == files(tmp_path / "folder")
    # A block that is broken is named by its address.
    bucket.put("merged/landings/block-000002.parquet", b"PAR1")
    broken = json.loads(run("status", bucket.address("merged"), "--json", status=3).stdout)["broken"]
    assert [of["block"] for of in broken] == [2] and bucket.address("merged/landings/block-000002.parquet") in broken[0]["error"]
    bucket.remove("merged/sweep.toml")
    missing = run("status", bucket.address("merged"), status=1).stderr
    assert bucket.address("merged/sweep.toml") in missing
    nowhere = run(sweep, "--out", "s3://no-such-bucket/x", status=1).stderr
    assert "s3://no-such-bucket/x" in nowhere and nowhere.count("\n") == 1
    assert "expected a folder, or an address" in run(sweep, "--out", "ftp://host/x", status=2).stderr
