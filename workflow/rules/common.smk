"""Settings, sheets and batches of wells, and what all rules take from them."""

import sys

from snakemake.exceptions import WorkflowError
from snakemake.logging import logger

# the library at the root is used as checked out
sys.path.insert(0, workflow.basedir)

from drillid.fleet.plan import Plan, prepare_environment
from drillid.errors import DrillidError
from drillid.fleet.stages import STAGES

prepare_environment(workflow.basedir)
try:
    PLAN = Plan.from_config(config)
except DrillidError as error:
    raise WorkflowError(str(error)) from None

RESULTS = PLAN.settings.results
if not PLAN.wells:
    logger.warning(
        f"{PLAN.settings.wells} lists no wells: nothing to do. Add a row for each well, as config/README.md says."
    )


def folders(stage, wells):
    return [f"{RESULTS}/{stage}/{well}" for well in wells]


def kept_folders(stage, wells):
    return [update(directory(folder)) for folder in folders(stage, wells)]


def everything():
    if not PLAN.wells:
        return []
    tables = [f"{RESULTS}/{name}" for name in ("fleet.zarr", "problems.csv", "verdicts.csv", "report.html")]
    return folders("depth", PLAN.wells) + folders("figures", PLAN.wells) + tables
