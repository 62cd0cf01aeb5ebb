"""One stage over a batch of wells."""

from __future__ import annotations

import contextlib
import importlib
import itertools
import json
import logging
import os
import resource
import sys
import time
import traceback
from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import pandas as pd

from drillid.config.listing import Listing
from drillid.config.settings import Settings
from drillid.config.sheets import read_sheets, read_start_ups
from drillid.datasets.checksums import check
from drillid.datasets.registry import PROBLEM_COLUMNS
from drillid.datasets.store import Problem, WellFolders, problems_table
from drillid.datasets.tables import read_table, write_table
from drillid.errors import DamageError, DrillidError, SettingsError, place_in_library
from drillid.fleet.aside import clear, forget_aside, set_aside
from drillid.fleet.children import mapped_apart
from drillid.fleet.explain import attributes_of, inputs_behind, inputs_of, known_inputs, remember_inputs
from drillid.fleet.lock import end_with_run, held
from drillid.fleet.manifest import AGAIN, KEY, PROBLEMS, stored_key, write_manifest, write_whole
from drillid.fleet.outcome import stored_name
from drillid.fleet.progress import SHOWN
from drillid.fleet.provenance import PACKAGE, digest, numerical_versions, package_hash
from drillid.fleet.stages import ALL_STAGES, STAGES, START_UPS, Stage, failed_on, fingerprint
from drillid.fleet.workers import client_of

_PRINT_EVERY_S = 2.0
_REPORTED = ("windows", "fits", "discrepancy", "depth")
"""Stages whose datasets the tables and the report read."""
_LOADED = package_hash()
"""The code of this process; a long-lived dask worker may hold an older one than the workflow."""


@dataclass(frozen=True)
class Outcome:
    """What became of one well: done, kept (nothing changed), empty (nothing to work on) or failed."""

    well: str
    status: str
    problems: int = 0
    seconds: float = 0.0
    trace: str = ""
    """Traceback of an unforeseen error; such a well has no key and is tried again by the next run."""
    fatal: bool = False
    """Whether the machine was at fault (disk, memory), in which case the job must fail."""
    core_seconds: float = field(default=0.0, compare=False)
    """Processor time, whereas `seconds` is elapsed time."""


@dataclass(frozen=True)
class Task:
    """Everything that a process needs to take one well through one stage."""

    stage: str
    listing: Listing
    settings: Settings
    results: Path
    code: str


def run_stage(
    stage: str,
    wells: Sequence[str],
    settings: Settings,
    log: str | Path | None = None,
    manifest: str | Path | None = None,
    made_from: str = "",
) -> list[Outcome]:
    """Take the wells of one batch through a stage.

    Each well ends with its datasets, a problems.csv and a key.json in `<results>/<stage>/<well>/`;
    a well whose key is unchanged is left alone, and one that fails gets a row in its problems.csv.

    Parameters
    ----------
    stage : name of the stage
    wells : wells of the batch
    settings : all settings
    log : file for the outcome of every well, tracebacks included
    manifest : file with the wells' keys, written last
    made_from : hash of code, settings and rigs that the batch was planned with, recorded in the manifest

    Raises
    ------
    SettingsError
        If the sheets cannot be used, or a dask worker holds older code.
    OSError
        If disk or memory failed for a well; by then all wells of the batch have been tried.
    """
    end_with_run()
    tasks, outcomes = tasks_of(stage, wells, settings), list[Outcome]()
    with logged(log) as logger, held(Path(settings.results).absolute() / stage / f".{wells[0]}.lock"):
        for outcome in _counted(stage, len(tasks), _outcomes(tasks, settings)):
            spent = f"{outcome.seconds:.1f} s, {outcome.core_seconds:.2f} s of one core"
            message = f"{outcome.well}: {outcome.status}, {outcome.problems} problem(s), {spent}"
            logger.info("%s", "\n".join(filter(None, [message, outcome.trace])))
            outcomes.append(outcome)
        fatal = [outcome for outcome in outcomes if outcome.fatal]
        if fatal:
            raise OSError("\n".join(f"{outcome.well}: {outcome.trace}" for outcome in fatal))
        if manifest is not None:
            # within the lock, as a job that briefly outlives its run may still be working on the batch
            write_manifest(manifest, wells, made_from)
    return outcomes


