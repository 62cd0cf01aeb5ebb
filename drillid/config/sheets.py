"""The two sheets a user fills in: wells with their rigs, and the log files of each well."""

import difflib
import io
import os
from collections.abc import Callable, Collection, Iterable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import pandas as pd
from pydantic import Field, field_validator

from drillid.config.files import read_text
from drillid.config.folders import SAFE, Roots, as_seen, folder_of, without_links
from drillid.config.rig import Rig
from drillid.config.validation import KeyFault, Strict
from drillid.errors import SettingsError
from drillid.formats.remote import url_of

if TYPE_CHECKING:
    from drillid.config.settings import Settings

Faults = Callable[[SettingsError], None]
"""What takes the faults of rows."""
_OPTIONAL = {"section", "tool", "folder", "fitted"}
"""Columns that a sheet need not have, beside the description."""
_SEPARATORS = {",": "commas", ";": "semicolons"}


def _checked_name(name: str) -> str:
    if not name.isprintable():
        raise KeyFault("", f"{name!r} holds characters that cannot be printed", "Write the name anew")
    if {".", ".."}.intersection(name.split("/")):
        raise KeyFault("", f"'{name}' is a path and no name", "Write the well's name")
    return name


class WellRow(Strict):
    """One row of the wells sheet."""

    well: str = Field(min_length=1, max_length=200)
    """Name of the well as people write it, such as 34/10-A-12 H."""
    rig: str = Field(pattern=SAFE)
    """Name of its rig description: the file `<rigs>/<rig>.yaml`; letters, digits, '_', '-' and '.'."""
    description: str = ""
    """Free text for the report."""
    section: str = Field(default="", max_length=200)
    """What its string runs in, such as hole section and mud: wells with the same text here may have drag in common."""
    tool: str = Field(default="", max_length=200)
    """Its bit or motor: wells with the same text here may have the laws of its cutting or its twist in common."""
    folder: str = Field(default="", pattern=rf"^$|{SAFE}", max_length=100)
    """Its folder in the results; by default the letters and digits of its name, 34-10-A-12-H for 34/10-A-12 H."""

    @field_validator("well")
    @classmethod
    def _is_a_name(cls, name: str) -> str:
        return _checked_name(name)


class LogRow(Strict):
    """One row of the logs sheet."""

    well: str = Field(min_length=1)
    """Name of a well of the wells sheet."""
    log: str = Field(min_length=1)
    """Path of one raw log file, absolute or relative to the folder that snakemake is started in; it lies in that
    folder, beside the sheet, or in a folder of the setting `log_roots`."""


class StartUpRow(Strict):
    """One row of the sheet of measured starts of rotation."""

    start_up: str = Field(min_length=1, max_length=200)
    """Name of the start of rotation as people write it."""
    description: str = Field(min_length=1)
    """YAML file that describes top drive, string, mud and friction, as of `drillid simulate start-up`."""
    survey: str = Field(min_length=1)
    """CSV file with depth_m, inclination_deg and, where the hole turns, azimuth_deg."""
    log: str = Field(min_length=1)
    """CSV file with t_s, td_rpm_measured, torque_knm_measured and, where measured, bit_rpm_min_measured and
    bit_rpm_max_measured; paths are relative to the folder that snakemake is started in, as those of the logs sheet."""
    depth_m: float = Field(gt=0, le=20_000)
    """Depth of the bit along the hole, in m."""
    fitted: str = ""
    """What is fitted, separated by commas; by default what holds at other depths of the hole as well."""
    folder: str = Field(default="", pattern=rf"^$|{SAFE}", max_length=100)
    """Its folder in the results; by default made from its name."""

    @field_validator("start_up")
    @classmethod
    def _is_a_name(cls, name: str) -> str:
        return _checked_name(name)


Row = TypeVar("Row", WellRow, LogRow, StartUpRow)
Named = TypeVar("Named", WellRow, StartUpRow)


@dataclass(frozen=True)
class Well:
    """One well with its rig description and logs, as a stage receives it."""

    name: str
    rig: Rig
    logs: tuple[Path, ...]


