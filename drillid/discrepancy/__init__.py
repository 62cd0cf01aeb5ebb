"""The discovery engine: what the model leaves unexplained, its cause, the extended model, the gain."""

from drillid.discrepancy.catalogue import CATALOGUE
from drillid.discrepancy.detectors.detection import Sign
from drillid.discrepancy.evidence import Conditions, Evidence, Knowledge
from drillid.discrepancy.stage import normality_probability, process, whitened_residuals, whiteness_probability
from drillid.discrepancy.verdicts.engine import examine
from drillid.discrepancy.verdicts.examination import Examination
from drillid.discrepancy.verdicts.intervals import EVIDENCE, flag, intervals, run_pulls, runs
from drillid.discrepancy.verdicts.verdict import Verdict

__all__ = [
    "CATALOGUE",
    "EVIDENCE",
    "Conditions",
    "Evidence",
    "Examination",
    "Knowledge",
    "Sign",
    "Verdict",
    "examine",
    "flag",
    "intervals",
    "normality_probability",
    "process",
    "run_pulls",
    "runs",
    "whitened_residuals",
    "whiteness_probability",
]
