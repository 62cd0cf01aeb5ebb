"""Snakemake's messages as `drillid run` shows them: progress by stage, warnings and errors.

All of Snakemake's messages are in .snakemake/log; if nothing is run, as with --dry-run, they are shown unchanged.
"""

import logging
import os

from rich.console import Console
from snakemake.logging import ColorizingTextHandler, DefaultFilter, DefaultFormatter
from snakemake_interface_logger_plugins.base import LogHandlerBase
from snakemake_interface_logger_plugins.common import LogEvent

from drillid.fleet.progress import SHOWN, RunProgress

_WITHOUT_WORK = {"all", "well", "figures_of_well"}
"""Rules that run nothing."""
_EXPECTED = tuple(f"output files of rule {rule} were not present" for rule in _WITHOUT_WORK)
"""Snakemake's warnings about these, whose outputs are made by other rules."""


class LogHandler(LogHandlerBase):
    """Holds messages back until it is known whether jobs are run."""

    def __post_init__(self) -> None:
        common = self.common_settings
        self.plain = ColorizingTextHandler(nocolor=common.nocolor)
        self.plain.setFormatter(DefaultFormatter(common.quiet, common.show_failed_logs))
        self.plain.addFilter(
            DefaultFilter(common.quiet, common.debug_dag, common.verbose, common.dryrun, common.printshellcmds)
        )
        self.as_it_is = common.dryrun or common.verbose or common.printshellcmds or common.debug_dag
        self.held, self.jobs = [], {}
        self.progress = None
        if Console(stderr=True).is_terminal and not self.as_it_is:
            os.environ[SHOWN] = "1"

    def emit(self, record: logging.LogRecord) -> None:
        """Show a message, hold it back, or leave it to the log file."""
        event = getattr(record, "event", None)
        if self.as_it_is:
            self.plain.handle(record)
        elif event == LogEvent.RUN_INFO and self.progress is None:
            jobs = {rule: count for rule, count in record.stats.items() if rule not in {*_WITHOUT_WORK, "total"}}
            self.held.clear()
            if jobs:
                self.progress = RunProgress(Console(stderr=True), jobs)
            else:
                self._say("Nothing to be done.")
        elif record.levelno >= logging.WARNING:
            if not any(warning in record.getMessage() for warning in _EXPECTED):
                self._say(self.plain.format(record))
        elif self.progress is None:
            self.held.append(record)
        else:
            self._follow(event, record)

    def _follow(self, event: LogEvent | None, record: logging.LogRecord) -> None:
        if event == LogEvent.JOB_INFO:
            self.jobs[record.jobid] = (record.rule_name, record.output)
            self.progress.job_started(record.rule_name)
        elif event == LogEvent.JOB_FINISHED and record.job_id in self.jobs:
            self.progress.job_ended(*self.jobs.pop(record.job_id))

    def _say(self, text: str) -> None:
        if self.progress is None:
            Console(stderr=True, soft_wrap=True).print(text, markup=False, highlight=False)
        else:
            self.progress.say(text)

    def close(self) -> None:
        """Stop the progress display, or show the messages held back if no job was run."""
        if self.progress is not None:
            self.progress.stop()
        for record in self.held:
            self.plain.handle(record)
        self.held.clear()
        super().close()

    writes_to_stream = True
    writes_to_file = False
    has_filter = True
    has_formatter = True
    needs_rulegraph = False
