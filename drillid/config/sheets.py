"""The two sheets a user fills in: wells with their rigs, and the log files of each well."""

import difflib
import os
import re
from collections.abc import Collection, Iterable
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, Generic, TypeVar

from pydantic import Field, field_validator

from drillid.config.folders import SAFE, Roots, as_seen, files_of, folder_apart, folder_of, without_links
from drillid.config.listing import Listing, StartUpListing
from drillid.config.sheet_rows import SheetRow, sheet_rows
from drillid.config.validation import KeyFault, Name, Strict, in_one_form
from drillid.errors import SettingsError
from drillid.formats.remote import url_of

if TYPE_CHECKING:
    from drillid.config.settings import Settings


def _checked_name(name: str) -> str:
    """The name of a well or start of rotation, in one form."""
    if not name.isprintable():
        raise KeyFault("", f"{name!r} holds characters that cannot be printed", "Retype the name")
    if {".", ".."}.intersection(name.split("/")):
        raise KeyFault("", f"'{name}' is a path, not a name", "Write the well's name")
    return in_one_form(name)


class WellRow(Strict):
    """One row of the wells sheet."""

    well: str = Field(min_length=1, max_length=200)
    """Name of the well as people write it, such as 34/10-A-12 H."""
    rig: str = Field(pattern=SAFE)
    """Name of its rig description: the file `<rigs>/<rig>.yaml`; letters, digits, '_', '-' and '.'."""
    description: str = ""
    """Free text for the report."""
    section: Name = Field(default="", max_length=200)
    """What its string runs in, such as hole section and mud: wells with the same text here may have drag in common."""
    tool: Name = Field(default="", max_length=200)
    """Its bit or motor: wells with the same text here may have its cutting law or its compliance in common."""
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
    """Path of one raw log file, absolute or relative to the folder that the run is started in; or a pattern of paths,
    such as raw/W1/*.csv; or an address, such as s3://bucket/W1/stand.csv, which may not be a pattern. Files lie in that
    folder, in that of the sheet, or in a folder of the setting `log_roots`."""


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
    bit_rpm_max_measured; paths are relative to the folder that the run is started in, as those of the logs sheet."""
    depth_m: float = Field(gt=0, le=20_000)
    """Depth of the bit along the hole, in m."""
    fitted: str = ""
    """Fitted parameters, separated by commas; by default those that apply at other depths of the hole as well."""
    folder: str = Field(default="", pattern=rf"^$|{SAFE}", max_length=100)
    """Its folder in the results; by default made from its name."""

    @field_validator("start_up")
    @classmethod
    def _is_a_name(cls, name: str) -> str:
        return _checked_name(name)


Named = TypeVar("Named", WellRow, StartUpRow)


@dataclass
class _Entry(Generic[Named]):
    """A well or a start of rotation as rows of the sheets make it; without `row` it is not listed as it should be."""

    folder: str
    row: Named | None = None
    logs: list[Path] = field(default_factory=list)
    faults: list[SettingsError] = field(default_factory=list)


def read_sheets(settings: "Settings") -> dict[str, Listing]:
    """All wells of the sheets by their folders, in the order of the wells sheet.

    A row that cannot be used is a fault of its well: one that does not validate, another row of a well, a well that
    would share the folder of another, a log that is listed twice or lies outside of the folders for logs. The well of a
    log that the wells sheet lacks comes last, and is a well with that fault, as is a row that names no well.

    Raises
    ------
    SettingsError
        For a sheet that cannot be used as a whole, or has no rows; without wells there may be starts of rotation.
    """
    sheet = Path(settings.wells)
    entries = _entries(sheet_rows(sheet, WellRow), "well")
    if not entries and settings.start_up_sheet is None:
        raise SettingsError(str(sheet), "lists no wells", "Add a row for each well")
    _add_logs(settings, entries)
    return {entry.folder: _listing(name, entry, settings) for name, entry in entries.items()}


def _listing(name: str, entry: _Entry[WellRow], settings: "Settings") -> Listing:
    row, logs, faults = entry.row, tuple(entry.logs), tuple(entry.faults)
    if row is None:
        return Listing(name, Path(settings.wells), logs, folder=entry.folder, faults=faults)
    rig_file = Path(settings.rigs) / f"{row.rig}.yaml"
    return Listing(name, rig_file, logs, row.description, entry.folder, row.section, row.tool, faults)


def read_start_ups(settings: "Settings") -> dict[str, StartUpListing]:
    """All measured starts of rotation by their folders, in the order of their sheet; none without a sheet.

    Faults, errors : as of `read_sheets`
    """
    if settings.start_up_sheet is None:
        return {}
    sheet = Path(settings.start_up_sheet)
    roots = Roots.of([".", sheet.parent, settings.results, *settings.log_roots])
    entries = _entries(sheet_rows(sheet, StartUpRow), "start_up")
    if not entries:
        remedy = "Add a row for each, or remove start_up_sheet from the configuration"
        raise SettingsError(str(sheet), "lists no starts of rotation", remedy)
    return {entry.folder: _start_up_listing(name, entry, sheet, roots) for name, entry in entries.items()}


def _start_up_listing(name: str, entry: _Entry[StartUpRow], sheet: Path, roots: Roots) -> StartUpListing:
    row, faults = entry.row, tuple(entry.faults)
    if row is None:
        return StartUpListing(name, sheet, (), folder=entry.folder, faults=faults)
    outside = [path for path in (row.description, row.survey, row.log) if not roots.hold(path)]
    if outside:
        faults = (*faults, _outside(f"{sheet}, '{name}'", outside[0], roots))
        return StartUpListing(name, sheet, (), folder=entry.folder, faults=faults)
    files = Path(row.log), Path(row.survey)
    fitted = tuple(part.strip() for part in row.fitted.split(",") if part.strip())
    return StartUpListing(
        name,
        Path(row.description),
        files,
        folder=entry.folder,
        faults=faults,
        depth=row.depth_m,
        fitted=fitted,
    )


def _entries(rows: Iterable[SheetRow[Named]], kind: str) -> dict[str, _Entry[Named]]:
    """Entries by the names of their wells or starts, each with a folder of its own on every file system."""
    found: dict[str, _Entry[Named]] = {}
    owners: dict[str, str] = {}
    called = kind.replace("_", "-")
    for row in rows:
        name = _name_in(row, kind)
        if name in found:
            twice = SettingsError(row.where, f"{called} '{name}' is listed twice", "Remove or rename one of the rows")
            found[name].faults.append(row.fault or twice)
            continue
        folder = _folder_in(row, name)
        other = owners.setdefault(as_seen(folder), name)
        if other == name:
            entry = _Entry(folder, row.content)
        else:
            what = f"{called}s '{other}' and '{name}' would share the folder '{folder}' where case is ignored"
            remedy = "Rename one of them, or give it another folder in a column 'folder' of this sheet"
            entry = _Entry(folder_apart(name), faults=[SettingsError(row.where, what, remedy)])
        entry.faults += [row.fault] if row.fault else []
        found[name] = entry
    return found


def _name_in(row: SheetRow[Any], kind: str) -> str:
    """The name in a row of a well or start of rotation; the row's place where it holds none."""
    name = row.cells.get(kind, "")
    try:
        return _checked_name(name) or Path(row.where).name
    except KeyFault:
        return Path(row.where).name


