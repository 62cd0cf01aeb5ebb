"""How the workflow is laid out: wells in batches, and what each stage of a batch depends on."""

import contextlib
import functools
import itertools
import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Self

from drillid.config.files import read_yaml
from drillid.config.listing import Listing
from drillid.config.settings import Settings
from drillid.config.sheets import read_sheets, read_start_ups
from drillid.datasets.store import WellFolders
from drillid.errors import SettingsError
from drillid.fleet.aside import forget_aside
from drillid.fleet.lock import results_held
from drillid.fleet.manifest import KEY, PROBLEMS, is_made_from, out_of_date
from drillid.fleet.mirror import hold_mirror, restore
from drillid.fleet.outcome import (
    closing_line,
    failed_start_ups,
    failed_wells,
    missing_logs,
    missing_logs_line,
    unfinished_start_ups,
    unfinished_wells,
)
from drillid.fleet.provenance import digest, source_hash, template_hash
from drillid.fleet.stages import ALL_STAGES, STAGES, START_UPS, failed_on, fingerprint
from drillid.fleet.workers import THREAD_VARIABLES
from drillid.formats.remote import size_of, states, url_of

REPORT = "report.html"
"""The fleet's page in the results; those of the wells are in the folder `report` beside it."""
_BASE_MB = 1000
_MB_PER_MB_OF_TEXT, _MB_PER_MB_COMPRESSED = 12, 60
"""Memory per size of the largest log; measured: 6 for CSV, LAS and WITSML and 37 for gzipped CSV and Parquet, on top of
250 MB of imports."""
_TEXT = (
    *(".csv", ".txt", ".tsv", ".tab", ".asc", ".dat", ".prn"),
    *(".las", ".lvm", ".wits", ".wits0", ".wit", ".xml", ".witsml"),
)
"""Suffixes of text logs."""


def prepare_environment(root: str | Path) -> None:
    """Let every job find the library below `root` and use one thread per process, as wells are spread over processes.

    Snakemake reads the rules again on each node of a cluster, so this takes effect there too.
    """
    os.environ["PYTHONPATH"] = os.pathsep.join(filter(None, [str(root), os.environ.get("PYTHONPATH")]))
    for variable in THREAD_VARIABLES:
        os.environ.setdefault(variable, "1")


