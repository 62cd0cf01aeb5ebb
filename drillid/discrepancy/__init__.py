"""The discovery engine: tests of the model, causes of its misfit, the extended model and its predictive gain."""

from drillid.discrepancy.catalogue import CATALOGUE
from drillid.discrepancy.detectors.detection import Detection
from drillid.discrepancy.evidence import Evidence, OperatingPoints
from drillid.discrepancy.stage import normality_p_value, process, whitened_residuals, whiteness_p_value
from drillid.discrepancy.verdicts.engine import examine
from drillid.discrepancy.verdicts.examination import Examination
from drillid.discrepancy.verdicts.intervals import EVIDENCE, flag, intervals, run_pulls, runs
from drillid.discrepancy.verdicts.verdict import Verdict
from drillid.fits.datasheet import DataSheet

__all__ = [
    "CATALOGUE",
    "EVIDENCE",
    "DataSheet",
    "Detection",
    "Evidence",
    "Examination",
    "OperatingPoints",
    "Verdict",
    "examine",
    "flag",
    "intervals",
    "normality_p_value",
    "process",
    "run_pulls",
    "runs",
    "whitened_residuals",
    "whiteness_p_value",
]
