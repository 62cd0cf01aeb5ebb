"""`drillid inspect`: what log files hold, whether they can be used as they are, and the rig description for them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import pandas as pd

from drillid.config.files import parse_yaml
from drillid.config.listing import Well
from drillid.config.rig import Clock, LogFile, Rig
from drillid.config.settings import Settings
from drillid.datasets.memory import WellInMemory
from drillid.errors import DrillidError, LogError, SettingsError
from drillid.inspection.contents import Contents, contents
from drillid.inspection.draft import UNKNOWN, draft
from drillid.records import stage as records_stage
from drillid.windows import stage as windows_stage


@dataclass(frozen=True)
class Inspection:
    """What log files hold.

    files : each table of each file
    refused : why a file could not be read
    draft : the rig description for them, YAML
    problems : what the records and windows made with it reject or note (where, what, remedy)
    segments : segments of the log with their windows, or the reason why they hold none; empty without records
    """

    files: tuple[Contents, ...]
    refused: tuple[DrillidError, ...]
    draft: str
    problems: tuple[tuple[str, str, str], ...]
    segments: pd.DataFrame

    def as_json(self) -> dict[str, Any]:
        """The same in a form that JSON can hold."""
        files = [asdict(each) for each in self.files]
        for each in files:
            each["gaps"] = [{"start": start, "seconds": seconds} for start, seconds in each["gaps"]]
        rows = [dict(zip(("where", "what", "remedy"), row, strict=True)) for row in self.problems]
        refused = [{"where": error.where, "what": error.what, "remedy": error.remedy} for error in self.refused]
        segments = self.segments.astype(object).where(self.segments.notna(), None).to_dict("records")
        return {"files": files, "refused": refused, "problems": rows, "segments": segments, "draft": self.draft}

    @property
    def windows(self) -> int:
        """Number of windows that fits can use."""
        return int(self.segments["windows"].sum()) if len(self.segments) else 0


def inspect(logs: Sequence[Path], name: str, clock: Clock, file: LogFile, settings: Settings) -> Inspection:
    """Look at log files, draft the rig description that reads them, and try it.

    Parameters
    ----------
    logs : the files of one well, fast and slow ones
    name : of the rig, for the description
    clock, file : what is known about their times and layout
    settings : lengths of windows and the like

    Raises
    ------
    LogError
        If none of the files can be read.
    """
    files, refused = list[Contents](), list[DrillidError]()
    for path in logs:
        try:
            files += contents(path, clock, file)
        except LogError as error:
            refused.append(error)
    if not files:
        raise refused[0]
    text = draft(name, files, clock, file)
    problems, segments = _tried(text, [path for path in logs if path in {each.path for each in files}], settings)
    return Inspection(tuple(files), tuple(refused), text, tuple(problems), segments)


def _tried(text: str, logs: Sequence[Path], settings: Settings) -> tuple[list[tuple[str, str, str]], pd.DataFrame]:
    """Records and windows with the drafted description: what they reject or note, and the segments."""
    try:
        rig = Rig.checked(parse_yaml(text, "draft"), "draft")
    except SettingsError as error:
        return [(error.where, error.what, error.remedy)], pd.DataFrame()
    unknown = [name for name, channel in rig.channels.items() if channel is not None and channel.column == UNKNOWN]
    if unknown:
        what = f"has no column for {', '.join(unknown)} yet, so that records and windows are not tried"
        return [("draft", what, f"Write the column's name and unit where it has '{UNKNOWN}'")], pd.DataFrame()
    well, folders = Well(rig.name, rig, tuple(logs)), WellInMemory(name=rig.name)
    problems = list(records_stage.process(well, folders, settings))
    segments = pd.DataFrame()
    if folders.has("records", "records"):
        problems += windows_stage.process(well, folders, settings)
        segments = folders.read_table("windows", "segments").fillna({"reason": ""})
    return [(problem.where, problem.what, problem.remedy) for problem in problems], segments
