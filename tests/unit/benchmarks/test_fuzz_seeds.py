"""Files from which mutated ones are made: every format has some, and nothing is wrong with them."""

from pathlib import Path

import pytest

from benchmarks.fuzz import seeds
from benchmarks.fuzz.trial import Mutated, taken_through
from drillid.formats import formats


@pytest.mark.parametrize("suffix", sorted({reader.SUFFIXES[0] for reader in formats().values()}))
def test_unchanged_files_of_every_format_are_read(tmp_path: Path, suffix: str) -> None:
    log = seeds.logs()[0]
    for number, write in enumerate(seeds.writers(suffix)):
        path = tmp_path / f"log_{number}{suffix}"
        Mutated(suffix, write(log), ()).write(path)
        assert taken_through(path) in ("windows", "no window")
