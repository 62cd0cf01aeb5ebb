"""Logs on a store that speaks S3: read, done again when replaced, and rows of their wells where they are missing."""

import json
import os
import re
import shutil
from collections.abc import Iterator
from pathlib import Path

import fsspec
import pandas as pd
import pytest

from drillid.config.settings import SimulateSettings
from drillid.demo.wells import write_demo_log
from tests.s3 import BUCKET, store
from tests.workflow.forked import snakemake
from tests.workflow.toys import ROOT

LOG = "D03_20250601T0600.csv.gz"


@pytest.fixture
def environment(monkeypatch: pytest.MonkeyPatch) -> Iterator[dict[str, str]]:
    with store() as found:
        for name, value in found.items():
            monkeypatch.setenv(name, value)
        yield found


def put(path: Path) -> None:
    """The log as an object of the bucket."""
    fsspec.filesystem("s3", skip_instance_cache=True).put_file(str(path), f"{BUCKET}/raw/{LOG}")


def run(folder: Path, *words: str, expect: int = 0) -> str:
    command = ["--snakefile", str(ROOT / "Snakefile"), "--cores", "1", "--scheduler", "greedy", "--until", "records"]
    code, output = snakemake(folder, [*command, *words], os.environ | {"PYTHONPATH": str(ROOT)})
    assert code == expect, output
    return output


def test_logs_on_s3_end_to_end(environment: dict[str, str], tmp_path: Path) -> None:
    local = tmp_path / LOG
    write_demo_log("D03", 0, local, SimulateSettings(drilling_s=60.0, connection_s=60.0))
    put(local)
    shutil.copytree(ROOT / "config/demo/rigs", tmp_path / "config/rigs")
    shutil.copy(ROOT / "config/config.yaml", tmp_path / "config")
    (tmp_path / "config/wells.tsv").write_text("well\trig\nW1\tcharlie\nW2\tcharlie\n")
    rows = f"W1\ts3://{BUCKET}/raw/{LOG}\nW2\ts3://{BUCKET}/raw/lost.csv\n"
    (tmp_path / "config/logs.tsv").write_text("well\tlog\n" + rows)
    batch = ("--config", "fleet={batch_size: 2}")
    run(tmp_path, *batch)
    records = tmp_path / "results/main/records"
    key = json.loads((records / "W1/key.json").read_text())
    assert key["status"] == "done"
    assert re.fullmatch(r"[0-9a-f]{64}", key["inputs"][f"s3://{BUCKET}/raw/{LOG}"])
    problem = pd.read_csv(records / "W2/problems.csv").iloc[0]
    assert problem[["where", "what"]].tolist() == [f"s3://{BUCKET}/raw/lost.csv", "does not exist"]
    assert re.search(r"^total +0$", run(tmp_path, *batch), re.MULTILINE)
    write_demo_log("D03", 1, local, SimulateSettings(drilling_s=60.0, connection_s=60.0))
    put(local)
    run(tmp_path, *batch)
    assert json.loads((records / "W1/key.json").read_text())["key"] != key["key"]


def test_a_store_that_does_not_answer_stops_the_run_and_nothing_is_lost(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from drillid.errors import SettingsError
    from drillid.fleet.provenance import file_manifest

    for name, value in {"ENDPOINT_URL": "http://127.0.0.1:9", "ACCESS_KEY_ID": "a", "SECRET_ACCESS_KEY": "b"}.items():
        monkeypatch.setenv(f"AWS_{name}", value)
    monkeypatch.setenv("AWS_MAX_ATTEMPTS", "1")
    with pytest.raises(SettingsError, match="does not respond"):
        file_manifest([Path("s3://nobody/raw/a.csv")])


def test_a_zarr_store_on_s3_has_the_state_of_its_objects(environment: dict[str, str], tmp_path: Path) -> None:
    from drillid.formats.remote import _listing, _state_at, size_of, states

    def state() -> str:
        _listing.cache_clear()
        _state_at.cache_clear()
        url = Path(f"s3://{BUCKET}/raw/log.zarr")
        return states([url])[url]

    system = fsspec.filesystem("s3", skip_instance_cache=True)
    objects = {"zarr.json": b"{}", "torque/c/0": b"1234", "torque/c/1": b"5678"}
    for name, content in objects.items():
        system.pipe_file(f"{BUCKET}/raw/log.zarr/{name}", content)
    before = state()
    assert size_of(before) == 10
    assert state() == before
    system.pipe_file(f"{BUCKET}/raw/log.zarr/torque/c/1", b"8765")
    changed = state()
    assert changed != before
    system.rm_file(f"{BUCKET}/raw/log.zarr/torque/c/0")
    assert size_of(state()) == 6
