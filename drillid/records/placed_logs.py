"""Logs that an earlier run placed in the records: those that have not changed are not read again.

What becomes of a log follows from the log itself and from the end of the log before it, which it continues. So each has
a key of these two, and after a log that arrives late between others, only those are read again for which it changes
that end.
"""

from __future__ import annotations

import hashlib
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Self

import xarray as xr

from drillid.datasets.registry import DATASETS
from drillid.datasets.reuse import Memo
from drillid.datasets.store import Problem, WellFolders
from drillid.formats.remote import states, url_of
from drillid.records.grid import End


@dataclass(frozen=True)
class PlacedLog:
    """What became of one log.

    state : state of its file
    key : hash of its samples; empty where it is not used
    first, samples : its place in the records
    end : where the next log may continue; None until a log is used
    """

    state: str
    key: str
    first: int
    samples: int
    end: End | None
    problems: tuple[Problem, ...]
    again: bool = False
    """Whether program or machine are at fault, so that the log is tried again."""

    @classmethod
    def of(cls, content: dict[str, Any]) -> Self:
        """The placed log from its JSON content."""
        end, problems = content["end"], tuple(Problem(**row) for row in content["problems"])
        end = None if end is None else End(end["rate"], end["time"], tuple(end["stamps"]))
        return cls(**{**content, "end": end, "problems": problems})


def file_states(paths: Sequence[Path]) -> dict[Path, str]:
    """Name, size and time of each file, which change with any replacement of it; empty where there is no file."""
    return {path: _local_state(path) if url_of(path) is None else "" for path in paths} | {
        path: f"{path} {state}" if state else "" for path, state in states(paths).items()
    }


def distinct_names(paths: Iterable[Path]) -> dict[Path, str]:
    """Names of logs; those of the same name are given as many of their folders as distinguish them."""
    paths = list(paths)
    ends = Counter(end for path in paths for end in _ends(path))
    return {path: next((end for end in _ends(path) if ends[end] == 1), str(path)) for path in paths}


def _ends(path: Path) -> list[str]:
    """The name, the name with its folder, and so on."""
    return ["/".join(path.parts[-count:]) for count in range(1, len(path.parts) + 1)]


def _local_state(path: Path) -> str:
    try:
        status = path.stat()
    except OSError:
        return ""
    return f"{path} {status.st_size} {status.st_mtime_ns}"


class EarlierLogs:
    """The logs as an earlier run left them.

    Parameters
    ----------
    logs : states of the files by their paths, in order of the logs' time
    """

    def __init__(self, folders: WellFolders, memo: Memo, logs: Mapping[Path, str]) -> None:
        self._memo, self._logs = memo, logs
        self._records = folders.earlier("records", "records")
        end, kept, behind = None, 0, dict(logs)
        for path in logs:
            placed = self.unchanged(path, end)
            if placed is None:
                break
            end, kept = placed.end, kept + placed.samples
            del behind[path]
        entries = [entry for entry in memo.earlier.values() if isinstance(entry, dict)]
        placed_before = {entry["state"] for entry in entries if "state" in entry}
        self.kept = 0 if placed_before.intersection(behind.values()) else kept
        """Samples with which earlier and new records begin; 0 if others of the earlier ones may be needed again."""

    def key(self, path: Path, end: End | None) -> str:
        """Key of what becomes of a log that continues a given end."""
        return self._memo.key("log", self._logs[path], end and asdict(end))

    def unchanged(self, path: Path, end: End | None) -> PlacedLog | None:
        """The log as placed before; None where it or the end that it continues has changed, or it was not there."""
        content = self._memo.earlier.get(self.key(path, end))
        if content is None or self._records is None or not self._logs[path]:
            return None
        return PlacedLog.of(content)

    def samples(self, placed: PlacedLog) -> xr.Dataset | None:
        """Samples of an unchanged log; None where they are among those that are kept."""
        if placed.first + placed.samples <= self.kept:
            return None
        assert self._records is not None
        return self._records.isel(time=slice(placed.first, placed.first + placed.samples))


def samples_key(samples: xr.Dataset) -> str:
    """Hash of a log's samples as the records hold them: 16 hexadecimal digits."""
    found = hashlib.sha256()
    for name, declared in DATASETS["records"].variables.items():
        if name != "log":
            found.update(samples[name].values.astype(declared.dtype).tobytes())
    return found.hexdigest()[:16]
