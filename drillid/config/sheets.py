"""The two sheets a user fills in: wells with their rigs, and the log files of each well."""

import difflib
import io
from collections.abc import Collection
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, TypeVar

import pandas as pd
from pydantic import Field

from drillid.config.rig import Rig
from drillid.config.validation import Strict
from drillid.errors import SettingsError

if TYPE_CHECKING:
    from drillid.config.settings import Settings

_NAME = r"^[A-Za-z0-9][A-Za-z0-9_.-]*$"


class WellRow(Strict):
    """One row of the wells sheet."""

    well: str = Field(pattern=_NAME)
    """Name of the well; letters, digits, '_', '-' and '.', as it names folders."""
    rig: str = Field(pattern=_NAME)
    """Name of its rig description: the file `<rigs>/<rig>.yaml`."""
    description: str = ""
    """Free text for the report."""


class LogRow(Strict):
    """One row of the logs sheet."""

    well: str = Field(pattern=_NAME)
    """Name of a well of the wells sheet."""
    log: str = Field(min_length=1)
    """Path of one raw log file, relative to the folder that snakemake is started in."""


Row = TypeVar("Row", WellRow, LogRow)


@dataclass(frozen=True)
class Well:
    """One well with its rig description and logs, as a stage receives it."""

    name: str
    rig: Rig
    logs: tuple[Path, ...]


@dataclass(frozen=True)
class Listing:
    """One well as listed in the sheets; its rig description is not read yet, and may be missing."""

    name: str
    rig_file: Path
    logs: tuple[Path, ...]
    description: str = ""

    def load(self) -> Well:
        """Read the rig description.

        Raises
        ------
        SettingsError
            If it is missing, cannot be read or does not validate, or if the well has no logs.
        """
        if not self.rig_file.is_file():
            raise SettingsError(
                str(self.rig_file),
                f"rig '{self.rig_file.stem}' has no description",
                f"Write this file, or correct the rig of well '{self.name}' in the wells sheet",
            )
        if not self.logs:
            raise SettingsError("logs sheet", f"well '{self.name}' has no logs", "List its log files there")
        return Well(self.name, Rig.from_yaml(self.rig_file), self.logs)

    def absolute(self) -> "Listing":
        """The same with absolute paths, which hold in any working folder."""
        return replace(self, rig_file=self.rig_file.absolute(), logs=tuple(log.absolute() for log in self.logs))


def read_sheets(settings: "Settings") -> dict[str, Listing]:
    """All wells of the sheets, in the order of the wells sheet.

    Raises
    ------
    SettingsError
        With sheet and row, for a sheet that cannot be read, a row that does not validate, a well
        listed twice, a log of an unknown well or listed twice.
    """
    wells = _rows(Path(settings.wells), WellRow)
    listed: dict[str, WellRow] = {}
    for where, row in wells:
        if row.well in listed:
            raise SettingsError(where, f"well '{row.well}' is listed twice", "Remove or rename one of the rows")
        listed[row.well] = row
    logs = _logs_of_wells(settings, listed.keys())
    return {
        name: Listing(name, Path(settings.rigs) / f"{row.rig}.yaml", tuple(logs[name]), row.description)
        for name, row in listed.items()
    }


def _logs_of_wells(settings: "Settings", names: Collection[str]) -> dict[str, list[Path]]:
    logs: dict[str, list[Path]] = {name: [] for name in names}
    seen: dict[str, str] = {}
    for where, row in _rows(Path(settings.logs), LogRow):
        if row.well not in logs:
            close = difflib.get_close_matches(row.well, names, n=1)
            remedy = f"Did you mean '{close[0]}'?" if close else f"Add the well to {settings.wells}"
            raise SettingsError(where, f"log of the unknown well '{row.well}'", remedy)
        if row.log in seen:
            raise SettingsError(
                where, f"log '{row.log}' is listed already at {seen[row.log]}", "Remove one of the rows"
            )
        seen[row.log] = where
        logs[row.well].append(Path(row.log))
    return logs


def _rows(path: Path, model: type[Row]) -> list[tuple[str, Row]]:
    """The sheet's rows, each with its place for messages; blank lines and lines that begin with '#' are skipped."""
    try:
        lines = path.read_text().splitlines()
    except (OSError, UnicodeDecodeError) as error:
        raise SettingsError(str(path), f"cannot be read ({error})", "Write the sheet or correct its path") from error
    used = [number for number, line in enumerate(lines, 1) if line.strip() and not line.startswith("#")]
    header = "\t".join(model.model_fields)
    if not used:
        raise SettingsError(str(path), "has no header", f"Begin the sheet with the line '{header}', separated by tabs")
    text = "\n".join(lines[number - 1] for number in used)
    try:
        table = pd.read_csv(io.StringIO(text), sep="\t", dtype=str, keep_default_na=False, index_col=False, quoting=3)
    except pd.errors.ParserError as error:
        raise SettingsError(
            str(path), f"is not a table ({error})", "Separate the columns by tabs, one row per line"
        ) from error
    return [_row(path, number, record, model) for number, record in zip(used[1:], _records(table), strict=True)]


def _records(table: pd.DataFrame) -> list[dict[str, str]]:
    stripped = table.fillna("").map(str.strip)
    return [{str(name).strip(): value for name, value in record.items()} for record in stripped.to_dict("records")]


def _row(path: Path, number: int, record: dict[str, str], model: type[Row]) -> tuple[str, Row]:
    where = f"{path}, row {number}"
    return where, model.checked(record, where)
