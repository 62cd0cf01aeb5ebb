"""Settings, sheets and batches of wells, and what all rules take from them."""

import atexit
import contextlib
import functools
import json
import os
import re
import sys
from pathlib import Path

from snakemake.exceptions import WorkflowError
from snakemake.logging import logger

# the library is the one checked out with these rules or, if they are fetched from a server, the installed one
CHECKOUT = Path(workflow.current_basedir.get_path_or_uri(secret_free=True)).parents[1]
if CHECKOUT.is_dir():
    sys.path.insert(0, str(CHECKOUT))

from drillid.fleet.command import OUTCOME
from drillid.fleet.fork_server import served
from drillid.fleet.installation import workflow_of_library
from drillid.fleet.lock import hold_results, name_run
from drillid.fleet.manifest import marks
from drillid.fleet.plan import REPORT, Plan, prepare_environment
from drillid.errors import DrillidError
from drillid.fleet.stages import START_UPS, STAGES


def hand_over(outcome):
    """Tell `drillid run`, if that started this workflow, what became of the wells; returns whether it did."""
    if OUTCOME in os.environ:
        Path(os.environ[OUTCOME]).write_text(json.dumps(outcome))
    return OUTCOME in os.environ


def refuse(reason):
    """End a run that does nothing, with the reason."""
    hand_over({"line": f"Nothing was done: {reason}"})
    raise WorkflowError(str(reason)) from None


prepare_environment(CHECKOUT if CHECKOUT.is_dir() else workflow_of_library())
try:
    PLAN = Plan.from_config(config, workflow.configfiles)
    SIMULATED = PLAN.simulated_logs()
except DrillidError as error:
    refuse(error)

BATCHES = PLAN.batches
RELEASES = contextlib.ExitStack()
BATCH_OF = {well: batch for batch, wells in BATCHES.items() for well in wells}

REFUSALS = []

if workflow.is_main_process:
    name_run()
    atexit.register(lambda: tell_where_nothing_is_done())


@functools.cache
def marked():
    """Inputs that are new, by the outputs that are out of date; where a run may delete these, it does so instead.

    Snakemake asks for it as it plans jobs, before it looks at their outputs; only then is it known whether it runs them
    or is asked for no more than a summary.
    """
    runs, out_of_date = workflow.execution_settings is not None and not workflow.dryrun, {}
    try:
        if runs and PLAN.restore_results():
            logger.info(f"{PLAN.settings.results} was fetched from {PLAN.settings.mirror}")
        elif not runs and PLAN.starts_from_copy:
            logger.info(f"{PLAN.settings.results} is not there; a run begins with its copy in {PLAN.settings.mirror}")
        out_of_date = PLAN.out_of_date()
        if runs and out_of_date:
            PLAN.drop_out_of_date()
            return {}
    except DrillidError as error:
        REFUSALS.append(str(error))
    return marks(out_of_date, workflow.snakemake_tmp_dir) if out_of_date else {}


def one_of(names):
    """Pattern of a wildcard that stands for one of these names; it matches nothing if there are none."""
    return "|".join(map(re.escape, names)) or "(?!)"


def wells(wildcards):
    return BATCHES[wildcards.batch]


def start_up(wildcards):
    return (wildcards.start_up,)


def raw_logs(wildcards):
    return PLAN.logs(wells(wildcards))


def processes(wildcards):
    return PLAN.threads(wells(wildcards))


def memory(wildcards):
    return PLAN.memory_mb(wells(wildcards))


def runtime(wildcards):
    return 10 + 5 * len(wells(wildcards))


def dependencies(stage, names=wells):
    """The batch's wells, code, settings, rigs and logs; if any of them changes, the stage is redone."""

    def parameter(name):
        return lambda wildcards: PLAN.dependencies(stage, names(wildcards))[name]

    return {name: parameter(name) for name in ("wells", "source", "settings", "rigs", "logs", "made_from")}


def again(output):
    """Input of a rule whose output is out of date where that may not be deleted, and so says why; else nothing."""

    def mark(wildcards):
        place = str(Path(PLAN.settings.results, output.format(**wildcards)))
        return marked().get(place, []) if workflow.is_main_process else []

    return mark


def manifests(stage):
    """Manifests of all batches: what waits for them has all wells."""
    return expand(f"<results>/{stage}/{{batch}}.json", batch=BATCHES)


def start_up_manifests():
    """Manifests of all starts of rotation."""
    return expand("<results>/start_ups/{start_up}.json", start_up=PLAN.start_ups)


def manifest_of_well(stage="{stage}"):
    """Manifest of the batch that holds the well."""
    return lambda wildcards: f"<results>/{stage.format(**wildcards)}/{BATCH_OF[wildcards.well]}.json"


def everything():
    """Tables and report, the figures that Snakemake's report shows, and all manifests, of which none may be missing."""
    # a missing intermediate file is remade only if it is a target
    stages = [manifest for stage in STAGES for manifest in manifests(stage)]
    tables = [
        f"<results>/{name}"
        for name in (
            *("fleet.zarr", "problems.csv", "verdicts.csv", "learnt.csv", "changes.csv", "report.html"),
            *("common_causes.csv", "well_standings.csv"),
            "ro-crate-metadata.json",
        )
    ]
    return stages + start_up_manifests() + expand("<results>/figures/{well}", well=PLAN.wells) + tables


def mirrored():
    """The file that shows that the copy of the results is up to date, if there is to be a copy."""
    return ["<results>/mirror.json"] if PLAN.settings.mirror and PLAN.wells else []


def begin():
    """Keep other runs away from the results, and other machines from their copy."""
    for refusal in REFUSALS:
        refuse(refusal)
    try:
        hold_results(Path(PLAN.settings.results))
        RELEASES.callback(PLAN.hold_mirror())
    except DrillidError as error:
        refuse(error)
    if workflow.local_exec:
        RELEASES.enter_context(served({job.rule.name for job in workflow.dag.needrun_jobs()}))


def end():
    """Report what became of the wells, to `drillid run` or else on the terminal; release the copy of the results."""
    RELEASES.close()
    tell(logger.info)


def tell(say):
    """Report what became of the wells, to `drillid run` or else as a line."""
    outcome = PLAN.outcome()
    if not hand_over(outcome):
        say(outcome["line"])


def tell_where_nothing_is_done():
    """The same for a run without jobs, where Snakemake does not call `onsuccess`: wells may have failed before."""
    if workflow.scheduler is not None and not workflow.dryrun and not len(workflow.dag):
        tell(lambda line: print(line, file=sys.stderr))


def forget_forced():
    """Have forced jobs, and those that follow from them, redo all their wells although nothing has changed."""
    for job in workflow.dag.needrun_jobs():
        if job.rule.name in STAGES and workflow.dag.reason(job).forced:
            PLAN.forget(job.rule.name, wells(job.wildcards))
        elif job.rule.name == START_UPS.name and workflow.dag.reason(job).forced:
            PLAN.forget(job.rule.name, start_up(job.wildcards))
