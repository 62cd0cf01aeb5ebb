"""Every dataset by its name."""

from drillid.datasets.examined import DISCREPANCIES as DISCREPANCIES
from drillid.datasets.examined import EXAMINATIONS as EXAMINATIONS
from drillid.datasets.identified import DEPTH, FITS, FLEET, JOINT_FITS, STACK_FITS
from drillid.datasets.measured import LOGS, MOBILITIES, RECORDS, SPECTRA, STACKS, STATES, WINDOWS

PROBLEM_COLUMNS = ("well", "stage", "where", "what", "remedy")
"""Columns of every stage's problems.csv: one row for everything that was rejected, with its reason."""

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
    "depth": DEPTH,
    "fleet": FLEET,
}