@dataclass(frozen=True)
class Listing:
    """One well as listed in the sheets; its rig description is not read yet, and may be missing.

    name : as people write it
    folder : of its results, and its name wherever the workflow needs one; by default made from the name
    section, tool : what it may have in common with other wells; empty where it has nothing
    """

    name: str
    rig_file: Path
    logs: tuple[Path, ...]
    description: str = ""
    folder: str = ""
    section: str = ""
    tool: str = ""

    def __post_init__(self) -> None:
        object.__setattr__(self, "folder", self.folder or folder_of(self.name))

    @property
    def stated(self) -> dict[str, Any]:
        """What its row of the sheet says that its results depend on."""
        return {}

    def load(self) -> Any:
        """The well with its rig description.

        Raises
        ------
        SettingsError
            If it is missing, cannot be read or does not validate, or if the well has no logs.
        """
        rig = self.load_rig()
        if not self.logs:
            raise SettingsError("logs sheet", f"well '{self.name}' has no logs", "List its log files there")
        return Well(self.name, rig, self.logs)

    def load_rig(self) -> Rig:
        """The rig description alone.

        Raises
        ------
        SettingsError
            If it is missing, cannot be read or does not validate.
        """
        if not self.rig_file.is_file():
            raise self._without_rig()
        return Rig.from_yaml(self.rig_file)

    def _without_rig(self) -> SettingsError:
        """The error of a rig that is not described, with the one that was probably meant."""
        rig, known = self.rig_file.stem, sorted(path.stem for path in self.rig_file.parent.glob("*.yaml"))
        close = difflib.get_close_matches(rig, known, n=1)
        meant = f"Did you mean '{close[0]}'? Else write" if close else "Write"
        remedy = f"{meant} this file, or correct the rig of well '{self.name}' in the wells sheet"
        return SettingsError(str(self.rig_file), f"rig '{rig}' has no description", remedy)

    def absolute(self) -> "Listing":
        """The same with absolute paths, which hold in any working folder; URLs stay as they are."""
        logs = tuple(log if url_of(log) else log.absolute() for log in self.logs)
        return replace(self, rig_file=self.rig_file.absolute(), logs=logs)


@dataclass(frozen=True)
class StartUp:
    """One measured start of rotation with its files, as its stage receives it."""

    name: str
    description: Path
    survey: Path
    log: Path
    depth: float
    """m, of the bit along the hole."""
    fitted: tuple[str, ...]
    """What is fitted; empty where the usual is."""


@dataclass(frozen=True)
class StartUpListing(Listing):
    """One start of rotation as listed in its sheet; its description stands in the place of a rig's."""

    depth: float = 0.0
    fitted: tuple[str, ...] = ()

    @property
    def stated(self) -> dict[str, Any]:
        """Depth and what is fitted."""
        return {"depth_m": self.depth, "fitted": list(self.fitted)}

    def load(self) -> StartUp:
        """The start with its files, none of which is read yet."""
        log, survey = self.logs
        return StartUp(self.name, self.rig_file, survey, log, self.depth, self.fitted)


def read_sheets(settings: "Settings", faults: Faults | None = None) -> dict[str, Listing]:
    """All wells of the sheets by their folders, in the order of the wells sheet.

    Parameters
    ----------
    settings : where the sheets are, and where logs may lie
    faults : what takes the faults of rows, which are left out; without it the first fault is raised

    Raises
    ------
    SettingsError
        With sheet and row, for a sheet that cannot be read, a row that does not validate, a well
        listed twice, wells that would share a folder, a log of an unknown well, listed twice, or
        outside of the folders that logs may lie in.
    """
    faults = _raise if faults is None else faults
    rows = _apart(_rows(Path(settings.wells), WellRow, faults), "well", faults)
    logs = _logs_of_wells(settings, rows.keys(), faults)
    listings = (
        Listing(
            name,
            Path(settings.rigs) / f"{row.rig}.yaml",
            tuple(logs[name]),
            row.description,
            row.folder,
            row.section,
            row.tool,
        )
        for name, row in rows.items()
    )
    return {listing.folder: listing for listing in listings}


def _raise(fault: SettingsError) -> None:
    raise fault


def read_start_ups(settings: "Settings", faults: Faults | None = None) -> dict[str, StartUpListing]:
    """All measured starts of rotation by their folders, in the order of their sheet; none without a sheet.

    Parameters, errors : as of `read_sheets`
    """
    if settings.start_up_sheet is None:
        return {}
    faults, sheet = _raise if faults is None else faults, Path(settings.start_up_sheet)
    roots = Roots.of([".", sheet.parent, settings.results, *settings.log_roots])
    listings = []
    for name, row in _apart(_rows(sheet, StartUpRow, faults), "start_up", faults).items():
        outside = [path for path in (row.description, row.survey, row.log) if not roots.hold(path)]
        if outside:
            faults(_outside(f"{sheet}, '{name}'", outside[0], roots))
            continue
        files = Path(row.log), Path(row.survey)
        fitted = tuple(part.strip() for part in row.fitted.split(",") if part.strip())
        listings.append(StartUpListing(name, Path(row.description), files, "", row.folder, "", "", row.depth_m, fitted))
    return {listing.folder: listing for listing in listings}