@dataclass(frozen=True)
class Plan:
    """The settings with the wells that their sheets list."""

    settings: Settings
    wells: Mapping[str, Listing]
    start_ups: Mapping[str, Listing] = field(default_factory=dict)
    _dependencies: dict[tuple[str, tuple[str, ...]], dict[str, Any]] = field(
        default_factory=dict, init=False, repr=False, compare=False
    )

    @classmethod
    def from_config(cls, config: Mapping[str, Any], files: Sequence[str | Path] = ()) -> Self:
        """Check the workflow's configuration and read its sheets.

        Parameters
        ----------
        config : the configuration as merged by Snakemake
        files : where it was read from, checked for duplicate keys, of which Snakemake itself takes the last

        Raises
        ------
        SettingsError
            If the configuration or a sheet cannot be used.
        """
        for file in files:
            read_yaml(file)
        settings = Settings.checked(dict(config), ", ".join(map(str, files)) or "configuration")
        return cls(settings, read_sheets(settings), read_start_ups(settings))

    @property
    def batches(self) -> dict[str, tuple[str, ...]]:
        """Wells of each job, by the batch's name: that of its well if batches hold one each, else a number."""
        names, size = tuple(self.wells), self.settings.fleet.batch_size
        if size == 1:
            return {name: (name,) for name in names}
        return {f"{start // size:04d}": names[start : start + size] for start in range(0, len(names), size)}

    @property
    def starts_from_copy(self) -> bool:
        """Whether this machine has no results, and a run begins with their copy, if there is one."""
        return self.settings.mirror is not None and not Path(self.settings.results).exists()

    def restore_results(self) -> bool:
        """Start from the copy of the results if this machine has none; returns whether it did.

        Raises
        ------
        SettingsError
            If the copy's place does not answer, or another machine works on the copy.
        """
        mirror = self.settings.mirror
        return mirror is not None and restore(Path(self.settings.results), mirror)

    def hold_mirror(self) -> Callable[[], None]:
        """Keep other machines away from the copy of the results until the returned function is called.

        Raises
        ------
        SettingsError
            If another machine works on the copy or has brought it up to date meanwhile, or its place does not answer.
        """
        mirror = self.settings.mirror
        return hold_mirror(Path(self.settings.results), mirror) if mirror is not None else lambda: None

    def out_of_date(self) -> dict[Path, str]:
        """Manifests that no longer hold, and outputs of the rules over all wells that do not, with reasons.

        Snakemake does not see these: a folder that is gone or has another key, changed inputs of a failed well; changed
        code, settings or rigs where it has no record, as the results come from another folder or machine.
        """
        return {path: reason for path, reason in self._reasons() if reason}

    def _reasons(self) -> Iterator[tuple[Path, str]]:
        """The same, with empty reasons for what holds."""
        results, batches = Path(self.settings.results), self.batches
        found = {results / stage / f"{batch}.json": wells for stage in STAGES for batch, wells in batches.items()}
        own = {results / START_UPS.name / f"{name}.json": (name,) for name in self.start_ups}
        for manifests, listings in ((found, self.wells), (own, self.start_ups)):
            failed = functools.partial(_failed_on, listings)
            for path, names in manifests.items():
                if path.exists():
                    made_from = self.dependencies(path.parent.name, names)["made_from"]
                    yield path, out_of_date(path, names, failed, made_from)
        over_all_wells = (
            ("fleet", PROBLEMS, self.fleet_dependencies()),
            ("common_causes", "common_causes.csv", self.common_causes_dependencies()),
            ("report", REPORT, self.report_dependencies()),
        )
        for rule, output, dependencies in over_all_wells:
            if (results / output).exists() and not is_made_from(results, rule, dependencies["made_from"]):
                yield results / output, "other code, settings or wells"
        report = results / REPORT
        if report.exists():
            pages = {well: report.with_suffix("") / f"{well}.html" for well in self.wells}
            yield report, next((f"page of {well} missing" for well, page in pages.items() if not page.exists()), "")

    def drop_out_of_date(self) -> None:
        """Delete the manifests that no longer hold, and make outputs over all wells that do not older than all else.

        Snakemake then sees what is to be done; the keys of a batch's other wells keep these from being redone.

        Raises
        ------
        SettingsError
            If another run works on the results, or as of `hold_mirror`; nothing is deleted then.
        """
        with results_held(Path(self.settings.results)), contextlib.ExitStack() as releases:
            releases.callback(self.hold_mirror())
            for path in self.out_of_date():
                if path.parent == Path(self.settings.results):
                    os.utime(path, (0, 0))
                else:
                    path.unlink(missing_ok=True)

    def outcome(self) -> dict[str, Any]:
        """How many wells there are, why some failed, which were not finished, which logs are missing, and the run's
        closing line.
        """
        results, wells, starts = Path(self.settings.results), tuple(self.wells), tuple(self.start_ups)
        failed, failed_starts = failed_wells(results, wells), failed_start_ups(results, starts)
        unfinished = unfinished_wells(results, wells)
        lines = [closing_line(wells, failed, unfinished)] if wells or not starts else []
        if starts:
            lines.append(
                closing_line(starts, failed_starts, unfinished_start_ups(results, starts), "starts of rotation")
            )
        logs = [log for listing in self.wells.values() for log in listing.logs]
        missing = missing_logs(logs) if self.settings.simulate is None else []
        lines += [missing_logs_line(missing)] if missing else []
        report = results.absolute() / REPORT
        told = {"report": str(report)} if report.exists() else {}
        return {
            "wells": len(wells),
            "failed": failed | failed_starts,
            "unfinished": list(unfinished),
            "missing_logs": missing,
            "line": " ".join(lines),
            **told,
        }

    def forget(self, stage: str, wells: Sequence[str]) -> None:
        """Delete the wells' keys and problems, so that the stage and those that follow are redone in any case."""
        again = {stage}
        for later in STAGES.values():
            if again.intersection(later.upstream):
                again.add(later.name)
        for name, well in itertools.product(again, wells):
            for file in (KEY, PROBLEMS):
                Path(self.settings.results, name, well, file).unlink(missing_ok=True)
            forget_aside(WellFolders(Path(self.settings.results), well), name)

    def threads(self, wells: Sequence[str]) -> int:
        """Number of processes that a job over these wells starts on its own machine."""
        fleet = self.settings.fleet
        return 1 if fleet.scheduler else min(fleet.processes, len(wells))

    def logs(self, wells: Sequence[str]) -> list[str]:
        """Log files that exist or are simulated; a missing one is its well's problem, not the workflow's."""
        simulated = self.settings.simulate is not None
        return [str(log) for well in wells for log in self.wells[well].logs if simulated or _may_be_input(log)]

    def start_up_files(self, name: str) -> list[str]:
        """Existing files of a start of rotation; a missing one becomes a row of problems.csv."""
        listing = self.start_ups[name]
        return [str(path) for path in (listing.rig_file, *listing.logs) if _may_be_input(path)]

    def memory_mb(self, wells: Sequence[str]) -> int:
        """Memory of a job that holds raw logs or their records, one log per process at a time, in MB."""
        largest = max((_memory_of(log) for well in wells for log in self.wells[well].logs), default=0.0)
        return self.threads(wells) * int(_BASE_MB + largest)

    def dependencies(self, stage: str, wells: Sequence[str]) -> dict[str, Any]:
        """What the stage depends on besides its inputs: code, sections of the settings, rigs and state of the logs, and
        `made_from`, one hash of all but the logs, which is the same on any machine.
        """
        asked = stage, tuple(wells)
        if asked not in self._dependencies:
            self._dependencies[asked] = self._computed_dependencies(*asked)
        return self._dependencies[asked]

    def _computed_dependencies(self, stage: str, wells: tuple[str, ...]) -> dict[str, Any]:
        simulated = self.settings.simulate is not None
        listings = self.start_ups if stage == START_UPS.name else self.wells
        prints = [fingerprint(ALL_STAGES[stage], listings[well], self.settings, simulated) for well in wells]
        found = {
            "source": prints[0]["source"],
            "settings": prints[0]["settings"],
            "rigs": digest([_of_sheets(each) for each in prints]),
        }
        logs = digest([each["logs"] for each in prints])
        return {"wells": list(wells), **found, "logs": logs, "made_from": digest(found)}

    def fleet_dependencies(self) -> dict[str, Any]:
        """The same for the tables over all wells."""
        source = source_hash("drillid.depth.fleet", "drillid.depth.changes", "drillid.discrepancy.learning.fleet")
        return _with_hash({"wells": list(self.wells), "start_ups": list(self.start_ups), "source": source})

    def common_causes_dependencies(self) -> dict[str, Any]:
        """The same for causes that wells have in common, with the hole section and tool of each well in the sheet."""
        return _with_hash(
            {
                "wells": {folder: {"section": well.section, "tool": well.tool} for folder, well in self.wells.items()},
                "source": source_hash("drillid.common_causes.stage"),
                "settings": self.settings.model_dump(mode="json", include={"common_causes"}),
            }
        )

    def report_dependencies(self) -> dict[str, Any]:
        """The same for the report, which lists the settings and describes the wells."""
        return _with_hash(
            {
                "wells": {folder: [listing.name, listing.description] for folder, listing in self.wells.items()},
                "start_ups": list(self.start_ups),
                "source": source_hash("drillid.report.page", "drillid.config.rig"),
                "templates": template_hash(),
                "settings": self.settings.model_dump(mode="json", exclude={"fleet", "mirror"}),
            }
        )

    def simulated_logs(self) -> dict[str, tuple[str, int]]:
        """Well and stand number of each simulated log, by the log's path below `<results>/raw`.

        Raises
        ------
        SettingsError
            If the logs sheet places such a log elsewhere.
        """
        if self.settings.simulate is None:
            return {}
        folder, found = Path(self.settings.results, "raw"), {}
        for well, listing in self.wells.items():
            for stand, log in enumerate(listing.logs):
                if not log.is_relative_to(folder):
                    remedy = f"Put it in {folder}, or remove the section 'simulate' from the configuration"
                    raise SettingsError(self.settings.logs, f"the simulated log {log} is elsewhere", remedy)
                found[str(log.relative_to(folder))] = (well, stand)
        return found

    def simulation_dependencies(self) -> dict[str, Any]:
        """What the simulated logs of the demo depend on."""
        section = self.settings.model_dump(mode="json", include={"simulate"})
        return {"source": source_hash("drillid.demo.wells"), "settings": section}


