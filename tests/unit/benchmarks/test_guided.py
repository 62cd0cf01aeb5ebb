"""Coverage-guided fuzzing: drillid's own errors pass, any other exception does not."""

from pathlib import Path
from typing import Any

import pytest

from benchmarks.fuzz.guided import FORMATS, reading, write_seeds
from drillid.formats import headers, read_log


@pytest.mark.parametrize("suffix", FORMATS)
def test_seeds_are_logs_and_damage_ends_in_an_error_of_drillid(suffix: str, tmp_path: Path) -> None:
    write_seeds(tmp_path, suffix)
    seeds = sorted(tmp_path.glob("seed_*"))
    assert seeds
    read = reading(tmp_path / f"log{suffix}", headers, read_log)
    for seed in reversed(seeds):
        read(seed.read_bytes())
    assert headers(tmp_path / f"log{suffix}")[0].columns[0] == "Time"
    read(b"\x00\xff")


def test_an_exception_of_others_is_a_failure(tmp_path: Path) -> None:
    def failing(*_: Any) -> Any:
        raise KeyError("nobody foresaw this")

    with pytest.raises(KeyError):
        reading(tmp_path / "log.csv", failing, read_log)(b"")
