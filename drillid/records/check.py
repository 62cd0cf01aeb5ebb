"""`drillid check`: everything that would fail, or be left out, in a run over a configuration; nothing is written."""

from __future__ import annotations

from collections.abc import Callable, Generator, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TypeVar

from drillid.config.listing import Listing, StartUp
from drillid.config.rig import Rig
from drillid.config.settings import Settings
from drillid.config.sheets import read_sheets, read_start_ups
from drillid.datasets.store import Problem
from drillid.errors import DrillidError
from drillid.records.grid import End
from drillid.records.joining import LIST_APART, LIST_ONCE, SlowLogs, found_now, sources
from drillid.records.placed_logs import distinct_names
from drillid.records.stage import FAILS_THE_JOB, LogOnGrid, in_time_order, log_on_grid, refusal

Place = TypeVar("Place")
Content = TypeVar("Content")


@dataclass(frozen=True)
class Finding:
    """One thing that a run would reject, or leave out with a note.

    fails : whether a log, a well or the whole run would fail
    """

    where: str
    what: str
    remedy: str
    fails: bool = True

    @classmethod
    def of(cls, error: DrillidError | Problem) -> Finding:
        """The finding that an error stands for."""
        return cls(error.where, error.what, error.remedy)

    @property
    def row(self) -> tuple[str, str, str, str]:
        """The finding as a row of a table, each cell in one line."""
        cells = ("fails" if self.fails else "note", self.where, self.what, self.remedy)
        first, where, what, remedy = (" ".join(cell.split()) for cell in cells)
        return first, where, what, remedy


@dataclass
class Checked:
    """What has been looked at so far."""

    wells: int = 0
    rigs: int = 0
    logs: int = 0
    start_ups: int = 0

    def __str__(self) -> str:
        starts = [(self.start_ups, "start of rotation", "starts of rotation")] if self.start_ups else []
        of_each = (self.wells, "well", "wells"), (self.rigs, "rig", "rigs"), (self.logs, "log", "logs"), *starts
        *first, last = (_counted(*each) for each in of_each)
        return f"{', '.join(first)} and {last} checked"

    def summary(self, findings: Sequence[Finding]) -> str:
        """What was checked, what would fail and what to do about it, in a sentence or two."""
        fails = sum(finding.fails for finding in findings)
        if fails:
            return (
                f"{self}: {_counted(fails, 'problem', 'problems')} would make a log, a well or the whole run fail. "
                "Correct each row marked 'fails' as its remedy says, and check again"
            )
        notes = f"; {_counted(len(findings), 'note', 'notes')} on what it would assume or leave out" if findings else ""
        return f"{self}: a run would accept everything{notes}"


def _counted(number: int, one: str, several: str) -> str:
    return f"{number} {one if number == 1 else several}"


def check(
    configuration: Path,
    checked: Checked,
    *,
    logs: bool = True,
    later_stages: Sequence[Callable[[Settings], object]] = (),
) -> Iterator[Finding]:
    """Findings in the configuration, sheets, descriptions and, unless `logs` is false, in every log.

    Parameters
    ----------
    configuration : the file that a run is given
    checked : counts what has been looked at
    later_stages : what stages after the records read of the settings, each of which raises SettingsError
    """
    settings = yield from _read(Settings.of_run, configuration)
    if settings is not None:
        for stage in later_stages:
            yield from _read(stage, settings)
        yield from _wells(settings, checked, logs)
        yield from _start_ups(settings, checked, logs)


def _wells(settings: Settings, checked: Checked, logs: bool) -> Iterator[Finding]:
    listings = (yield from _read(read_sheets, settings)) or {}
    # a well whose row is refused has the sheet in place of its rig description
    rigs: dict[Path, Rig | None] = {Path(settings.wells): None}
    for listing in listings.values():
        checked.wells += 1
        yield from map(Finding.of, listing.faults)
        yield from _well(listing, settings, rigs, checked, logs)
        checked.rigs = len(rigs) - 1