def run_configured(
    stage: str, wells: Sequence[str], config: dict[str, Any], log: str, manifest: str, made_from: str
) -> None:
    """`run_stage` with the workflow's configuration as passed to a job."""
    run_stage(stage, wells, Settings.checked(config, "configuration"), log, manifest, made_from)


def tasks_of(stage: str, wells: Sequence[str], settings: Settings) -> list[Task]:
    """What `process_well` needs for each of these wells.

    Raises
    ------
    SettingsError
        If the sheets cannot be used.
    """
    listings: Mapping[str, Listing] = read_start_ups(settings) if stage == START_UPS.name else read_sheets(settings)
    results = Path(settings.results).absolute()
    return [Task(stage, listings[well].absolute(), settings, results, _LOADED) for well in wells]


def process_well(task: Task) -> Outcome:
    """Take one well through one stage; any failure becomes a row in its problems.csv, if that can be written.

    Raises
    ------
    SettingsError
        If this process has loaded other code than the workflow.
    """
    if task.code != _LOADED:
        raise SettingsError("dask worker", "runs an older version of drillid", "Restart the dask workers")
    try:
        # a dask worker may still be at the well although its run was killed
        with held(task.results / task.stage / f".{task.listing.folder}.well.lock"):
            return _processed(task)
    except (OSError, MemoryError) as error:
        # not a fault of the stage itself: its results cannot be written, or existing files not be read or removed
        return _fallen(task, _machine_fault(error), traceback.format_exc(), fatal=True)


def _processed(task: Task) -> Outcome:
    began, began_work = time.perf_counter(), time.process_time()
    stage, folders = ALL_STAGES[task.stage], WellFolders(task.results, task.listing.folder, name=task.listing.name)
    folder = folders.stage(stage.name)
    key = _key(stage, task.listing, task.settings, folders)
    failed = _failed_key(key, task.listing)
    if stored_key(folder) in (key["key"], failed["key"]):
        return Outcome(task.listing.name, "kept", len(_read_problems(folder / PROBLEMS)))
    read = {} if stage.reads else inputs_of([task.listing.rig_file, *task.listing.logs], known_inputs(folder))
    inputs = {name: checksum for name, (_, checksum) in read.items()}
    provenance = attributes_of(key, inputs_behind(folders) if stage.reads else inputs)
    folders = replace(folders, basis=key["basis"], provenance=provenance)
    set_aside(folders, stage.name)
    end = _End("empty")
    if all(folders.has(*dataset) for dataset in stage.reads):
        end = _attempt(stage, task, folders)
    if end.status == "failed":
        clear(folders, stage.name)
    write_table(problems_table(task.listing.name, stage.name, end.problems), folder / PROBLEMS)
    if not end.trace:
        content = _tried_again(failed if end.status == "failed" else key, end.problems)
        # stored with the key but not part of its hash: how the numbers came to be, for `drillid explain`
        if read:
            remember_inputs(folder, read)
        files = sorted(path.name for path in folder.iterdir() if not path.name.startswith("."))
        beside = {"status": end.status, "versions": numerical_versions(), "inputs": inputs, "files": files}
        write_whole(folder / KEY, json.dumps({**content, **beside}, indent=1))
    if end.status == "done":
        forget_aside(folders, stage.name)
    seconds, worked = time.perf_counter() - began, time.process_time() - began_work
    return Outcome(task.listing.name, end.status, len(end.problems), seconds, end.trace, end.fatal, worked)


def drop_damaged(results: Path, wells: Sequence[str]) -> None:
    """Remove damaged datasets, which tables and report would read, each with a row; the next run remakes them."""
    for well, stage in itertools.product(wells, _REPORTED):
        folders = WellFolders(results, well)
        try:
            for made in sorted([*folders.stage(stage).glob("*.zarr"), *folders.stage(stage).glob("*.csv")]):
                check(made, stage)
        except DamageError as error:
            name = stored_name(folders)
            clear(folders, stage)
            write_table(problems_table(name, stage, [Problem.of(error)]), folders.stage(stage) / PROBLEMS)