def _with_hash(dependencies: dict[str, Any]) -> dict[str, Any]:
    """What a rule over all wells depends on, with `made_from`, one hash of it, which is the same on any machine."""
    return {**dependencies, "made_from": digest(dependencies)}


def _may_be_input(path: Path) -> bool:
    """Whether a file exists, and its name is none that Snakemake would take for a pattern.

    Those that are no inputs count all the same: the state of all of them is in the stage's `params`.
    """
    return os.path.exists(path) and not set("{}<>").intersection(str(path))


def _failed_on(listings: Mapping[str, Listing], name: str) -> str:
    return failed_on(listings[name])


def _of_sheets(of_well: Mapping[str, Any]) -> Any:
    """What the sheets and the rig description say about a well."""
    further = [of_well[name] for name in ("name", "stated") if name in of_well]
    return [of_well["rig"], *further] if further else of_well["rig"]


def _memory_of(log: Path) -> float:
    """Memory that the log needs on top of the imports, in MB; 0 if it does not exist (yet)."""
    try:
        size = log.stat().st_size if url_of(log) is None else size_of(states([log])[log])
    except OSError:
        return 0.0
    return size / 1e6 * (_MB_PER_MB_OF_TEXT if log.suffix.lower() in _TEXT else _MB_PER_MB_COMPRESSED)
