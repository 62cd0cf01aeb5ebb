"""Progress of a run: a live line for each stage on a terminal, else a plain line when a stage has ended."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

from drillid.fleet.manifest import failed_in

if TYPE_CHECKING:
    from rich.console import Console
    from rich.progress import TaskID

SHOWN = "DRILLID_PROGRESS"
"""Environment variable that tells jobs that the run's progress is shown, so that they print no lines."""


class RunProgress:
    """Finished jobs of each rule, and wells that failed in them.

    Parameters
    ----------
    console : where it is shown; only a terminal has live lines
    jobs : number of jobs of each rule, in the order in which data flow
    """

    def __init__(self, console: Console, jobs: Mapping[str, int]) -> None:
        from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

        self.console, self.jobs = console, dict(jobs)
        self.ended, self.failed = Counter[str](), Counter[str]()
        self.lines = Progress(
            TextColumn("{task.description}"),
            BarColumn(),
            MofNCompleteColumn(separator=" of "),
            TimeElapsedColumn(),
            TextColumn("{task.fields[failed]}", style="red"),
            console=console,
            disable=not console.is_terminal,
        )
        self.tasks: dict[str, TaskID] = {
            rule: self.lines.add_task(rule, total=total, start=False, failed="") for rule, total in self.jobs.items()
        }
        self.lines.start()

    def job_started(self, rule: str) -> None:
        """A job of the rule has begun: the rule's clock runs from the first one on."""
        if rule in self.tasks:
            self.lines.start_task(self.tasks[rule])

    def job_ended(self, rule: str, outputs: list[str]) -> None:
        """A job of the rule has made its outputs, which may include a manifest of wells."""
        if rule not in self.tasks:
            return
        self.ended[rule] += 1
        manifests = [path for path in map(Path, outputs) if path.suffix == ".json" and path.parent.name == rule]
        self.failed[rule] += sum(map(failed_in, manifests))
        failed = f"{self.failed[rule]} well(s) failed" if self.failed[rule] else ""
        self.lines.update(self.tasks[rule], advance=1, failed=failed)
        if not self.console.is_terminal and self.ended[rule] == self.jobs[rule]:
            line = f"{rule}: {self.ended[rule]} of {self.jobs[rule]} job(s) done"
            self.say(", ".join(filter(None, [line, failed])))

    def say(self, text: str) -> None:
        """Print a message above the live lines."""
        self.console.print(text, markup=False, highlight=False, soft_wrap=True)

    def stop(self) -> None:
        """Stop updating the lines."""
        self.lines.stop()