@contextlib.contextmanager
def damage_dropped(results: Path, wells: Sequence[str]) -> Iterator[None]:
    """Have the next run make again what is found damaged within this context, which ends by it."""
    try:
        yield
    except DamageError:
        drop_damaged(results, wells)
        raise


def collect_problems(results: Path, wells: Sequence[str], start_ups: Sequence[str] = ()) -> pd.DataFrame:
    """The problems of all wells and stages as one table, in the order of wells and stages, then those of starts of
    rotation.
    """
    files = [WellFolders(results, well).stage(stage) / PROBLEMS for well in wells for stage in STAGES]
    files += [WellFolders(results, start_up).stage(START_UPS.name) / PROBLEMS for start_up in start_ups]
    tables = [table for table in map(_read_problems, files) if len(table)]
    return pd.concat(tables, ignore_index=True) if tables else pd.DataFrame(columns=list(PROBLEM_COLUMNS))


@dataclass(frozen=True)
class _End:
    """How the work of one stage on one well ended; see Outcome."""

    status: str
    problems: tuple[Problem, ...] = ()
    trace: str = ""
    fatal: bool = False


def _attempt(stage: Stage, task: Task, folders: WellFolders) -> _End:
    if task.listing.faults:
        return _End("failed", tuple(map(Problem.of, task.listing.faults)))
    process = importlib.import_module(stage.module).process
    try:
        problems = tuple(process(task.listing.load(), folders, task.settings))
    except DamageError as error:
        # the damaged dataset counts as never made, so that the next run makes it anew, not from what was set aside
        (folders.stage(error.stage) / KEY).unlink(missing_ok=True)
        forget_aside(folders, error.stage)
        return _End("failed", (Problem.of(error),), traceback.format_exc())
    except DrillidError as error:
        return _End("failed", (Problem.of(error),))
    except (OSError, MemoryError) as error:
        return _End("failed", (_machine_fault(error),), traceback.format_exc(), fatal=True)
    except Exception as error:  # the other wells go on; problem row, log and the missing key record it
        return _End("failed", (_unforeseen(error),), traceback.format_exc())
    made = stage.reads or folders.has(stage.name, stage.name)
    return _End("done" if made else "failed", problems)


def _machine_fault(error: OSError | MemoryError) -> Problem:
    place = str(getattr(error, "filename", None) or "this machine")
    what = f"{type(error).__name__}: {error}"
    return Problem(place, what, "Fix the disk, permissions or memory, then run again; nothing needs to be deleted")


def _unforeseen(error: BaseException) -> Problem:
    place = place_in_library(error)
    file = Path(place.filename)
    name = file.relative_to(PACKAGE.parent) if file.is_relative_to(PACKAGE) else file.name
    what = f"{type(error).__name__}: {error}"
    remedy = "A fault in the program: report it with the job's log"
    return Problem(f"{name}, line {place.lineno}", what, remedy)


def _key(stage: Stage, listing: Listing, settings: Settings, folders: WellFolders) -> dict[str, Any]:
    content = fingerprint(stage, listing, settings)
    content["upstream"] = {name: stored_key(folders.stage(name)) for name in stage.upstream}
    basis = digest([*(content[name] for name in ("source", "settings", "rig")), numerical_versions()])
    return {"key": digest(content), "basis": basis, **content}


def _failed_key(key: dict[str, Any], listing: Listing) -> dict[str, Any]:
    """The key of a failure, valid until the rig description or the logs change in any way."""
    state = failed_on(listing)
    return {**key, "key": digest([key["key"], "failed", state]), "failed_on": state}


def _tried_again(key: dict[str, Any], problems: Sequence[Problem]) -> dict[str, Any]:
    """The key or, where something could not be read, another one that no next run takes for its own."""
    again = [problem.where for problem in problems if problem.again]
    return {**key, "key": digest([key["key"], again]), AGAIN: True} if again else key