def _apart(rows: Iterable[tuple[str, Named]], kind: str, faults: Faults) -> dict[str, Named]:
    """Rows by the names of their wells or starts, each with a folder of its own on every file system."""
    found: dict[str, Named] = {}
    owners: dict[str, str] = {}
    called = kind.replace("_", "-")
    for where, row in rows:
        name: str = getattr(row, kind)
        if name in found:
            faults(SettingsError(where, f"{called} '{name}' is listed twice", "Remove or rename one of the rows"))
            continue
        folder = row.folder or folder_of(name)
        other = owners.setdefault(as_seen(folder), name)
        if other != name:
            what = f"{called}s '{other}' and '{name}' would share the folder '{folder}' where case does not count"
            remedy = "Rename one of them, or give it another folder in a column 'folder' of this sheet"
            faults(SettingsError(where, what, remedy))
            continue
        found[name] = row
    return found


def _logs_of_wells(settings: "Settings", names: Collection[str], faults: Faults) -> dict[str, list[Path]]:
    logs: dict[str, list[Path]] = {name: [] for name in names}
    seen: dict[str, tuple[str, str]] = {}
    roots = Roots.of([".", Path(settings.logs).parent, settings.results, *settings.log_roots])
    for where, row in _rows(Path(settings.logs), LogRow, faults):
        path = without_links(row.log)
        if row.well not in logs:
            faults(_unknown(where, row.well, names, settings.wells))
        elif path in seen:
            other, log = seen[path]
            name = "" if os.path.normpath(log) == os.path.normpath(row.log) else f" as '{log}', which is the same file"
            what = f"log '{row.log}' is listed already at {other}{name}"
            faults(SettingsError(where, what, "Remove one of the rows"))
        elif not roots.hold(row.log):
            faults(_outside(where, row.log, roots))
        else:
            seen[path] = where, row.log
            logs[row.well].append(Path(row.log))
    return logs


def _unknown(where: str, well: str, names: Collection[str], sheet: str) -> SettingsError:
    close = difflib.get_close_matches(well, names, n=1)
    remedy = f"Did you mean '{close[0]}'?" if close else f"Add the well to {sheet}"
    return SettingsError(where, f"log of the unknown well '{well}'", remedy)


def _outside(where: str, log: str, roots: Roots) -> SettingsError:
    folder = os.path.dirname(log if "://" in log else os.path.realpath(log))
    what = f"log '{log}' lies in {folder}, outside of the folders for logs: {', '.join(roots.folders)}"
    return SettingsError(where, what, f"If it may be read, add to the configuration: log_roots: [{folder}]")


def _rows(path: Path, model: type[Row], faults: Faults) -> Iterator[tuple[str, Row]]:
    """The sheet's rows, each with its place for messages; blank lines and lines that begin with '#' are skipped."""
    lines = read_text(path).splitlines()
    used = [number for number, line in enumerate(lines, 1) if line.strip() and not line.startswith("#")]
    header = "\t".join(name for name in model.model_fields if name not in _OPTIONAL)
    if used and "\t" not in lines[used[0] - 1]:
        _check_separator(path, lines[used[0] - 1])
    if not used:
        raise SettingsError(str(path), "has no header", f"Begin the sheet with the line '{header}', separated by tabs")
    text = "\n".join(lines[number - 1] for number in used)
    try:
        table = pd.read_csv(io.StringIO(text), sep="\t", dtype=str, keep_default_na=False, index_col=False, quoting=3)
    except pd.errors.ParserError as error:
        raise SettingsError(
            str(path), f"is not a table ({error})", "Separate the columns by tabs, one row per line"
        ) from error
    for number, record in zip(used[1:], _records(table), strict=True):
        where = f"{path}, row {number}"
        try:
            row = model.checked(record, where)
        except SettingsError as fault:
            faults(fault)
        else:
            yield where, row


def _check_separator(path: Path, header: str) -> None:
    for separator, plural in _SEPARATORS.items():
        if separator in header:
            remedy = "Save the sheet as text with tabs between its columns"
            raise SettingsError(str(path), f"has {plural} between its columns '{header}'", remedy)


def _plain(cell: str) -> str:
    """A cell without spaces around it, and without the quotes in which Excel saves one with a comma or a quote."""
    text = cell.strip()
    is_quoted = len(text) > 1 and text[0] == text[-1] == '"'
    return text[1:-1].replace('""', '"').strip() if is_quoted else text


def _records(table: pd.DataFrame) -> list[dict[str, str]]:
    stripped = table.fillna("").map(_plain)
    return [{str(name).strip(): value for name, value in record.items()} for record in stripped.to_dict("records")]