def _folder_in(row: SheetRow[Any], name: str) -> str:
    stated = row.cells.get("folder", "")
    return stated if re.match(SAFE, stated) else folder_of(name)


def _add_logs(settings: "Settings", entries: dict[str, _Entry[WellRow]]) -> None:
    """Add the logs to their wells, and the wells that the wells sheet lacks."""
    listed, sheet = list(entries), Path(settings.logs)
    rows = list(sheet_rows(sheet, LogRow))
    if listed and not rows:
        raise SettingsError(str(sheet), "lists no logs", "Add a row for each log file")
    taken = {as_seen(entry.folder) for entry in entries.values()}
    logs = _Logs(Roots.of([".", sheet.parent, settings.results, *settings.log_roots]))
    for row in rows:
        name = _name_in(row, "well")
        if name not in entries:
            folder = folder_of(name)
            entries[name] = _Entry(folder_apart(name) if as_seen(folder) in taken else folder)
            taken.add(as_seen(entries[name].folder))
        entry = entries[name]
        if row.content is None:
            entry.faults += [row.fault] if row.fault else []
        elif name not in listed:
            entry.faults.append(_unknown(row.where, name, listed, settings.wells))
        else:
            logs.add(row.where, row.content.log, entry)


class _Logs:
    """The logs of all wells, each of which may be listed once and only in folders for logs."""

    def __init__(self, roots: Roots) -> None:
        self._roots = roots
        self._seen: dict[str, tuple[str, str]] = {}

    def add(self, where: str, log: str, entry: _Entry[WellRow]) -> None:
        """Add the logs of a row to its well, up to the first that may not be added, which is a fault."""
        for each in files_of(log) if self._roots.hold(log) else [log]:
            fault = self._fault(where, each)
            if fault is not None:
                entry.faults.append(fault)
                return
            self._seen[without_links(each)] = where, each
            entry.logs.append(Path(each))

    def _fault(self, where: str, log: str) -> SettingsError | None:
        if not _is_text(log):
            return SettingsError(where, f"the name of the log {log!a} is not in UTF-8", "Rename the file")
        before = self._seen.get(without_links(log))
        if before is not None:
            return _listed_twice(where, log, *before)
        if not self._roots.hold(log):
            return _outside(where, log, self._roots)
        if "*" in log and url_of(Path(log)):
            what = f"log '{log}' is a pattern, and patterns of addresses are not resolved"
            return SettingsError(where, what, "List each of them, or mount their folder")
        return None


def _is_text(name: str) -> bool:
    """Whether a file's name can be written; of bytes that are no UTF-8 Python makes characters that cannot."""
    try:
        name.encode()
    except UnicodeEncodeError:
        return False
    return True


def _listed_twice(where: str, log: str, before: str, other: str) -> SettingsError:
    """The error of a log that an earlier row lists, maybe by another name."""
    name = "" if os.path.normpath(log) == os.path.normpath(other) else f" as '{other}', which is the same file"
    return SettingsError(where, f"log '{log}' is already listed at {before}{name}", "Remove one of the rows")


def _unknown(where: str, well: str, names: Collection[str], sheet: str) -> SettingsError:
    close = difflib.get_close_matches(well, names, n=1)
    remedy = f"Did you mean '{close[0]}'?" if close else f"Add the well to {sheet}"
    return SettingsError(where, f"log of the unknown well '{well}'", remedy)


def _outside(where: str, log: str, roots: Roots) -> SettingsError:
    folder = os.path.dirname(log if "://" in log else os.path.realpath(log))
    what = f"log '{log}' lies in {folder}, outside the folders for logs: {', '.join(roots.folders)}"
    return SettingsError(where, what, f"If it may be read, add to the configuration: log_roots: [{folder}]")