def _start_ups(settings: Settings, checked: Checked, logs: bool) -> Iterator[Finding]:
    """Findings in the sheet of measured starts of rotation, if there is one, and in the files that it lists."""
    listings = (yield from _read(read_start_ups, settings)) or {}
    for listing in listings.values():
        checked.start_ups += 1
        yield from map(Finding.of, listing.faults)
        if not listing.faults:
            yield from _start_up(listing.load(), f"{settings.start_up_sheet}, '{listing.name}'", logs)


def _start_up(start: StartUp, where: str, logs: bool) -> Iterator[Finding]:
    """Findings in the files of a start of rotation and in what its row asks of them."""
    from drillid.config.described_well import DescribedWell
    from drillid.simulation.start_up_files import read_start_up, read_survey

    described = yield from _read(DescribedWell.from_yaml, start.description)
    survey = yield from _read(read_survey, start.survey)
    if logs:
        yield from _read(read_start_up, start.log)
    if described is not None and survey is not None:
        try:
            described.model(survey, start.depth, start.fitted).rig()
        except DrillidError as error:
            yield Finding(where, f"{error.where}: {error.what}", error.remedy)


def _read(read: Callable[[Place], Content], place: Place) -> Generator[Finding, None, Content | None]:
    """Finding in a file or sheet that cannot be used; returns what is read of a sound one."""
    try:
        return read(place)
    except DrillidError as error:
        yield Finding.of(error)
        return None


def _well(
    listing: Listing, settings: Settings, rigs: dict[Path, Rig | None], checked: Checked, logs: bool
) -> Iterator[Finding]:
    if listing.rig_file not in rigs:
        rigs[listing.rig_file] = yield from _read(Listing.load_rig, listing)
    if not listing.logs and not listing.faults:
        yield Finding(settings.logs, f"well '{listing.name}' has no logs", "List its log files there")
    rig = rigs[listing.rig_file]
    if rig is None or not logs or settings.simulate is not None:
        return
    fast, slow = sources(listing.logs, rig)
    checked.logs += len(listing.logs)
    starts, unread = in_time_order(fast, found_now)
    yield from map(Finding.of, unread)
    rigs_of, end = {source.path: source.rig for source in fast}, None
    times, commanded = list[tuple[int, int, Path]](), list[bool]()
    for path in starts:
        sound = yield from _log(path, rigs_of[path], end, slow)
        if sound is not None:
            times.append((*sound.span, path))
            commanded.append("torque_command" in sound.channels)
            own = End.of(sound.ticks)
            end = own if end is None or own.time > end.time else end
    yield from _overlapping(times)
    spans = [(first, last) for first, last, _ in times]
    yield from (replace(Finding.of(error), fails=False) for error in slow.problems(spans))
    if rig.controller is None and commanded and not any(commanded):
        what = f"states no controller, and no log of the well '{listing.name}' holds torque_command, which shows it"
        remedy = "Add 'controller' with its gain 'proportional', or map the torque command under 'channels'"
        yield Finding(str(listing.rig_file), what, remedy)


def _overlapping(times: Sequence[tuple[int, int, Path]]) -> Iterator[Finding]:
    """Logs that others cover entirely or in part; first and last stamp (ns) and file of each."""
    names = distinct_names(path for _, _, path in times)
    end, before = -1, Path()
    for first, last, path in sorted(times):
        if last <= end:
            what = f"lies entirely within the time of the logs up to '{names[before]}' and is not used"
            yield Finding(str(path), what, LIST_ONCE)
            continue
        if first <= end:
            what = (
                f"begins {(end - first) / 1e9:.4g} s before the end of '{names[before]}'; that part of it is not used"
            )
            yield Finding(str(path), what, LIST_APART, fails=False)
        end, before = last, path


def _log(path: Path, rig: Rig, end: End | None, slow: SlowLogs) -> Generator[Finding, None, LogOnGrid | None]:
    """Findings in one log that follows the end of another: its table, its clock, its channels and their units.

    Returns a sound log.
    """
    try:
        log = log_on_grid(path, rig, end, slow)
    except FAILS_THE_JOB:
        raise
    except Exception as error:  # as in a run, one log must not take the others along
        yield Finding.of(refusal(path, error))
        return None
    for what, remedy in log.notes:
        yield Finding(str(path), what, remedy, fails=False)
    return log
