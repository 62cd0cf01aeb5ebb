"""Every dataset by its name."""

from drillid.datasets.examined import DISCREPANCIES as DISCREPANCIES
from drillid.datasets.examined import EXAMINATIONS as EXAMINATIONS
from drillid.datasets.identified import DEPTH, FITS, FLEET, JOINT_FITS, STACK_FITS, START_UPS
from drillid.datasets.measured import LOGS, MOBILITIES, RECORDS, SPECTRA, STACKS, STATES, WINDOWS

PROBLEM_COLUMNS = ("well", "stage", "where", "what", "remedy")
"""Columns of every stage's problems.csv: one row for everything that was rejected, with its reason."""

CHANGE_COLUMNS = {
    "well": "name of the well",
    "change": "kind of the change, see below",
    "from_m": "depth at which windows, verdict or the change of the joint fit begin, m",
    "to_m": "depth at which they end, m",
    "from_time": "start of the first of the windows, UTC",
    "to_time": "end of the last of the windows, UTC",
    "count": "number of windows, or of problems of one kind",
    "stage": "stage of the problem or of the fit",
    "where": "place of the first of the problems",
    "before": "the earlier state: the verdict with its probability, the parameter with its 95 % band, the reason for a "
    "failure",
    "now": "the present state: the verdict, the parameter, the reason for a failure, the first of the problems",
    "reason": "what has changed in the inputs of windows, fit or verdict, as far as the stages' keys show it: "
    "logs, settings, rig description, code, versions",
    "since": "end of the newest window of the well that the last report knew, UTC",
}
"""Columns of changes.csv: what is new since the last report; a column that does not apply is empty."""

CHANGES = {
    "new_well": "the well is in no earlier report",
    "removed_well": "the well is no longer listed",
    "failed": "the well failed in a stage, as it did not before, or for another reason",
    "recovered": "the well failed before and no longer does",
    "new_windows": "windows of new or late logs",
    "changed_windows": "windows whose samples have changed, as those of a corrected log",
    "removed_windows": "windows that no longer exist",
    "changed_joint_fit": "a parameter of the joint fit lies outside its earlier 95 % band; its values are those at the "
    "depth where it lies farthest outside",
    "new_verdict": "a verdict on depths that had none",
    "changed_verdict": "a verdict other than before; or its probability has changed by 0.1 or more, or its size lies "
    "outside its earlier interval",
    "withdrawn_verdict": "a verdict on depths that no longer have one",
    "new_problem": "something was rejected; rows that differ only in their numbers are one kind",
}
"""Kinds of changes with their meaning."""

DATASETS = {
    "records": RECORDS,
    "logs": LOGS,
    "states": STATES,
    "windows": WINDOWS,
    "spectra": SPECTRA,
    "mobility": MOBILITIES,
    "stacks": STACKS,
    "fits": FITS,
    "stack_fits": STACK_FITS,
    "joint": JOINT_FITS,
    "discrepancy": DISCREPANCIES,
    "examination": EXAMINATIONS,
    "start_ups": START_UPS,
    "depth": DEPTH,
    "fleet": FLEET,
}
