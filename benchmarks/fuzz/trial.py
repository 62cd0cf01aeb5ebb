"""One mutated file: how it is made from its number, and its way through reader, record and windows."""

import functools
import io
import traceback
import warnings
import zipfile
from dataclasses import dataclass
from pathlib import Path
from random import Random
from types import SimpleNamespace
from typing import Any

import numpy as np
import pandas as pd
import xarray as xr

from benchmarks.fuzz import mutations, seeds
from drillid.config.settings import Settings
from drillid.datasets.memory import WellInMemory
from drillid.errors import DrillidError
from drillid.formats import first_stamp
from drillid.formats.readers import wits
from drillid.records.stage import regular_record
from drillid.windows import stage as windows
from tests.raw_logs import RIG

WITS_RIG = RIG.model_copy(
    update={
        "channels": {
            name: channel.model_copy(update={"column": seeds.WITS_CODES[str(channel.column)]})
            for name, channel in RIG.channels.items()
        }
    }
)
SETTINGS = Settings.checked({"windows": {"length_s": 2.0}}, "fuzz")
_TABLES_CHANGED = 0.6
"""Share of files whose table is changed before it is written."""
_LEFT_OUT = 0.1
"""Share of changed stores that lack the file instead."""


@dataclass(frozen=True)
class Mutated:
    """One file, and how it came to be."""

    suffix: str
    content: bytes
    mutations: tuple[str, ...]

    def write(self, path: Path) -> None:
        """The file, or the folder of a store, whose files lie in an archive."""
        if self.suffix != ".zarr":
            path.write_bytes(self.content)
            return
        with zipfile.ZipFile(io.BytesIO(self.content)) as archive:
            archive.extractall(path)


def mutated(number: int, seed: int) -> Mutated:
    """File `number` of a series: its table changed, its bytes changed, or both."""
    random = Random(f"{seed}/{number}")
    suffixes = seeds.suffixes()
    suffix = suffixes[number % len(suffixes)]
    writer = random.randrange(len(seeds.writers(suffix)))
    log = random.randrange(len(_logs()))
    done = list[str]()
    content = _in_good_order(suffix, writer, log)
    if random.random() < _TABLES_CHANGED:
        table = _logs()[log]
        for change in random.choices(mutations.OF_TABLES, k=random.choice((1, 1, 2, 3))):
            table = _changed(change, random, table)
            done.append(change.__name__)
        try:
            content = seeds.writers(suffix)[writer](table)
        except Exception:  # the writers of others refuse some tables: then only the bytes are changed
            done = ["unwritten"]
    if not done or done == ["unwritten"] or random.random() < 0.2:
        for change_bytes in random.choices(mutations.OF_BYTES, k=random.choice((1, 1, 2, 3))):
            content = _bytes_changed(change_bytes, random, content, suffix)
            done.append(change_bytes.__name__)
    return Mutated(suffix, content, tuple(done))


def _bytes_changed(change: mutations.OfBytes, random: Random, content: bytes, suffix: str) -> bytes:
    """The file with some bytes changed; of a store, one of its files, or one left out."""
    if suffix != ".zarr":
        return change(random, content)
    with zipfile.ZipFile(io.BytesIO(content)) as archive:
        files = {name: archive.read(name) for name in archive.namelist()}
    name = random.choice(list(files) or [".zattrs"])
    files[name] = change(random, files.get(name, b""))
    if random.random() < _LEFT_OUT:
        del files[name]
    return seeds.archive(files)


def _changed(change: mutations.OfTable, random: Random, table: pd.DataFrame) -> pd.DataFrame:
    """The table after a change, or as it was where the change does not fit what others left of it."""
    try:
        return change(random, table)
    except (TypeError, ValueError, KeyError, IndexError, OverflowError, AttributeError, pd.errors.OutOfBoundsDatetime):
        return table


@functools.cache
def _logs() -> list[pd.DataFrame]:
    return seeds.logs()


@functools.cache
def _in_good_order(suffix: str, writer: int, log: int) -> bytes:
    return seeds.writers(suffix)[writer](_logs()[log])


def taken_through(path: Path) -> str:
    """Take a file through reader, record and windows; what it ends with: 'windows', 'no window', or a class of errors.

    Raises
    ------
    Exception
        Any that is no error of drillid, and warnings of numpy, which stand for numbers that are none.
    """
    rig = RIG if set(path.suffixes).isdisjoint(wits.SUFFIXES) else WITS_RIG
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        warnings.simplefilter("error", RuntimeWarning)
        try:
            first_stamp(path, rig.time.column, rig.time.zone)
            record = regular_record(path, rig, SETTINGS.records)
        except DrillidError as error:
            _check_told(error)
            return type(error).__name__
        folders, samples = WellInMemory(name="fuzz"), record.samples.sizes["time"]
        folders.write("records", "records", record.samples.assign(log=("time", np.zeros(samples, np.int16))))
        columns = {"file": [path.name], "first_sample": [0], "samples": [samples], "key": ["log"]}
        logs = xr.Dataset({name: ("log", values) for name, values in columns.items()}, {"log": [0]})
        folders.write("records", "logs", logs)
        well: Any = SimpleNamespace(name="fuzz", rig=rig, logs=(path,))
        return "no window" if windows.process(well, folders, SETTINGS) else "windows"


def _check_told(error: DrillidError) -> None:
    """An error must say where, what and what to do, in a few lines."""
    for text in (error.where, error.what, error.remedy):
        if not text or len(text) > _LONGEST_TEXT:
            raise AssertionError(f"a message of {len(text)} characters: {text[:100]}")


_LONGEST_TEXT = 5000


def place(error: BaseException) -> str:
    """Where an exception came from: the last line of the library in its traceback, and its kind."""
    frames = traceback.extract_tb(error.__traceback__)
    own = [frame for frame in frames if "drillid" in Path(frame.filename).parts] or frames
    message = (str(error) or "").splitlines()[:1]
    return f"{type(error).__name__} in {Path(own[-1].filename).name}:{own[-1].lineno}: {''.join(message)[:150]}"