def _read_problems(path: Path) -> pd.DataFrame:
    try:
        return read_table(path, dtype=str, keep_default_na=False)
    except (FileNotFoundError, ValueError):
        return pd.DataFrame(columns=list(PROBLEM_COLUMNS))


def _outcomes(tasks: Sequence[Task], settings: Settings) -> Iterator[Outcome]:
    """Outcomes in the order in which the wells finish."""
    fleet = settings.fleet
    if fleet.scheduler is None and min(fleet.processes, len(tasks)) < 2:
        for task, future in mapped_apart(process_well, tasks):
            yield _result(task, future)
        return
    with client_of(fleet, len(tasks)) as client:
        from distributed import as_completed

        futures = {client.submit(process_well, task, pure=False): task for task in tasks}
        for future in as_completed(futures):
            yield _result(futures[future], future)


def _result(task: Task, future: Any) -> Outcome:
    """The outcome, or that of a failed well, with a row, if its process died."""
    error = future.exception()
    if not _is_death(error):
        outcome: Outcome = future.result()
        return outcome
    problem = Problem(
        f"process of the stage {task.stage}",
        "the process was killed, probably out of memory",
        "Give the job more memory, or fewer processes, then run again",
    )
    return _fallen(task, problem, f"{type(error).__name__}: {error}")


def _fallen(task: Task, problem: Problem, trace: str, fatal: bool = False) -> Outcome:
    """The outcome of a failed well, whose results are not kept; writes its problem row if that is possible."""
    folders = WellFolders(task.results, task.listing.folder, name=task.listing.name)
    with contextlib.suppress(OSError):
        clear(folders, task.stage)
        table = problems_table(task.listing.name, task.stage, [problem])
        write_table(table, folders.stage(task.stage) / PROBLEMS)
    return Outcome(task.listing.name, "failed", 1, trace=trace, fatal=fatal)


def _is_death(error: BaseException | None) -> bool:
    """Whether the process was killed or ended itself; dask's error counts only if dask has been loaded."""
    distributed = sys.modules.get("distributed")
    deaths = (BrokenProcessPool,) if distributed is None else (BrokenProcessPool, distributed.KilledWorker)
    return isinstance(error, deaths)


def _counted(stage: str, total: int, outcomes: Iterator[Outcome]) -> Iterator[Outcome]:
    """Print counts line by line, as several jobs share the terminal; nothing if the run's progress is shown there."""
    if SHOWN in os.environ:
        yield from outcomes
        return
    from rich.console import Console

    console, printed, counts = Console(stderr=True, highlight=False), time.monotonic(), dict[str, int]()
    for number, outcome in enumerate(outcomes, 1):
        counts[outcome.status] = counts.get(outcome.status, 0) + 1
        if number == total or time.monotonic() - printed > _PRINT_EVERY_S:
            printed = time.monotonic()
            which = outcome.well if total == 1 else f"{number} of {total} wells"
            console.print(f"{stage}: {which}: " + ", ".join(f"{count} {status}" for status, count in counts.items()))
        yield outcome


@contextlib.contextmanager
def logged(path: str | Path | None) -> Iterator[logging.Logger]:
    """A logger to the job's own file, overwritten, whose last line is the time and memory used; silent without path."""
    logger = logging.Logger("drillid.fleet.run")
    handler = logging.NullHandler() if path is None else _file_handler(Path(path))
    logger.addHandler(handler)
    try:
        yield logger
    finally:
        used = [resource.getrusage(whose) for whose in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
        seconds = sum(each.ru_utime + each.ru_stime for each in used)
        logger.info("job: %.2f s of one core, at most %.0f MB a process", seconds, max(u.ru_maxrss for u in used) / 1e3)
        handler.close()


def _file_handler(path: Path) -> logging.Handler:
    path.parent.mkdir(parents=True, exist_ok=True)
    handler = logging.FileHandler(path, mode="w")
    handler.setFormatter(logging.Formatter("%(asctime)s %(message)s"))
    return handler
